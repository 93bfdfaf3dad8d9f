//! The connection to the robot, and the errors where there is none.
//!
//! Holds the `--port` flag, the exit codes of link errors, and Ctrl-C. Does not depend
//! on a subcommand.

use super::explain::{failure, failure_with_help};
use super::{Cause, Failure};
use crate::device::link::ports::{self, SerialLink};
use crate::device::link::{LinkError, words};
use crate::device::trial::TrialStop;
use crate::gait::gait_file::limits::LeavesLimits;
use protocol::{FRAME_RATE_HZ, STREAM_CAPACITY, WalkEnd};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use thiserror::Error;

/// The `--port` flag.
#[derive(Debug, Clone, clap::Args)]
pub struct Port {
    /// Serial port [default: the only Nano on USB]
    #[arg(long, value_name = "PORT")]
    pub port: Option<String>,
}

impl Port {
    /// Opens the port and waits for the robot's hello.
    pub fn connect(&self) -> Result<SerialLink, Failure> {
        ports::connect(self.port.as_deref()).map_err(unreachable_robot)
    }

    /// For commands that the user is to type next.
    pub fn as_flag(&self) -> String {
        self.port.as_ref().map_or(String::new(), |port| format!(" --port {port}"))
    }
}

/// The exit code of a link error.
pub fn link_cause(error: &LinkError) -> Cause {
    if error.is_from_robot() { Cause::Robot } else { Cause::Link }
}

/// A link error with its exit code and its help.
pub fn unreachable_robot(error: LinkError) -> Failure {
    let cause = link_cause(&error);
    match error.help() {
        Some(help) => failure_with_help(cause, error, help),
        None => failure(cause, error),
    }
}

/// The failure of a walk that ended early; `then` ends the help.
pub fn stopped(stop: TrialStop, then: &str) -> Failure {
    let help = match &stop {
        TrialStop::Fault { fault } => format!("{}, {}", words::fault_help(*fault), words::CLEAR_FAULT),
        TrialStop::Early { .. } | TrialStop::Stuck { .. } => "see its state: host status".to_owned(),
        TrialStop::Ended { end: WalkEnd::StreamDry, .. } => {
            format!(
                "this computer or its adapter was late by {} ms or more: close other programs; on Linux, \
                 `setserial PORT low_latency` stops an FTDI adapter from delaying every answer by 16 ms",
                1000 * u32::from(STREAM_CAPACITY) / FRAME_RATE_HZ
            )
        }
        TrialStop::Ended { .. } => "it was stopped from outside this program".to_owned(),
        TrialStop::LinkLost => {
            "check cable and port, and whether this computer was asleep or overloaded".to_owned()
        }
        TrialStop::Entry => "check whether a leg is caught; the robot was ordered to stop".to_owned(),
        TrialStop::Link { source } => source.help().unwrap_or_else(|| "check cable and supply".to_owned()),
        TrialStop::Interrupted => return failure(Cause::Interrupted, stop),
    };
    let cause = match &stop {
        TrialStop::Link { source } => link_cause(source),
        _ => Cause::Robot,
    };
    failure_with_help(cause, stop, format!("{help}; {then}"))
}

#[derive(Debug, Error)]
#[error("the robot's gait cannot be played at this amplitude")]
struct BeyondLimits {
    source: LeavesLimits,
}

/// The failure of an amplitude that the robot's gait cannot be played at.
pub fn beyond_limits(source: LeavesLimits) -> Failure {
    let help = match source.largest {
        Some(largest) => format!("the largest amplitude that fits is {largest}; or --clip"),
        None => "no amplitude fits; --clip holds joints at their limits".to_owned(),
    };
    failure_with_help(Cause::Input, BeyondLimits { source }, help)
}

#[derive(Debug, Error)]
#[error("cannot catch Ctrl-C")]
struct NoSignal {
    source: ctrlc::Error,
}

/// From now on, Ctrl-C sets the flag; a second one ends the program.
pub fn interruptible() -> Result<Arc<AtomicBool>, Failure> {
    let stop = Arc::new(AtomicBool::new(false));
    let flag = Arc::clone(&stop);
    let asked = move || {
        if flag.swap(true, Ordering::Relaxed) {
            std::process::exit(Cause::Interrupted as i32);
        }
    };
    ctrlc::set_handler(asked).map_err(|source| failure(Cause::Machine, NoSignal { source }))?;
    Ok(stop)
}
