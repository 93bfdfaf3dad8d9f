//! Gaits beyond the paper: the trajectory itself, searched in simulation.
//!
//! Holds the search and the report on its result. The result is a gait file like
//! any other, which the firmware plays unchanged. Does not depend on learning.

pub mod basis;
pub mod figure;
pub mod front;
pub mod heading;
pub mod report;
pub mod result;
pub mod score;
pub mod search;
pub mod space;
pub mod tolerances;
