//! `policy.json`: what the best policy is and where it comes from.
//!
//! Holds the file's name and its only type, for writing and reading. Does not depend
//! on a task.

use super::config::Learning;
use crate::run_folder::{self, FileError};
use serde::{Deserialize, Serialize};
use std::path::Path;

/// The file's name, beside the policy in the run folder.
pub const POLICY_DESCRIPTION: &str = "policy.json";

/// Evaluation and origin of a policy.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PolicyDescription {
    /// Random seed of the run.
    pub seed: u64,
    /// Updates done when it was evaluated.
    pub updates: u64,
    /// Control steps gathered by then.
    pub env_steps: u64,
    /// Mean reward of an evaluation episode.
    pub reward: f64,
    /// Mean forward speed of the evaluation.
    pub speed_m_s: f64,
    /// Algorithm and schedule.
    pub learning: Learning,
}

impl PolicyDescription {
    /// Writes the file into a run folder.
    ///
    /// # Errors
    /// [`FileError`] with the old file still in place.
    pub fn save(&self, run: &Path) -> Result<(), FileError> {
        let text = format!("{:#}\n", serde_json::json!(self));
        run_folder::write(&run.join(POLICY_DESCRIPTION), text.as_bytes())
    }
}
