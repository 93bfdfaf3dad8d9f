//! The result of a fit, for people and for scripts.
//!
//! Does not depend on how it was made.

use super::joined::Joined;
use super::{Args, Fitted, USUAL_AMPLITUDE};
use crate::cause_chain::message_of;
use crate::cli::explain::{path_text, warn};
use crate::gait::fit::{FEW_ROWS, JointFit, R2_WARNING, Seam};
use crate::gait::gait_file::limits::{as_typed, round_down};
use crate::gait::gait_file::{GaitFile, gait_sha256};
use crate::run_folder;
use protocol::{Amplitude, Joint};
use serde_json::{Value, json};
use std::path::Path;

/// Prints the table, or with `--json` one object; warnings go to standard error.
pub fn print(args: &Args, fitted: &Fitted) {
    let warnings = warnings(fitted);
    for warning in &warnings {
        warn(warning);
    }
    if args.json {
        print_json(fitted, &warnings);
    } else {
        print_words(fitted);
    }
}

fn warnings(Fitted { seams, pace, crowded_strides, comparison, chosen, .. }: &Fitted) -> Vec<String> {
    let mut warnings = Vec::new();
    let poor: Vec<String> = Joint::ALL
        .into_iter()
        .zip(&seams.taken.fits)
        .filter_map(|(joint, fit)| fit.series.r2.map(|r2| (joint, r2)))
        .filter(|&(_, r2)| r2 < R2_WARNING)
        .map(|(joint, r2)| format!("{} ({r2:.2})", joint.name()))
        .collect();
    if !poor.is_empty() {
        let fewer = match crowded_strides {
            Some(strides) => format!(
                "it must follow {strides:.1} strides; record the stride itself: host record without --window"
            ),
            None => "fit fewer strides at a time (--rows)".to_owned(),
        };
        warnings.push(format!(
            "R2 is below {R2_WARNING} of {}: the curve does not follow the recording; {fewer}",
            poor.join(", ")
        ));
    }
    for (joint, fit) in Joint::ALL.into_iter().zip(&seams.taken.fits) {
        let frames = fit.seam_jump_deg.abs() / pace.frame_deg();
        if frames > 1.0 {
            warnings.push(format!(
                "{}: strides meet with a step of {:.1} degrees, for which its servo takes {frames:.1} frames; \
                 --seam continuous joins them",
                joint.name(),
                fit.seam_jump_deg
            ));
        }
    }
    let rows = chosen.rows.len();
    if rows < FEW_ROWS {
        warnings.push(format!("{rows} rows are few: below {FEW_ROWS} the curve may swing between them"));
    }
    warnings.extend(pace.warning(seams));
    match comparison {
        Ok(comparison) => warnings.extend(comparison.as_ref().and_then(|comparison| comparison.warning())),
        Err(error) => warnings.push(format!("not compared with the policy: {}", message_of(error))),
    }
    warnings
}

fn print_words(fitted: &Fitted) {
    let Fitted { out, gait, pace, comparison, chosen, .. } = fitted;
    println!(
        "{}: rows {}..{} of {}, {:.3} s recorded, {:.3} s played, seam {}",
        gait.name,
        chosen.rows.start,
        chosen.rows.end,
        chosen.path.display(),
        chosen.recorded_s,
        gait.period_s,
        gait.provenance.seam.as_deref().unwrap_or_default()
    );
    println!(
        "1 unit of the recording is taken for {} degrees about the centre, {} degrees at the centre; \
         radians: --unit-deg 57.2958 --centre-unit-deg 57.2958",
        chosen.scale.unit_deg, chosen.scale.centre_unit_deg
    );
    if let Some(found) = &chosen.found {
        println!(
            "found that stride: it correlates {:.3} with the next, its ends differ by {:.0} % of the movement",
            found.correlation,
            100.0 * found.seam_mismatch
        );
    }
    print_table(fitted);
    println!("\n{}", reach(gait));
    match pace.largest_followed {
        Some(a) if a >= Amplitude::MAX.value() => println!("the servos follow it at every amplitude"),
        Some(amplitude) => println!("the servos follow it up to {amplitude}x"),
        None => println!("the servos follow it at no amplitude"),
    }
    if let Ok(Some(comparison)) = comparison {
        println!("{}", comparison.words(gait.period_s));
    }
    println!("gait {} in {} and {}", digest(gait), out.display(), out.with_extension("bin").display());
    if let Some(amplitude) = next_amplitude(fitted) {
        // Without a name, the next command takes the last run's gait.
        let default = Path::new(run_folder::LATEST).join(run_folder::GAIT);
        let is_default =
            default.canonicalize().ok().is_some_and(|path| out.canonicalize().ok() == Some(path));
        let named = if is_default { String::new() } else { format!(" --gait {}", out.display()) };
        println!("Next: cargo run -p host -- upload-gait --amp {amplitude}{named}");
    }
}

/// The usual amplitude, as far as limits and servos let it; none if they let none.
fn next_amplitude(Fitted { gait, pace, .. }: &Fitted) -> Option<f64> {
    let fits = gait.largest_amplitude().map_or(USUAL_AMPLITUDE, |l| round_down(l.amplitude));
    let amplitude = fits.min(pace.largest_followed?).min(USUAL_AMPLITUDE);
    (amplitude >= Amplitude::MIN.value()).then_some(amplitude)
}

