//! The search: initialise with many gaits, refine the best few, validate.
//!
//! Holds the budget, counted in simulated trials, and the order of the stages.
//! The first stage tries many plain gaits once on the fitted robot. The best
//! three are refined by CMA-ES (crate `cmaes`) among curves of one wave per
//! stride, on a few sampled robots; the best of these is refined further among
//! curves of more waves, on more robots. The result is the gait that is best on
//! validation robots, which the search did not see. The same seed and budget
//! give the same gait on any number of cores. Does not depend on files and flags.

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

/// Gaits of the first stage that are refined.
const CANDIDATES: usize = 3;
/// Shares of the budget: the first stage, and all candidates together. The rest refines the best.
const INITIAL_SHARE: f64 = 0.08;
const CANDIDATES_SHARE: f64 = 0.3;
/// Share of a large budget that is left for validation.
const VALIDATION_SHARE: f64 = 0.03;
/// Spread of a search's first gaits, in units of [`Space`].
const CANDIDATES_STEP: f64 = 0.5;
const REFINING_STEP: f64 = 0.2;
/// Gaits of a generation: a multiple of the cores that people have.
const POPULATION: usize = 16;
/// Waves per stride of the curves among which the best candidate is refined.
const WAVES: [usize; 2] = [2, 3];
/// Finalists from each kind of curves: the best point, and the mean of the last generation.
const FINALISTS: usize = 2;
/// Validation robots after Ctrl-C, when somebody waits.
const VALIDATION_ROBOTS_AFTER_STOP: usize = 2;

/// Numbers of robots in the stages of a search.
#[derive(Debug, Clone, Copy)]
struct Draws {
    /// On which each candidate is refined,
    candidates: u64,
    /// on which the best of them is refined,
    refining: u64,
    /// and on which the finalists are compared.
    validation: u64,
}

/// For usual budgets.
const USUAL: Draws = Draws { candidates: 2, refining: 4, validation: 16 };
/// For budgets that the usual validation alone would spend: to try the command out.
const FEW: Draws = Draws { candidates: 1, refining: 1, validation: 2 };
/// Budgets below this have few robots.
pub const SMALL_BUDGET: u64 = 600;

const fn draws_for(budget: u64) -> Draws {
    if budget < SMALL_BUDGET { FEW } else { USUAL }
}

/// Stage of a search.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stage {
    /// Many gaits, each tried once on the fitted robot.
    Initialising,
    /// The best of them, each refined by itself.
    Candidates,
    /// The best candidate, refined among richer curves.
    Refining,
    /// All finalists, on robots that no stage has seen.
    Validating,
}

/// Progress of a search.
#[derive(Debug, Clone, PartialEq)]
pub struct Progress<'a> {
    /// The stage that runs.
    pub stage: Stage,
    /// Trials simulated so far.
    pub trials: u64,
    /// Score of the best gait of this stage; lower is better.
    pub score: f64,
    /// That gait.
    pub motion: &'a Motion,
}

/// Result of a search.
#[derive(Debug, Clone, PartialEq)]
pub struct Found {
    /// The gait.
    pub motion: Motion,
    /// All finalists, to continue from.
    pub pool: Pool,
    /// Trials simulated.
    pub trials: u64,
    /// Whether it was told to stop.
    pub stopped: bool,
}

/// A search, before it runs.
pub struct Search<'a> {
    /// The fitted robot, about which robots are sampled.
    pub robot: &'a Robot,
    /// The gaits, by waves per stride.
    pub space: &'a (dyn Fn(usize) -> Space + Sync),
    /// Aim and length of a trial.
    pub test: Test,
    /// How sampled robots differ.
    pub tolerances: Tolerances,
    /// Random seed.
    pub seed: u64,
    /// Trials to simulate; exceeded by one generation and the validation at most.
    pub budget: u64,
    /// Set to end the search now, with the best gait so far.
    pub stop: &'a AtomicBool,
}

/// Reports progress.
struct ProgressReporter<'a> {
    progress: &'a mut dyn FnMut(&Progress<'_>),
    stage: Stage,
    trials: u64,
}

impl ProgressReporter<'_> {
    fn report(&mut self, score: f64, motion: &Motion) {
        (self.progress)(&Progress { stage: self.stage, trials: self.trials, score, motion });
    }
}

