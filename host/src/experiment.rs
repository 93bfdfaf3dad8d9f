//! The paper's study: methods, amplifications, legs, trials, and the results.
//!
//! Holds the plan of sections 2.4 and 3, the trials' marks, the statistics over
//! trials, the figures, and the verdict on each of the paper's claims. Does not
//! depend on where a trial is walked: in simulation, on the virtual robot, or on
//! a real one.

pub mod at_speed;
#[cfg(test)]
mod by_hand;
pub mod claims;
pub mod comparison;
pub mod energy_balance;
pub mod figures;
pub mod ledger;
pub mod materials;
pub mod method;
pub mod plan;
pub mod report;
pub mod results;
pub mod study;
pub mod summary;
pub mod trial;
pub mod twin_trials;
