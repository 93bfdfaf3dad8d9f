//! `host play`: setpoints from this computer, one a frame.
//!
//! For trajectories that no gait table holds, and for a policy in closed loop. Holds
//! the flags and the report. Does not depend on where the poses come from ([`file`] or
//! [`policy`]) or how they are sent ([`crate::device::stream`]).

mod file;
#[cfg(feature = "train")]
mod policy;

use super::ranges::check_range;
use super::reach::{self, Port, interruptible, unreachable_robot};
use super::recording::Recording;
use super::{Cause, Failure};
use crate::device::link::words;
use crate::device::stream::{self, PoseDeg};
use crate::device::trial::{self, Trial, TrialStop};
use crate::run_folder;
use indicatif::{ProgressBar, ProgressStyle};
use protocol::{FRAME_RATE_HZ, JOINT_COUNT, State};
use serde_json::json;
use std::cell::Cell;
use std::path::PathBuf;
use thiserror::Error;

/// Play a trajectory or a policy from this computer.
///
/// The robot gets 60 setpoints a second. A trajectory is played as it is, at its own pace, once or for --seconds:
/// columns of actions as in `fit`, or degrees from neutral with --degrees. With
/// --policy, the policy of a run walks in simulation, and the robot gets the same
/// setpoints as the simulated one.
///
/// The robot moves slowly to the first pose. It stops when a setpoint is late: its
/// buffer holds three, 50 ms.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    recording: Recording,
    /// Play a run's policy in closed loop in the simulation [default run: the last one]
    #[arg(long, value_name = "RUN", num_args = 0..=1, default_missing_value = run_folder::LATEST)]
    #[arg(conflicts_with = "trajectory")]
    policy: Option<PathBuf>,
    /// Columns are degrees from neutral
    #[arg(long, conflicts_with_all = ["policy", "unit_deg", "centre_unit_deg"])]
    degrees: bool,
    /// How long to play; a file starts again at its end [default: the file once, a policy 12 s]
    #[arg(long, value_name = "S")]
    seconds: Option<f64>,
    /// Scale about each joint's mean [default: 1; a policy's own stroke is 1.875]
    #[arg(long = "amp", value_name = "X")]
    amplitude: Option<f64>,
    /// Play what leaves the joint limits, held at the limits
    #[arg(long)]
    clip: bool,
    #[command(flatten)]
    port: Port,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Error)]
enum PlayError {
    #[error(
        "{joint} would go to {angle_deg:.1} degrees at {time_s:.2} s; its limit is {limit_deg} either way"
    )]
    Limits { joint: &'static str, angle_deg: f64, time_s: f64, limit_deg: f64 },
    #[cfg(not(feature = "train"))]
    #[error("this program was built without training, which --policy needs")]
    NoPolicies,
}

/// What is played.
struct Programme {
    /// For people and scripts.
    name: String,
    /// One a frame, in degrees, before limits.
    poses: Box<dyn Iterator<Item = PoseDeg>>,
    /// How many, if they do not end before.
    frames: u32,
    limit_deg: f64,
}

pub fn run(args: Args) -> Result<(), Failure> {
    check_range("seconds", args.seconds, 0.1, 86_400.0)?;
    check_range("amp", args.amplitude, 0.1, 3.0)?;
    let Programme { name, poses, frames, limit_deg } = programme(&args)?;

    let mut link = args.port.connect()?;
    trial::prepare(&mut link).map_err(unreachable_robot)?;
    let stop = interruptible()?;
    let bar = progress_bar(frames, args.json);
    let (sent, clipped) = (Cell::new(0_u32), Cell::new(0_u32));
    let poses = poses.map(|pose| {
        let limited = pose.map(|deg| deg.clamp(-limit_deg, limit_deg));
        sent.set(sent.get() + 1);
        clipped.set(clipped.get() + u32::from(limited != pose));
        limited
    });
    let played = stream::stream(&mut link, poses, &stop, |state: State, played: u32| {
        bar.set_message(words::state(state));
        bar.set_position(u64::from(played));
    });
    bar.finish_and_clear();
    let mut played = played.map_err(unreachable_robot)?;
    let stopped = played.stop.take();
    if stopped.is_none() && sent.get() < frames {
        let fell_s = f64::from(sent.get()) / f64::from(FRAME_RATE_HZ);
        eprintln!("warning: the simulated robot fell after {fell_s:.1} s, which ended it");
    }
    if args.json {
        print_json(&name, &played, clipped.get(), stopped.as_ref());
    } else {
        print_words(&name, &played, clipped.get());
    }
    stopped.map_or(Ok(()), |stop| Err(reach::stopped(stop, "then play it again")))
}

fn programme(args: &Args) -> Result<Programme, Failure> {
    match &args.policy {
        None => file::programme(args),
        #[cfg(feature = "train")]
        Some(run) => policy::programme(args, run),
        #[cfg(not(feature = "train"))]
        Some(_) => Err(super::explain::failure_with_help(
            Cause::Usage,
            PlayError::NoPolicies,
            "build it with training: cargo run -p host -- play",
        )),
    }
}

/// Refuses what leaves the limits, unless `--clip` allows it.
fn check_limits(args: &Args, poses: &[PoseDeg], limit_deg: f64) -> Result<(), Failure> {
    let beyond = (0..poses.len() * JOINT_COUNT)
        .map(|i| (i / JOINT_COUNT, i % JOINT_COUNT))
        .max_by(|&a, &b| poses[a.0][a.1].abs().total_cmp(&poses[b.0][b.1].abs()))
        .filter(|&(frame, joint)| poses[frame][joint].abs() > limit_deg + 1e-9);
    let Some((frame, joint)) = beyond.filter(|_| !args.clip) else { return Ok(()) };
    let error = PlayError::Limits {
        joint: protocol::Joint::ALL[joint].name(),
        angle_deg: poses[frame][joint],
        time_s: frame as f64 / f64::from(FRAME_RATE_HZ),
        limit_deg,
    };
    let help = "take a smaller --amp, or let --clip hold joints at their limits; see --limit-deg";
    Err(super::explain::failure_with_help(Cause::Input, error, help))
}

fn print_words(name: &str, trial: &Trial, clipped: u32) {
    println!("played {name} for {:.2} s, {} frames", trial.duration_s(), trial.frames());
    println!("energy      {:8.3} J", trial.energy_j());
    if trial.frames() > 0 {
        println!("mean power  {:8.3} W", trial.energy_j() / trial.duration_s());
    }
    if clipped > 0 {
        println!("a joint was held at its limit in {clipped} frames");
    }
    if let Some(missed) = trial.last().map(|t| t.missed_samples).filter(|&missed| missed > 0) {
        println!("{missed} power samples failed; the preceding one was used instead");
    }
}

fn print_json(name: &str, trial: &Trial, clipped: u32, stopped: Option<&TrialStop>) {
    let frames = trial.frames();
    let result = json!({
        "played": name,
        "stopped": stopped.map(ToString::to_string),
        "frames_played": frames,
        "duration_s": trial.duration_s(),
        "energy_j": trial.energy_j(),
        "mean_power_w": (frames > 0).then(|| trial.energy_j() / trial.duration_s()),
        "clipped_frames": clipped,
        "missed_samples": trial.last().map_or(0, |t| t.missed_samples),
    });
    println!("{result:#}");
}

fn progress_bar(frames: u32, json: bool) -> ProgressBar {
    if json {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::new(u64::from(frames));
    let style = ProgressStyle::with_template("{msg:9} {bar:40} {pos}/{len} frames");
    bar.with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
}
