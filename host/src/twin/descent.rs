//! Local search for the nearest minimum of the score.
//!
//! Levenberg and Marquardt's method on reweighted errors: the score is a mean
//! of absolute errors, so an error of half the size gets twice the weight. The
//! simulation is smooth in its parameters, so finite differences give the gradient,
//! and all sets of a step are scored in parallel.

use super::objective::{Objective, Verdict};
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

/// Share of a parameter's range over which a slope is taken.
const DIFFERENCE: f64 = 0.02;
/// Errors below this are as good as none.
const FINE_ERROR: f64 = 0.01;
/// Dampings that are tried at once, as multiples of the last one's.
const DAMPINGS: [f64; 4] = [0.1, 1.0, 10.0, 100.0];
/// Makes the least of them ten times the largest that has just failed.
const BEYOND_ALL_DAMPINGS: f64 = 10_000.0;
/// Where nothing is gained beyond that, it is the bottom.
const LEAST_GAIN: f64 = 2e-4;
/// Nor with this damping.
const MOST_DAMPING: f64 = 1e6;

/// How a descent goes on.
pub struct Descent {
    /// Shares of the parameters' ranges, within 0 to 1.
    pub shares: Vec<f64>,
    /// What they come to.
    pub verdict: Verdict,
    damping: f64,
    /// Change of each error per share of each parameter, here.
    slopes: Option<DMatrix<f64>>,
}

impl Descent {
    /// Begins at a set.
    pub fn new(objective: &Objective<'_>, shares: &[f64]) -> Self {
        let shares: Vec<f64> = shares.iter().map(|share| share.clamp(0.0, 1.0)).collect();
        let verdict = objective.judge(&shares);
        Self { shares, verdict, damping: 0.1, slopes: None }
    }

    /// Sets that a step judges.
    pub fn cost(&self) -> u64 {
        (self.shares.len() + DAMPINGS.len()) as u64
    }

    /// One step; `false` at the bottom.
    pub fn step(&mut self, objective: &Objective<'_>) -> bool {
        let slopes = self.slopes.take().unwrap_or_else(|| self.slopes(objective));
        let steps: Vec<Vec<f64>> =
            DAMPINGS.iter().map(|factor| self.solve(&slopes, self.damping * factor)).collect();
        let verdicts: Vec<Verdict> = steps.par_iter().map(|shares| objective.judge(shares)).collect();
        let best = verdicts
            .into_iter()
            .zip(steps)
            .zip(DAMPINGS)
            .min_by(|((a, _), _), ((b, _), _)| a.score.total_cmp(&b.score));
        match best {
            Some(((verdict, shares), factor)) if verdict.score < self.verdict.score => {
                let gained = self.verdict.score - verdict.score;
                self.damping = (self.damping * factor).max(1e-6);
                (self.verdict, self.shares) = (verdict, shares);
                gained > LEAST_GAIN * self.verdict.score
            }
            _ => {
                self.slopes = Some(slopes);
                self.damping *= BEYOND_ALL_DAMPINGS;
                self.damping < MOST_DAMPING
            }
        }
    }

    fn slopes(&self, objective: &Objective<'_>) -> DMatrix<f64> {
        let columns: Vec<Vec<f64>> = (0..self.shares.len())
            .into_par_iter()
            .map(|k| {
                let difference = if self.shares[k] + DIFFERENCE > 1.0 { -DIFFERENCE } else { DIFFERENCE };
                let mut shares = self.shares.clone();
                shares[k] += difference;
                let there = objective.judge(&shares).errors;
                there
                    .iter()
                    .zip(&self.verdict.errors)
                    .map(|(there, here)| (there - here) / difference)
                    .collect()
            })
            .collect();
        DMatrix::from_fn(self.verdict.errors.len(), columns.len(), |row, column| columns[column][row])
    }

    /// The set to which a damped step leads, kept within the ranges.
    fn solve(&self, slopes: &DMatrix<f64>, damping: f64) -> Vec<f64> {
        let weights: Vec<f64> =
            self.verdict.errors.iter().map(|error| 1.0 / error.abs().max(FINE_ERROR)).collect();
        let weighted = DMatrix::from_fn(slopes.nrows(), slopes.ncols(), |i, k| weights[i] * slopes[(i, k)]);
        let normal = slopes.transpose() * &weighted;
        let towards = -(weighted.transpose() * DVector::from_column_slice(&self.verdict.errors));
        let mut held = vec![false; self.shares.len()];
        // A parameter at its bound that would leave it is held there, and the others solved again.
        for _ in 0..self.shares.len() {
            let matrix =
                DMatrix::from_fn(held.len(), held.len(), |i, k| match (held[i] || held[k], i == k) {
                    (true, same) => f64::from(u8::from(same)),
                    (false, true) => normal[(i, i)] * (1.0 + damping) + 1e-9,
                    (false, false) => normal[(i, k)],
                });
            let right = DVector::from_fn(held.len(), |i, _| if held[i] { 0.0 } else { towards[i] });
            let Some(step) = matrix.cholesky().map(|matrix| matrix.solve(&right)) else { break };
            let leaves: Vec<usize> = (0..held.len())
                .filter(|k| {
                    let at_bound = (self.shares[*k] <= 0.0 && step[*k] < 0.0)
                        || (self.shares[*k] >= 1.0 && step[*k] > 0.0);
                    !held[*k] && at_bound
                })
                .collect();
            if leaves.is_empty() {
                return self.shares.iter().zip(step.iter()).map(|(x, dx)| (x + dx).clamp(0.0, 1.0)).collect();
            }
            for k in leaves {
                held[k] = true;
            }
        }
        self.shares.clone()
    }
}
