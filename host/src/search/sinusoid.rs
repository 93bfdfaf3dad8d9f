//! A sinusoidal gait, found by Bayesian optimisation: the baseline for learned gaits.
//!
//! Holds the search and the task that it plays. It is tuned for the same reward
//! that a policy is trained on, with as many simulated seconds, so that neither
//! side of a comparison had the better tuning. Does not depend on files.
//!
//! # Source
//! Paper, sections 3 and 4: "sinusoid function", tuned by Bayesian optimisation
//! in the authors' earlier work. What is searched and how is ours: [`wave`].

mod draw;
pub mod result;
pub mod search;
pub mod surrogate;
pub mod task;
pub mod wave;
