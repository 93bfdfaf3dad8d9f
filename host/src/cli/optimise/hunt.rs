//! The searches of one command, watched: progress bar, Ctrl-C, and the report's robots.

use super::Args;
use crate::optimise::basis::Basis;
use crate::optimise::report::{AtAmplitude, OverDraws, TRIAL_S, over_amplitudes, over_draws};
use crate::optimise::score::{Aim, Test};
use crate::optimise::search::{Found, Progress, Search, Start};
use crate::optimise::space::{Bounds, Motion, Space};
use crate::optimise::tolerances::Tolerances;
use crate::robot::Robot;
use indicatif::{ProgressBar, ProgressStyle};
use std::sync::atomic::{AtomicBool, Ordering};

/// Length of a trial of the search; reports take the paper's 12 s.
const SEARCH_TRIAL_S: f64 = 5.0;
/// The report's seed is another than the search's.
const REPORT_SEED: u64 = 0x5eed_0f7e;
/// Reports only play; what was aimed at does not matter to a walk.
const REPORT: Test = Test { aim: Aim::Speed, duration_s: TRIAL_S };
/// Draws at each amplitude: a quarter of the report's.
const AMPLITUDE_SHARE: usize = 4;

/// What all searches of a command share.
pub struct Hunt<'a> {
    pub args: &'a Args,
    pub robot: &'a Robot,
    pub basis: &'a Basis,
    pub stop: &'a AtomicBool,
    pub tolerances: Tolerances,
}

impl Hunt<'_> {
    /// From the start that was asked for.
    pub fn first(&self, aim: Aim, start: &Start, budget: u64) -> Found {
        self.watched(aim, budget, "", |search, progress| search.run(start, progress))
    }

    /// From a gait that was found.
    pub fn next(&self, aim: Aim, from: &Motion, budget: u64, what: &str) -> Found {
        self.watched(aim, budget, what, |search, progress| search.go_on(from, progress))
    }

    fn watched(
        &self,
        aim: Aim,
        budget: u64,
        what: &str,
        go: impl FnOnce(&Search<'_>, &mut dyn FnMut(&Progress<'_>) -> bool) -> Found,
    ) -> Found {
        let bounds = Bounds::of(self.robot);
        let space = |waves| Space::new(self.basis.clone(), bounds, waves);
        let search = Search {
            robot: self.robot,
            space: &space,
            test: Test { aim, duration_s: SEARCH_TRIAL_S },
            tolerances: self.tolerances,
            seed: self.args.seed,
            budget,
        };
        let bar = ProgressBar::new(budget).with_style(
            ProgressStyle::with_template(
                "{prefix}{bar:30} {pos}/{len} trials, {msg}, {elapsed} gone, {eta} to go",
            )
            .unwrap_or_else(|_| ProgressStyle::default_bar()),
        );
        bar.set_prefix(what.to_owned());
        let mut said = 0;
        let found = go(&search, &mut |progress: &Progress<'_>| {
            let words = format!("score {:.3}, {:.2} s a stride", progress.score, progress.motion.period_s);
            bar.set_position(progress.trials);
            // For logs: a line a tenth.
            if bar.is_hidden() && progress.trials >= said + budget / 10 {
                said = progress.trials;
                eprintln!("{what}{said} of {budget} trials, {words}");
            }
            bar.set_message(words);
            !self.stop.load(Ordering::Relaxed)
        });
        bar.finish_and_clear();
        found
    }

    /// A gait over robots that no search has seen.
    pub fn over_draws(&self, motion: &Motion) -> OverDraws {
        let (seed, draws) = (REPORT_SEED ^ self.args.seed, usize::from(self.args.draws));
        over_draws(self.robot, &self.tolerances, &REPORT, motion, 1.0, (seed, draws))
    }

    /// The same from half its stroke to one and a half, over fewer robots.
    pub fn over_amplitudes(&self, motion: &Motion) -> Vec<AtAmplitude> {
        let draws = usize::from(self.args.draws).div_ceil(AMPLITUDE_SHARE);
        over_amplitudes(self.robot, &self.tolerances, &REPORT, motion, (REPORT_SEED ^ self.args.seed, draws))
    }
}
