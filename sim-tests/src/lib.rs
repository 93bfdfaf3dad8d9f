//! The virtual robot: the real firmware image on an emulated Nano, its chips,
//! and a simulated body, all in one emulated time.
//!
//! Owns everything that stands in for hardware. Refuses to be shipped: what
//! links simavr is, as a whole, under simavr's GPL-3, and nothing imports
//! this crate.

pub mod body;
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
