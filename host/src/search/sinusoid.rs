//! A sinusoidal gait, found by Bayesian optimisation: the rival of learned gaits.
//!
//! Owns the search and the task that it plays; the gait it ends with is a file
//! like any other. It is tuned for the very reward that a policy is trained on,
//! with as many simulated seconds, so that neither side of a comparison had the
//! better tuning.
//!
//! # Source
//! Paper, sections 3 and 4: "sinusoid function", tuned by Bayesian optimisation
//! in the authors' earlier work. What is searched and how is ours: [`wave`].

mod draw;
pub mod search;
pub mod surrogate;
pub mod task;
pub mod wave;
