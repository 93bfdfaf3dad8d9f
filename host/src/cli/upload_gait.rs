//! `host upload-gait`: sends a gait from its file, or a recording, to the robot.
//!
//! Holds the flags, the check of the limits at the asked amplitude, and the report.
//! Does not depend on the transfer ([`crate::device::upload`]).

mod check;

use super::agreement;
use super::explain::{failure, failure_with_help, path_text};
use super::material::Material;
use super::output;
use super::ranges::amplitude_flag;
use super::reach::{Port, link_cause, unreachable_robot};
use super::recording::Recording;
use super::robots::{self, RobotArg};
use super::{Cause, Failure};
use crate::device::upload::upload_result::{GaitResult, SampledResult, UploadResult};
use crate::device::upload::{self, Stage, UploadError, Uploaded};
use crate::gait::gait_file::gait_sha256;
use crate::gait::gait_file::limits::{LeavesLimits, as_typed};
use crate::robot::BeyondRange;
use crate::run_folder;
use check::Check;
use indicatif::{ProgressBar, ProgressStyle};
use protocol::command::Storage;
use protocol::gait::MAX_ROWS;
use protocol::{Amplitude, Calibration};
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Send a gait to the robot, verify and store it.
///
/// The gait and its amplitude become active together, or not at all.
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
    /// Upload another robot's gait, or to a robot that is not calibrated as described
    #[arg(long)]
    anyway: bool,
    /// Keep it in RAM only, until the next reset
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
    /// Name on the robot, up to 16 characters [default: from the file]
    #[arg(long, requires = "sampled")]
    name: Option<String>,
    /// Run folder whose trajectory is sent [default: the last run's]
    #[arg(long, value_name = "DIR", requires = "sampled", conflicts_with = "trajectory")]
    run: Option<PathBuf>,
    #[command(flatten, next_help_heading = "With --sampled")]
    recording: Recording,
}

#[derive(Debug, Error)]
#[error("{flag} was given, but this uploads a gait, not a recording")]
struct NotSampled {
    flag: &'static str,
}

#[derive(Debug, Error)]
#[error("{path} leaves the joint limits")]
struct Refused {
    path: String,
    source: LeavesLimits,
}

#[derive(Debug, Error)]
#[error("{path} leaves the joints' ranges of {robot}")]
struct BeyondRobot {
    path: String,
    robot: String,
    source: BeyondRange,
}

pub fn run(mut args: Args) -> Result<(), Failure> {
    args.recording.run = args.run.take();
    let amplitude = amplitude_flag(args.amplitude)?;
    let material = material(&args)?;
    robots::warn_of(&material.robot);
    check_range(&args, &material)?;
    let clipped_share = clipped_share(&args, &material, amplitude)?;
    if args.dry_run {
        return rehearse(&args, &material, amplitude, clipped_share);
    }

    let mut link = args.port.connect()?;
    if let Some(differs) = agreement::check(&mut link, &material.robot, args.anyway, &args.port)? {
        eprintln!("warning: the robot is {differs}");
    }
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
        output::print_json(&UploadResult {
            gait: gait_result(&material, clipped_share),
            port: link.name().to_owned(),
            gait_crc32: format!("{:08x}", uploaded.gait.crc32),
            amplitude: as_typed(uploaded.gait.amplitude),
            saved: uploaded.storage == Storage::Saved,
            transfer_s: uploaded.transfer.as_secs_f64(),
            total_s: uploaded.total.as_secs_f64(),
        });
    } else {
        print_words(&uploaded, &material, clipped_share);
        if uploaded.storage == Storage::Saved {
            println!("Next: cargo run -p host -- measure{}", args.port.as_flag());
        }
    }
    Ok(())
}

/// Reads what the flags name.
fn material(args: &Args) -> Result<Material, Failure> {
    if args.sampled {
        return Material::sampled(&args.recording, args.name.as_deref(), args.robot.as_deref());
    }
    if let Some(flag) = args.recording.given() {
        let help = "add --sampled to play the recording as it is; or fit it first: host fit";
        return Err(failure_with_help(Cause::Usage, NotSampled { flag }, help));
    }
    let default = || Path::new(run_folder::LATEST).join(run_folder::GAIT);
    let path = args.gait.clone().unwrap_or_else(default);
    Material::load(path, RobotArg::folder(args.robot.as_deref()), args.anyway)
}

/// Everything but the upload.
fn rehearse(
    args: &Args,
    material: &Material,
    amplitude: Amplitude,
    clipped_share: f64,
) -> Result<(), Failure> {
    let check = Check::of(material, amplitude, check::calibration(&args.port, &material.robot)?);
    if !args.clip {
        check.verdict()?;
    }
    let warnings = check.warnings();
    for warning in &warnings {
        eprintln!("warning: {warning}");
    }
    if args.json {
        let gait = gait_result(material, clipped_share);
        output::print_json(&check.result(gait, args.amplitude, warnings));
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

fn gait_result(material: &Material, clipped_share: f64) -> GaitResult {
    let sampled = material.sampled.as_ref().map(|sampled| SampledResult {
        rows: sampled.table.rows.as_slice().len(),
        recorded_rows: sampled.recorded_rows,
        step_deg: sampled.step_deg,
        worst_deg: sampled.worst_deg,
    });
    GaitResult {
        gait: path_text(&material.path),
        gait_name: material.playable.encoded().name().as_str().to_owned(),
        gait_sha256: gait_sha256(&material.bytes),
        gait_source: material.source.to_owned(),
        period_s: material.period_s(),
        clipped_share,
        sampled,
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

/// Refuses a gait that turns joints farther than the robot lets them: its servos would
/// stall at their ends. `--clip` holds joints at the gait's own limits, not the robot's.
fn check_range(args: &Args, material: &Material) -> Result<(), Failure> {
    let asked_deg = material.playable.asked_deg(args.amplitude, args.clip);
    material.robot.check_range(&asked_deg).map_err(|source| {
        let help = "take a smaller amplitude, or a gait that was fitted for this robot (host fit --robot FOLDER); \
                    or correct the joint's range or joint_limit_deg";
        let path = material.path.display().to_string();
        failure_with_help(Cause::Input, BeyondRobot { path, robot: material.robot.name.clone(), source }, help)
    })
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
             if it fails again, the EEPROM is worn out: --ram does not use it",
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
