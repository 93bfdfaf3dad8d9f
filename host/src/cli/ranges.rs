//! The numbers that flags of several commands share, and their ranges.
//!
//! Holds the checks that clap cannot make of numbers with a fraction. Does not
//! depend on a subcommand.

use super::explain::failure;
use super::{Cause, Failure};
use protocol::{Amplitude, Speed};
use thiserror::Error;

/// Shortest and longest trial, in seconds.
pub const DURATION_RANGE_S: (f64, f64) = (0.1, 3600.0);

/// A flag whose value is outside its range, or NaN.
#[derive(Debug, Error)]
#[error("--{flag} is {value}; it must be within {min} to {max}")]
pub struct OutOfRange {
    pub flag: &'static str,
    pub value: f64,
    pub min: f64,
    pub max: f64,
}

/// Refuses a value outside `min` to `max`; no value is always allowed.
pub fn check(flag: &'static str, value: Option<f64>, min: f64, max: f64) -> Result<(), OutOfRange> {
    match value {
        Some(value) if !(min..=max).contains(&value) => Err(OutOfRange { flag, value, min, max }),
        _ => Ok(()),
    }
}

/// The same as a usage error.
pub fn check_range(flag: &'static str, value: Option<f64>, min: f64, max: f64) -> Result<(), Failure> {
    check(flag, value, min, max).map_err(|error| failure(Cause::Usage, error))
}

/// The value of `--amp`, if a robot plays it.
pub fn amplitude_flag(value: f64) -> Result<Amplitude, Failure> {
    let (min, max) = (Amplitude::MIN.value(), Amplitude::MAX.value());
    let error = OutOfRange { flag: "amp", value, min, max };
    Amplitude::from_f64(value).ok_or_else(|| failure(Cause::Usage, error))
}

/// An amplitude or a speed, from a flag or typed during a walk, that no robot plays.
#[derive(Debug, Error)]
pub enum BadNumber {
    #[error("an amplitude of {value}; it must be within {} to {}", Amplitude::MIN.value(), Amplitude::MAX.value())]
    Amplitude { value: f64 },
    #[error("a speed of {value}; it must be within 0 to {} of the gait's own", Speed::MAX.value())]
    Speed { value: f64 },
}

/// The amplitude, within [`Amplitude::MIN`] to [`Amplitude::MAX`].
pub fn amplitude(value: f64) -> Result<Amplitude, BadNumber> {
    Amplitude::from_f64(value).ok_or(BadNumber::Amplitude { value })
}

/// The speed, within 0 to [`Speed::MAX`].
pub fn speed(value: f64) -> Result<Speed, BadNumber> {
    Speed::from_f64(value).ok_or(BadNumber::Speed { value })
}
