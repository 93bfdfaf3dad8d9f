//! Errors of `train`, with help texts and exit codes.
//!
//! Holds what the user reads. Does not depend on the learner beyond its error types.

use super::range::SeedsFileError;
use crate::cli::{Cause, Failure};
use crate::learn::run_config::ConfigError;
use crate::learn::td3::device::{Device, DeviceError};
use crate::learn::td3::outcome::TrainError;
use crate::learn::td3::tensor_file::TensorFileError;
use crate::run_folder::FileError;
use miette::Diagnostic;
use std::error::Error;
use std::io::ErrorKind;
use std::path::Path;
use thiserror::Error as ThisError;

/// Why training did not start, or did not complete.
#[derive(Debug, ThisError, Diagnostic)]
pub enum TrainCliError {
    #[error("{folder} already holds a run")]
    #[diagnostic(help("continue it with `--resume {folder}`, or name another folder"))]
    FolderInUse { folder: String },
    #[error("interrupted after {updates} updates; the run is saved")]
    #[diagnostic(help("continue with: cargo run -p host -- train --resume {folder}"))]
    Interrupted { updates: u64, folder: String },
    #[error("cannot use this configuration")]
    Config(#[from] ConfigError),
    #[error("cannot use this robot")]
    Robot(#[from] crate::robot::RobotError),
    #[error("env.randomisation.twin_spread is {value}, but robot {robot} has no fitted spread")]
    #[diagnostic(help(
        "fit it to measured trials first (host twin fit), or set twin_spread = 0 in a --config: the other \
         ranges need no fit"
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
    Seeds(#[from] SeedsError),
    #[error("training stopped")]
    #[diagnostic(help(
        "the best policy so far, if there is one, is in {folder}; if learning diverged, try another --seed or smaller learning rates in a --config"
    ))]
    Train { folder: String, source: TrainError },
    #[error("training stopped: the disk is full")]
    #[diagnostic(help("free some space, then: cargo run -p host -- train --resume {folder}"))]
    DiskFull { folder: String, source: TrainError },
    #[error("cannot catch Ctrl-C")]
    Signals(#[from] ctrlc::Error),
}

impl TrainCliError {
    /// Training in this folder stopped.
    pub fn stopped(folder: &Path, source: TrainError) -> Self {
        let folder = folder.display().to_string();
        if is_disk_full(&source) { Self::DiskFull { folder, source } } else { Self::Train { folder, source } }
    }
}

/// Whether a write failed for lack of space.
fn is_disk_full(error: &TrainError) -> bool {
    let is_full = |error: &(dyn Error + 'static)| {
        error
            .downcast_ref::<std::io::Error>()
            .is_some_and(|io| matches!(io.kind(), ErrorKind::StorageFull | ErrorKind::QuotaExceeded))
    };
    let first: &(dyn Error + 'static) = error;
    std::iter::successors(Some(first), |&cause| cause.source()).any(is_full)
}

impl From<TrainCliError> for Failure {
    fn from(error: TrainCliError) -> Self {
        let cause = match &error {
            TrainCliError::FolderInUse { .. } => Cause::Usage,
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
            | TrainCliError::DiskFull { .. }
            | TrainCliError::Signals(_) => Cause::Machine,
        };
        Self::new(cause, error)
    }
}

/// Errors that only several seeds can have.
#[derive(Debug, ThisError)]
pub enum SeedsError {
    #[error(transparent)]
    Range(#[from] SeedsFileError),
    #[error("cannot compare the policies")]
    Policy(#[from] TensorFileError),
    #[error(transparent)]
    File(#[from] FileError),
    #[error("the thread that trained a seed panicked; its message is above")]
    Panicked,
}

impl SeedsError {
    /// The exit code.
    pub fn cause(&self) -> Cause {
        match self {
            Self::Range(_) => Cause::Input,
            Self::File(error) => crate::cli::explain::file_cause(error),
            Self::Policy(_) | Self::Panicked => Cause::Machine,
        }
    }
}
