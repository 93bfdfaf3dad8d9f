//! A pose as pulses: angles through the calibration into the frame's burst.
//!
//! Holds no state. Does not depend on the servo driver beyond its role, nor on
//! where the pose comes from.

use protocol::{Angle, Calibration, JOINT_COUNT, Joint};

use crate::chips::{ServoBurst, ServoChip, ServoDriver};

/// Gives each joint its pulse in a burst that starts as
/// [`limp_burst`](ServoDriver::limp_burst), if the servos are to be on; returns
/// whether one would be at its servo's limit.
pub fn set_pulses(
    burst: &mut ServoBurst,
    pose: &[Angle; JOINT_COUNT],
    calibration: &Calibration,
    servos_on: bool,
) -> bool {
    let mut held = false;
    for joint in Joint::ALL {
        let servo = calibration.joint(joint);
        let counts = servo.counts(pose[joint.index()].units());
        held |= counts == servo.min_counts || counts == servo.max_counts;
        if servos_on {
            ServoChip::set_pulse(burst, servo.channel, counts);
        }
    }
    held
}
