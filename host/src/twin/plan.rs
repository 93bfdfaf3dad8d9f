//! How a fit spends its evaluations: several searches, then one from the best.

/// The first sets are spread over this share of each range.
const FIRST_STEP: f64 = 0.2;
/// Searches before the last, which goes on from the best of theirs.
const SEARCHES: u64 = 3;

/// Where a search begins.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Begin {
    /// Anywhere: three searches, the first from what data sheets say, the
    /// others from random sets, then one more from the best of all with steps
    /// a quarter as long. It does not depend on what the description says of
    /// the parameters that are searched.
    Anywhere,
    /// One search, from the description's own values.
    Description,
}

/// How long and from where a search goes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Budget {
    /// Of the optimiser.
    pub seed: u64,
    /// Sets of parameters to try.
    pub evaluations: u64,
    /// Share of each range over which the first sets are spread.
    pub first_step: f64,
    /// Where.
    pub begin: Begin,
}

impl Default for Budget {
    fn default() -> Self {
        Self { seed: 0, evaluations: 3000, first_step: FIRST_STEP, begin: Begin::Anywhere }
    }
}

impl Budget {
    /// One search after the other: seed, evaluations, length of the first step, and how it begins.
    pub fn legs(&self) -> Vec<Leg> {
        match self.begin {
            Begin::Description => {
                vec![Leg {
                    seed: self.seed,
                    until: self.evaluations,
                    step: self.first_step,
                    from: From::Robot,
                }]
            }
            Begin::Anywhere => (0..=SEARCHES)
                .map(|k| Leg {
                    seed: self.seed.wrapping_mul(SEARCHES + 1).wrapping_add(k),
                    until: self.evaluations * (k + 1) / (SEARCHES + 1),
                    step: if k < SEARCHES { self.first_step } else { 0.25 * self.first_step },
                    from: match k {
                        0 => From::DataSheets,
                        k if k < SEARCHES => From::Random,
                        _ => From::Best,
                    },
                })
                .collect(),
        }
    }
}

/// What a leg begins at.
#[derive(Debug, Clone, Copy)]
pub enum From {
    Robot,
    DataSheets,
    Random,
    Best,
}

/// One run of the optimiser.
#[derive(Debug, Clone, Copy)]
pub struct Leg {
    pub seed: u64,
    /// Evaluations of the whole search at its end.
    pub until: u64,
    pub step: f64,
    pub from: From,
}
