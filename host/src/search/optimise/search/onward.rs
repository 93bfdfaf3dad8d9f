//! On from what was found, for another aim.
//!
//! Owns the step: its own robots and generations, a small first spread, and
//! curves of two and of three waves as a first search has them.

use super::refine::Round;
use super::{FINALISTS, Found, POPULATION, Progress, Search, Stage, Told, WAVES, draws_for};

/// Spread of the first gaits: the one begun at is nearly what is wanted.
const STEP: f64 = 0.1;
/// Stages of draws before this belong to first searches.
const STAGE: u64 = 16;
/// Between the seeds of steps: more than a search ever begins again.
const SEEDS_APART: u64 = 1 << 32;

/// The fewest trials that a step of a search of `budget` trials in all takes.
#[must_use]
pub const fn least_step(budget: u64) -> u64 {
    // A generation and its middle among each kind of curves, on the fewest robots.
    let generation = (POPULATION as u64 + 1) * draws_for(0).winners;
    WAVES.len() as u64 * (generation + FINALISTS as u64 * draws_for(budget).judges)
}

impl Search<'_> {
    /// Searches on from the best so far for this aim, of whatever search. What it
    /// finds joins the others; `number` says which step of all this is.
    pub fn go_on(&self, found: &mut Found, number: u64, progress: &mut dyn FnMut(&Progress<'_>)) {
        let mut told = Told { progress, stage: Stage::Refining, trials: 0 };
        let Some(from) = found.pool.best(&self.test) else { return };
        let wide = (self.space)(WAVES.into_iter().max().unwrap_or(1));
        let mut point = wide.point(from.motion);
        let judging = (WAVES.len() * FINALISTS * found.pool.judges()) as u64;
        let until = self.budget.saturating_sub(judging);
        let mut finalists = Vec::new();
        for (k, waves) in WAVES.into_iter().enumerate() {
            // Faster waves than are searched stay what they are: they belong to the gait.
            let held = point.split_off((self.space)(waves).dimension().min(point.len()));
            let stage = STAGE + WAVES.len() as u64 * number + k as u64;
            let draws = self.draws(stage, draws_for(self.budget).winners);
            let until = until * (k + 1) as u64 / WAVES.len() as u64;
            let round = Round {
                space: &wide,
                held: &held,
                draws: &draws,
                step: STEP,
                // The middle is tried after the last generation.
                until: until.saturating_sub(draws.len() as u64),
                seed: self.seed.wrapping_add(SEEDS_APART.wrapping_mul(number + 1)),
            };
            let refined = self.refine(&round, point.clone(), &mut told);
            finalists.extend(refined.iter().map(|(_, point)| round.motion(point)));
            if let Some((_, best)) = refined.into_iter().min_by(|a, b| a.0.total_cmp(&b.0)) {
                point = best;
            }
            point.extend(held);
        }
        // What a stopped step found was hardly refined, and people wait.
        if self.stopped() {
            found.stopped = true;
        } else {
            told.stage = Stage::Judging;
            told.trials += found.pool.add(&self.test, finalists);
            if let Some(best) = found.pool.best(&self.test) {
                told.tell(best.score, best.motion);
            }
        }
        found.trials += told.trials;
    }
}
