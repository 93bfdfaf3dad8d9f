//! Looks for the gait: sows, lets the best compete, and refines the winner.
//!
//! Owns the budget, counted in simulated trials, and the order of the search.
//! Sowing tries many plain gaits once on the fitted robot. The best three are
//! searched further by CMA-ES (crate `cmaes`) among curves of one wave a
//! stride, on a few drawn robots; the best of these goes on among curves of
//! more waves, on more robots. What is best on robots that the search did not
//! see wins. The same seed and budget give the same gait on any number of cores.

mod start;

pub use start::Start;

use super::score::Test;
use super::space::{Motion, Space};
use super::tolerances::{Draw, Tolerances};
use crate::robot::Robot;
use cmaes::{CMAESOptions, DVector};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use std::sync::Mutex;

/// Gaits that compete.
const RIVALS: usize = 3;
/// Shares of the budget: sowing, and all rivals together. The rest refines.
const SOWING: f64 = 0.08;
const RIVALRY: f64 = 0.3;
/// Drawn robots of the rivals' and of the winner's search.
const RIVALS_DRAWS: u64 = 2;
const WINNERS_DRAWS: u64 = 4;
/// Robots that choose among what the search found.
const JUDGES: u64 = 16;
/// Spread of a search's first gaits, in units of [`Space`].
const RIVALS_STEP: f64 = 0.5;
const WINNERS_STEP: f64 = 0.2;
/// Gaits a generation: a multiple of the cores that people have.
const POPULATION: usize = 16;
/// Waves a stride of the curves that the winner is refined among.
const WAVES: [usize; 2] = [2, 3];

/// How far a search has come.
#[derive(Debug, Clone, PartialEq)]
pub struct Progress<'a> {
    /// Trials simulated.
    pub trials: u64,
    /// Of the best gait of this stage.
    pub score: f64,
    /// That gait.
    pub motion: &'a Motion,
}

/// What a search found.
#[derive(Debug, Clone, PartialEq)]
pub struct Found {
    /// The gait.
    pub motion: Motion,
    /// Trials simulated.
    pub trials: u64,
    /// Whether it was told to stop.
    pub stopped: bool,
}

/// What is searched, and how long.
pub struct Search<'a> {
    /// The robot that the draws surround.
    pub robot: &'a Robot,
    /// The gaits, by waves a stride.
    pub space: &'a (dyn Fn(usize) -> Space + Sync),
    /// What is wanted.
    pub test: Test,
    /// What must be borne.
    pub tolerances: Tolerances,
    /// Of everything that is drawn.
    pub seed: u64,
    /// Trials to simulate, or a few more.
    pub budget: u64,
}

/// Whom to tell, and what was said.
struct Told<'a> {
    progress: &'a mut dyn FnMut(&Progress<'_>) -> bool,
    trials: u64,
    stopped: bool,
}

impl Told<'_> {
    fn tell(&mut self, score: f64, motion: &Motion) -> bool {
        self.stopped |= !(self.progress)(&Progress { trials: self.trials, score, motion });
        !self.stopped
    }
}

