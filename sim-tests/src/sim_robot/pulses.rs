//! Pulses as a bench measures them: on or off, how far, how fast.
//!
//! Holds what the default calibration means in counts. Does not depend on the code
//! under test: the numbers are written out here.

use super::Pulses;
use crate::fixtures::Gait;
use protocol::{FRAME_RATE_HZ, JOINT_COUNT};

/// Counts at neutral.
pub const NEUTRAL_COUNTS: f64 = 330.0;
/// Counts a degree.
pub const COUNTS_PER_DEG: f64 = 5.0 / 3.0;
/// Largest step of a joint on its way to a pose or to a stand: 1 degree a frame,
/// and two roundings of half a count each.
pub const SLOW_STEP_COUNTS: f64 = COUNTS_PER_DEG + 1.0;

/// Counts of all eight outputs.
///
/// # Panics
/// If one is limp.
#[must_use]
pub fn counts(pulses: &Pulses) -> [f64; JOINT_COUNT] {
    pulses.map(|counts| f64::from(counts.expect("servos on")))
}

/// Largest distance between two poses, in counts.
#[must_use]
pub fn step(a: &Pulses, b: &Pulses) -> f64 {
    let (a, b) = (counts(a), counts(b));
    (0..JOINT_COUNT).map(|joint| (a[joint] - b[joint]).abs()).fold(0.0, f64::max)
}

/// Largest distance between two poses in a row, in counts.
#[must_use]
pub fn largest_step(pulses: &[Pulses]) -> f64 {
    pulses.windows(2).map(|pair| step(&pair[0], &pair[1])).fold(0.0, f64::max)
}

/// Largest difference from angles in degrees, in counts.
#[must_use]
pub fn error_from(angles_deg: &[f64; JOINT_COUNT], pulses: &Pulses) -> f64 {
    let errors = counts(pulses).into_iter().zip(angles_deg);
    errors.map(|(counts, deg)| (counts - NEUTRAL_COUNTS - COUNTS_PER_DEG * deg).abs()).fold(0.0, f64::max)
}

/// Largest difference from the gait's own formula in a frame of its stride, in counts.
#[must_use]
pub fn error_counts(gait: &Gait, value: f64, frame: usize, pulses: &Pulses) -> f64 {
    let phase = (frame as f64 / (gait.period_s * f64::from(FRAME_RATE_HZ))).fract();
    error_from(&std::array::from_fn(|joint| gait.angle_deg(joint, phase, value)), pulses)
}

/// Whether every output has its pulse.
#[must_use]
pub fn servos_on(pulses: &Pulses) -> bool {
    pulses.iter().all(Option::is_some)
}

/// Whether no output has one.
#[must_use]
pub fn servos_off(pulses: &Pulses) -> bool {
    pulses.iter().all(Option::is_none)
}
