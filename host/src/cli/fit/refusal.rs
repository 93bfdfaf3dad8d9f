//! Why no gait came of a fit, and the user's next move.

use crate::cli::explain::{failure, failure_with_help, file_cause};
use crate::cli::{Cause, Failure};
use crate::gait_file::{GaitFileError, UnusableGait};
use crate::trajectory::TrajectoryError;

pub fn unplayable(error: UnusableGait) -> Failure {
    let help = match &error {
        UnusableGait::Name { .. } => "give it another: --name NAME",
        UnusableGait::JointValue { field: "centre_deg", .. } => {
            "a joint's centre follows from its mean action: see --centre-unit-deg, --centre-offset-deg, \
             --negate and --limit-deg"
        }
        UnusableGait::JointValue { .. } | UnusableGait::Deviation { .. } => {
            "a joint moves by --unit-deg per unit of action; are the recording's units others?"
        }
        _ => return failure(Cause::Input, error),
    };
    failure_with_help(Cause::Input, error, help)
}

pub fn unreadable(error: TrajectoryError) -> Failure {
    let help = match &error {
        TrajectoryError::File(_) => {
            "`host record` writes runs/latest/trajectory.csv; or name a CSV of your own"
        }
        TrajectoryError::NoHeader { .. } | TrajectoryError::MissingJoints { .. } => {
            "say what the columns hold, left to right: --columns time_s,hip1,ank1,-,... (or `columns` in --map FILE)"
        }
        TrajectoryError::UnevenTime { .. } => {
            "choose rows without a gap (--rows A..B), or give the duration yourself (--period S)"
        }
        TrajectoryError::Number { .. } | TrajectoryError::RowLength { .. } => {
            "correct the line, or skip a column of no interest with `-` in --columns"
        }
        _ => return failure(Cause::Input, error),
    };
    failure_with_help(Cause::Input, error, help)
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
