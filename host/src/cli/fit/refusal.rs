//! Why a fit made no gait, and what to do next.
//!
//! Does not depend on the fit itself.

use crate::cli::explain::{failure, failure_with_help, file_cause};
use crate::cli::{Cause, Failure};
use crate::gait::gait_file::{GaitFileError, UnusableGait};
use crate::robot::{BeyondRange, Robot};
use thiserror::Error;

pub fn unplayable(error: UnusableGait) -> Failure {
    let help = match &error {
        UnusableGait::Name { .. } => "give it another: --name NAME",
        UnusableGait::JointValue { field: "centre_deg", .. } => {
            "a joint's centre follows from its mean value: for pulses or ticks give the value at neutral \
             (--neutral 1500, --neutral 330); see also --centre-unit-deg, --negate and --limit-deg"
        }
        UnusableGait::JointValue { .. } | UnusableGait::Deviation { .. } => {
            "a joint moves by --unit-deg per unit of action; check the recording's units"
        }
        _ => return failure(Cause::Input, error),
    };
    failure_with_help(Cause::Input, error, help)
}

/// Of a gait that is beyond its robot at amplitude 1.0.
#[derive(Debug, Error)]
#[error("the gait leaves the joints' ranges of {robot} at amplitude 1.0")]
struct BeyondRobot {
    robot: String,
    source: BeyondRange,
}

pub fn beyond_range(source: BeyondRange, robot: &Robot) -> Failure {
    let help = "a joint moves by --unit-deg per unit of action; check the recording's units, or correct the \
                joint's range or joint_limit_deg of the robot";
    failure_with_help(Cause::Input, BeyondRobot { robot: robot.name.clone(), source }, help)
}

pub fn unsaved(error: GaitFileError) -> Failure {
    match &error {
        GaitFileError::File(file) => failure_with_help(
            file_cause(file),
            error,
            "the file that was there before, if any, is unharmed; free some space or choose another --out",
        ),
        _ => failure(Cause::Input, error),
    }
}
