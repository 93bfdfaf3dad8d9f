//! `host stop`: stop the robot, whatever it is doing and whoever started it.

use super::explain::failure_with_help;
use super::reach::{Port, unreachable_robot};
use super::{Cause, Failure};
use crate::device::link::{ports, words};
use protocol::{Command, State};
use std::time::{Duration, Instant};
use thiserror::Error;

/// From the order to a stand, at bounded joint speed, takes a second or two.
const PATIENCE: Duration = Duration::from_secs(6);

/// Stop the robot.
///
/// It stands where it is for a second, then its servos go limp.
///
/// The first thing on the wire is a single byte that the robot obeys even in the
/// middle of a damaged frame. If a host still holds the port, stop it there with
/// Ctrl-C.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    port: Port,
}

#[derive(Debug, Error)]
#[error("the robot was told to stop {} s ago and is {} still", PATIENCE.as_secs(), words::state(*.state))]
struct GoesOn {
    state: State,
}

pub fn run(args: Args) -> Result<(), Failure> {
    let mut link = ports::connect_and_stop(args.port.port.as_deref()).map_err(unreachable_robot)?;
    link.order(Command::Stop).map_err(unreachable_robot)?;
    let deadline = Instant::now() + PATIENCE;
    loop {
        let state = link.status().map_err(unreachable_robot)?.state;
        match state {
            State::Entering | State::Walking | State::Stopping | State::Booting => {}
            State::Idle | State::Holding | State::Fault(_) => {
                println!("the robot is {}", words::state_in_full(state));
                return Ok(());
            }
        }
        if Instant::now() >= deadline {
            let help = "switch its servo supply off, then look for the cause: host status";
            return Err(failure_with_help(Cause::Robot, GoesOn { state }, help));
        }
        std::thread::sleep(Duration::from_millis(50));
    }
}
