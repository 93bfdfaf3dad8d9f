//! The paper's whole study: methods, amplifications, legs, trials, and what follows.
//!
//! Owns the plan of sections 2.4 and 3, the trials' marks, the statistics over
//! trials, the figures, and the verdict on each of the paper's claims. Where a
//! trial is walked - in the twin, on the virtual robot, on a real one - makes no
//! difference to the rest.

pub mod at_speed;
pub mod books;
#[cfg(test)]
mod by_hand;
pub mod claims;
pub mod figures;
pub mod ledger;
pub mod materials;
pub mod method;
pub mod paper;
pub mod plan;
pub mod report;
pub mod study;
pub mod summary;
pub mod trial;
pub mod twin_trials;
