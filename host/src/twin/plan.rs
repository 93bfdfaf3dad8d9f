//! How long a fit searches, and from where.

use super::parameters::Parameter;
use crate::robot::Robot;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Descents of a search that may begin anywhere.
const DESCENTS: u64 = 5;
/// Share of the evaluations that they may take.
const FOR_DESCENTS: f64 = 0.7;
/// Random sets begin in this middle part of each range.
const MIDDLE: (f64, f64) = (0.2, 0.8);

/// Where a search begins.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Begin {
    /// Anywhere: a descent from what data sheets say, four more from random
    /// sets. What the description says of the parameters that are searched
    /// does not matter.
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
    /// Where each descent begins, and how many evaluations the search may have taken at its end.
    pub fn descents(&self, start: &Robot, parameters: &[Parameter]) -> Vec<(Vec<f64>, u64)> {
        let shares = |of: &mut dyn FnMut(&Parameter) -> f64| parameters.iter().map(of).collect::<Vec<f64>>();
        let for_descents = (FOR_DESCENTS * self.evaluations as f64) as u64;
        match self.begin {
            Begin::Description => vec![(shares(&mut |p| p.share_of(start)), for_descents)],
            Begin::Anywhere => {
                let mut random = ChaCha8Rng::seed_from_u64(self.seed);
                (0..DESCENTS)
                    .map(|k| {
                        let from = if k == 0 {
                            shares(&mut |p| p.first_share())
                        } else {
                            shares(&mut |_| random.random_range(MIDDLE.0..=MIDDLE.1))
                        };
                        (from, for_descents * (k + 1) / DESCENTS)
                    })
                    .collect()
            }
        }
    }
}
