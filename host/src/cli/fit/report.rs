//! What a fit came to, for people and for scripts.

use super::Args;
use crate::cli::explain::path_text;
use crate::cli::recording::Chosen;
use crate::fit::{FEW_ROWS, JointFit, R2_WARNING};
use crate::gait_file::limits::round_down;
use crate::gait_file::{GaitFile, gait_sha256};
use crate::run_folder;
use protocol::{Amplitude, JOINT_COUNT, Joint};
use serde_json::json;
use std::path::Path;

/// Strides this uneven at the seam are worth a warning: more than a servo turns in a frame.
const SEAM_WARNING_DEG: f64 = 5.0;

/// What the README's story uploads at.
const USUAL_AMPLITUDE: f64 = 2.2;

/// Prints the table, or with `--json` one object; warnings go to standard error.
pub fn print(args: &Args, out: &Path, gait: &GaitFile, fits: &[JointFit; JOINT_COUNT], chosen: &Chosen) {
    let warnings = warnings(fits, chosen);
    for warning in &warnings {
        eprintln!("warning: {warning}");
    }
    if args.json {
        print_json(out, gait, fits, chosen, &warnings);
    } else {
        print_table(out, gait, fits, chosen);
    }
}

fn warnings(fits: &[JointFit; JOINT_COUNT], chosen: &Chosen) -> Vec<String> {
    let mut warnings = Vec::new();
    for joint in Joint::ALL {
        let fit = &fits[joint.index()];
        if let Some(r2) = fit.series.r2.filter(|&r2| r2 < R2_WARNING) {
            warnings.push(format!(
                "{}: R2 is {r2:.2}, below {R2_WARNING}: the curve does not show what the recording does; \
                 fit fewer strides at a time (--rows)",
                joint.name()
            ));
        }
        if fit.seam_jump_deg.abs() > SEAM_WARNING_DEG {
            warnings.push(format!(
                "{}: strides meet with a step of {:.1} degrees; --seam continuous joins them",
                joint.name(),
                fit.seam_jump_deg
            ));
        }
    }
    let rows = chosen.rows.len();
    if rows < FEW_ROWS {
        warnings.push(format!("{rows} rows are few: below {FEW_ROWS} the curve may swing between them"));
    }
    warnings
}

fn print_table(out: &Path, gait: &GaitFile, fits: &[JointFit; JOINT_COUNT], chosen: &Chosen) {
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
    if let Some(found) = &chosen.found {
        println!(
            "found that stride: it correlates {:.3} with the next, its ends differ by {:.0} % of the movement",
            found.correlation,
            100.0 * found.seam_mismatch
        );
    }
    println!("\njoint  residual RMS     R2   centre   stroke     seam   (degrees at amplitude 1.0)");
    for joint in Joint::ALL {
        let JointFit { series, stroke_deg, seam_jump_deg } = &fits[joint.index()];
        let r2 = series.r2.map_or("still".into(), |r2| format!("{r2:.3}"));
        let residual = series.residual_rms_deg.unwrap_or(0.0);
        println!(
            "{:5}  {residual:12.2}  {r2:>5}  {:7.2}  {stroke_deg:7.2}  {seam_jump_deg:7.2}",
            joint.name(),
            series.centre_deg
        );
    }
    println!("\n{}", reach(gait));
    println!("gait {} in {} and {}", digest(gait), out.display(), out.with_extension("bin").display());
    let largest = gait.largest_amplitude().map_or(USUAL_AMPLITUDE, |l| round_down(l.amplitude));
    let amplitude = largest.min(USUAL_AMPLITUDE);
    if amplitude >= Amplitude::MIN.value() {
        // Without a name, the next command takes the last run's gait.
        let default = Path::new(run_folder::LATEST).join(run_folder::GAIT);
        let is_default =
            default.canonicalize().ok().is_some_and(|path| out.canonicalize().ok() == Some(path));
        let named = if is_default { String::new() } else { format!(" --gait {}", out.display()) };
        println!("Next: cargo run -p host -- upload-gait --amp {amplitude}{named}");
    }
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

fn print_json(
    out: &Path,
    gait: &GaitFile,
    fits: &[JointFit; JOINT_COUNT],
    chosen: &Chosen,
    warnings: &[String],
) {
    let joints: Vec<_> = Joint::ALL
        .into_iter()
        .map(|joint| {
            let JointFit { series, stroke_deg, seam_jump_deg } = &fits[joint.index()];
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
        "warnings": warnings,
    });
    println!("{result:#}");
}
