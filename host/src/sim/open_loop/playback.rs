//! A gait as the servos get it from the firmware.
//!
//! Owns the two things between a curve and a servo: the frames, each computed
//! from the robot's own bytes and held within the gait's limits, and the PWM's
//! counts. Refuses nothing: whatever a [`Playable`] is, can be played.

use super::FRAME_RATE_HZ;
use crate::calibration::count_us;
use crate::playable::Playable;
use crate::robot::Robot;
use protocol::{Amplitude, Calibration};

/// A gait at an amplitude, on its way to the servos of a robot.
#[derive(Debug, Clone, Copy)]
pub struct Playback<'a> {
    playable: &'a Playable,
    amplitude: Amplitude,
    /// What one count of the PWM turns a servo by.
    count_deg: f64,
}

impl<'a> Playback<'a> {
    /// On a robot whose calibration fits its servos, so that neutral is a whole count.
    #[must_use]
    pub fn new(playable: &'a Playable, amplitude: Amplitude, robot: &Robot) -> Self {
        let count_deg = count_us(&Calibration::authors().board()) / robot.servo.pulse_us_per_deg;
        Self { playable, amplitude, count_deg }
    }

    /// Setpoints of the frame at that time into the walk, in radians from neutral.
    #[must_use]
    pub fn setpoints_rad(&self, time_s: f64) -> [f64; 8] {
        // Negative times are frame 0; after 2^32 frames, 2.3 years, it stands.
        let frame = (time_s * FRAME_RATE_HZ).round() as u32;
        let angles = self.playable.frame(frame, self.amplitude);
        angles.map(|angle| ((angle.deg() / self.count_deg).round() * self.count_deg).to_radians())
    }
}
