//! Gaits in the running, each with its walks on the judges.
//!
//! Owns the judges: robots that no stage of the search has seen. What is wanted
//! changes no walk, so that a gait which was found for one speed is compared at
//! any other without another trial.

use crate::search::optimise::score::Test;
use crate::search::optimise::space::Motion;
use crate::search::optimise::tolerances::Draw;
use crate::sim::open_loop::Walk;
use rayon::prelude::*;

/// The gaits, in the order in which they were found.
#[derive(Debug, Clone, PartialEq)]
pub struct Pool {
    judges: Vec<Draw>,
    gaits: Vec<(Motion, Vec<Walk>)>,
}

/// The best gait for an aim.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Best<'a> {
    /// Its number.
    pub number: usize,
    /// On the judges.
    pub score: f64,
    /// Itself.
    pub motion: &'a Motion,
}

impl Pool {
    /// None yet.
    #[must_use]
    pub fn new(judges: Vec<Draw>) -> Self {
        Self { judges, gaits: Vec::new() }
    }

    /// How many judges there are.
    #[must_use]
    pub fn judges(&self) -> usize {
        self.judges.len()
    }

    /// The gaits.
    pub fn motions(&self) -> impl Iterator<Item = &Motion> {
        self.gaits.iter().map(|(motion, _)| motion)
    }

    /// Puts gaits before the judges; how many trials that took.
    pub fn add(&mut self, test: &Test, motions: Vec<Motion>) -> u64 {
        let walks: Vec<Vec<Walk>> = motions
            .par_iter()
            .map(|motion| self.judges.iter().map(|judge| test.walk(judge, motion, 1.0)).collect())
            .collect();
        let trials = (self.judges.len() * motions.len()) as u64;
        self.gaits.extend(motions.into_iter().zip(walks));
        trials
    }

    /// The gait that the judges like best, the first of equals; none of none.
    #[must_use]
    pub fn best(&self, test: &Test) -> Option<Best<'_>> {
        let judged = self.gaits.iter().enumerate().map(|(number, (motion, walks))| Best {
            number,
            score: test.score_of(walks.iter().copied()),
            motion,
        });
        judged.min_by(|a, b| a.score.total_cmp(&b.score))
    }
}
