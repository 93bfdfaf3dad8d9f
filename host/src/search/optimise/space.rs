//! From a point of the search to a gait that the servos can follow.
//!
//! Holds what every number of a point means, and the repair: every point becomes a
//! gait within its joints' limits and its servos' speed, so that a search needs
//! no penalties for gaits that cannot be played. Does not depend on the search.

use super::basis::{Basis, Curve, WAVES, steepest};
use crate::gait::fit::mean_over_stride;
use crate::gait::gait_file::{GaitFile, JointSeries};
use crate::robot::Robot;
use core::f64::consts::SQRT_2;
use core::ops::Range;
use protocol::gait::{COEFFICIENT_COUNT, DEGREE};
use protocol::{JOINT_COUNT, Joint};

/// Setpoints move no faster than this share of what the servo does without load.
pub const SPEED_MARGIN: f64 = 0.9;
/// Joints stay this far from their mechanical ends.
pub const STOP_MARGIN_DEG: f64 = 3.0;
/// Strides are no shorter, whatever is asked for: 12 frames.
const LEAST_PERIOD_S: f64 = 0.2;
/// Nor longer: slower than the authors' robot walked.
const MOST_PERIOD_S: f64 = 4.0;
/// One unit of the search: of the stride's duration, as a share of it,
const PERIOD_UNIT: f64 = 0.25;
/// of a joint's centre,
const CENTRE_UNIT_DEG: f64 = 8.0;
/// and of the one-wave part of its curve; faster waves have smaller units, alike in speed.
const WAVE_UNIT_DEG: f64 = 8.0;
/// A stride of this duration is 0.
const MIDDLE_PERIOD_S: f64 = 0.8;

/// What a gait may ask of its robot.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounds {
    /// Least and most angle from neutral of each joint: hips 1 to 4, then knees.
    pub ranges_deg: [(f64, f64); JOINT_COUNT],
    /// Fastest setpoint.
    pub speed_deg_s: f64,
}

impl Bounds {
    /// Of a robot, with our margins.
    #[must_use]
    pub fn of(robot: &Robot) -> Self {
        Self {
            // A range narrower than the margins leaves no stroke.
            ranges_deg: robot
                .joint_reaches_deg()
                .map(|(low, high)| ((low + STOP_MARGIN_DEG).min(0.0), (high - STOP_MARGIN_DEG).max(0.0))),
            speed_deg_s: SPEED_MARGIN * robot.servo.top_speed_rad_s().to_degrees(),
        }
    }

    /// How far all of these joints turn both ways, numbered as in `ranges_deg`.
    #[must_use]
    pub fn either_way_deg(&self, joints: Range<usize>) -> f64 {
        self.ranges_deg[joints].iter().map(|(low, high)| high.min(-low)).fold(f64::INFINITY, f64::min)
    }
}

/// The gaits that are searched: curves of up to so many waves a stride.
#[derive(Debug, Clone)]
pub struct Space {
    basis: Basis,
    bounds: Bounds,
    waves: usize,
}

/// A gait as the search has it.
#[derive(Debug, Clone, PartialEq)]
pub struct Motion {
    /// Duration of a stride.
    pub period_s: f64,
    /// Angle about which each joint moves, from neutral.
    pub centres_deg: [f64; JOINT_COUNT],
    /// Chebyshev coefficients of the deviations.
    pub curves_deg: [Curve; JOINT_COUNT],
}

impl Motion {
    /// Angles at a time, in radians.
    #[must_use]
    pub fn angles_rad(&self, time_s: f64, amplitude: f64) -> [f64; JOINT_COUNT] {
        let x = 2.0 * (time_s / self.period_s).rem_euclid(1.0) - 1.0;
        core::array::from_fn(|j| {
            let deviation_deg = crate::gait::gait_file::chebyshev(&self.curves_deg[j], x);
            (self.centres_deg[j] + amplitude * deviation_deg).to_radians()
        })
    }

    /// A gait's motion at an amplitude.
    #[must_use]
    pub fn of(gait: &GaitFile, amplitude: f64) -> Self {
        Self {
            period_s: gait.period_s,
            centres_deg: gait.joints.each_ref().map(|joint| joint.centre_deg),
            curves_deg: gait.joints.each_ref().map(|joint| joint.coefficients_deg.map(|c| amplitude * c)),
        }
    }

    /// The curves for a gait file, with the limits that they were made for.
    #[must_use]
    pub fn series(&self, ranges_deg: &[(f64, f64); JOINT_COUNT]) -> [JointSeries; JOINT_COUNT] {
        core::array::from_fn(|j| JointSeries {
            centre_deg: self.centres_deg[j],
            min_deg: ranges_deg[j].0,
            max_deg: ranges_deg[j].1,
            coefficients_deg: self.curves_deg[j],
            residual_rms_deg: None,
            r2: None,
        })
    }

    /// How far any joint is asked to leave its range at an amplitude, in degrees; negative
    /// while all keep within.
    #[must_use]
    pub fn excess_deg(&self, bounds: &Bounds, amplitude: f64) -> f64 {
        let joints = self.centres_deg.iter().zip(&self.curves_deg).zip(&bounds.ranges_deg);
        joints
            .map(|((centre_deg, curve), (low_deg, high_deg))| {
                let (low, high) = range_of(curve);
                (centre_deg + amplitude * high - high_deg).max(low_deg - (centre_deg + amplitude * low))
            })
            .fold(f64::NEG_INFINITY, f64::max)
    }

