//! Twin delayed deep deterministic policy gradients: the paper's learner.
//!
//! Owns the algorithm and a run's learning files. Refuses to know rapier: a
//! task is an [`Env`]. The same seed gives the same run bit for bit on the same
//! machine and [`device::Device`], interrupted or not; of CUDA that is not known.
//!
//! `configs/paper.toml` is the paper, each reading with its reason. What no
//! number in that file can undo, and why:
//! - A round's transitions are gathered while the round before is learned, so
//!   that neither core waits: the actions that a round learns from first are
//!   one round older than in algorithm 1.
//! - Time limits are not ends: a truncated episode's last state keeps its
//!   value. The authors' code ignores every end instead.
//! - Rewards are not normalised, as in the text; the authors' code does so.
//! - Every transition is learned from as soon as it is there; the Tianshou of
//!   the authors kept whole episodes only and so gathered about 80 steps an
//!   update where it was asked for 10.
//! - The actor moves on updates 2, 4, 6 as in TD3's paper; Tianshou's counts
//!   from 0 and moves it on 1, 3, 5.
//!
//! `configs/walk.toml`, `quick.toml` and `robust.toml` deviate further and say why
//! beside each number.

pub mod adam;
pub mod agent;
pub mod checkpoint;
pub mod collect;
pub mod config;
pub mod curve;
pub mod device;
pub mod evaluate;
pub mod events;
pub mod kernels;
pub mod learner;
pub mod networks;
pub mod outcome;
pub mod policy;
pub mod preset;
pub mod random;
pub mod replay;
pub mod run_config;
pub mod tensor_file;
#[cfg(feature = "torch")]
pub mod torch;
pub mod trainer;

use crate::env::Env;

/// What the best policy is, beside it in the run folder.
pub const POLICY_DESCRIPTION: &str = "policy.json";

/// Builds a task; every call builds the same.
pub type MakeEnv<'a> = &'a (dyn Fn() -> Box<dyn Env> + Sync);
