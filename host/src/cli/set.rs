//! `host set`: changes a detached walk.
//!
//! An attached walk takes the same changes from the terminal it runs in. Does not
//! depend on who started the walk.

use super::explain::{failure, failure_with_help};
use super::ranges::{self, BadNumber};
use super::reach::{Port, beyond_limits, unreachable_robot};
use super::{Cause, Failure};
use crate::device::link::ports::SerialLink;
use crate::device::link::words;
use crate::gait::gait_file::limits::as_typed;
use crate::gait::gait_player::Playable;
use protocol::command::Record;
use protocol::{Amplitude, Command, Speed, State};
use thiserror::Error;

/// Change amplitude or speed of a detached walk; pause or resume it.
///
/// The robot moves smoothly to the new value. --amp also becomes the
/// amplitude of the next walk, until the next reset.
#[derive(Debug, clap::Args)]
#[command(group = clap::ArgGroup::new("change").required(true).multiple(true))]
pub struct Args {
    /// Amplitude about each joint's centre, 0.5 to 3.0
    #[arg(long = "amp", value_name = "X", group = "change")]
    amplitude: Option<f64>,
    /// Speed, 0 to 2; 1 is the gait's own period
    #[arg(long, value_name = "X", group = "change", conflicts_with_all = ["pause", "resume"])]
    speed: Option<f64>,
    /// Stand still in mid stride, servos on
    #[arg(long, group = "change", conflicts_with = "resume")]
    pause: bool,
    /// Walk on at the gait's own speed
    #[arg(long, group = "change")]
    resume: bool,
    /// Take an amplitude at which joints are held at their limits
    #[arg(long, requires = "amplitude")]
    clip: bool,
    #[command(flatten)]
    port: Port,
}

#[derive(Debug, Error)]
#[error("the robot is not walking: it is {}", words::state_in_full(*.state))]
struct NotWalking {
    state: State,
}

/// Refuses an amplitude at which the robot's gait would be held at its limits.
fn check_limits(link: &mut SerialLink, amplitude: Amplitude) -> Result<(), Failure> {
    let bytes = link.read(Record::Gait).map_err(unreachable_robot)?;
    // Without a gait the robot itself says so.
    match Playable::from_bytes(&bytes) {
        Ok(gait) => gait.check_limits(as_typed(amplitude)).map_err(beyond_limits),
        Err(_) => Ok(()),
    }
}

pub fn run(args: Args) -> Result<(), Failure> {
    let usage = |error: BadNumber| failure(Cause::Usage, error);
    let amplitude = args.amplitude.map(ranges::amplitude).transpose().map_err(usage)?;
    let speed = match (args.speed, args.pause, args.resume) {
        (Some(value), ..) => Some(ranges::speed(value).map_err(usage)?),
        (None, true, _) => Some(Speed::PAUSED),
        (None, _, true) => Some(Speed::ONE),
        _ => None,
    };
    let mut link = args.port.connect()?;
    let state = link.status().map_err(unreachable_robot)?.state;
    if speed.is_some() && matches!(state, State::Idle | State::Stopping | State::Fault(_) | State::Booting) {
        let help = "start a walk that does not depend on this program: host walk --detached --for 60. \
                    If it was walking a moment ago, opening the port has reset it: the first opening \
                    after plugging in does";
        return Err(failure_with_help(Cause::Robot, NotWalking { state }, help));
    }
    if let Some(amplitude) = amplitude.filter(|_| !args.clip) {
        check_limits(&mut link, amplitude)?;
    }
    let changes = [amplitude.map(Command::SetAmplitude), speed.map(Command::SetSpeed)];
    for change in changes.into_iter().flatten() {
        link.order(change).map_err(unreachable_robot)?;
    }
    let state = link.status().map_err(unreachable_robot)?.state;
    // Speeds slide: the state that answers is the one that is being left.
    let doing = match (speed, state) {
        (Some(Speed::PAUSED), State::Walking) => "slowing down to stand still, servos on",
        (Some(speed), State::Holding) if speed != Speed::PAUSED => "about to walk on",
        (_, state) => words::state_in_full(state),
    };
    println!("done; the robot is {doing}");
    Ok(())
}
