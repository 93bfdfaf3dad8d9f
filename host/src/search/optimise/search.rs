//! Looks for the gait: sows, lets the best compete, and refines the winner.
//!
//! Owns the budget, counted in simulated trials, and the order of the search.
//! Sowing tries many plain gaits once on the fitted robot. The best three are
//! searched further by CMA-ES (crate `cmaes`) among curves of one wave a
//! stride, on a few drawn robots; the best of these goes on among curves of
//! more waves, on more robots. What is best on robots that the search did not
//! see wins. The same seed and budget give the same gait on any number of cores.

mod onward;
mod pool;
mod refine;
mod start;

pub use onward::least_step;
pub use pool::Pool;
pub use start::Start;

use super::score::Test;
use super::space::{Motion, Space};
use super::tolerances::{Draw, Tolerances};
use crate::robot::Robot;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use refine::Round;
use std::sync::atomic::{AtomicBool, Ordering};

/// Gaits that compete.
const RIVALS: usize = 3;
/// Shares of the budget: sowing, and all rivals together. The rest refines.
const SOWING: f64 = 0.08;
const RIVALRY: f64 = 0.3;
/// What is left to the judges of a large budget.
const JUDGING: f64 = 0.03;
/// Spread of a search's first gaits, in units of [`Space`].
const RIVALS_STEP: f64 = 0.5;
const WINNERS_STEP: f64 = 0.2;
/// Gaits a generation: a multiple of the cores that people have.
const POPULATION: usize = 16;
/// Waves a stride of the curves that the winner is refined among.
const WAVES: [usize; 2] = [2, 3];
/// Finalists that a search among curves of some waves leaves: its best, and its middle.
const FINALISTS: usize = 2;
/// Judges of a search that was told to stop: people wait.
const HASTY_JUDGES: usize = 2;

/// Robots of a search's stages.
#[derive(Debug, Clone, Copy)]
struct Draws {
    /// Of the rivals' and of the winner's search.
    rivals: u64,
    winners: u64,
    /// Robots that choose among what the search found.
    judges: u64,
}

/// Of a search that is worth its name.
const USUAL: Draws = Draws { rivals: 2, winners: 4, judges: 16 };
/// Of a budget that the usual judges alone would spend: for trying things out.
const FEW: Draws = Draws { rivals: 1, winners: 1, judges: 2 };
/// Budgets below this have few robots.
pub const SMALL_BUDGET: u64 = 600;

const fn draws_for(budget: u64) -> Draws {
    if budget < SMALL_BUDGET { FEW } else { USUAL }
}

/// What a search is at.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stage {
    /// Plain gaits, each once.
    Sowing,
    /// The best of them, each searched on from.
    Rivals,
    /// The best of these, among richer curves.
    Refining,
    /// All that were found, on robots that no stage has seen.
    Judging,
}

/// How far a search has come.
#[derive(Debug, Clone, PartialEq)]
pub struct Progress<'a> {
    /// Where.
    pub stage: Stage,
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
    /// All that were in the running, to search on from.
    pub pool: Pool,
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
    /// Set by anybody who wants it to end now, with the best so far.
    pub stop: &'a AtomicBool,
}

/// Whom to tell, and how far it is.
struct Told<'a> {
    progress: &'a mut dyn FnMut(&Progress<'_>),
    stage: Stage,
    trials: u64,
}

impl Told<'_> {
    fn tell(&mut self, score: f64, motion: &Motion) {
        (self.progress)(&Progress { stage: self.stage, trials: self.trials, score, motion });
    }
}

