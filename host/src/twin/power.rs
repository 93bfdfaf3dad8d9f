//! The electrical power that explains measured powers best, within physics.
//!
//! `P = electronics + mechanical / efficiency + holding` is linear in two
//! numbers that must stay within bounds, so the best are found exactly for any
//! simulated trials, and the search has two parameters less.

use super::predict::Prediction;
use crate::robot::Power;

/// Eight idle servos at 4 mA or more, a Nano at 15 and a PCA9685 at 6, all at
/// 5 V: a robot that stands still draws no less.
const ELECTRONICS_W: (f64, f64) = (0.25, 0.6);
/// One over the efficiency, which is never above 1 and no servo's below 0.1.
const INVERSE_EFFICIENCY: (f64, f64) = (1.0, 10.0);

/// Least squares of the relative errors of power, within the bounds.
pub fn best(power: &Power, predictions: &[Prediction], measured_w: &[f64]) -> Power {
    // Each trial: e a + k b = c, in shares of what was measured.
    let rows: Vec<[f64; 3]> = predictions
        .iter()
        .zip(measured_w)
        .map(|(p, measured)| [1.0 / measured, p.mechanical_w / measured, 1.0 - p.holding_w / measured])
        .collect();
    let sum = |of: fn(&[f64; 3]) -> f64| rows.iter().map(of).sum::<f64>();
    let (aa, bb, ab) = (sum(|r| r[0] * r[0]), sum(|r| r[1] * r[1]), sum(|r| r[0] * r[1]));
    let (ac, bc) = (sum(|r| r[0] * r[2]), sum(|r| r[1] * r[2]));
    let within = |value: f64, (min, max): (f64, f64)| value.max(min).min(max);
    let determinant = aa * bb - ab * ab;
    let inside = [(ac * bb - bc * ab) / determinant, (bc * aa - ac * ab) / determinant];
    // The least of a bowl over a rectangle lies inside, or on one of four edges.
    let on_edge_of_e = |e: f64| [e, within((bc - ab * e) / bb, INVERSE_EFFICIENCY)];
    let on_edge_of_k = |k: f64| [within((ac - ab * k) / aa, ELECTRONICS_W), k];
    let candidates = [
        [within(inside[0], ELECTRONICS_W), within(inside[1], INVERSE_EFFICIENCY)],
        on_edge_of_e(ELECTRONICS_W.0),
        on_edge_of_e(ELECTRONICS_W.1),
        on_edge_of_k(INVERSE_EFFICIENCY.0),
        on_edge_of_k(INVERSE_EFFICIENCY.1),
    ];
    let residual =
        |x: &[f64; 2]| rows.iter().map(|r| (r[0] * x[0] + r[1] * x[1] - r[2]).powi(2)).sum::<f64>();
    let mut best = [ELECTRONICS_W.0, INVERSE_EFFICIENCY.0];
    for candidate in candidates {
        if residual(&candidate) < residual(&best) {
            best = candidate;
        }
    }
    Power { electronics_w: best[0], efficiency: 1.0 / best[1], ..power.clone() }
}

/// What that power model says of a trial.
pub fn of(power: &Power, prediction: &Prediction) -> f64 {
    power.electronics_w + prediction.mechanical_w / power.efficiency + prediction.holding_w
}
