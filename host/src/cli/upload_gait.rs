//! `host upload-gait`: a gait from its file, or a recording, onto the robot.
//!
//! Owns the flags, the check of the limits at the asked amplitude, and the
//! words; the transfer is [`crate::device::upload`]'s.

mod check;
pub(super) mod material;

use super::explain::{failure, failure_with_help, path_text};
use super::reach::{Port, link_cause, unreachable_robot};
use super::recording::Recording;
use super::{Cause, Failure};
use crate::device::upload::{self, Stage, UploadError, Uploaded};
use crate::gait::gait_file::gait_sha256;
use crate::gait::gait_file::limits::{LeavesLimits, as_typed};
use check::Check;
use indicatif::{ProgressBar, ProgressStyle};
use material::Material;
use protocol::command::Storage;
use protocol::gait::MAX_ROWS;
use protocol::{Amplitude, Calibration};
use serde_json::{Value, json};
use std::path::PathBuf;
use thiserror::Error;

/// Send a gait to the robot, verify and store it.
///
/// The gait becomes active at once or not at all, and so does the amplitude.
/// Both are kept through power-off, unless --ram is given.
///
/// With --sampled, a trajectory is sent as it was recorded, not smoothed: up to
/// 27 rows as they are, more resampled to 27.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Amplitude about each joint's centre, 0.5 to 3.0; 1.875 is a policy's own stroke
    #[arg(long = "amp", value_name = "X")]
    amplitude: f64,
    /// The gait: a readable file, or the bytes of a table (.bin) [default: that of the last run]
    #[arg(long, value_name = "FILE", conflicts_with = "sampled")]
    gait: Option<PathBuf>,
    #[command(flatten)]
    port: Port,
    /// Folder of the robot that it is for [default: the run's, else the Ant with the gait's legs]
    #[arg(long, value_name = "FOLDER")]
    robot: Option<PathBuf>,
    /// Keep it in RAM only: gone at the next reset
    #[arg(long)]
    ram: bool,
    /// Play a gait that leaves the joint limits, held at the limits
    #[arg(long)]
    clip: bool,
    /// Check limits, joint speeds and pulses; move and change nothing
    #[arg(long)]
    dry_run: bool,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
    /// Send the trajectory of the last run, or of the CSV that is named, as samples
    #[arg(long)]
    sampled: bool,
    /// What the robot will call the samples, up to 16 characters [default: from the file]
    #[arg(long, requires = "sampled")]
    name: Option<String>,
    /// Run folder whose trajectory is sent [default: the last run's]
    #[arg(long, value_name = "DIR", requires = "sampled", conflicts_with = "trajectory")]
    run: Option<PathBuf>,
    #[command(flatten, next_help_heading = "With --sampled")]
    recording: Recording,
}

