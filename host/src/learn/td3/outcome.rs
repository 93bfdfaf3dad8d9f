//! What a training run says while it goes on and when it ends.
//!
//! Owns the words between the trainer and whoever shows them.

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
    /// Losses or weights are no numbers any more.
    #[error("learning diverged at update {updates}: critic loss {critic_loss}, mean value {q_mean}")]
    Diverged {
        /// Updates done.
        updates: u64,
        /// Of the latest round.
        critic_loss: f64,
        /// Of the latest round.
        q_mean: f64,
    },
    /// The task's fault.
    #[error(transparent)]
    Collect(#[from] CollectError),
    /// The checkpoint's fault.
    #[error(transparent)]
    Checkpoint(#[from] CheckpointError),
    /// A policy cannot be written.
    #[error(transparent)]
    Policy(#[from] TensorFileError),
    /// Another file cannot be written.
    #[error(transparent)]
    File(#[from] FileError),
    /// The device's fault.
    #[error(transparent)]
    Device(#[from] DeviceError),
    /// A bug in the simulation; its message is on standard error.
    #[error("the thread that gathers experience panicked")]
    CollectorGone,
}

/// How a run ended without an error.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ending {
    /// The schedule is done.
    Done,
    /// Asked to stop; the checkpoint is written.
    Stopped,
}

/// What a run came to.
#[derive(Debug)]
pub struct Outcome {
    /// How.
    pub ending: Ending,
    /// Every evaluation; the first is that of the untrained policy.
    pub curve: Vec<CurvePoint>,
    /// Index of the best.
    pub best: usize,
    /// Updates done.
    pub updates: u64,
    /// Control steps gathered.
    pub env_steps: u64,
    /// Wall-clock time, interruptions left out.
    pub wall_s: f64,
}

/// What the caller hears while a run goes on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Event {
    /// An interrupted run goes on; its best policy is in the folder.
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
    /// An evaluation is done and saved.
    Evaluated {
        /// The row of the learning curve.
        point: CurvePoint,
        /// Its policy is the best so far, and written.
        best: bool,
    },
}
