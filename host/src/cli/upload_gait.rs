//! `host upload-gait`: a gait from its file onto the robot.
//!
//! Owns the flags, the check of the limits at the asked amplitude, and the
//! words; the transfer is [`crate::upload`]'s.

use super::explain::{failure, failure_with_help, path_text};
use super::reach::{Port, link_cause};
use super::{Cause, Failure};
use crate::gait_file::limits::{LeavesLimits, as_typed};
use crate::gait_file::{GaitFile, GaitFileError, gait_sha256};
use crate::run_folder;
use crate::upload::{self, Stage, UploadError, Uploaded};
use indicatif::{ProgressBar, ProgressStyle};
use protocol::Amplitude;
use protocol::command::Storage;
use serde_json::json;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Send a gait to the robot, verify and store it.
///
/// The gait becomes active at once or not at all, and so does the amplitude.
/// Both are kept through power-off, unless --ram is given.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Amplitude about each joint's centre, 0.5 to 3.0; 1.875 is a policy's own stroke
    #[arg(long = "amp", value_name = "X")]
    amplitude: f64,
    /// The gait: a readable file, or the bytes of a table (.bin) [default: that of the last run]
    #[arg(long, value_name = "FILE")]
    gait: Option<PathBuf>,
    #[command(flatten)]
    port: Port,
    /// Keep it in RAM only: gone at the next reset
    #[arg(long)]
    ram: bool,
    /// Play a gait that leaves the joint limits, held at the limits
    #[arg(long)]
    clip: bool,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Error)]
enum BadFlag {
    #[error("--amp is {value}; it must be within {} to {}", Amplitude::MIN.value(), Amplitude::MAX.value())]
    Amplitude { value: f64 },
}

#[derive(Debug, Error)]
#[error("{path} leaves the joint limits")]
struct Refused {
    path: String,
    source: LeavesLimits,
}

pub fn run(args: Args) -> Result<(), Failure> {
    let amplitude = Amplitude::from_f64(args.amplitude)
        .ok_or_else(|| failure(Cause::Usage, BadFlag::Amplitude { value: args.amplitude }))?;
    let path = args.gait.clone().unwrap_or_else(|| Path::new(run_folder::LATEST).join(run_folder::GAIT));
    let gait = GaitFile::load(&path).map_err(unreadable)?;
    let table = gait.encoded().map_err(|e| failure(Cause::Input, e))?;
    let clipped_share = clipped_share(&args, &path, &gait)?;

    let mut link = args.port.connect()?;
    let bar = progress_bar(table.len(), args.json);
    let outcome = upload::upload(&mut link, &table, amplitude, !args.ram, |stage, sent| {
        bar.set_message(words_of(stage));
        bar.set_position(sent as u64);
    });
    bar.finish_and_clear();
    let uploaded = outcome.map_err(failed)?;

    let sha256 = gait_sha256(&table);
    if args.json {
        let result = json!({
            "port": link.name(),
            "gait": path_text(&path),
            "gait_name": uploaded.gait.name.as_str(),
            "gait_crc32": format!("{:08x}", uploaded.gait.crc32),
            "gait_sha256": sha256,
            "gait_source": gait.provenance.source.name(),
            "amplitude": as_typed(uploaded.gait.amplitude),
            "period_s": gait.period_s,
            "clipped_share": clipped_share,
            "saved": uploaded.storage == Storage::Saved,
            "transfer_s": uploaded.transfer.as_secs_f64(),
            "total_s": uploaded.total.as_secs_f64(),
        });
        println!("{result:#}");
    } else {
        print_words(&uploaded, &sha256, table.len(), clipped_share);
        if uploaded.storage == Storage::Saved {
            println!("Next: cargo run -p host -- measure{}", args.port.as_flag());
        }
    }
    Ok(())
}

fn print_words(uploaded: &Uploaded, sha256: &str, len: usize, clipped_share: f64) {
    let gait = &uploaded.gait;
    println!(
        "the robot has gait \"{}\" (CRC {:08x}) at {}x",
        gait.name.as_str(),
        gait.crc32,
        as_typed(gait.amplitude)
    );
    println!("sha256 {sha256}");
    if clipped_share > 0.0 {
        println!("joints will be held at their limits during {:.1} % of each stride", 100.0 * clipped_share);
    }
    let transfer_ms = uploaded.transfer.as_millis();
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
fn clipped_share(args: &Args, path: &Path, gait: &GaitFile) -> Result<f64, Failure> {
    match gait.check_limits(args.amplitude) {
        Ok(()) => Ok(0.0),
        Err(_) if args.clip => Ok(gait.clipped_share(args.amplitude)),
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
            let refused = Refused { path: path.display().to_string(), source };
            Err(failure_with_help(Cause::Input, refused, help))
        }
    }
}

fn unreadable(error: GaitFileError) -> Failure {
    let help = match &error {
        GaitFileError::File(_) => "`host fit` writes runs/latest/gait.toml; or name another: --gait FILE",
        GaitFileError::Bytes { .. } => "copy the file again, or use the gait.toml beside it",
        GaitFileError::Parse { .. } | GaitFileError::Unusable { .. } => "write it anew with `host fit`",
    };
    failure_with_help(Cause::Input, error, help)
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
