//! What `host simulate --json` prints, as a type that is written and read.
//!
//! Holds the fields of the JSON, both ways. Does not depend on how a gait is
//! played.

use crate::robot::LegScale;
use crate::sim::open_loop::Walk;
use serde::{Deserialize, Serialize};

/// Result of the walks from all starts.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SimulateResult {
    /// Path of the gait file.
    pub gait: String,
    pub gait_name: String,
    pub gait_sha256: String,
    pub gait_source: String,
    /// Duration of a stride.
    pub period_s: f64,
    /// About each joint's centre.
    pub amplitude: f64,
    /// Length of the walk from each start.
    pub duration_s: f64,
    /// How many.
    pub starts: u32,
    pub seed: u64,
    /// Name of the robot.
    pub robot: String,
    /// Shins, in units of 23 cm.
    pub leg_scale: LegScale,
    pub mass_kg: f64,
    /// Share of a stride in which a joint is held at its limit.
    pub clipped_share: f64,
    /// Starts from which the robot fell.
    pub fell: usize,
    /// One row for each start.
    pub walks: Vec<StartResult>,
    /// As on standard error.
    pub warnings: Vec<String>,
    #[serde(flatten)]
    pub figures: Figures<Spread>,
}

/// The walk from one start. Infinite figures, of a robot that stood still, are null.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct StartResult {
    /// Number of the start, from 0.
    pub start: u32,
    pub start_yaw_deg: f64,
    /// The floor's friction differs by this share.
    pub start_friction_share: f64,
    /// Displacement along the world's y.
    pub sideways_m: f64,
    /// From the supply.
    pub energy_j: f64,
    /// Farthest that the torso leaned.
    pub max_tilt_deg: f64,
    pub fell: bool,
    #[serde(flatten)]
    pub figures: Figures<Option<f64>>,
}

/// The figures of a walk, or of all walks.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Figures<T> {
    /// Distance over time.
    pub speed_m_s: T,
    /// From the supply.
    pub mean_power_w: T,
    /// Energy per weight and distance.
    pub cost_of_transport: T,
    /// Net displacement.
    pub distance_m: T,
    /// Displacement along the world's x.
    pub forward_m: T,
    /// Counter-clockwise, whole turns included.
    pub turned_deg: T,
    /// Share of the time with torso or knees on the ground.
    pub dragged_share: T,
}

/// Where the figures of a walk are.
pub const OF_WALK: Figures<fn(&Walk) -> f64> = Figures {
    speed_m_s: |walk| walk.speed_m_s,
    mean_power_w: |walk| walk.mean_power_w,
    cost_of_transport: |walk| walk.cost_of_transport,
    distance_m: |walk| walk.distance_m,
    forward_m: |walk| walk.displacement_m[0],
    turned_deg: |walk| walk.turned_rad.to_degrees(),
    dragged_share: |walk| walk.dragged_share,
};

impl<T: Copy> Figures<T> {
    /// Each figure by itself.
    pub fn map<U>(&self, of: impl Fn(T) -> U) -> Figures<U> {
        Figures {
            speed_m_s: of(self.speed_m_s),
            mean_power_w: of(self.mean_power_w),
            cost_of_transport: of(self.cost_of_transport),
            distance_m: of(self.distance_m),
            forward_m: of(self.forward_m),
            turned_deg: of(self.turned_deg),
            dragged_share: of(self.dragged_share),
        }
    }
}

/// One figure over the starts.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Spread<T = Option<f64>> {
    /// Arithmetic mean; like the others null in JSON if it is infinite or NaN.
    pub mean: T,
    /// Standard deviation over the starts; 0 for a single one.
    pub spread: T,
    pub least: T,
    pub most: T,
}

/// A number that JSON can hold.
pub fn finite(value: f64) -> Option<f64> {
    value.is_finite().then_some(value)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_result_is_read_as_it_was_written() {
        let figure = |value: f64| OF_WALK.map(|_| finite(value));
        let still = StartResult {
            start: 0,
            start_yaw_deg: 1.0,
            start_friction_share: -0.1,
            sideways_m: 0.0,
            energy_j: 3.0,
            max_tilt_deg: 2.0,
            fell: true,
            figures: figure(f64::INFINITY),
        };
        let spread = Spread { mean: None, spread: Some(0.5), least: Some(0.25), most: None };
        let written = SimulateResult {
            gait: "gait.toml".into(),
            gait_name: "trot".into(),
            gait_sha256: "ab".into(),
            gait_source: "trained".into(),
            period_s: 1.2,
            amplitude: 2.0,
            duration_s: 60.0,
            starts: 1,
            seed: 7,
            robot: "Ant".into(),
            leg_scale: crate::robot::LegScale::LONG,
            mass_kg: 0.92,
            clipped_share: 0.0,
            fell: 1,
            walks: vec![still],
            warnings: vec!["it lags".into()],
            figures: OF_WALK.map(|_| spread),
        };

        let json = serde_json::to_value(&written).unwrap();

        assert!(json["speed_m_s"]["mean"].is_null() && json["walks"][0]["speed_m_s"].is_null(), "{json}");
        assert_eq!(serde_json::from_value::<SimulateResult>(json).unwrap(), written);
    }
}
