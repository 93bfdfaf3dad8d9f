//! The progress of a training run, on a terminal or in a log.
//!
//! Holds the bar and the lines above it. Does not depend on how many runs there are.

use crate::learn::td3::outcome::Event;
use indicatif::{ProgressBar, ProgressState, ProgressStyle};

/// A bar over all of a run's updates, with `name` before it.
pub fn progress_bar(name: &str, total_updates: u64) -> ProgressBar {
    let style = "{prefix}{bar:20} {pos}/{len} updates, {rate}, done in {eta}  {wide_msg}";
    let bar = ProgressBar::new(total_updates);
    // The template is a constant; if it were invalid, indicatif's default would be used.
    let style = ProgressStyle::with_template(style).unwrap_or(ProgressStyle::default_bar());
    // indicatif's rate has four decimals.
    let rate = |state: &ProgressState, out: &mut dyn std::fmt::Write| {
        let _ = write!(out, "{:.0}/s", state.per_sec());
    };
    bar.set_style(style.with_key("rate", rate));
    bar.set_prefix(name.to_owned());
    bar
}

/// Prints a line above the bar, or alone if standard error is not a terminal.
pub fn say(bar: &ProgressBar, line: &str) {
    if bar.is_hidden() {
        eprintln!("{line}");
    } else {
        bar.println(line);
    }
}

/// Moves the bar, and prints a line for an evaluation.
pub fn show(bar: &ProgressBar, event: &Event) {
    match event {
        Event::Resumed { updates } => {
            bar.set_position(*updates);
            bar.reset_eta();
        }
        Event::Round { updates, .. } => bar.set_position(*updates),
        Event::Evaluated { point, best } => {
            // Plus zero turns -0.00 into 0.00.
            let speed_m_s = (point.speed_m_s * 100.0).round() / 100.0 + 0.0;
            bar.set_message(format!("reward {:.1}, {speed_m_s:.2} m/s", point.reward));
            let line = format!(
                "{}{:>7} updates {:>9} steps {:>6.0} s  reward {:>8.1}  {speed_m_s:>6.2} m/s{}",
                bar.prefix(),
                point.updates,
                point.env_steps,
                point.wall_s,
                point.reward,
                if *best { "  best so far" } else { "" }
            );
            say(bar, &line);
        }
    }
}
