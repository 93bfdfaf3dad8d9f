//! Twin delayed deep deterministic policy gradients: the paper's learner.
//!
//! Owns the algorithm and a run's learning files. Refuses to know rapier: a
//! task is an [`Env`]. The same seed gives the same run bit for bit on the same
//! machine, interrupted or not.
//!
//! Deviations from the paper, and why:
//! - An epoch is 2,500 updates and there are 100, as the text says; Table 1
//!   swaps the two. Ten control steps are gathered an update, as in Table 1.
//! - `policy_noise_clip` is 0.5, from TD3's own paper; Table 1 is silent.
//! - The first 20,000 control steps take random actions. The paper is silent,
//!   and a buffer of one fresh network's actions teaches nothing.
//! - Time limits are not ends: a truncated episode's last state keeps its
//!   value. The authors' code ignores every end instead.
//! - Rewards are not normalised, as in the text; the authors' code does so.
//! - Transitions are handed over every 25 updates, 250 at once, so that
//!   gathering and learning can overlap with a result that no timing changes.
//! - Three hidden layers, as the text says; the authors' code builds four.
//! - Exploration noise may last (`exploration_correlation`); the paper's is
//!   white. A servo turns 2 degrees in a control step, so white noise shakes
//!   the setpoints and leaves the legs where they are.
//!
//! `configs/quick.toml` deviates further and says why beside each number.

pub mod adam;
pub mod agent;
pub mod checkpoint;
pub mod collect;
pub mod config;
pub mod curve;
pub mod evaluate;
pub mod networks;
pub mod outcome;
pub mod policy;
pub mod random;
pub mod replay;
pub mod run_config;
pub mod tensor_file;
pub mod trainer;

use crate::env::Env;

/// What the best policy is, beside it in the run folder.
pub const POLICY_DESCRIPTION: &str = "policy.json";

/// Builds a task; every call builds the same.
pub type MakeEnv<'a> = &'a (dyn Fn() -> Box<dyn Env> + Sync);
