//! All that talks to a robot, or listens to what watches it.
//!
//! Holds the serial link, the upload of gaits and calibrations, streaming, trials
//! and the motion tracker. Does not depend on the simulator: it speaks
//! [`protocol`] to whatever answers on a port.

pub mod calibration;
pub mod link;
pub mod session;
pub mod stream;
pub mod tracker;
pub mod trial;
pub mod upload;