/// Both seams side by side, within 100 columns.
fn print_table(Fitted { seams, pace, .. }: &Fitted) {
    let own = seams.own_stroke.map_or(String::new(), |amplitude| format!("{:.2}x", amplitude.value()));
    let other = |seam| if seam == seams.seam() { "" } else { ", not in the gait" };
    let head = |seam: Seam| format!("seam {}{}", seam.name(), other(seam));
    println!("\n{:24}| {:34} | {}", "", head(Seam::Continuous), head(Seam::Free));
    let columns = format!("{:>6}{:>7}{:>7}{:>7}{own:>7}", "RMS", "R2", "jump", "1.0x");
    println!("{:6}{:>8}{:>9} | {columns} | {columns}", "joint", "centre", "stroke");
    for joint in Joint::ALL {
        let JointFit { series, stroke_deg, .. } = &seams.taken.fits[joint.index()];
        let side = |seam| seams.with(seam).map_or("no such gait".into(), |joined| side(joined, joint));
        println!(
            "{:6}{:8.2}{stroke_deg:9.2} | {:34} | {}",
            joint.name(),
            series.centre_deg,
            side(Seam::Continuous),
            side(Seam::Free)
        );
    }
    println!("degrees at amplitude 1.0; R2: share of the trajectory's variance that the curve keeps;");
    println!("jump: from a stride's end to the next one's start;");
    let own = seams.own_stroke.map_or(String::new(), |_| format!(" and {own}, the policy's own stroke"));
    println!(
        "1.0x{own}: peak joint speed, the seam included, in degrees/s; the servos do {:.0}",
        pace.servo_deg_s
    );
}

/// One joint with one seam.
fn side(joined: &Joined, joint: Joint) -> String {
    let JointFit { series, seam_jump_deg, .. } = &joined.fits[joint.index()];
    let r2 = series.r2.map_or("still".into(), |r2| format!("{r2:.3}"));
    let at_one = joined.at_one[joint.index()].deg_s();
    let own =
        joined.at_own_stroke.map_or(String::new(), |peaks| format!("{:.0}", peaks[joint.index()].deg_s()));
    // Not -0.00: a continuous seam's jump is rounding.
    let jump = if seam_jump_deg.abs() < 0.005 { 0.0 } else { *seam_jump_deg };
    format!("{:6.2}{r2:>7}{jump:7.2}{at_one:7.0}{own:>7}", series.residual_rms_deg.unwrap_or(0.0))
}

/// How far the gait may be amplified, in words.
fn reach(gait: &GaitFile) -> String {
    let (least, most) = (Amplitude::MIN.value(), Amplitude::MAX.value());
    match gait.largest_amplitude() {
        Some(l) if l.amplitude < least => format!(
            "no amplitude from {least} fits: {} meets its limit of {:.0} degrees at {:.2}",
            l.joint.name(),
            l.limit_deg,
            round_down(l.amplitude)
        ),
        Some(l) if l.amplitude < most => format!(
            "largest amplitude that fits: {:.2}, where {} meets its limit of {:.0} degrees at phase {:.2}",
            round_down(l.amplitude),
            l.joint.name(),
            l.limit_deg,
            l.phase
        ),
        _ => format!("every amplitude up to {most} fits the limits"),
    }
}

fn digest(gait: &GaitFile) -> String {
    gait.encoded().map(|bytes| gait_sha256(&bytes)).unwrap_or_default()
}

fn print_json(fitted: &Fitted, warnings: &[String]) {
    let Fitted { out, gait, seams, pace, comparison, chosen, .. } = fitted;
    let joints: Vec<_> = Joint::ALL
        .into_iter()
        .map(|joint| {
            let JointFit { series, stroke_deg, seam_jump_deg } = &seams.taken.fits[joint.index()];
            json!({
                "name": joint.name(),
                "residual_rms_deg": series.residual_rms_deg,
                "r2": series.r2,
                "centre_deg": series.centre_deg,
                "stroke_deg": stroke_deg,
                "seam_jump_deg": seam_jump_deg,
            })
        })
        .collect();
    let largest = gait.largest_amplitude();
    let result = json!({
        "gait": path_text(out),
        "gait_bytes": path_text(&out.with_extension("bin")),
        "gait_sha256": digest(gait),
        "gait_source": gait.provenance.source.name(),
        "name": gait.name,
        "seed": gait.provenance.seed,
        "rows": [chosen.rows.start, chosen.rows.end],
        "recorded_s": chosen.recorded_s,
        "period_s": gait.period_s,
        "seam": gait.provenance.seam,
        "unit_deg": gait.unit_deg,
        "largest_amplitude": largest.map(|l| round_down(l.amplitude)),
        "limiting_joint": largest.map(|l| l.joint.name()),
        "joints": joints,
        "own_stroke_amplitude": seams.own_stroke.map(as_typed),
        "servo_deg_s": pace.servo_deg_s,
        "largest_followed_amplitude": pace.largest_followed,
        "seams": {
            "free": seams.with(Seam::Free).map(seam_to_json),
            "continuous": seams.with(Seam::Continuous).map(seam_to_json),
        },
        "open_loop": comparison.as_ref().ok(),
        "next_amplitude": next_amplitude(fitted),
        "warnings": warnings,
    });
    println!("{result:#}");
}

fn seam_to_json(joined: &Joined) -> Value {
    let joint = |joint: Joint| {
        let JointFit { series, seam_jump_deg, .. } = &joined.fits[joint.index()];
        let own = joined.at_own_stroke.map(|peaks| peaks[joint.index()]);
        json!({
            "name": joint.name(),
            "residual_rms_deg": series.residual_rms_deg,
            "r2": series.r2,
            "seam_jump_deg": seam_jump_deg,
            "peak_deg_s": joined.at_one[joint.index()].deg_s(),
            "peak_deg_s_own_stroke": own.map(|peak| peak.deg_s()),
            "curve_peak_deg_s": joined.at_one[joint.index()].curve_deg_s,
            "curve_peak_deg_s_own_stroke": own.map(|peak| peak.curve_deg_s),
        })
    };
    json!({ "joints": Joint::ALL.map(joint) })
}
