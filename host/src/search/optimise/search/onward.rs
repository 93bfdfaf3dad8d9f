//! A further search for another aim, from the gaits that were found.
//!
//! Holds the step: its own robots and generations, a small first spread, and
//! curves of two and of three waves as in a first search. Does not depend on
//! which aims follow each other.

use super::refine::Round;
use super::{FINALISTS, Found, POPULATION, Progress, ProgressReporter, Search, Stage, WAVES, draws_for};

/// Spread of the first generation: the gait it starts from is close to the aim.
const STEP: f64 = 0.1;
/// Numbers of sampled robots below this stage belong to first searches.
const STAGE: u64 = 16;
/// Between the seeds of steps: more than the restarts of any search.
const SEEDS_APART: u64 = 1 << 32;

/// The fewest trials that a step of a search of `budget` trials in all takes.
#[must_use]
pub const fn least_step(budget: u64) -> u64 {
    // A generation and its mean among each kind of curves, on the fewest robots.
    let generation = (POPULATION as u64 + 1) * draws_for(0).refining;
    WAVES.len() as u64 * (generation + FINALISTS as u64 * draws_for(budget).validation)
}

impl Search<'_> {
    /// Continues from the best gait so far for this aim. The gaits that it finds join the pool;
    /// `number` is the number of the step.
    pub fn go_on(&self, found: &mut Found, number: u64, progress: &mut dyn FnMut(&Progress<'_>)) {
        let mut reporter = ProgressReporter { progress, stage: Stage::Refining, trials: 0 };
        let Some(from) = found.pool.best(&self.test) else { return };
        let wide = (self.space)(WAVES.into_iter().max().unwrap_or(1));
        let mut point = wide.point(from.motion);
        let validation = (WAVES.len() * FINALISTS * found.pool.robots()) as u64;
        let until = self.budget.saturating_sub(validation);
        let mut finalists = Vec::new();
        for (k, waves) in WAVES.into_iter().enumerate() {
            // Faster waves than these are not searched, and stay part of the gait.
            let held = point.split_off((self.space)(waves).dimension().min(point.len()));
            let stage = STAGE + WAVES.len() as u64 * number + k as u64;
            let draws = self.draws(stage, draws_for(self.budget).refining);
            let until = until * (k + 1) as u64 / WAVES.len() as u64;
            let round = Round {
                space: &wide,
                held: &held,
                draws: &draws,
                step: STEP,
                // The mean is tried after the last generation.
                until: until.saturating_sub(draws.len() as u64),
                seed: self.seed.wrapping_add(SEEDS_APART.wrapping_mul(number + 1)),
            };
            let refined = self.refine(&round, point.clone(), &mut reporter);
            finalists.extend(refined.iter().map(|(_, point)| round.motion(point)));
            if let Some((_, best)) = refined.into_iter().min_by(|a, b| a.0.total_cmp(&b.0)) {
                point = best;
            }
            point.extend(held);
        }
        // After Ctrl-C somebody waits, and what the step found is hardly refined.
        if self.stopped() {
            found.stopped = true;
        } else {
            reporter.stage = Stage::Validating;
            reporter.trials += found.pool.add(&self.test, finalists);
            if let Some(best) = found.pool.best(&self.test) {
                reporter.report(best.score, best.motion);
            }
        }
        found.trials += reporter.trials;
    }
}
