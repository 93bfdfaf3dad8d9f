//! The virtual robot: the real firmware image on an emulated Nano, its chips,
//! and a simulated body, all in one emulated time.
//!
//! Holds everything that replaces hardware. It is not shipped: what links simavr is,
//! as a whole, under simavr's GPL-3. Nothing depends on this crate.

// A bench that nothing depends on: where a name says it all, no sentence repeats it.
#![allow(missing_docs)]

pub mod body;
pub mod calibrated;
pub mod client;
pub mod devices;
pub mod electric;
pub mod firmware_image;
pub mod fixtures;
pub mod nano;
pub mod pty;
pub mod report;
pub mod sim_robot;
pub mod virtual_robot;
