//! What `train --json` prints: one line, of one seed or of several.
//!
//! Holds the only types of that line, for writing and reading. Does not depend on how
//! a run is trained.

use crate::learn::td3::device::Device;
use serde::{Deserialize, Serialize};

/// Result of a run of one seed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrainResult {
    /// The run folder.
    pub run: String,
    /// The best policy's file.
    pub policy: String,
    /// Random seed.
    pub seed: u64,
    /// Device of the updates.
    pub device: Device,
    /// Whether the schedule is complete.
    pub finished: bool,
    /// Evaluation reward of the untrained policy.
    pub reward_untrained: f64,
    /// Evaluation reward of the best policy.
    pub reward_trained: f64,
    /// Evaluation speed of the best policy.
    pub speed_m_s: f64,
    /// Updates after which the best policy was evaluated.
    pub best_updates: u64,
    /// Updates done.
    pub updates: u64,
    /// Control steps gathered.
    pub train_env_steps: u64,
    /// Wall-clock time without interruptions.
    pub wall_s: f64,
}

/// Result of `--seeds`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SeedsResult {
    /// The folder of all seeds, which is a run with the best seed's files.
    pub run: String,
    /// The best policy's file.
    pub policy: String,
    /// The best seed.
    pub seed: u64,
    /// Its reward in the comparison.
    pub reward_trained: f64,
    /// Its speed in the comparison.
    pub speed_m_s: f64,
    /// Every seed, in the order of their numbers.
    pub seeds: Vec<SeedResult>,
}

/// One seed of `--seeds`; reward and speed are means over the episodes of the comparison.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SeedResult {
    /// Random seed.
    pub seed: u64,
    /// Mean reward of an episode.
    pub reward: f64,
    /// Mean forward speed.
    pub speed_m_s: f64,
    /// Updates done; 0 if it diverged.
    pub updates: u64,
    /// Wall-clock time without interruptions; 0 if it diverged.
    pub wall_s: f64,
    /// Whether training was completed.
    pub ending: SeedEnding,
}

/// How the training of a seed ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum SeedEnding {
    /// The schedule is complete.
    Done,
    /// Learning or the simulation diverged; the best policy so far was kept.
    Diverged,
}
