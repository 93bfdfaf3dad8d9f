//! The duration of one count of the servos' PWM.
//!
//! Holds the arithmetic that files, uploads and the simulation share. Does not
//! depend on calibration files or on the link to a robot.

use protocol::calibration::BoardCalibration;

/// Duration of one PWM count, in microseconds: 4.08 for the authors' 25 MHz and 60 Hz.
#[must_use]
pub fn count_us(board: &BoardCalibration) -> f64 {
    (f64::from(board.prescale) + 1.0) / (f64::from(board.oscillator_khz) / 1e3)
}
