//! CMA-ES from a point, on a few robots.
//!
//! Holds the use of crate `cmaes`: seeds, generations, what is kept. Does not
//! depend on the stages of a search.

use super::{POPULATION, ProgressReporter, Search};
use crate::search::optimise::space::{Motion, Space};
use crate::search::optimise::tolerances::Draw;
use cmaes::{CMAESOptions, DVector};
use std::sync::Mutex;

/// One refinement.
pub(super) struct Round<'a> {
    /// The gaits of the points.
    pub(super) space: &'a Space,
    /// Numbers behind every point, which stay as they are.
    pub(super) held: &'a [f64],
    /// The robots.
    pub(super) draws: &'a [Draw],
    /// Spread of the first generation.
    pub(super) step: f64,
    /// It ends when the search has simulated so many trials.
    pub(super) until: u64,
    /// Of the first generation; restarts count on from it.
    pub(super) seed: u64,
}

impl Round<'_> {
    /// The gait of a point.
    pub(super) fn motion(&self, point: &[f64]) -> Motion {
        if self.held.is_empty() {
            self.space.motion(point)
        } else {
            self.space.motion(&[point, self.held].concat())
        }
    }
}

impl Search<'_> {
    /// CMA-ES from a point, restarted with another seed when it has converged. Returns scores and
    /// points: the best of each run and the mean of its last generation.
    pub(super) fn refine(
        &self,
        round: &Round<'_>,
        from: Vec<f64>,
        reporter: &mut ProgressReporter<'_>,
    ) -> Vec<(f64, Vec<f64>)> {
        let trials = Mutex::new(reporter.trials);
        let score = |point: &DVector<f64>| {
            if self.stopped() {
                // Ends the generation; points that were not tried have no score.
                return f64::NAN;
            }
            if let Ok(mut trials) = trials.lock() {
                *trials += round.draws.len() as u64;
            }
            self.test.score(round.draws, &round.motion(point.as_slice()))
        };
        let mut found: Vec<(f64, Vec<f64>)> = Vec::new();
        let mut from = from;
        let mut again = 0_u32;
        while !self.stopped() && reporter.trials < round.until {
            let options = CMAESOptions::new(from.clone(), round.step / f64::from(1 + again))
                .population_size(POPULATION)
                .seed(round.seed.wrapping_add(u64::from(again)));
            let Ok(mut search) = options.build(score) else { break };
            let mut best: Option<(f64, Vec<f64>)> = None;
            loop {
                let ended = search.next_parallel().is_some();
                reporter.trials = trials.lock().map_or(reporter.trials, |trials| *trials);
                if let Some(individual) = search.overall_best_individual() {
                    best = Some((individual.value, individual.point.iter().copied().collect()));
                }
                let Some((score, point)) = &best else { break };
                reporter.report(*score, &round.motion(point));
                if ended || self.stopped() || reporter.trials >= round.until {
                    break;
                }
            }
            let mean: Vec<f64> = search.mean().iter().copied().collect();
            let mean_score = score(search.mean());
            reporter.trials = trials.lock().map_or(reporter.trials, |trials| *trials);
            let Some(best) = best else { break };
            from.clone_from(&best.1);
            found.push(best);
            if !mean_score.is_nan() {
                found.push((mean_score, mean));
            }
            again += 1;
        }
        found
    }
}
