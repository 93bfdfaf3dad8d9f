//! The gaits that were found, each with its walks on the validation robots.
//!
//! Holds those robots, which no stage of the search has seen. Does not depend on
//! the aim: the aim has no effect on a walk, so that a gait which was found for
//! one speed is compared at any other without another trial.

use crate::search::optimise::score::Test;
use crate::search::optimise::space::Motion;
use crate::search::optimise::tolerances::Draw;
use crate::sim::open_loop::Walk;
use rayon::prelude::*;

/// The gaits, in the order in which they were found.
#[derive(Debug, Clone, PartialEq)]
pub struct Pool {
    robots: Vec<Draw>,
    gaits: Vec<(Motion, Vec<Walk>)>,
}

/// The best gait for an aim.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Best<'a> {
    /// Its number.
    pub number: usize,
    /// On the validation robots; lower is better.
    pub score: f64,
    /// Its curves.
    pub motion: &'a Motion,
}

impl Pool {
    /// A pool without gaits.
    #[must_use]
    pub fn new(robots: Vec<Draw>) -> Self {
        Self { robots, gaits: Vec::new() }
    }

    /// The number of validation robots.
    #[must_use]
    pub fn robots(&self) -> usize {
        self.robots.len()
    }

    /// The gaits, in the order in which they were found.
    pub fn motions(&self) -> impl Iterator<Item = &Motion> {
        self.gaits.iter().map(|(motion, _)| motion)
    }

    /// Plays gaits on the validation robots; returns how many trials that took.
    pub fn add(&mut self, test: &Test, motions: Vec<Motion>) -> u64 {
        let walks: Vec<Vec<Walk>> = motions
            .par_iter()
            .map(|motion| self.robots.iter().map(|robot| test.walk(robot, motion, 1.0)).collect())
            .collect();
        let trials = (self.robots.len() * motions.len()) as u64;
        self.gaits.extend(motions.into_iter().zip(walks));
        trials
    }

    /// The gait with the lowest score, the first of equals; `None` of an empty pool.
    #[must_use]
    pub fn best(&self, test: &Test) -> Option<Best<'_>> {
        let scored = self.gaits.iter().enumerate().map(|(number, (motion, walks))| Best {
            number,
            score: test.score_of(walks.iter().copied()),
            motion,
        });
        scored.min_by(|a, b| a.score.total_cmp(&b.score))
    }
}
