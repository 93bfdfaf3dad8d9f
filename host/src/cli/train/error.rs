//! Why nothing was trained, or not to the end, and the user's next move.
//!
//! Owns the exit codes of `train`.

use super::seeds;
use crate::cli::{Cause, Failure};
use crate::learn::td3::device::{Device, DeviceError};
use crate::learn::td3::outcome::TrainError;
use crate::learn::td3::run_config::ConfigError;
use crate::run_folder::FileError;
use miette::Diagnostic;
use thiserror::Error;

/// What a training can end with but a policy.
#[derive(Debug, Error, Diagnostic)]
pub enum TrainCliError {
    #[error("{folder} holds a run already")]
    #[diagnostic(help("go on with it by `--resume {folder}`, or name another folder"))]
    Taken { folder: String },
    #[error("{value} is no leg scale: it must be between 0.3 and 2")]
    Leg { value: f64 },
    #[error("interrupted after {updates} updates; everything is saved")]
    #[diagnostic(help("go on with: cargo run -p host -- train --resume {folder}"))]
    Interrupted { updates: u64, folder: String },
    #[error("cannot use this configuration")]
    Config(#[from] ConfigError),
    #[error("cannot use this robot")]
    Robot(#[from] crate::robot::RobotError),
    #[error("env.randomisation.twin_spread is {value}, but robot {robot} has no fitted spread to draw from")]
    #[diagnostic(help(
        "fit it to measured trials first (host twin fit), or set twin_spread = 0 in a --config: the other \
         differences need no fit"
    ))]
    NoSpread { value: f64, robot: String },
    #[error("cannot train on device {device}")]
    Device {
        device: Device,
        source: DeviceError,
        #[help]
        help: &'static str,
    },
    #[error("cannot prepare the run's folder")]
    Folder(#[from] FileError),
    #[error(transparent)]
    Seeds(#[from] seeds::SeedsError),
    #[error("training stopped")]
    #[diagnostic(help(
        "the best policy so far, if there is one, is in {folder}; if learning diverged, try another --seed or smaller learning rates in a --config"
    ))]
    Train { folder: String, source: TrainError },
    #[error("cannot catch Ctrl-C")]
    Signals(#[from] ctrlc::Error),
}

impl From<TrainCliError> for Failure {
    fn from(error: TrainCliError) -> Self {
        let cause = match &error {
            TrainCliError::Taken { .. } | TrainCliError::Leg { .. } => Cause::Usage,
            TrainCliError::Config(_) | TrainCliError::Robot(_) | TrainCliError::NoSpread { .. } => {
                Cause::Input
            }
            TrainCliError::Train { source: TrainError::Checkpoint(error), .. } if !error.is_of_writing() => {
                Cause::Input
            }
            TrainCliError::Interrupted { .. } => Cause::Interrupted,
            TrainCliError::Seeds(error) => error.cause(),
            TrainCliError::Device { .. }
            | TrainCliError::Folder(_)
            | TrainCliError::Train { .. }
            | TrainCliError::Signals(_) => Cause::Machine,
        };
        Self::new(cause, error)
    }
}
