//! What `host sinusoid --json` prints, as a type that is written and read.
//!
//! Holds the fields of the JSON, both ways. Does not depend on how a gait is
//! searched.

use super::wave::Pairs;
use crate::learn::preset::Preset;
use crate::robot::LegScale;
use crate::search::null_is_infinite;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Result of a search.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SinusoidResult {
    /// Shins, in units of 23 cm.
    pub leg: LegScale,
    /// `--seed`.
    pub seed: u64,
    /// The task that the gait was tuned for.
    pub preset: Preset,
    /// Legs that swing together.
    pub pairs: Pairs,
    /// Of the whole command.
    pub wall_s: f64,
    /// Gaits that were tried.
    pub evaluations: usize,
    /// Rounds that were begun.
    pub rounds: u32,
    /// Simulated time of the search.
    pub simulated_s: f64,
    /// Mean reward of a control step.
    pub reward_per_step: f64,
    /// Duration of a stride.
    pub period_s: f64,
    /// Along the world's x.
    pub speed_m_s: f64,
    /// Displacement of the described robot along the world's x in 12 s, open loop.
    pub forward_m: f64,
    /// The same along the world's y.
    pub sideways_m: f64,
    /// Servos and electronics.
    pub power_w: f64,
    /// Infinite if the robot got nowhere, or backwards.
    #[serde(deserialize_with = "null_is_infinite")]
    pub cost_of_transport: f64,
    /// Episodes that ended by a fall.
    pub falls: usize,
    /// The amplitude at which the gait file has the stroke that was tuned.
    pub amplitude: f64,
    /// Period and waves, by the names of [`Sinusoid::NAMES`](super::wave::Sinusoid::NAMES).
    pub parameters: BTreeMap<String, f64>,
    /// Path of the gait file.
    pub gait: String,
    /// Of the table that a robot plays; empty if no table holds the gait.
    pub gait_sha256: String,
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Infinity is null in JSON.
    #[test]
    fn a_result_is_read_as_it_was_written() {
        let written = SinusoidResult {
            leg: crate::robot::LegScale::SHORT,
            seed: 3,
            preset: Preset::Psto,
            pairs: Pairs::Ends,
            wall_s: 1.5,
            evaluations: 22,
            rounds: 1,
            simulated_s: 2934.0,
            reward_per_step: 0.5,
            period_s: 1.2,
            speed_m_s: -0.1,
            forward_m: -1.2,
            sideways_m: 0.1,
            power_w: 0.9,
            cost_of_transport: f64::INFINITY,
            falls: 0,
            amplitude: 1.875,
            parameters: [("period_s".to_owned(), 1.2)].into(),
            gait: "run/gait.toml".into(),
            gait_sha256: "ab".into(),
        };

        let json = serde_json::to_value(&written).unwrap();

        assert!(json["cost_of_transport"].is_null());
        assert_eq!(serde_json::from_value::<SinusoidResult>(json).unwrap(), written);
    }
}
