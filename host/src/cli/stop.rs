//! `host stop`: stops the robot, whatever it is doing.
//!
//! Does not depend on who started the walk.

use super::explain::failure_with_help;
use super::reach::{Port, unreachable_robot};
use super::{Cause, Failure};
use crate::device::link::{ports, words};
use protocol::{Command, State};
use std::time::{Duration, Instant};
use thiserror::Error;

/// From the order to a stand, at bounded joint speed, takes a second or two.
const STOP_TIMEOUT: Duration = Duration::from_secs(6);

/// Stop the robot.
///
/// It stands where it is for a second, then its servos go limp.
///
/// The first thing that is sent is a single byte, which the robot obeys even in the
/// middle of a damaged frame. While another host command uses the robot, press Ctrl-C
/// there instead: that stops it too.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    port: Port,
}

#[derive(Debug, Error)]
#[error("the robot was ordered to stop {} s ago and is still {}", STOP_TIMEOUT.as_secs(), words::state(*.state))]
struct StillMoving {
    state: State,
}

pub fn run(args: Args) -> Result<(), Failure> {
    let mut link = ports::connect_and_stop(args.port.port.as_deref()).map_err(unreachable_robot)?;
    link.order(Command::Stop).map_err(unreachable_robot)?;
    let deadline = Instant::now() + STOP_TIMEOUT;
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
            let help = "switch its servo supply off, then see the cause: host status";
            return Err(failure_with_help(Cause::Robot, StillMoving { state }, help));
        }
        std::thread::sleep(Duration::from_millis(50));
    }
}
