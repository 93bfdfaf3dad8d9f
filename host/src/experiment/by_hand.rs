//! Conditions and studies made by hand, for tests.

use super::method::Method;
use super::study::{LegStudy, Study, Venue};
use super::summary::{self, Condition, Mean};
use crate::robot::LegScale;

/// A mean, give or take so much.
pub fn mean(mean: f64, half: f64) -> Option<Mean> {
    Some(Mean { mean, ci95: Some(half) })
}

/// A condition of three trials without figures.
pub fn condition(method: Method, leg: LegScale, amplification: f64) -> Condition {
    Condition {
        method,
        leg,
        amplification,
        n: 3,
        trials: 3,
        speed_m_s: None,
        power_w: None,
        cost_of_transport: None,
        falls: 0,
        marks: Vec::new(),
        setpoint_speed_max_rad_s: None,
        not_run: None,
    }
}

/// A study of such conditions, with nothing else in it.
pub fn study(legs: &[LegScale], conditions: Vec<Condition>) -> Study {
    let of_leg = |&leg: &LegScale| LegStudy { leg, gaits: Vec::new(), learning: None, stride: None };
    Study {
        robot: "Ant".into(),
        venue: Venue::Twin,
        legs: legs.iter().map(of_leg).collect(),
        best: summary::best(&conditions),
        conditions,
        claims: Vec::new(),
        trials: Vec::new(),
        parameters: Vec::new(),
        descriptions: Vec::new(),
        skipped: Vec::new(),
        energy: Vec::new(),
        prepare_wall_s: 0.0,
        wall_s: 125.0,
    }
}
