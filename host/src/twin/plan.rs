//! How long a fit searches, and from where.
//!
//! Holds the budget and the random starts. Does not depend on the score.

use super::parameters::Parameter;
use crate::robot::Robot;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Local searches of a fit with [`Begin::Anywhere`].
const DESCENTS: u64 = 5;
/// Share of the evaluations for random sets; the best are starts of local searches.
const FOR_RANDOM: f64 = 0.08;
/// Share of the evaluations after which the local searches end.
const FOR_DESCENTS: f64 = 0.7;

/// Where a search starts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Begin {
    /// A local search from the parameters' first values, and more from the best of many
    /// random sets. The description's values of these parameters do not matter.
    Anywhere,
    /// One local search, from the description's own values.
    Description,
}

/// Length and starts of a search.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Budget {
    /// Random seed of the random sets and of CMA-ES.
    pub seed: u64,
    /// Sets of parameters to try, or a few more.
    pub evaluations: u64,
    /// Share of each range over which the last search's first sets are spread about the best.
    pub first_step: f64,
    /// Starts of the local searches.
    pub begin: Begin,
}

impl Default for Budget {
    fn default() -> Self {
        Self { seed: 0, evaluations: 1800, first_step: 0.03, begin: Begin::Anywhere }
    }
}

impl Budget {
    /// The start that every search has: the parameters' first values, or the description's.
    pub fn first(&self, start: &Robot, parameters: &[Parameter]) -> Vec<f64> {
        let share_of = |parameter: &Parameter| match self.begin {
            Begin::Description => parameter.share_of(start),
            Begin::Anywhere => parameter.first_share(),
        };
        parameters.iter().map(share_of).collect()
    }

    /// Sets drawn evenly from the ranges: candidates for further starts.
    pub fn random(&self, parameters: &[Parameter]) -> Vec<Vec<f64>> {
        let count = match self.begin {
            Begin::Description => 0,
            Begin::Anywhere => (FOR_RANDOM * self.evaluations as f64) as usize,
        };
        let mut random = ChaCha8Rng::seed_from_u64(self.seed);
        (0..count).map(|_| parameters.iter().map(|_| random.random_range(0.0..=1.0)).collect()).collect()
    }

    /// Total of evaluations after which each local search ends; at most one per start.
    pub fn descents(&self, tried: u64, begins: usize) -> Vec<u64> {
        let count = DESCENTS.min(begins as u64);
        let until = (FOR_DESCENTS * self.evaluations as f64) as u64;
        (1..=count).map(|k| tried + until.saturating_sub(tried) * k / count).collect()
    }
}
