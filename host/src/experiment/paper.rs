//! What the paper prints.
//!
//! Owns its numbers and nothing else: Zhu and Rosendo, *PSTO: Learning
//! Energy-Efficient Locomotion for Quadruped Robots*, Machines 2022, 10, 185.

use super::method::Method;

/// Amplifications of sections 2.4 and 3.
pub const AMPLIFICATIONS: [f64; 8] = [1.0, 1.2, 1.4, 1.6, 1.8, 2.0, 2.2, 2.4];
/// Legs of both groups, in units of 23 cm.
pub const LEGS: [f64; 2] = [1.0, 0.6];
/// Length of a trial.
pub const TRIAL_S: f64 = 12.0;
/// The speed at which Figure 5 compares.
pub const FIGURE_5_SPEED_M_S: f64 = 0.12;
/// The speed that its robot does not exceed.
pub const TOP_SPEED_M_S: f64 = 0.139;

/// Table 2: cost of transport and speed of the best of a method.
#[must_use]
pub fn table_2(method: Method, leg: f64) -> Option<(f64, f64)> {
    let long = (leg - LEGS[0]).abs() < 1e-9;
    let short = (leg - LEGS[1]).abs() < 1e-9;
    match method {
        Method::Original if long => Some((0.688, 0.127)),
        Method::Sinusoid if long => Some((0.639, 0.127)),
        Method::Psto if long => Some((0.595, 0.139)),
        Method::Original if short => Some((0.839, 0.096)),
        Method::Sinusoid if short => Some((0.764, 0.104)),
        Method::Psto if short => Some((0.563, 0.139)),
        _ => None,
    }
}

/// Figure 5 and section 3: mean power at 0.12 m/s on long legs.
#[must_use]
pub const fn figure_5_w(method: Method) -> Option<f64> {
    match method {
        Method::Original => Some(0.837),
        Method::Sinusoid => Some(0.802),
        Method::Psto => Some(0.776),
        _ => None,
    }
}
