//! Direct search of gaits in simulation, and the gaits that it found.
//!
//! Holds two searches, of any trajectory and of sine waves, and the gaits that
//! come with the program. Does not depend on the link to a robot.

pub mod bundled_gaits;
#[cfg(feature = "train")]
pub mod optimise;
#[cfg(feature = "train")]
pub mod sinusoid;

/// Reads a number that JSON cannot hold: an infinite one, or NaN, is written as null.
#[cfg(feature = "train")]
fn null_is_infinite<'de, D: serde::Deserializer<'de>>(source: D) -> Result<f64, D::Error> {
    Ok(<Option<f64> as serde::Deserialize>::deserialize(source)?.unwrap_or(f64::INFINITY))
}
