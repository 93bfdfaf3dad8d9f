//! Gaits beyond the paper: the trajectory itself, searched in the twin.
//!
//! Owns the search and what is known of its outcome. What it finds is a gait
//! file like any other: the firmware plays it unchanged.

pub mod basis;
pub mod figure;
pub mod front;
pub mod report;
pub mod score;
pub mod search;
pub mod space;
pub mod tolerances;
