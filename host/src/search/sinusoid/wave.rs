//! A gait of sine waves, twelve numbers of it.
//!
//! Holds what each number means. Legs swing in two pairs; a pair's hips have an
//! amplitude, a phase and an offset, and so have its knees. The first pair's
//! hips are where phases are counted from, and the period is free: 1 + 4 x 3 - 1.
//!
//! Every point of the unit cube is a gait that the servos can follow. An
//! amplitude is searched as a share of the largest that offset, period and servo
//! allow, not in degrees: most of a box of degrees would ask for more than a
//! servo can do, and a repair would map many points to one gait, so that the
//! surrogate sees plateaus.
//!
//! The mean of both pairs is one number and their difference another, cubed:
//! every combination of values can be reached, and at most points the pairs are
//! nearly equal. With one number for each pair the search ended in gaits in which
//! one pair dragged the other. Does not depend on how gaits are scored.

use crate::robot::Robot;
use crate::search::optimise::space::{Bounds, Motion, SPEED_MARGIN, Space};
use crate::sim::AntEnvConfig;
use crate::sim::ant_env::ACTION_DEG;
use core::f64::consts::TAU;
use protocol::{JOINT_COUNT, LEG_COUNT};
use serde::{Deserialize, Serialize};

/// Numbers that a gait is searched by.
pub const DIMENSION: usize = 12;
/// Shortest stride: below it, a servo of 2 rad/s swings a hip by 5 degrees either way.
pub const LEAST_PERIOD_S: f64 = 0.3;
/// Longest: a servo of 2 rad/s then swings a hip by 36 degrees either way, and
/// little more is within the joints' limits.
pub const MOST_PERIOD_S: f64 = 2.0;
/// Seen from above hips turn counter-clockwise: forwards for two legs, backwards for the others.
const FORWARDS: [f64; LEG_COUNT] = [-1.0, -1.0, 1.0, 1.0];
/// Largest offset, as a share of the joints' limits: beyond, less than half of the stroke would be left.
const OFFSET_SHARE: f64 = 0.5;

/// Which legs swing together.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum Pairs {
    /// Legs 1 and 3, 2 and 4, which stand opposite each other
    #[default]
    Diagonal,
    /// Front legs and rear legs: 1 and 4, 2 and 3
    Ends,
    /// Left legs and right legs: 1 and 2, 3 and 4
    Sides,
}

impl Pairs {
    /// The pair of a leg, 0 or 1.
    const fn of(self, leg: usize) -> usize {
        let pairs = match self {
            Self::Diagonal => [0, 1, 0, 1],
            Self::Ends => [0, 1, 1, 0],
            Self::Sides => [0, 0, 1, 1],
        };
        pairs[leg]
    }

    /// Names of both pairs, by their legs.
    #[must_use]
    pub const fn names(self) -> [&'static str; 2] {
        match self {
            Self::Diagonal => ["1+3", "2+4"],
            Self::Ends => ["1+4", "2+3"],
            Self::Sides => ["1+2", "3+4"],
        }
    }

    /// Which way a hip's offset takes its leg. Diagonal legs turn as one line
    /// does, so that both pairs can stand across the way they walk, where a hip's
    /// swing takes a foot farthest; others both go forwards.
    const fn offset_sign(self, leg: usize) -> f64 {
        match self {
            Self::Diagonal => 1.0,
            Self::Ends | Self::Sides => FORWARDS[leg],
        }
    }
}

/// One wave: `offset + amplitude * cos(2 pi (time / period + phase))`.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Wave {
    /// Half the stroke.
    pub amplitude_deg: f64,
    /// In strides, ahead of the first pair's hips.
    pub phase: f64,
    /// About which it swings.
    pub offset_deg: f64,
}

/// A sinusoidal gait.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sinusoid {
    /// Duration of a stride.
    pub period_s: f64,
    /// Of both pairs; the wave's positive half is forwards.
    pub hips: [Wave; 2],
    /// Of both pairs; a positive angle is as the joint has it.
    pub knees: [Wave; 2],
}

