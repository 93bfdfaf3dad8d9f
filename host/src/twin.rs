//! The twin: the simulated robot, fitted to and validated against measured trials.
//!
//! Holds the two file formats (tables that a robot played, trials that were
//! measured), the prediction of speed, power and cost of transport, the scores,
//! and the search for the robot's parameters. Does not depend on trials that it
//! was not given: a fit is scored by the fitted trials alone.

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
pub use report::{Both, Condition, FitReport, Fitted, HalfStep, Method, Pair, Report};
pub use score::{line_to, mean_relative_error, spearman};
pub use validate::{Options, validate};

#[cfg(test)]
mod tests;