#[derive(Debug, Error)]
enum BadFlag {
    #[error("--amp is {value}; it must be within {} to {}", Amplitude::MIN.value(), Amplitude::MAX.value())]
    Amplitude { value: f64 },
    #[error("{flag} was given, but this uploads a gait, not a recording")]
    NotSampled { flag: &'static str },
}

#[derive(Debug, Error)]
#[error("{path} leaves the joint limits")]
struct Refused {
    path: String,
    source: LeavesLimits,
}

pub fn run(mut args: Args) -> Result<(), Failure> {
    args.recording.run = args.run.take();
    let amplitude = Amplitude::from_f64(args.amplitude)
        .ok_or_else(|| failure(Cause::Usage, BadFlag::Amplitude { value: args.amplitude }))?;
    let material = Material::of(&args)?;
    let clipped_share = clipped_share(&args, &material, amplitude)?;
    if args.dry_run {
        return rehearse(&args, &material, amplitude, clipped_share);
    }

    let mut link = args.port.connect()?;
    let calibration = check::calibration_on(&mut link).map_err(unreachable_robot)?;
    let calibration = (calibration.unwrap_or_else(Calibration::authors), "the robot's".to_owned());
    for warning in Check::of(&material, amplitude, calibration).warnings() {
        eprintln!("warning: {warning}");
    }
    let bar = progress_bar(material.bytes.len(), args.json);
    let outcome = upload::upload(&mut link, &material.bytes, amplitude, !args.ram, |stage, sent| {
        bar.set_message(words_of(stage));
        bar.set_position(sent as u64);
    });
    bar.finish_and_clear();
    let uploaded = outcome.map_err(failed)?;

    if args.json {
        let mut result = to_json(&material, clipped_share);
        let more = json!({
            "port": link.name(),
            "gait_crc32": format!("{:08x}", uploaded.gait.crc32),
            "amplitude": as_typed(uploaded.gait.amplitude),
            "saved": uploaded.storage == Storage::Saved,
            "transfer_s": uploaded.transfer.as_secs_f64(),
            "total_s": uploaded.total.as_secs_f64(),
        });
        merge(&mut result, more);
        println!("{result:#}");
    } else {
        print_words(&uploaded, &material, clipped_share);
        if uploaded.storage == Storage::Saved {
            println!("Next: cargo run -p host -- measure{}", args.port.as_flag());
        }
    }
    Ok(())
}

/// Everything but the upload.
fn rehearse(
    args: &Args,
    material: &Material,
    amplitude: Amplitude,
    clipped_share: f64,
) -> Result<(), Failure> {
    let check = Check::of(material, amplitude, check::calibration(&args.port)?);
    if !args.clip {
        check.verdict()?;
    }
    let warnings = check.warnings();
    for warning in &warnings {
        eprintln!("warning: {warning}");
    }
    if args.json {
        let mut result = to_json(material, clipped_share);
        merge(&mut result, json!({ "dry_run": true, "amplitude": args.amplitude, "warnings": warnings }));
        merge(&mut result, check.to_json());
        println!("{result:#}");
        return Ok(());
    }
    let (name, period_s) = (material.playable.encoded().name(), material.period_s());
    println!("gait \"{}\" at {}x, a stride in {period_s:.3} s", name.as_str(), args.amplitude);
    print_samples(material);
    print_clipped(clipped_share);
    check.print();
    println!("{} bytes could be uploaded; nothing was", material.bytes.len());
    Ok(())
}

fn to_json(material: &Material, clipped_share: f64) -> Value {
    let sampled = material.sampled.as_ref().map(|sampled| {
        json!({
            "rows": sampled.table.rows.as_slice().len(),
            "recorded_rows": sampled.recorded_rows,
            "step_deg": sampled.step_deg,
            "worst_deg": sampled.worst_deg,
        })
    });
    json!({
        "gait": path_text(&material.path),
        "gait_name": material.playable.encoded().name().as_str(),
        "gait_sha256": gait_sha256(&material.bytes),
        "gait_source": material.source,
        "period_s": material.period_s(),
        "clipped_share": clipped_share,
        "sampled": sampled,
    })
}

/// Adds the fields of one object to another.
fn merge(object: &mut Value, more: Value) {
    if let (Value::Object(fields), Value::Object(more)) = (object, more) {
        fields.extend(more);
    }
}

fn print_samples(material: &Material) {
    let Some(sampled) = &material.sampled else { return };
    let rows = sampled.table.rows.as_slice().len();
    let resampled = if sampled.recorded_rows > rows {
        format!("{rows} rows, of {} recorded: a robot takes {MAX_ROWS}", sampled.recorded_rows)
    } else {
        format!("{rows} rows as recorded; a robot takes up to {MAX_ROWS}")
    };
    println!(
        "{resampled}; steps of {:.2} degree, at most {:.2} degree off the recording at 1x",
        sampled.step_deg, sampled.worst_deg
    );
}

fn print_clipped(clipped_share: f64) {
    if clipped_share > 0.0 {
        println!("joints will be held at their limits during {:.1} % of each stride", 100.0 * clipped_share);
    }
}

fn print_words(uploaded: &Uploaded, material: &Material, clipped_share: f64) {
    let gait = &uploaded.gait;
    println!(
        "the robot has gait \"{}\" (CRC {:08x}) at {}x",
        gait.name.as_str(),
        gait.crc32,
        as_typed(gait.amplitude)
    );
    println!("sha256 {}", gait_sha256(&material.bytes));
    print_samples(material);
    print_clipped(clipped_share);
    let (len, transfer_ms) = (material.bytes.len(), uploaded.transfer.as_millis());
    match uploaded.storage {
        Storage::Saved => println!(
            "{len} bytes transferred and verified in {transfer_ms} ms, saved in {:.2} s",
            uploaded.total.as_secs_f64()
        ),
        _ => println!(
            "{len} bytes transferred and verified in {transfer_ms} ms; in RAM only: \
             the next reset brings back the gait saved before"
        ),
    }
}

/// Share of the stride at the limits: 0 unless `--clip` allows more.
fn clipped_share(args: &Args, material: &Material, amplitude: Amplitude) -> Result<f64, Failure> {
    match material.check_limits(args.amplitude) {
        Ok(()) => Ok(0.0),
        Err(_) if args.clip => Ok(material.clipped_share(amplitude)),
        Err(source) => {
            let help = match source.largest {
                Some(largest) => format!(
                    "the largest amplitude that fits is {largest}: --amp {largest}; or --clip holds joints at their limits"
                ),
                None => format!(
                    "no amplitude from {} fits this gait: fit it with other scales or limits; \
                     or --clip holds joints at their limits",
                    Amplitude::MIN.value()
                ),
            };
            let refused = Refused { path: material.path.display().to_string(), source };
            Err(failure_with_help(Cause::Input, refused, help))
        }
    }
}

fn failed(error: UploadError) -> Failure {
    match &error {
        UploadError::Link { source, .. } => {
            let cause = link_cause(source);
            match source.help() {
                Some(help) => failure_with_help(cause, error, help),
                None => failure(cause, error),
            }
        }
        UploadError::TooLong { .. } | UploadError::Amplitude { .. } => failure(Cause::Input, error),
        UploadError::Differs { .. } => failure_with_help(Cause::Robot, error, "repeat the upload"),
        UploadError::NotSaved | UploadError::SaveTimeout => failure_with_help(
            Cause::Robot,
            error,
            "the gait is active until the next reset; the one saved before is intact. Repeat the upload; \
             if it fails again, the EEPROM is worn out: --ram does without it",
        ),
    }
}

fn progress_bar(len: usize, json: bool) -> ProgressBar {
    if json {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::new(len as u64);
    let style = ProgressStyle::with_template("{msg:12} {bar:40} {pos}/{len} bytes");
    bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
    bar
}

const fn words_of(stage: Stage) -> &'static str {
    match stage {
        Stage::Transfer => "transferring",
        Stage::Commit => "activating",
        Stage::Verify => "verifying",
        Stage::Save => "saving",
    }
}
