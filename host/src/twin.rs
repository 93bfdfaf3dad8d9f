//! The twin: the simulated robot held to what a measured one did.
//!
//! Owns the authors' kind of files (tables that a robot played, trials that
//! it walked), the prediction of speed, power and cost of transport, the
//! scores, and the search for the robot's parameters. Refuses to look at a
//! trial that it was not given: a fit chooses by the fitted trials alone.

mod descent;
mod error;
mod files;
mod fit;
mod objective;
mod parameters;
mod plan;
mod power;
mod predict;
mod report;
mod score;
mod validate;

pub use error::TwinError;
pub use files::{Gait, Measured, Tables, Trials};
pub use fit::{Fit, Progress, fit};
pub use parameters::{PARAMETERS, Parameter};
pub use plan::{Begin, Budget};
pub use predict::{Prediction, predict};
pub use report::{Both, Condition, HalfStep, Method, Pair, Report};
pub use score::{line_to, mean_relative_error, spearman};
pub use validate::{Options, validate};

#[cfg(test)]
mod tests;
