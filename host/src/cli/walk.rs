//! `host walk`: lets the robot walk, with this program or without.
//!
//! Holds the flags and the report; [`lines`] takes the changes that can be typed
//! meanwhile. Does not depend on how the robot is kept walking ([`crate::device::trial`]).

mod lines;

use super::explain::failure;
use super::ranges::{self, BadNumber};
use super::reach::{self, Port, interruptible, unreachable_robot};
use super::{Cause, Failure};
use crate::device::link::ports::SerialLink;
use crate::device::link::{LinkError, words};
use crate::device::trial::{self, Order, Trial, TrialStop};
use crate::gait::gait_file::limits::as_typed;
use crate::gait::gait_player::Playable;
use lines::{Lines, WalkConsole};
use protocol::command::{ActiveGait, Record};
use protocol::{Amplitude, Command, FRAME_RATE_HZ, Refusal, Speed, WalkEnd};
use serde_json::json;
use thiserror::Error;

/// Shortest and longest walk that can be asked for.
const FOR_RANGE_S: (f64, f64) = (0.1, 86_400.0);

/// Let the robot walk, attached or by itself, and print its energy.
///
/// Attached, which is the default, the robot depends on this program: Ctrl-C stops
/// it, and an unplugged cable does within a second. Meanwhile type `amp 1.8`,
/// `speed 0.5`, `pause`, `resume` or `stop`, and Enter.
///
/// With --detached it walks on by itself, until its time is over or it is
/// stopped: `host stop`, its button, or a fault.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Stop after this many seconds [default: walk until stopped]
    #[arg(long = "for", value_name = "S")]
    seconds: Option<f64>,
    /// Walk on without this program; needs --for
    #[arg(long, requires = "seconds")]
    detached: bool,
    /// Amplitude of this walk, 0.5 to 3.0 [default: as uploaded]
    #[arg(long = "amp", value_name = "X")]
    amplitude: Option<f64>,
    /// Speed, 0 to 2; 1 is the gait's own period
    #[arg(long, value_name = "X", conflicts_with = "period")]
    speed: Option<f64>,
    /// Duration of one stride in seconds, instead of --speed
    #[arg(long, value_name = "S")]
    period: Option<f64>,
    /// Rehearse: everything happens but the pulses, and the servos stay limp
    #[arg(long, conflicts_with = "detached")]
    dry_run: bool,
    /// Walk even if joints are held at their limits at this amplitude
    #[arg(long)]
    clip: bool,
    /// Take changes from standard input even if it is not a terminal
    #[arg(long, conflicts_with = "detached")]
    stdin: bool,
    #[command(flatten)]
    port: Port,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Error)]
enum WalkError {
    #[error("--for is {value} s; it must be within {} to {}", FOR_RANGE_S.0, FOR_RANGE_S.1)]
    Seconds { value: f64 },
    #[error(transparent)]
    Number(#[from] BadNumber),
    #[error(
        "--period is {asked_s} s; the gait's own is {own_s} s, and it can be played in {} s or more",
        own_s / Speed::MAX.value()
    )]
    Period { asked_s: f64, own_s: f64 },
}

/// What the robot is about to walk.
struct Plan {
    gait: ActiveGait,
    amplitude: Amplitude,
    order: Order,
    /// The gait whose limits are to be kept.
    kept_within: Option<Playable>,
}

pub fn run(args: Args) -> Result<(), Failure> {
    let frames = check_flags(&args).map_err(|e| failure(Cause::Usage, e))?;
    let mut link = args.port.connect()?;
    trial::prepare(&mut link).map_err(unreachable_robot)?;
    let plan = plan(&mut link, &args, frames)?;
    if args.detached { detached(&mut link, &args, &plan) } else { attached(&mut link, &args, &plan) }
}

fn check_flags(args: &Args) -> Result<Option<u32>, WalkError> {
    if let Some(value) = args.seconds.filter(|s| !(FOR_RANGE_S.0..=FOR_RANGE_S.1).contains(s)) {
        return Err(WalkError::Seconds { value });
    }
    args.amplitude.map(ranges::amplitude).transpose()?;
    args.speed.map(ranges::speed).transpose()?;
    Ok(args.seconds.map(|seconds| (seconds * f64::from(FRAME_RATE_HZ)).round() as u32))
}