/// Bounds of setpoints in a task: the robot's and the task's own.
#[must_use]
pub fn bounds(robot: &Robot, task: &AntEnvConfig) -> Bounds {
    let own = Bounds::of(robot);
    let task_deg = task.setpoint_limit * ACTION_DEG;
    let task_deg_s = task.slew_limit_rad_s.map_or(f64::INFINITY, f64::to_degrees);
    Bounds {
        ranges_deg: own
            .ranges_deg
            .map(|(low_deg, high_deg)| (low_deg.max(-task_deg), high_deg.min(task_deg))),
        speed_deg_s: (SPEED_MARGIN * robot.servo.top_speed_rad_s().to_degrees()).min(task_deg_s),
    }
}

impl Sinusoid {
    /// No waves: the robot stands.
    pub const STILL: Self = {
        let still = Wave { amplitude_deg: 0.0, phase: 0.0, offset_deg: 0.0 };
        Self { period_s: 1.0, hips: [still; 2], knees: [still; 2] }
    };

    /// The gait of a point of the unit cube; numbers that are missing are 0.5.
    #[must_use]
    pub fn at(point: &[f64], bounds: Bounds) -> Self {
        let mut numbers = point.iter().map(|n| if n.is_finite() { n.clamp(0.0, 1.0) } else { 0.5 });
        let mut next = || numbers.next().unwrap_or(0.5);
        // On a logarithmic scale.
        let period_s = LEAST_PERIOD_S * (MOST_PERIOD_S / LEAST_PERIOD_S).powf(next());
        let ahead = next();
        let mut around = |widest_apart: f64| {
            let (common, apart) = (next(), 2.0 * next() - 1.0);
            let apart = widest_apart * apart * apart * apart;
            [common + apart, common - apart]
        };
        let mut shares = || around(0.5).map(|share| share.clamp(0.0, 1.0));
        let (hip_offsets, hip_strokes) = (shares(), shares());
        let (knee_offsets, knee_strokes) = (shares(), shares());
        // A whole circle, cut where a knee is in step with its hip, which takes no foot off the ground.
        let knees_ahead = around(0.25);
        let wave = |angle_deg: f64, offset: f64, stroke: f64, phase: f64| {
            let offset_deg = OFFSET_SHARE * angle_deg * (2.0 * offset - 1.0);
            let room_deg = angle_deg - offset_deg.abs();
            let amplitude_deg = stroke * room_deg.min(bounds.speed_deg_s * period_s / TAU);
            Wave { amplitude_deg, phase: phase.rem_euclid(1.0), offset_deg }
        };
        let hip_phases = [0.0, ahead];
        let hip_deg = bounds.either_way_deg(0..LEG_COUNT);
        let knee_deg = bounds.either_way_deg(LEG_COUNT..JOINT_COUNT);
        Self {
            period_s,
            hips: core::array::from_fn(|i| wave(hip_deg, hip_offsets[i], hip_strokes[i], hip_phases[i])),
            knees: core::array::from_fn(|i| {
                wave(knee_deg, knee_offsets[i], knee_strokes[i], hip_phases[i] + knees_ahead[i])
            }),
        }
    }

    /// The waves as curves that the firmware plays, within the space's bounds.
    #[must_use]
    pub fn motion(&self, pairs: Pairs, space: &Space) -> Motion {
        let mut centres_deg = [0.0; JOINT_COUNT];
        let mut waves_deg = [[0.0; 2]; JOINT_COUNT];
        let parts = |wave: &Wave, sign: f64| {
            let (sine, cosine) = (TAU * wave.phase).sin_cos();
            [sign * wave.amplitude_deg * cosine, -sign * wave.amplitude_deg * sine]
        };
        for leg in 0..LEG_COUNT {
            let (hip, knee) = (&self.hips[pairs.of(leg)], &self.knees[pairs.of(leg)]);
            centres_deg[leg] = pairs.offset_sign(leg) * hip.offset_deg;
            waves_deg[leg] = parts(hip, FORWARDS[leg]);
            centres_deg[LEG_COUNT + leg] = knee.offset_deg;
            waves_deg[LEG_COUNT + leg] = parts(knee, 1.0);
        }
        space.swinging(self.period_s, centres_deg, &waves_deg)
    }

