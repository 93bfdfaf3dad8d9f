//! A gait with the rounding of firmware and PWM.
//!
//! Holds the two steps between a curve and a servo: frames computed from the
//! gait's bytes and clamped to its limits, then whole counts of the PWM. Does not
//! depend on calibration files or on the link to a robot.

use super::FRAME_RATE_HZ;
use crate::gait::gait_player::Playable;
use crate::pwm::count_us;
use crate::robot::Robot;
use protocol::{Amplitude, Calibration, JOINT_COUNT};

/// A gait at an amplitude, for the servos of a robot.
#[derive(Debug, Clone, Copy)]
pub struct Playback<'a> {
    playable: &'a Playable,
    amplitude: Amplitude,
    /// Degrees that one count of the PWM turns a servo.
    count_deg: f64,
}

impl<'a> Playback<'a> {
    /// For a robot whose neutral pulses are whole counts of the PWM.
    #[must_use]
    pub fn new(playable: &'a Playable, amplitude: Amplitude, robot: &Robot) -> Self {
        let count_deg = count_us(&Calibration::authors().board()) / robot.servo.pulse_us_per_deg;
        Self { playable, amplitude, count_deg }
    }

    /// Setpoints of the frame at that time into the walk, in radians from neutral.
    #[must_use]
    pub fn setpoints_rad(&self, time_s: f64) -> [f64; JOINT_COUNT] {
        // Negative times are frame 0; the number saturates after 2^32 frames, 2.3 years.
        let frame = (time_s * FRAME_RATE_HZ).round() as u32;
        let angles = self.playable.frame(frame, self.amplitude);
        angles.map(|angle| ((angle.deg() / self.count_deg).round() * self.count_deg).to_radians())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gait::gait_file::{GaitFile, JointSeries, Provenance, Source};
    use crate::robot::LegScale;
    use protocol::Joint;

    fn gait() -> Playable {
        let mut coefficients_deg = [0.0; 11];
        (coefficients_deg[1], coefficients_deg[2]) = (20.0, 5.0);
        let series = JointSeries {
            centre_deg: 7.0,
            min_deg: -30.0,
            max_deg: 30.0,
            coefficients_deg,
            ..Default::default()
        };
        let gait = GaitFile {
            name: "known".into(),
            period_s: 0.731,
            unit_deg: crate::gait::scale::TABLE_DEG_PER_ACTION,
            provenance: Provenance::of(Source::Fitted),
            joints: Joint::ALL.map(|_| series.clone()),
        };
        Playable::from_bytes(&gait.encoded().unwrap()).unwrap()
    }

    /// The pulses that the firmware's own calibration makes of the same angles.
    #[test]
    fn servos_get_whole_counts_of_the_angles_that_the_robot_computes() {
        let (gait, robot) = (gait(), Robot::ant(LegScale::LONG).unwrap());
        let amplitude = Amplitude::from_f64(2.0).unwrap();
        let playback = Playback::new(&gait, amplitude, &robot);
        let calibration = Calibration::authors().joint(Joint::Knee2);

        for frame in 0..200 {
            let setpoint_deg = playback.setpoints_rad(f64::from(frame) / FRAME_RATE_HZ)[5].to_degrees();
            let counts = calibration.counts(gait.frame(frame, amplitude)[5].units());

            assert!((setpoint_deg - 0.6 * (f64::from(counts) - 330.0)).abs() < 1e-3, "frame {frame}");
        }
        let highest =
            (0..200).map(|f| playback.setpoints_rad(f64::from(f) / FRAME_RATE_HZ)[5]).fold(0.0, f64::max);
        assert!((highest.to_degrees() - 30.0).abs() < 1e-6, "not held at its limit: {highest}");
    }
}
