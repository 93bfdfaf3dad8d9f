//! The same gait from many starts, over all cores.
//!
//! Owns the numbers of the starts: each has its own stream of the seed, so a
//! start is the same whatever starts beside it, and on whichever core. Refuses
//! results that are no numbers.

use super::{Trial, Walk, play};
use crate::robot::Robot;
use crate::sim::start::{Perturbation, Start};
use rand::{RngCore as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use std::panic::{AssertUnwindSafe, catch_unwind};
use thiserror::Error;

/// From where to play.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Starts {
    /// How far they differ.
    pub perturbation: Perturbation,
    /// The same seed draws the same starts.
    pub seed: u64,
    /// How many.
    pub count: u32,
}

impl Starts {
    /// One of them.
    #[must_use]
    pub fn start(&self, number: u32) -> Start {
        let mut random = ChaCha8Rng::seed_from_u64(self.seed);
        random.set_stream(number.into());
        Start::drawn(&self.perturbation, random.next_u64())
    }
}

/// The engine's numbers ran away: no robot moves like that.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[error("the simulation of start {start} diverged: its numbers grew beyond all bounds")]
pub struct Diverged {
    /// Counted from 0.
    pub start: u32,
}

/// Plays `gait` from each start, on as many cores as there are; walks are in
/// the order of the starts. `trial.start` is not looked at.
///
/// # Errors
/// [`Diverged`] for the first start of which nothing can be said.
pub fn play_starts(
    robot: &Robot,
    trial: &Trial,
    starts: &Starts,
    gait: impl Fn(f64) -> [f64; 8] + Sync,
) -> Result<Vec<Walk>, Diverged> {
    let one = |start: u32| {
        let trial = Trial { start: starts.start(start), ..*trial };
        // A world that ran away trips the engine's own assertions.
        let walk = catch_unwind(AssertUnwindSafe(|| play(robot, &trial, &gait)));
        walk.ok().filter(Walk::is_sound).ok_or(Diverged { start })
    };
    let walks: Vec<_> = (0..starts.count).into_par_iter().map(one).collect();
    walks.into_iter().collect()
}
