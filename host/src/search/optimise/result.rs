//! What `host optimise --json` prints, as a type that is written and read.
//!
//! Holds the fields of the JSON, both ways. Does not depend on how a gait is
//! searched.

use super::report::{AtAmplitude, OverDraws, PowerBalance};
use crate::robot::LegScale;
use crate::search::null_is_infinite;
use serde::{Deserialize, Serialize};

/// Result of a search. Angles, speeds and powers are those at amplitude 1.0.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct OptimiseResult {
    /// Shins, in units of 23 cm.
    pub leg: LegScale,
    /// `--seed`.
    pub seed: u64,
    /// Search and report.
    pub wall_s: f64,
    /// Simulated trials of the search.
    pub evaluations: u64,
    /// Whether Ctrl-C ended the search or its report.
    pub interrupted: bool,
    /// Path of the gait file.
    pub gait: String,
    /// Of the table that a robot plays; empty if no table holds the gait.
    pub gait_sha256: String,
    /// Duration of a stride.
    pub period_s: f64,
    /// The speed that was asked for; none of a search for speed.
    pub min_speed_m_s: Option<f64>,
    /// Median over the robots of the report; infinite if half of them stood still.
    #[serde(deserialize_with = "null_is_infinite")]
    pub cost_of_transport_median: f64,
    /// Nine tenths of the robots are below.
    #[serde(deserialize_with = "null_is_infinite")]
    pub cost_of_transport_p90: f64,
    /// Median over the robots of the report.
    #[serde(deserialize_with = "null_is_infinite")]
    pub speed_m_s_median: f64,
    /// A tenth of the robots is slower.
    #[serde(deserialize_with = "null_is_infinite")]
    pub speed_m_s_p10: f64,
    /// Median displacement along the world's x in 12 s; forward is positive.
    #[serde(deserialize_with = "null_is_infinite")]
    pub forward_m: f64,
    /// Median displacement along the world's y in 12 s.
    #[serde(deserialize_with = "null_is_infinite")]
    pub sideways_m: f64,
    /// Median over the robots of the report, from the supply.
    #[serde(deserialize_with = "null_is_infinite")]
    pub power_w_median: f64,
    /// Median of what a robot turns in 12 s, either way.
    #[serde(deserialize_with = "null_is_infinite")]
    pub yaw_deg_median: f64,
    /// Fastest setpoint.
    pub setpoint_speed_max_rad_s: f64,
    /// What a servo does without load.
    pub servo_speed_rad_s: f64,
    /// Share of the robots whose servos are slower than the fastest setpoint.
    pub slower_servos_share: f64,
    /// Whether the robots differ by the uncertainty of a fit.
    pub twin_spread_used: bool,
    /// All that was counted over the robots of the report.
    pub over_draws: OverDraws,
    /// The same at each amplitude; empty if Ctrl-C came first.
    pub amplitudes: Vec<AtAmplitude>,
    /// Least and most amplitude that the gait declares as safe.
    pub safe_amplitudes: Option<[f64; 2]>,
    /// Where the power goes; none if that simulation diverged.
    pub power: Option<PowerBalance>,
    /// Cost of transport of the electronics alone, at the median speed.
    #[serde(deserialize_with = "null_is_infinite")]
    pub cost_of_transport_of_electronics: f64,
    /// With `--objective pareto` only.
    #[serde(flatten)]
    pub front: Option<FrontResult>,
}

/// The front of speed against cost of transport.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FrontResult {
    /// Its gaits, the slowest first.
    #[serde(rename = "front")]
    pub points: Vec<FrontPoint>,
    /// Gaits that were found, and that another beats in speed and cost.
    #[serde(rename = "front_dropped")]
    pub dropped: usize,
    /// Speeds that were asked for and that no gait reaches.
    #[serde(rename = "front_unreached_m_s")]
    pub unreached_m_s: Vec<f64>,
}

/// One gait of a front.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FrontPoint {
    /// The speed that it was chosen for.
    pub asked_m_s: f64,
    /// Whether its median speed is as fast as that.
    pub reached: bool,
    /// Duration of a stride.
    pub period_s: f64,
    /// What a robot calls it.
    pub name: String,
    /// Path of the gait file.
    pub gait: String,
    /// Of the table that a robot plays.
    pub gait_sha256: String,
    /// Least and most amplitude that it declares as safe.
    pub safe_amplitudes: Option<[f64; 2]>,
    /// All that was counted over the robots of the report.
    pub over_draws: OverDraws,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::search::optimise::report::Quantiles;

    fn walks() -> OverDraws {
        let infinite = Quantiles { p10: 0.3, median: 0.4, p90: f64::INFINITY };
        OverDraws {
            draws: 8,
            cost_of_transport: infinite,
            speed_m_s: infinite,
            forward_m: infinite,
            sideways_m: infinite,
            power_w: infinite,
            yaw_deg: infinite,
            tilt_deg: infinite,
            strained_share: infinite,
            fell: 1,
            dragged: 2,
            slower_servos: 3,
        }
    }

    /// Infinity is null in JSON, and no front is no field.
    #[test]
    fn a_result_is_read_as_it_was_written() {
        let point = FrontPoint {
            asked_m_s: 0.2,
            reached: true,
            period_s: 0.8,
            name: "a".into(),
            gait: "front-1.toml".into(),
            gait_sha256: "ab".into(),
            safe_amplitudes: Some([0.8, 1.0]),
            over_draws: walks(),
        };
        let plain = OptimiseResult {
            leg: crate::robot::LegScale::LONG,
            seed: 3,
            wall_s: 1.5,
            evaluations: 100,
            interrupted: false,
            gait: "run/gait.toml".into(),
            gait_sha256: "cd".into(),
            period_s: 0.8,
            min_speed_m_s: None,
            cost_of_transport_median: 0.4,
            cost_of_transport_p90: f64::INFINITY,
            speed_m_s_median: 0.2,
            speed_m_s_p10: 0.1,
            forward_m: 2.4,
            sideways_m: -0.1,
            power_w_median: 1.0,
            yaw_deg_median: 3.0,
            setpoint_speed_max_rad_s: 2.5,
            servo_speed_rad_s: 3.0,
            slower_servos_share: 0.25,
            twin_spread_used: true,
            over_draws: walks(),
            amplitudes: Vec::new(),
            safe_amplitudes: None,
            power: None,
            cost_of_transport_of_electronics: 0.1,
            front: None,
        };
        let front = FrontResult { points: vec![point], dropped: 1, unreached_m_s: vec![0.5] };
        let pareto = OptimiseResult { front: Some(front), ..plain.clone() };

        for written in [plain, pareto] {
            let json = serde_json::to_value(&written).unwrap();

            assert_eq!(json.get("front").is_some(), written.front.is_some());
            assert!(json["cost_of_transport_p90"].is_null());
            assert_eq!(serde_json::from_value::<OptimiseResult>(json).unwrap(), written);
        }
    }
}
