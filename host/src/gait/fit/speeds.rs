//! How fast a gait turns the joints, and up to which amplitude servos follow.
//!
//! Holds two peaks for each joint: along its curve, and in the frame in which one
//! stride's end becomes the next one's start. They are kept apart: a servo that is
//! too slow for the curve lags all the time, while one that meets a jump catches up
//! a few frames later. The rest of that frame's movement, without the jump, counts as
//! curve. Angles are the robot's own, from [`Playable`]. Does not depend on a robot's
//! description.

use crate::gait::gait_file::limits::round_down;
use crate::gait::gait_player::Playable;
use protocol::gait::phase_step;
use protocol::{Amplitude, FRAME_RATE_HZ, JOINT_COUNT, Joint};

/// Phases that a stride is looked at.
const PHASES: usize = 8192;

/// Fastest change of a joint's setpoint from one frame to the next.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct PeakSpeed {
    /// Along the curve, a jump at the seam left out.
    pub curve_deg_s: f64,
    /// Across the seam, wherever in the frame it lies, the jump included.
    pub seam_deg_s: f64,
    /// From a stride's end to the next one's start, within the gait's limits.
    pub jump_deg: f64,
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
    Joint::ALL.map(|joint| {
        let mut peak = PeakSpeed { jump_deg: jump_deg(gait, joint, amplitude), ..PeakSpeed::default() };
        for frame in frames(gait, joint, amplitude) {
            peak.curve_deg_s = peak.curve_deg_s.max(frame.curve_deg_s);
            if frame.crosses_seam {
                peak.seam_deg_s = peak.seam_deg_s.max(frame.asked_deg_s);
            }
        }
        peak
    })
}

/// The joint whose curve is the fastest, and how fast; a jump at the seam is left out.
#[must_use]
pub fn fastest(peaks: &[PeakSpeed; JOINT_COUNT]) -> (Joint, f64) {
    let speeds = Joint::ALL.into_iter().zip(peaks.iter().map(|peak| peak.curve_deg_s));
    // Of several that are alike, the first.
    speeds.rev().max_by(|(_, a), (_, b)| a.total_cmp(b)).unwrap_or((Joint::Hip1, 0.0))
}

/// Share of the stride in which the curve of `joint` is faster than `servo_deg_s`.
#[must_use]
pub fn lagging_share(gait: &Playable, joint: Joint, amplitude: Amplitude, servo_deg_s: f64) -> f64 {
    let lags = |frame: &Frame| frame.curve_deg_s > servo_deg_s;
    frames(gait, joint, amplitude).filter(lags).count() as f64 / PHASES as f64
}

/// From one setpoint to the next.
struct Frame {
    /// What the servo is asked for.
    asked_deg_s: f64,
    /// Without the jump, if there is one in it.
    curve_deg_s: f64,
    crosses_seam: bool,
}

/// A frame from each of the stride's phases.
fn frames(gait: &Playable, joint: Joint, amplitude: Amplitude) -> impl Iterator<Item = Frame> + '_ {
    // In 1/65536 of a stride; a stride is 6 frames at least.
    let step = (phase_step(gait.encoded().period_us()) >> 16) as u16;
    let jump_deg = jump_deg(gait, joint, amplitude);
    (0..=u16::MAX).step_by(65_536 / PHASES).map(move |phase| {
        let (next, crosses_seam) = phase.overflowing_add(step);
        let change_deg = angle_deg(gait, joint, next, amplitude) - angle_deg(gait, joint, phase, amplitude);
        let along_deg = if crosses_seam { change_deg - jump_deg } else { change_deg };
        let rate = f64::from(FRAME_RATE_HZ);
        Frame { asked_deg_s: change_deg.abs() * rate, curve_deg_s: along_deg.abs() * rate, crosses_seam }
    })
}

/// Start minus end. 1/65536 of a stride lies between, which is rounding.
fn jump_deg(gait: &Playable, joint: Joint, amplitude: Amplitude) -> f64 {
    angle_deg(gait, joint, 0, amplitude) - angle_deg(gait, joint, u16::MAX, amplitude)
}

fn angle_deg(gait: &Playable, joint: Joint, phase: u16, amplitude: Amplitude) -> f64 {
    let encoded = gait.encoded();
    encoded.limited(joint, encoded.setpoint(joint, phase, amplitude)).deg()
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
