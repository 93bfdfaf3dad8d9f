//! `record.json`: what a policy did while its trajectory was recorded.
//!
//! Holds the file's name and its only type, for writing and reading. Does not depend
//! on the learner, so that `fit` reads the file in a program without it.

use super::fit::MOST_STRIDES;
use protocol::JOINT_COUNT;
use serde::{Deserialize, Serialize};

/// The file's name, beside the trajectory in the run folder.
pub const RECORD: &str = "record.json";
/// Times in a trajectory are rounded, and a flag's value may be.
const PERIOD_TOLERANCE: f64 = 0.01;

/// Means over the recorded part of all trials in which the robot did not fall.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RecordSummary {
    /// Mean duration of a stride, or that of the window.
    pub period_s: f64,
    /// Length of the window, if one was asked for: strides below are then windows.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub window_s: Option<f64>,
    /// Strides in the window, if the motion has strides.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub strides_in_window: Option<f64>,
    /// Trials played.
    pub trials: usize,
    /// Trials in which the robot fell.
    pub fell: usize,
    /// Strides in the average.
    pub strides_averaged: usize,
    /// Strides left out, because they correlate too little with the others.
    pub strides_left_out: usize,
    /// Correlation of the motion with itself one stride later, or of the trials' windows
    /// with their mean.
    pub correlation: f64,
    /// Standard deviation from the average stride, in action units, in joint order.
    pub spread: [f64; JOINT_COUNT],
    /// The same in degrees, at the policy's own stroke.
    pub spread_deg: [f64; JOINT_COUNT],
    /// R2 of a degree-10 curve, as `fit` fits it; `None` for a joint that stands still.
    pub polynomial_r2: [Option<f64>; JOINT_COUNT],
    /// Mean speed along x.
    pub speed_m_s: f64,
    /// Mean reward of a control step.
    pub reward_per_step: f64,
    /// Mean electrical power, servos and electronics.
    pub power_w: f64,
}

impl RecordSummary {
    /// Strides that share one curve, if they are more than it can follow.
    #[must_use]
    pub fn crowded_strides(&self) -> Option<f64> {
        self.strides_in_window.filter(|&strides| strides > MOST_STRIDES)
    }

    /// Whether rows that last `recorded_s` last as long as the recorded stride, within 1 %.
    #[must_use]
    pub fn lasts(&self, recorded_s: f64) -> bool {
        (recorded_s - self.period_s).abs() <= PERIOD_TOLERANCE * self.period_s
    }
}

/// The file: a summary, and the trajectory that it belongs to.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PolicyRecord {
    /// The summary, whose keys stand beside the hash.
    #[serde(flatten)]
    pub summary: RecordSummary,
    /// SHA-256 of `trajectory.csv`, in hexadecimal.
    pub trajectory_sha256: String,
}
