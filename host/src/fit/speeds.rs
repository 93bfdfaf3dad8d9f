//! How fast a gait turns the joints, and up to which amplitude servos follow.
//!
//! Owns the two peaks of a joint: along its curve, and in the frame in which
//! one stride's end becomes the next one's start. They are kept apart, for a
//! servo that is too slow for the curve lags all along, while one that meets a
//! jump catches up a few frames later. Angles are the robot's own, as
//! [`Playable`] has them. Refuses nothing.

use crate::gait_file::limits::round_down;
use crate::playable::Playable;
use protocol::gait::phase_step;
use protocol::{Amplitude, FRAME_RATE_HZ, JOINT_COUNT, Joint};

/// Phases that a stride is looked at.
const PHASES: usize = 8192;

/// Fastest change of a joint's setpoint from one frame to the next.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct PeakSpeed {
    /// Within the stride.
    pub curve_deg_s: f64,
    /// Across the seam, wherever in the frame it lies.
    pub seam_deg_s: f64,
}

impl PeakSpeed {
    /// The faster of both: what the servo is asked for.
    #[must_use]
    pub fn deg_s(&self) -> f64 {
        self.curve_deg_s.max(self.seam_deg_s)
    }
}

/// Peak speed of every joint at `amplitude`, held within the gait's limits.
#[must_use]
pub fn peak_speeds(gait: &Playable, amplitude: Amplitude) -> [PeakSpeed; JOINT_COUNT] {
    let encoded = gait.encoded();
    // In 1/65536 of a stride; a stride is 6 frames at least.
    let step = (phase_step(encoded.period_us()) >> 16) as u16;
    Joint::ALL.map(|joint| {
        let angle_deg = |phase| encoded.limited(joint, encoded.setpoint(joint, phase, amplitude)).deg();
        let mut peak = PeakSpeed::default();
        for phase in (0..=u16::MAX).step_by(65_536 / PHASES) {
            let (next, crosses) = phase.overflowing_add(step);
            let fast_deg_s = (angle_deg(next) - angle_deg(phase)).abs() * f64::from(FRAME_RATE_HZ);
            let place = if crosses { &mut peak.seam_deg_s } else { &mut peak.curve_deg_s };
            *place = place.max(fast_deg_s);
        }
        peak
    })
}

/// The largest amplitude, in hundredths, at which no joint's curve is faster
/// than `servo_deg_s`; none if even the robot's least is.
///
/// Speeds grow with the amplitude, up to where a joint meets its limits.
#[must_use]
pub fn largest_followed(gait: &Playable, servo_deg_s: f64) -> Option<f64> {
    let follows = |hundredths: u32| {
        let amplitude = Amplitude::from_f64(f64::from(hundredths) / 100.0);
        amplitude.is_some_and(|a| peak_speeds(gait, a).iter().all(|peak| peak.curve_deg_s <= servo_deg_s))
    };
    let (least, most) = (Amplitude::MIN.value() * 100.0, Amplitude::MAX.value() * 100.0);
    let (mut low, mut high) = (least.round() as u32, most.round() as u32);
    if follows(high) {
        return Some(round_down(f64::from(high) / 100.0));
    }
    if !follows(low) {
        return None;
    }
    while high - low > 1 {
        let middle = u32::midpoint(low, high);
        if follows(middle) { low = middle } else { high = middle }
    }
    Some(round_down(f64::from(low) / 100.0))
}

#[cfg(test)]
mod tests;