fn plan(link: &mut SerialLink, args: &Args, frames: Option<u32>) -> Result<Plan, Failure> {
    let no_gait = || LinkError::Refused { command: "walk", refusal: Refusal::NoGait };
    let status = link.status().map_err(unreachable_robot)?;
    let gait = status.gait.ok_or_else(|| unreachable_robot(no_gait()))?;
    let bytes = link.read(Record::Gait).map_err(unreachable_robot)?;
    let playable = Playable::from_bytes(&bytes).map_err(|_| unreachable_robot(no_gait()))?;
    let asked = args.amplitude.and_then(Amplitude::from_f64);
    let amplitude = asked.unwrap_or(gait.amplitude);
    if asked.is_some() && !args.clip {
        playable.check_limits(as_typed(amplitude)).map_err(reach::beyond_limits)?;
    }
    let speed = match args.period {
        Some(asked_s) => {
            let own_s = playable.period_s();
            let speed = Speed::from_f64(own_s / asked_s).filter(|speed| *speed != Speed::PAUSED);
            speed.ok_or_else(|| failure(Cause::Usage, WalkError::Period { asked_s, own_s }))?
        }
        None => args.speed.and_then(Speed::from_f64).unwrap_or(Speed::ONE),
    };
    let order = Order { frames, amplitude: asked, speed, dry_run: args.dry_run };
    Ok(Plan { gait, amplitude, order, kept_within: (!args.clip).then_some(playable) })
}

fn detached(link: &mut SerialLink, args: &Args, plan: &Plan) -> Result<(), Failure> {
    let Order { frames, amplitude, speed, dry_run } = plan.order;
    link.order(Command::Walk { amplitude, frames, detached: true, dry_run }).map_err(unreachable_robot)?;
    if speed != Speed::ONE {
        link.order(Command::SetSpeed(speed)).map_err(unreachable_robot)?;
    }
    let state = link.status().map_err(unreachable_robot)?.state;
    let seconds = args.seconds.unwrap_or_default();
    if args.json {
        let result = json!({
            "detached": true,
            "state": words::state(state),
            "gait_name": plan.gait.name.as_str(),
            "amplitude": as_typed(plan.amplitude),
            "speed": speed.value(),
            "for_s": seconds,
        });
        println!("{result:#}");
        return Ok(());
    }
    let port = args.port.as_flag();
    println!(
        "the robot walks \"{}\" at {}x by itself for {seconds} s, then stands and goes limp",
        plan.gait.name.as_str(),
        as_typed(plan.amplitude),
    );
    println!("Stop it before: cargo run -p host -- stop{port}, its button, or its supply's switch");
    println!("Afterwards: cargo run -p host -- measure --last{port}");
    Ok(())
}

fn attached(link: &mut SerialLink, args: &Args, plan: &Plan) -> Result<(), Failure> {
    let stop = interruptible()?;
    let mut console =
        WalkConsole::new(plan.order.frames, args.json, Lines::open(args.stdin), plan.kept_within.clone());
    let trial = trial::walk(link, &plan.order, &stop, &mut console);
    console.finish();
    let mut trial = trial.map_err(unreachable_robot)?;
    let stopped = trial.stop.take().filter(|stop| {
        // It was typed: the walk ended as it was meant to.
        !(matches!(stop, TrialStop::Ended { end: WalkEnd::Asked, .. }) && console.stop_was_typed())
    });
    let end = if console.stop_was_typed() { WalkEnd::Asked } else { WalkEnd::Finished };
    let ended = stopped.as_ref().map_or(words::walk_end(end).to_owned(), ToString::to_string);
    if args.json {
        print_json(&trial, plan, &console, stopped.as_ref());
    } else {
        print_words(&trial, plan, &ended);
    }
    stopped.map_or(Ok(()), |stop| Err(reach::stopped(stop, "then walk again")))
}

fn mean_power_w(trial: &Trial) -> Option<f64> {
    (trial.frames() > 0).then(|| trial.energy_j() / trial.duration_s())
}

fn print_words(trial: &Trial, plan: &Plan, ended: &str) {
    let rehearsed = if plan.order.dry_run { "rehearsed" } else { "walked" };
    println!(
        "{rehearsed} \"{}\" for {:.2} s, {} frames: {ended}",
        plan.gait.name.as_str(),
        trial.duration_s(),
        trial.frames()
    );
    println!("energy      {:8.3} J", trial.energy_j());
    if let Some(power_w) = mean_power_w(trial) {
        println!("mean power  {power_w:8.3} W");
    }
    let Some(last) = trial.last() else { return };
    if last.clipped_frames > 0 {
        println!("a joint was held at its limit in {} frames", last.clipped_frames);
    }
    if last.missed_samples > 0 {
        println!("{} power samples failed; the preceding one was used instead", last.missed_samples);
    }
}

fn print_json(trial: &Trial, plan: &Plan, console: &WalkConsole, stopped: Option<&TrialStop>) {
    let last = trial.last();
    let result = json!({
        "detached": false,
        "dry_run": plan.order.dry_run,
        "gait_name": plan.gait.name.as_str(),
        "amplitude": as_typed(console.amplitude().unwrap_or(plan.amplitude)),
        "speed": console.speed().unwrap_or(plan.order.speed).value(),
        "stopped": stopped.map(ToString::to_string),
        "frames_played": trial.frames(),
        "duration_s": trial.duration_s(),
        "energy_j": trial.energy_j(),
        "mean_power_w": mean_power_w(trial),
        "clipped_frames": last.map_or(0, |t| t.clipped_frames),
        "missed_samples": last.map_or(0, |t| t.missed_samples),
    });
    println!("{result:#}");
}
