//! How far gaits may turn a joint.
//!
//! Holds the one rule for all commands: the tighter of the drawn range and the
//! description's `joint_limit_deg`, both from neutral. Does not depend on gaits.

use super::{Limbs, Robot};
use core::fmt;
use protocol::{JOINT_COUNT, Joint};
use thiserror::Error;

/// What gaits round their angles to is finer than this.
const TOLERANCE_DEG: f64 = 0.05;

/// A joint that is asked to turn farther than its robot lets it.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[error("{} turns {}, but is asked for {:.1}", .joint.name(), Range(*.range_deg), said(*.range_deg, *.asked_deg))]
pub struct BeyondRange {
    /// Which joint.
    pub joint: Joint,
    /// Least and most angle from neutral.
    pub range_deg: (f64, f64),
    /// The angle farthest beyond it.
    pub asked_deg: f64,
}

/// A range in words.
struct Range((f64, f64));

impl fmt::Display for Range {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (low_deg, high_deg) = self.0;
        if is_either_way(self.0) {
            write!(f, "{high_deg:.1} degrees either way")
        } else {
            write!(f, "from {low_deg:.1} to {high_deg:.1} degrees")
        }
    }
}

fn is_either_way((low_deg, high_deg): (f64, f64)) -> bool {
    (low_deg + high_deg).abs() < TOLERANCE_DEG
}

/// Either way has no sign.
fn said(range_deg: (f64, f64), asked_deg: f64) -> f64 {
    if is_either_way(range_deg) { asked_deg.abs() } else { asked_deg }
}

impl Robot {
    /// Least and most angle from neutral, in degrees, that gaits may ask of a
    /// joint: the tighter of its drawn range and `joint_limit_deg`.
    #[must_use]
    pub fn joint_range_deg(&self, joint: Joint) -> (f64, f64) {
        self.joint_ranges_deg()[joint.index()]
    }

    /// [`Self::joint_range_deg`] of all joints, hips 1 to 4, then knees.
    #[must_use]
    pub fn joint_ranges_deg(&self) -> [(f64, f64); JOINT_COUNT] {
        let limbs = Limbs::of(self);
        let limit_deg = self.joint_limit_deg;
        Joint::ALL.map(|joint| {
            let (low_deg, high_deg) = limbs.drawn_range_deg(joint);
            // A range that excludes neutral was refused.
            (low_deg.max(-limit_deg).min(0.0), high_deg.min(limit_deg).max(0.0))
        })
    }

    /// How far servos turn the joints: [`Self::joint_ranges_deg`] and the servos'
    /// end stops. Searches keep to this; the Ant's end stop is a fitted number,
    /// tighter than what its authors' gaits ask for, so uploads do not.
    #[must_use]
    pub fn joint_reaches_deg(&self) -> [(f64, f64); JOINT_COUNT] {
        let stop_deg = self.servo.end_stop_deg;
        self.joint_ranges_deg().map(|(low_deg, high_deg)| (low_deg.max(-stop_deg), high_deg.min(stop_deg)))
    }

    /// The joint that is farthest beyond its range; `asked_deg` are the lowest and
    /// highest angle of each joint.
    ///
    /// # Errors
    /// [`BeyondRange`] for that joint; the first of those that are as far.
    pub fn check_range(&self, asked_deg: &[(f64, f64); JOINT_COUNT]) -> Result<(), BeyondRange> {
        let ranges_deg = self.joint_ranges_deg();
        let mut worst: Option<(f64, BeyondRange)> = None;
        for joint in Joint::ALL {
            let range_deg = ranges_deg[joint.index()];
            let (lowest_deg, highest_deg) = asked_deg[joint.index()];
            for (asked_deg, excess_deg) in
                [(highest_deg, highest_deg - range_deg.1), (lowest_deg, range_deg.0 - lowest_deg)]
            {
                let most_deg = worst.as_ref().map_or(0.0, |(most_deg, _)| *most_deg);
                if excess_deg > most_deg + TOLERANCE_DEG {
                    worst = Some((excess_deg, BeyondRange { joint, range_deg, asked_deg }));
                }
            }
        }
        worst.map_or(Ok(()), |(_, beyond)| Err(beyond))
    }
}

impl Limbs {
    /// From neutral; rounded, so that what is equal in degrees is equal.
    fn drawn_range_deg(&self, joint: Joint) -> (f64, f64) {
        let j = joint.index();
        let leg = &self.legs[j % self.legs.len()];
        let hinge = if j < self.legs.len() { &leg.hip } else { &leg.knee };
        let deg = |rad: f64| (rad.to_degrees() * 1e4).round() / 1e4;
        hinge.range_rad.map_or((f64::NEG_INFINITY, f64::INFINITY), |[low, high]| (deg(low), deg(high)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::LegScale;
    use std::sync::Arc;

    /// The Ant with hips that are drawn to turn so far.
    fn ant(hip_range_deg: [f64; 2]) -> Robot {
        let mut robot = Robot::ant(LegScale::LONG).unwrap();
        for leg in &mut Arc::make_mut(&mut robot.drawn).legs {
            leg.hip.range_rad = Some(hip_range_deg.map(f64::to_radians));
        }
        robot
    }

    #[test]
    fn the_tighter_of_the_drawn_range_and_the_joint_limit_holds() {
        let robot = ant([-5.0, 70.0]);

        assert_eq!(robot.joint_range_deg(Joint::Hip1), (-5.0, 55.0));
        assert_eq!(robot.joint_range_deg(Joint::Knee1), (-55.0, 55.0));
        assert_eq!(robot.joint_reaches_deg()[Joint::Hip1.index()], (-5.0, 45.0));
    }

    #[test]
    fn the_first_of_the_joints_that_are_farthest_beyond_is_named() {
        let mut asked_deg = [(-12.0, 12.0); JOINT_COUNT];

        let said = ant([-5.0, 5.0]).check_range(&asked_deg).unwrap_err().to_string();
        assert_eq!(said, "hip1 turns 5.0 degrees either way, but is asked for 12.0");

        asked_deg[2].0 = -13.0;
        let said = ant([-5.0, 20.0]).check_range(&asked_deg).unwrap_err().to_string();
        assert_eq!(said, "hip3 turns from -5.0 to 20.0 degrees, but is asked for -13.0");
        assert_eq!(ant([-13.01, 12.0]).check_range(&asked_deg), Ok(()));
    }
}