    /// Fastest that any setpoint moves, at an amplitude.
    #[must_use]
    pub fn fastest_deg_s(&self, amplitude: f64) -> f64 {
        self.curves_deg.iter().map(|curve| amplitude * steepest(curve) / self.period_s).fold(0.0, f64::max)
    }
}

impl Space {
    /// Curves of up to `waves` a stride, one to four.
    #[must_use]
    pub fn new(basis: Basis, bounds: Bounds, waves: usize) -> Self {
        Self { basis, bounds, waves: waves.clamp(1, WAVES) }
    }

    /// Numbers that a gait is searched by: its period, and of each joint the
    /// centre and two a wave.
    #[must_use]
    pub fn dimension(&self) -> usize {
        1 + JOINT_COUNT * (1 + 2 * self.waves)
    }

    /// The gait of a point; a point that is too short says zero for the rest.
    #[must_use]
    pub fn motion(&self, point: &[f64]) -> Motion {
        let mut numbers = point.iter().map(|n| if n.is_finite() { *n } else { 0.0 });
        let mut next = || numbers.next().unwrap_or(0.0);
        let period_s = MIDDLE_PERIOD_S * (PERIOD_UNIT * next()).exp();
        let mut motion = Motion {
            period_s,
            centres_deg: [0.0; JOINT_COUNT],
            curves_deg: [[0.0; COEFFICIENT_COUNT]; JOINT_COUNT],
        };
        for joint in Joint::ALL {
            motion.centres_deg[joint.index()] = CENTRE_UNIT_DEG * next();
        }
        // Wave by wave, so that a point of fewer waves is one of more with zeros behind.
        for wave in 0..self.waves {
            for curve in &mut motion.curves_deg {
                for own in &self.basis.curves[wave] {
                    let share_deg = unit_deg(wave) * next();
                    curve.iter_mut().zip(own).for_each(|(sum, c)| *sum += share_deg * c);
                }
            }
        }
        self.repaired(motion)
    }

    /// Joints that swing about their centres like waves, one a stride: the size
    /// in degrees of each one's cosine and sine.
    #[must_use]
    pub fn swinging(
        &self,
        period_s: f64,
        centres_deg: [f64; JOINT_COUNT],
        waves_deg: &[[f64; 2]; JOINT_COUNT],
    ) -> Motion {
        let [cosine, sine] = &self.basis.curves[0];
        let curves_deg = waves_deg.map(|[of_cosine, of_sine]| {
            core::array::from_fn(|k| (of_cosine * cosine[k] + of_sine * sine[k]) / SQRT_2)
        });
        self.repaired(Motion { period_s, centres_deg, curves_deg })
    }

    /// The point whose gait comes nearest to a motion.
    #[must_use]
    pub fn point(&self, motion: &Motion) -> Vec<f64> {
        let mut point = vec![(motion.period_s / MIDDLE_PERIOD_S).ln() / PERIOD_UNIT];
        point.extend(
            motion
                .centres_deg
                .iter()
                .zip(&motion.curves_deg)
                .map(|(centre_deg, curve)| (centre_deg + mean_over_stride(curve)) / CENTRE_UNIT_DEG),
        );
        let shares = motion.curves_deg.map(|curve| self.basis.shares(&curve));
        for wave in 0..self.waves {
            point.extend(shares.iter().flat_map(|shares| shares[wave].map(|share| share / unit_deg(wave))));
        }
        point
    }

    /// The nearest motion that keeps the bounds: strokes give way to angles, the
    /// period to speeds.
    #[must_use]
    pub fn repaired(&self, mut motion: Motion) -> Motion {
        let Bounds { ranges_deg, speed_deg_s } = self.bounds;
        let joints = motion.centres_deg.iter_mut().zip(&mut motion.curves_deg);
        for ((centre_deg, curve), (low_deg, high_deg)) in joints.zip(ranges_deg) {
            // A joint that cannot move either way walks no robot.
            *centre_deg = centre_deg.clamp(0.9 * low_deg, 0.9 * high_deg);
            let (low, high) = range_of(curve);
            let shrink =
                |room_deg: f64, used_deg: f64| if used_deg > room_deg { room_deg / used_deg } else { 1.0 };
            let share = shrink(high_deg - *centre_deg, high).min(shrink(*centre_deg - low_deg, -low));
            curve.iter_mut().for_each(|c| *c *= share);
        }
        let turned_deg = motion.curves_deg.iter().map(steepest).fold(0.0, f64::max);
        let least_s = (turned_deg / speed_deg_s).clamp(LEAST_PERIOD_S, MOST_PERIOD_S);
        motion.period_s = motion.period_s.clamp(least_s, MOST_PERIOD_S);
        let too_fast = (turned_deg / (speed_deg_s * motion.period_s)).max(1.0);
        motion.curves_deg.iter_mut().flatten().for_each(|c| *c /= too_fast);
        motion
    }
}

/// One unit of a wave: root mean square of the deviation, in degrees.
fn unit_deg(wave: usize) -> f64 {
    WAVE_UNIT_DEG / SQRT_2 / (wave + 1) as f64
}

/// Lowest and highest value, at phases a degree-10 curve hides nothing between.
fn range_of(curve: &Curve) -> (f64, f64) {
    const POINTS: usize = 32 * DEGREE;
    (0..=POINTS)
        .map(|i| crate::gait::gait_file::chebyshev(curve, 2.0 * i as f64 / POINTS as f64 - 1.0))
        .fold((0.0, 0.0), |(low, high), value| (f64::min(low, value), f64::max(high, value)))
}

#[cfg(test)]
mod tests;