impl Search<'_> {
    /// Searches until the budget is spent or `progress` says `false`.
    pub fn run(&self, start: &Start, progress: &mut dyn FnMut(&Progress<'_>) -> bool) -> Found {
        let mut told = Told { progress, trials: 0, stopped: false };
        let sown = self.sow(start, &mut told);
        let plain = (self.space)(start.waves());
        // Their own robots for each stage: what pleased the last stage's by chance is found out.
        let draws = self.draws(1, RIVALS_DRAWS);
        let until = |share: f64| (share * self.budget as f64) as u64;
        let mut rivals = Vec::new();
        for (k, point) in sown.into_iter().enumerate() {
            let share = SOWING + RIVALRY * (k + 1) as f64 / RIVALS as f64;
            let found = self.refine(&plain, &draws, point.clone(), RIVALS_STEP, until(share), &mut told);
            // Told to stop before anything was searched: as it was sown.
            rivals.extend(if found.is_empty() { vec![(f64::INFINITY, point)] } else { found });
        }
        rivals.sort_by(|a, b| a.0.total_cmp(&b.0));
        rivals.truncate(RIVALS);
        let mut finalists: Vec<Motion> = rivals.iter().map(|(_, point)| plain.motion(point)).collect();
        let mut point = rivals.swap_remove(0).1;
        for (k, waves) in WAVES.into_iter().enumerate() {
            if told.stopped {
                break;
            }
            let space = (self.space)(waves);
            let draws = self.draws(2 + k as u64, WINNERS_DRAWS);
            let share = SOWING + RIVALRY + (0.97 - SOWING - RIVALRY) * (k + 1) as f64 / WAVES.len() as f64;
            let from = padded(&point, space.dimension());
            let found = self.refine(&space, &draws, from, WINNERS_STEP, until(share), &mut told);
            finalists.extend(found.iter().map(|(_, point)| space.motion(point)));
            if let Some((_, best)) = found.into_iter().min_by(|a, b| a.0.total_cmp(&b.0)) {
                point = best;
            }
        }
        self.judged(finalists, told)
    }

    /// Searches on from a gait, among curves of more waves alone; what it was
    /// itself stays in the running.
    pub fn go_on(&self, from: &Motion, progress: &mut dyn FnMut(&Progress<'_>) -> bool) -> Found {
        let mut told = Told { progress, trials: 0, stopped: false };
        let space = (self.space)(WAVES[0]);
        let until = self.budget.saturating_sub(JUDGES * 3);
        let draws = self.draws(2, WINNERS_DRAWS);
        let found = self.refine(&space, &draws, space.point(from), WINNERS_STEP, until, &mut told);
        let finalists =
            core::iter::once(from.clone()).chain(found.iter().map(|(_, point)| space.motion(point)));
        self.judged(finalists.collect(), told)
    }

    /// The finalist that is best on robots that no stage has seen.
    fn judged(&self, mut finalists: Vec<Motion>, mut told: Told<'_>) -> Found {
        let judges = self.draws(9, JUDGES);
        let judged: Vec<f64> = finalists.par_iter().map(|motion| self.test.score(&judges, motion)).collect();
        told.trials += JUDGES * finalists.len() as u64;
        let best = judged.iter().enumerate().min_by(|a, b| a.1.total_cmp(b.1)).map_or(0, |(k, _)| k);
        told.tell(judged[best], &finalists[best]);
        Found { motion: finalists.swap_remove(best), trials: told.trials, stopped: told.stopped }
    }

    /// Robots of one stage.
    fn draws(&self, stage: u64, count: u64) -> Vec<Draw> {
        (0..count).map(|k| self.tolerances.draw(self.robot, self.seed, stage << 32 | k)).collect()
    }

    /// Points to search on from, the best first.
    fn sow(&self, start: &Start, told: &mut Told<'_>) -> Vec<Vec<f64>> {
        let space = (self.space)(start.waves());
        let count = ((SOWING * self.budget as f64) as usize).max(RIVALS);
        let mut random = ChaCha8Rng::seed_from_u64(self.seed);
        let points: Vec<Vec<f64>> = (0..count).map(|k| start.point(&space, k, &mut random)).collect();
        let nominal = [Draw::nominal(self.robot)];
        let mut scored: Vec<(f64, Vec<f64>)> = Vec::with_capacity(points.len());
        for part in points.chunks(8 * POPULATION) {
            let scores: Vec<f64> =
                part.par_iter().map(|point| self.test.score(&nominal, &space.motion(point))).collect();
            told.trials += part.len() as u64;
            scored.extend(scores.into_iter().zip(part.iter().cloned()));
            scored.sort_by(|a, b| a.0.total_cmp(&b.0));
            scored.truncate(RIVALS);
            let best = scored.first().map(|(score, point)| (*score, space.motion(point)));
            if best.is_some_and(|(score, motion)| !told.tell(score, &motion)) {
                break;
            }
        }
        scored.into_iter().map(|(_, point)| point).collect()
    }

    /// CMA-ES from a point, again with another seed where it has converged; its
    /// best points and the middle of where it ended.
    fn refine(
        &self,
        space: &Space,
        draws: &[Draw],
        from: Vec<f64>,
        step: f64,
        until: u64,
        told: &mut Told<'_>,
    ) -> Vec<(f64, Vec<f64>)> {
        let trials = Mutex::new(told.trials);
        let score = |point: &DVector<f64>| {
            if let Ok(mut trials) = trials.lock() {
                *trials += draws.len() as u64;
            }
            self.test.score(draws, &space.motion(point.as_slice()))
        };
        let mut found: Vec<(f64, Vec<f64>)> = Vec::new();
        let mut from = from;
        let mut again = 0_u32;
        while !told.stopped && told.trials < until {
            let options = CMAESOptions::new(from.clone(), step / f64::from(1 + again))
                .population_size(POPULATION)
                .seed(self.seed.wrapping_add(u64::from(again)));
            let Ok(mut search) = options.build(score) else { break };
            let mut best: Option<(f64, Vec<f64>)> = None;
            loop {
                let ended = search.next_parallel().is_some();
                told.trials = trials.lock().map_or(told.trials, |trials| *trials);
                if let Some(individual) = search.overall_best_individual() {
                    best = Some((individual.value, individual.point.iter().copied().collect()));
                }
                let Some((score, point)) = &best else { break };
                if !told.tell(*score, &space.motion(point)) || ended || told.trials >= until {
                    break;
                }
            }
            let middle: Vec<f64> = search.mean().iter().copied().collect();
            let middle_score = score(search.mean());
            told.trials = trials.lock().map_or(told.trials, |trials| *trials);
            let Some(best) = best else { break };
            from.clone_from(&best.1);
            found.extend([best, (middle_score, middle)]);
            again += 1;
        }
        found
    }
}

/// A point among fewer waves, or of a longer search, as long as `dimension`.
fn padded(point: &[f64], dimension: usize) -> Vec<f64> {
    point.iter().copied().chain(core::iter::repeat(0.0)).take(dimension).collect()
}

#[cfg(test)]
mod tests;