    /// Names of [`Self::numbers`].
    pub const NAMES: [&'static str; DIMENSION + 1] = [
        "period_s",
        "hips_a_amplitude_deg",
        "hips_a_phase",
        "hips_a_offset_deg",
        "hips_b_amplitude_deg",
        "hips_b_phase",
        "hips_b_offset_deg",
        "knees_a_amplitude_deg",
        "knees_a_phase",
        "knees_a_offset_deg",
        "knees_b_amplitude_deg",
        "knees_b_phase",
        "knees_b_offset_deg",
    ];

    /// All of it, the reference phase of 0 included, in the order of [`Self::NAMES`].
    #[must_use]
    pub fn numbers(&self) -> [f64; DIMENSION + 1] {
        let waves = [self.hips, self.knees];
        let mut numbers = [self.period_s; DIMENSION + 1];
        for (place, wave) in numbers[1..].chunks_exact_mut(3).zip(waves.iter().flatten()) {
            place.copy_from_slice(&[wave.amplitude_deg, wave.phase, wave.offset_deg]);
        }
        numbers
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::learn::preset::Preset;
    use crate::learn::run_config::RunConfig;
    use crate::robot::LegScale;
    use crate::search::optimise::basis::Basis;

    fn walk() -> (Bounds, Space) {
        let robot = Robot::ant(LegScale::LONG).expect("a leg scale");
        let task = RunConfig::preset(Preset::Walk).expect("it comes with the program").env;
        let bounds = bounds(&robot, &task);
        (bounds, Space::new(Basis::new().expect("the algebra holds"), bounds, 1))
    }

    /// Farthest that the curve lies from the wave: the amplitude's hundredth part.
    #[test]
    fn a_known_gait_has_the_waves_that_were_asked_for() {
        let (_, space) = walk();
        let wave = |amplitude_deg, phase, offset_deg| Wave { amplitude_deg, phase, offset_deg };
        let gait = Sinusoid {
            period_s: 1.2,
            hips: [wave(20.0, 0.0, 5.0), wave(15.0, 0.5, -5.0)],
            knees: [wave(10.0, 0.25, 10.0), wave(12.0, 0.7, -10.0)],
        };

        let motion = gait.motion(Pairs::Diagonal, &space);

        assert_eq!(motion.period_s, 1.2, "nothing was to be repaired");
        let mut worst_deg = 0.0_f64;
        for i in 0..100 {
            let time_s = 1.2 * f64::from(i) / 100.0;
            let angles = motion.angles_rad(time_s, 1.0).map(f64::to_degrees);
            let turn = |phase: f64| (TAU * (time_s / 1.2 + phase)).cos();
            let asked = [
                5.0 - 20.0 * turn(0.0),
                -5.0 - 15.0 * turn(0.5),
                5.0 + 20.0 * turn(0.0),
                -5.0 + 15.0 * turn(0.5),
                10.0 + 10.0 * turn(0.25),
                -10.0 + 12.0 * turn(0.7),
                10.0 + 10.0 * turn(0.25),
                -10.0 + 12.0 * turn(0.7),
            ];
            for (angle, asked) in angles.iter().zip(asked) {
                worst_deg = worst_deg.max((angle - asked).abs());
            }
        }
        assert!(worst_deg < 0.15, "{worst_deg} degrees");
    }

    #[test]
    fn every_point_is_a_gait_that_needs_no_repair_but_rounding() {
        let (bounds, space) = walk();
        for number in 0..500 {
            let point: Vec<f64> =
                (0..DIMENSION).map(|i| (f64::from(number) * (0.618 + 0.1 * i as f64)).fract()).collect();
            let gait = Sinusoid::at(&point, bounds);

            let motion = gait.motion(Pairs::Ends, &space);

            assert!((motion.period_s / gait.period_s - 1.0).abs() < 0.02, "{point:?}");
            assert!(motion.fastest_deg_s(1.0) <= bounds.speed_deg_s * 1.000_001, "{point:?}");
            assert!(motion.excess_deg(&bounds, 1.0) <= 1e-6, "{point:?}");
        }
    }
}
