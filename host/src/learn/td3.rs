//! TD3, twin delayed deep deterministic policy gradients: the paper's learner.
//!
//! Holds the algorithm and a run's learning files. Does not depend on a simulator: a
//! task is an [`Env`], and what configures learner and task together is
//! `learn::run_config`. The same seed gives the same run bit for bit on the same
//! machine and [`device::Device`], interrupted or not; for CUDA this was not tested.
//!
//! `configs/paper.toml` follows the paper, with a reason for each choice between
//! readings. Where this code deviates from the paper or from the authors' code
//! whatever the file says, and why:
//! - A round's transitions are gathered while the learner works on the round before,
//!   so that neither core waits: the weights that gather are one round older than in
//!   algorithm 1.
//! - A time limit is not terminal: the last state of a truncated episode is
//!   bootstrapped. The authors' code ignores every end instead.
//! - Rewards are not normalised, as in the text; the authors' code normalises them.
//! - Every transition enters the replay buffer at the end of its round. The Tianshou of
//!   the authors stored whole episodes only and so gathered about 80 steps an update
//!   where it was asked for 10.
//! - The actor is updated on updates 2, 4, 6 as in TD3's paper; Tianshou counts from 0
//!   and updates it on 1, 3, 5.
//!
//! `configs/walk.toml`, `quick.toml`, `robust.toml` and `psto.toml` deviate further and
//! say why beside each number.

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
pub mod policy_description;
pub mod random;
pub mod replay;
pub mod tensor_file;
#[cfg(feature = "torch")]
pub mod torch;
pub mod trainer;

use crate::env::Env;

/// Builds a task; every call builds an equal one.
pub type MakeEnv<'a> = &'a (dyn Fn() -> Box<dyn Env> + Sync);
