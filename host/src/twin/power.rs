//! The electrical power that explains measured powers best, within physics.
//!
//! `P = electronics + mechanical / efficiency + heat * torque^2` is linear in
//! three numbers that must stay within bounds, so the best are found exactly
//! for any simulated trials, and the search has three parameters less.

use super::predict::Prediction;
use crate::robot::Power;
use nalgebra::{DMatrix, DVector};

/// Controller, driver and eight idle servos: 20 to 100 mA at 5 V.
const ELECTRONICS_W: (f64, f64) = (0.1, 0.5);
/// One over the efficiency, which is never above 1 and no servo's below 0.1.
const INVERSE_EFFICIENCY: (f64, f64) = (1.0, 10.0);
/// The winding's heat. A servo that is stalled at 1 N m draws 5 to 10 W.
const HEAT_W_PER_N2_M2: (f64, f64) = (0.0, 10.0);

/// Least squares of the relative errors of power, within the bounds.
pub fn best(predictions: &[Prediction], measured_w: &[f64]) -> Power {
    let bounds = [ELECTRONICS_W, INVERSE_EFFICIENCY, HEAT_W_PER_N2_M2];
    let columns = |p: &Prediction| [1.0, p.mechanical_w, p.squared_torque_n2_m2];
    let rows: Vec<[f64; 3]> = predictions
        .iter()
        .zip(measured_w)
        .map(|(prediction, measured)| columns(prediction).map(|value| value / measured))
        .collect();
    let residual = |x: &[f64; 3]| -> f64 {
        rows.iter().map(|row| (row.iter().zip(x).map(|(a, b)| a * b).sum::<f64>() - 1.0).powi(2)).sum()
    };
    let mut best = [bounds[0].0, bounds[1].0, bounds[2].0];
    let mut least = residual(&best);
    // Each number is free, or at its lower, or at its upper bound.
    for code in 0..27 {
        let mut x = [0.0; 3];
        let mut free = Vec::new();
        for (k, value) in x.iter_mut().enumerate() {
            match code / 3_usize.pow(k as u32) % 3 {
                0 => free.push(k),
                1 => *value = bounds[k].0,
                _ => *value = bounds[k].1,
            }
        }
        if !free.is_empty() {
            let matrix = DMatrix::from_fn(rows.len(), free.len(), |row, k| rows[row][free[k]]);
            let rest = DVector::from_fn(rows.len(), |row, _| {
                1.0 - rows[row].iter().zip(&x).map(|(a, b)| a * b).sum::<f64>()
            });
            let Ok(solved) = matrix.svd(true, true).solve(&rest, 1e-12) else { continue };
            for (k, value) in free.iter().zip(solved.iter()) {
                x[*k] = *value;
            }
        }
        let allowed = x.iter().zip(bounds).all(|(value, (min, max))| (min..=max).contains(value));
        if allowed && residual(&x) < least {
            (best, least) = (x, residual(&x));
        }
    }
    Power { electronics_w: best[0], efficiency: 1.0 / best[1], heat_w_per_n2_m2: best[2] }
}

/// What that power model says of a trial.
pub fn of(power: &Power, prediction: &Prediction) -> f64 {
    power.electronics_w
        + prediction.mechanical_w / power.efficiency
        + power.heat_w_per_n2_m2 * prediction.squared_torque_n2_m2
}
