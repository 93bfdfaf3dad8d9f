//! Events, result and errors of a training run.
//!
//! Holds the types between the trainer and the command line. Does not depend on how
//! they are shown.

use super::checkpoint::CheckpointError;
use super::collect::CollectError;
use super::curve::CurvePoint;
use super::device::DeviceError;
use super::tensor_file::TensorFileError;
use crate::run_folder::FileError;
use thiserror::Error;

/// Why a run stopped before its schedule was done.
#[derive(Debug, Error)]
pub enum TrainError {
    /// Losses or weights are NaN, infinite or too large.
    #[error("learning diverged at update {updates}: critic loss {critic_loss}, mean value {q_mean}")]
    Diverged {
        /// Updates done.
        updates: u64,
        /// Critic loss of the latest round.
        critic_loss: f64,
        /// Mean value of the latest round.
        q_mean: f64,
    },
    /// The task failed.
    #[error(transparent)]
    Collect(#[from] CollectError),
    /// The checkpoint cannot be read or written.
    #[error(transparent)]
    Checkpoint(#[from] CheckpointError),
    /// The policy cannot be written.
    #[error(transparent)]
    Policy(#[from] TensorFileError),
    /// Another file cannot be written.
    #[error(transparent)]
    File(#[from] FileError),
    /// The device is not available, or failed.
    #[error(transparent)]
    Device(#[from] DeviceError),
    /// A bug in the simulation; the panic's message is on standard error.
    #[error("the thread that gathers experience panicked")]
    CollectorGone,
}

/// How a run ended, where there was no error.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ending {
    /// The schedule is complete.
    Done,
    /// Stopped on request, with a checkpoint.
    Stopped,
}

/// Result of a training run.
#[derive(Debug)]
pub struct Outcome {
    /// Complete or stopped.
    pub ending: Ending,
    /// Every evaluation; the first is of the untrained policy.
    pub curve: Vec<CurvePoint>,
    /// Index of the best evaluation.
    pub best: usize,
    /// Updates done.
    pub updates: u64,
    /// Control steps gathered.
    pub env_steps: u64,
    /// Wall-clock time without interruptions.
    pub wall_s: f64,
}

/// Progress of a run, as the caller sees it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Event {
    /// An interrupted run is resumed; its best policy is in the folder.
    Resumed {
        /// Updates done before.
        updates: u64,
    },
    /// A round is done.
    Round {
        /// Updates done.
        updates: u64,
        /// Control steps gathered.
        env_steps: u64,
    },
    /// An evaluation is done and written.
    Evaluated {
        /// The row of the learning curve.
        point: CurvePoint,
        /// Whether its policy is the best so far; it is then written.
        best: bool,
    },
}
