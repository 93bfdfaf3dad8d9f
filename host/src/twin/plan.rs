//! How long a fit searches, and from where.

use super::parameters::Parameter;
use crate::robot::Robot;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Descents of a search that may begin anywhere.
const DESCENTS: u64 = 5;
/// Share of the evaluations that go to random sets, of which the best are descended from.
const FOR_RANDOM: f64 = 0.08;
/// Share of the evaluations at which the descents end.
const FOR_DESCENTS: f64 = 0.7;

/// Where a search begins.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Begin {
    /// Anywhere: a descent from the parameters' first values, and more from the best
    /// of many random sets. What the description says of the parameters that
    /// are searched does not matter.
    Anywhere,
    /// One descent, from the description's own values.
    Description,
}

/// How long and from where a search goes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Budget {
    /// Of the random sets and of the last search.
    pub seed: u64,
    /// Sets of parameters to try, or a few more.
    pub evaluations: u64,
    /// Share of each range over which the last search's first sets are spread about the best.
    pub first_step: f64,
    /// Where.
    pub begin: Begin,
}

impl Default for Budget {
    fn default() -> Self {
        Self { seed: 0, evaluations: 1800, first_step: 0.03, begin: Begin::Anywhere }
    }
}

impl Budget {
    /// The set of which a search is sure: the parameters' first values, or the description's.
    pub fn first(&self, start: &Robot, parameters: &[Parameter]) -> Vec<f64> {
        let share_of = |parameter: &Parameter| match self.begin {
            Begin::Description => parameter.share_of(start),
            Begin::Anywhere => parameter.first_share(),
        };
        parameters.iter().map(share_of).collect()
    }

    /// Sets from anywhere in the ranges, which tell where else to descend.
    pub fn random(&self, parameters: &[Parameter]) -> Vec<Vec<f64>> {
        let count = match self.begin {
            Begin::Description => 0,
            Begin::Anywhere => (FOR_RANDOM * self.evaluations as f64) as usize,
        };
        let mut random = ChaCha8Rng::seed_from_u64(self.seed);
        (0..count).map(|_| parameters.iter().map(|_| random.random_range(0.0..=1.0)).collect()).collect()
    }

    /// How many evaluations the search may have taken at the end of each descent, of which there
    /// are no more than places to begin at.
    pub fn descents(&self, tried: u64, begins: usize) -> Vec<u64> {
        let count = DESCENTS.min(begins as u64);
        let until = (FOR_DESCENTS * self.evaluations as f64) as u64;
        (1..=count).map(|k| tried + until.saturating_sub(tried) * k / count).collect()
    }
}
