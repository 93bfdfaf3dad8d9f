//! In what a robot's calibration disagrees with a robot's description.
//!
//! Holds the tolerances. A horn sits on the servo's spline in steps of a tooth, so the
//! neutral pulse of a robot that was calibrated by hand may differ by a tooth. Does not
//! depend on a link to a robot.

use crate::calibration::RobotCalibration;
use crate::robot::Robot;
use protocol::command::CalibrationSource;
use protocol::{Calibration, Joint};
use std::fmt;

/// A tooth of the coarsest common spline, 21 teeth, is 17 degrees.
const SPLINE_DEG: f64 = 20.0;
/// Of a robot that has never been calibrated: its neutral is a default, so it must be right.
const DEFAULT_DEG: f64 = 3.0;
/// Share by which the scale may differ: servos of one type differ by a few per cent.
const SCALE_SHARE: f64 = 0.1;

/// One disagreement.
#[derive(Debug, Clone, PartialEq)]
pub struct Difference {
    /// Joints that share it.
    pub joints: Vec<Joint>,
    /// What the robot has, and what its description says.
    pub what: String,
}

impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.joints.len() == Joint::ALL.len() {
            return write!(f, "all joints: {}", self.what);
        }
        let names: Vec<_> = self.joints.iter().map(|joint| joint.name()).collect();
        write!(f, "{}: {}", names.join(", "), self.what)
    }
}

/// In what the calibration in use disagrees with the robot; empty if it agrees.
///
/// A robot that was calibrated may differ by a tooth of the spline, by servos' own spread of
/// the scale, and, where the description does not give `channels` or `reversed`, in these: the
/// calibration then knows them better.
#[must_use]
pub fn differences(in_use: &Calibration, source: CalibrationSource, robot: &Robot) -> Vec<Difference> {
    let (found, described) = (RobotCalibration::from_record(in_use), RobotCalibration::of_robot(robot));
    let is_calibrated = matches!(source, CalibrationSource::Stored | CalibrationSource::NotSaved);
    let neutral_deg = if is_calibrated { SPLINE_DEG } else { DEFAULT_DEG };
    let mut all: Vec<Difference> = Vec::new();
    let mut note = |joint: Joint, what: String| match all.iter_mut().find(|other| other.what == what) {
        Some(other) => other.joints.push(joint),
        None => all.push(Difference { joints: vec![joint], what }),
    };
    for joint in Joint::ALL {
        let (has, says) = (&found.joints[joint.index()], &described.joints[joint.index()]);
        let compares_channels = robot.servo.channels.is_some() || !is_calibrated;
        if compares_channels && has.channel != says.channel {
            note(joint, format!("on output {}, but {} in the description", has.channel, says.channel));
        }
        let compares_directions = robot.servo.reversed.is_some() || !is_calibrated;
        if compares_directions && has.reversed != says.reversed {
            let word = |reversed| if reversed { "reversed" } else { "not reversed" };
            note(joint, format!("{}, but {} in the description", word(has.reversed), word(says.reversed)));
        }
        let (scale, said) = (has.us_per_degree, says.us_per_degree);
        if (scale / said - 1.0).abs() > SCALE_SHARE {
            note(joint, format!("{scale:.2} us a degree, but {said:.2} in the description"));
        }
        let apart_deg = (has.neutral_us - says.neutral_us) / said;
        if apart_deg.abs() > neutral_deg {
            note(
                joint,
                format!(
                    "neutral at {:.0} us, but {:.0} us in the description, {:.0} degrees apart",
                    has.neutral_us,
                    says.neutral_us,
                    apart_deg.abs()
                ),
            );
        }
    }
    all
}