impl Search<'_> {
    /// Searches until the budget is spent or `stop` is set.
    pub fn run(&self, start: &Start, progress: &mut dyn FnMut(&Progress<'_>)) -> Found {
        let mut told = Told { progress, stage: Stage::Sowing, trials: 0 };
        let sown = self.sow(start, &mut told);
        let plain = (self.space)(start.waves());
        // Their own robots for each stage: what pleased the last stage's by chance is found out.
        let count = draws_for(self.budget);
        let draws = self.draws(1, count.rivals);
        let until = |share: f64| (share * self.budget as f64) as u64;
        told.stage = Stage::Rivals;
        let mut rivals = Vec::new();
        for (k, point) in sown.into_iter().enumerate() {
            let share = SOWING + RIVALRY * (k + 1) as f64 / RIVALS as f64;
            let until = until(share);
            let round =
                Round { space: &plain, held: &[], draws: &draws, step: RIVALS_STEP, until, seed: self.seed };
            let found = self.refine(&round, point.clone(), &mut told);
            // Told to stop before anything was searched: as it was sown.
            rivals.extend(if found.is_empty() { vec![(f64::INFINITY, point)] } else { found });
        }
        rivals.sort_by(|a, b| a.0.total_cmp(&b.0));
        rivals.truncate(RIVALS);
        let mut finalists: Vec<Motion> = rivals.iter().map(|(_, point)| plain.motion(point)).collect();
        // As it is, richer curves and all: no search may come to less than what it began at.
        if let Start::Gait(motion) = start {
            finalists.push(plain.repaired((**motion).clone()));
        }
        let mut point = rivals.swap_remove(0).1;
        told.stage = Stage::Refining;
        let refining = self.judging_share(&count) - SOWING - RIVALRY;
        for (k, waves) in WAVES.into_iter().enumerate() {
            if self.stopped() {
                break;
            }
            let space = (self.space)(waves);
            let draws = self.draws(2 + k as u64, count.winners);
            let until = until(SOWING + RIVALRY + refining * (k + 1) as f64 / WAVES.len() as f64);
            let from = padded(&point, space.dimension());
            let round =
                Round { space: &space, held: &[], draws: &draws, step: WINNERS_STEP, until, seed: self.seed };
            let found = self.refine(&round, from, &mut told);
            finalists.extend(found.iter().map(|(_, point)| space.motion(point)));
            if let Some((_, best)) = found.into_iter().min_by(|a, b| a.0.total_cmp(&b.0)) {
                point = best;
            }
        }
        self.judged(finalists, told)
    }

    /// The share of the budget at which judging begins.
    fn judging_share(&self, count: &Draws) -> f64 {
        if self.budget < SMALL_BUDGET {
            // Three per cent would be less than one walk of each finalist.
            let walks = count.judges as usize * (RIVALS + FINALISTS * WAVES.len());
            1.0 - walks as f64 / self.budget.max(1) as f64
        } else {
            1.0 - JUDGING
        }
    }

    /// The finalist that is best on robots that no stage has seen.
    fn judged(&self, finalists: Vec<Motion>, mut told: Told<'_>) -> Found {
        let stopped = self.stopped();
        told.stage = Stage::Judging;
        let mut judges = self.draws(9, draws_for(self.budget).judges);
        if stopped {
            judges.truncate(HASTY_JUDGES);
        }
        let first = finalists[0].clone();
        let mut pool = Pool::new(judges);
        told.trials += pool.add(&self.test, finalists);
        let (score, motion) =
            pool.best(&self.test).map_or((f64::INFINITY, first), |best| (best.score, best.motion.clone()));
        told.tell(score, &motion);
        Found { motion, pool, trials: told.trials, stopped }
    }

    fn stopped(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
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
            let tried =
                |point: &Vec<f64>| (!self.stopped()).then(|| self.test.score(&nominal, &space.motion(point)));
            let scores: Vec<Option<f64>> = part.par_iter().map(tried).collect();
            told.trials += scores.iter().flatten().count() as u64;
            let scores = scores.into_iter().map(|score| score.unwrap_or(f64::INFINITY));
            scored.extend(scores.zip(part.iter().cloned()));
            scored.sort_by(|a, b| a.0.total_cmp(&b.0));
            scored.truncate(RIVALS);
            if self.stopped() {
                break;
            }
            if let Some((score, point)) = scored.first() {
                told.tell(*score, &space.motion(point));
            }
        }
        scored.into_iter().map(|(_, point)| point).collect()
    }
}

/// A point among fewer waves, or of a longer search, as long as `dimension`.
fn padded(point: &[f64], dimension: usize) -> Vec<f64> {
    point.iter().copied().chain(core::iter::repeat(0.0)).take(dimension).collect()
}

#[cfg(test)]
mod tests;
