//! Direct search of gaits in simulation, and the gaits that it found.
//!
//! Does not depend on the link to a robot.

pub mod bundled_gaits;
#[cfg(feature = "train")]
pub mod optimise;
#[cfg(feature = "train")]
pub mod sinusoid;