impl Search<'_> {
    /// Searches until the budget is spent or `stop` is set.
    pub fn run(&self, start: &Start, progress: &mut dyn FnMut(&Progress<'_>)) -> Found {
        let mut reporter = ProgressReporter { progress, stage: Stage::Initialising, trials: 0 };
        let initial = self.initial(start, &mut reporter);
        let plain = (self.space)(start.waves());
        // Other robots for each stage: a gait that suited the last stage's by chance is found out.
        let count = draws_for(self.budget);
        let draws = self.draws(1, count.candidates);
        let until = |share: f64| (share * self.budget as f64) as u64;
        reporter.stage = Stage::Candidates;
        let mut candidates = Vec::new();
        for (k, point) in initial.into_iter().enumerate() {
            let share = INITIAL_SHARE + CANDIDATES_SHARE * (k + 1) as f64 / CANDIDATES as f64;
            let until = until(share);
            let round = Round {
                space: &plain,
                held: &[],
                draws: &draws,
                step: CANDIDATES_STEP,
                until,
                seed: self.seed,
            };
            let found = self.refine(&round, point.clone(), &mut reporter);
            // Stopped before anything was refined: as it was tried first.
            candidates.extend(if found.is_empty() { vec![(f64::INFINITY, point)] } else { found });
        }
        candidates.sort_by(|a, b| a.0.total_cmp(&b.0));
        candidates.truncate(CANDIDATES);
        let mut finalists: Vec<Motion> = candidates.iter().map(|(_, point)| plain.motion(point)).collect();
        // Unchanged, with all its curves: no search may end with a worse gait than it started from.
        if let Start::Gait(motion) = start {
            finalists.push(plain.repaired((**motion).clone()));
        }
        let mut point = candidates.swap_remove(0).1;
        reporter.stage = Stage::Refining;
        let refining = self.validation_begins_at(&count) - INITIAL_SHARE - CANDIDATES_SHARE;
        for (k, waves) in WAVES.into_iter().enumerate() {
            if self.stopped() {
                break;
            }
            let space = (self.space)(waves);
            let draws = self.draws(2 + k as u64, count.refining);
            let until =
                until(INITIAL_SHARE + CANDIDATES_SHARE + refining * (k + 1) as f64 / WAVES.len() as f64);
            let from = padded(&point, space.dimension());
            let round = Round {
                space: &space,
                held: &[],
                draws: &draws,
                step: REFINING_STEP,
                until,
                seed: self.seed,
            };
            let found = self.refine(&round, from, &mut reporter);
            finalists.extend(found.iter().map(|(_, point)| space.motion(point)));
            if let Some((_, best)) = found.into_iter().min_by(|a, b| a.0.total_cmp(&b.0)) {
                point = best;
            }
        }
        self.validated(finalists, reporter)
    }

    /// The share of the budget after which validation begins.
    fn validation_begins_at(&self, count: &Draws) -> f64 {
        if self.budget < SMALL_BUDGET {
            // 3 % would be less than one walk of each finalist.
            let walks = count.validation as usize * (CANDIDATES + FINALISTS * WAVES.len());
            1.0 - walks as f64 / self.budget.max(1) as f64
        } else {
            1.0 - VALIDATION_SHARE
        }
    }

    /// The finalist that is best on robots that no stage has seen.
    fn validated(&self, finalists: Vec<Motion>, mut reporter: ProgressReporter<'_>) -> Found {
        let stopped = self.stopped();
        reporter.stage = Stage::Validating;
        let mut robots = self.draws(9, draws_for(self.budget).validation);
        if stopped {
            robots.truncate(VALIDATION_ROBOTS_AFTER_STOP);
        }
        let first = finalists[0].clone();
        let mut pool = Pool::new(robots);
        reporter.trials += pool.add(&self.test, finalists);
        let (score, motion) =
            pool.best(&self.test).map_or((f64::INFINITY, first), |best| (best.score, best.motion.clone()));
        reporter.report(score, &motion);
        Found { motion, pool, trials: reporter.trials, stopped }
    }

    fn stopped(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }

    /// Robots of one stage.
    fn draws(&self, stage: u64, count: u64) -> Vec<Draw> {
        (0..count).map(|k| self.tolerances.draw(self.robot, self.seed, stage << 32 | k)).collect()
    }

    /// Points to refine from, the best first.
    fn initial(&self, start: &Start, reporter: &mut ProgressReporter<'_>) -> Vec<Vec<f64>> {
        let space = (self.space)(start.waves());
        let count = ((INITIAL_SHARE * self.budget as f64) as usize).max(CANDIDATES);
        let mut random = ChaCha8Rng::seed_from_u64(self.seed);
        let points: Vec<Vec<f64>> = (0..count).map(|k| start.point(&space, k, &mut random)).collect();
        let nominal = [Draw::nominal(self.robot)];
        let mut scored: Vec<(f64, Vec<f64>)> = Vec::with_capacity(points.len());
        for part in points.chunks(8 * POPULATION) {
            let tried =
                |point: &Vec<f64>| (!self.stopped()).then(|| self.test.score(&nominal, &space.motion(point)));
            let scores: Vec<Option<f64>> = part.par_iter().map(tried).collect();
            reporter.trials += scores.iter().flatten().count() as u64;
            let scores = scores.into_iter().map(|score| score.unwrap_or(f64::INFINITY));
            scored.extend(scores.zip(part.iter().cloned()));
            scored.sort_by(|a, b| a.0.total_cmp(&b.0));
            scored.truncate(CANDIDATES);
            if self.stopped() {
                break;
            }
            if let Some((score, point)) = scored.first() {
                reporter.report(*score, &space.motion(point));
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
