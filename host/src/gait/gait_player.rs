//! The setpoints of a gait, polynomial or sampled, before a robot plays them.
//!
//! Every angle is the one that the robot itself will compute, from the same bytes.
//! Holds how far and how fast a gait moves each joint. Does not depend on a robot's
//! limits, which the caller knows.

use crate::gait::gait_file::GaitFile;
use crate::gait::gait_file::limits::{LeavesLimits, round_down};
use protocol::calibration::JointCalibration;
use protocol::gait::{Encoded, GaitError, phase_step, scaled_phase_step};
use protocol::{Amplitude, Angle, FRAME_RATE_HZ, GaitTable, JOINT_COUNT, Joint, Speed};

/// Phases that a stride is looked at, 1/8192 apart.
const PHASES: usize = 8192;
/// Angles here are the robot's, rounded to 1/256 degree: at amplitude 3 their
/// deviations are off by three halves of that.
const TOLERANCE_DEG: f64 = 0.02;

/// A gait as the robot has it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Playable {
    encoded: Encoded,
}

/// What one joint is asked for over a stride.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Demand {
    /// Lowest angle, within the gait's own limits.
    pub lowest_deg: f64,
    /// Highest angle, within the gait's own limits.
    pub highest_deg: f64,
    /// Fastest change from one frame to the next.
    pub fastest_deg_s: f64,
    /// Share of the stride in which it is faster than the servo.
    pub too_fast_share: f64,
}

/// A pulse that a servo would have to be sent, but is not.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BeyondPulses {
    /// Which joint.
    pub joint: Joint,
    /// The angle, in 1/256 degree.
    pub angle: Angle,
    /// Counts that it would take.
    pub counts: i32,
    /// Shortest and longest that the calibration allows.
    pub range: (u16, u16),
}

impl Playable {
    /// The gait in `bytes`, as uploaded or read back.
    ///
    /// # Errors
    /// What is wrong with them.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, GaitError> {
        let mut encoded = Encoded::EMPTY;
        encoded.replace(bytes)?;
        Ok(Self { encoded })
    }

    /// The gait's own bytes and evaluation.
    #[must_use]
    pub const fn encoded(&self) -> &Encoded {
        &self.encoded
    }

    /// Duration of a stride at speed 1.0.
    #[must_use]
    pub fn period_s(&self) -> f64 {
        f64::from(self.encoded.period_us()) / 1e6
    }

    /// Angles in a frame of a walk, counted from 0, at speed 1.0 and within the
    /// gait's limits: as the firmware's player computes them.
    #[must_use]
    pub fn frame(&self, frame: u32, amplitude: Amplitude) -> [Angle; JOINT_COUNT] {
        let phase_q32 = frame.wrapping_mul(phase_step(self.encoded.period_us()));
        Joint::ALL.map(|joint| self.limited(joint, (phase_q32 >> 16) as u16, amplitude))
    }

    /// Checks that no joint leaves the gait's limits at `amplitude`.
    ///
    /// # Errors
    /// [`LeavesLimits`] for the joint that would leave them the farthest.
    pub fn check_limits(&self, amplitude: f64) -> Result<(), LeavesLimits> {
        // A polynomial's extremes are known exactly.
        if let Ok(table) = GaitTable::decode(self.encoded.bytes()) {
            return GaitFile::from_table(&table).check_limits(amplitude);
        }
        let mut worst: Option<(f64, LeavesLimits)> = None;
        let mut largest = f64::INFINITY;
        for joint in Joint::ALL {
            let centre_deg = self.encoded.centre(joint).deg();
            for (sign, limit_deg) in [(1.0, self.limit_deg(joint, 127)), (-1.0, self.limit_deg(joint, -127))]
            {
                let (phase, deviation_deg) = self.extreme(joint, sign);
                if deviation_deg * sign > 0.0 {
                    largest = largest.min((limit_deg - centre_deg) / deviation_deg);
                }
                let angle_deg = centre_deg + amplitude * deviation_deg;
                let excess_deg = (angle_deg - limit_deg) * sign;
                if excess_deg > TOLERANCE_DEG && worst.is_none_or(|(most, _)| excess_deg > most) {
                    let found = LeavesLimits { amplitude, joint, phase, angle_deg, limit_deg, largest: None };
                    worst = Some((excess_deg, found));
                }
            }
        }
        let Some((_, mut found)) = worst else { return Ok(()) };
        found.largest = Some(round_down(largest).min(Amplitude::MAX.value()))
            .filter(|&largest| largest >= Amplitude::MIN.value());
        Err(found)
    }

    /// Lowest and highest angle that each joint is asked for at `amplitude`; held at
    /// the gait's own limits, or as if it had none.
    #[must_use]
    pub fn asked_deg(&self, amplitude: f64, held: bool) -> [(f64, f64); JOINT_COUNT] {
        Joint::ALL.map(|joint| {
            let centre_deg = self.encoded.centre(joint).deg();
            let (low_deg, high_deg) = (self.limit_deg(joint, -127), self.limit_deg(joint, 127));
            let end_deg = |sign: f64| {
                let asked_deg = centre_deg + amplitude * self.extreme(joint, sign).1;
                if held { asked_deg.clamp(low_deg, high_deg) } else { asked_deg }
            };
            (end_deg(-1.0), end_deg(1.0))
        })
    }

    /// Share of the stride in which at least one joint is held at its limit.
    #[must_use]
    pub fn clipped_share(&self, amplitude: Amplitude) -> f64 {
        let is_clipped = |phase: &u16| {
            Joint::ALL.into_iter().any(|joint| {
                let asked = self.encoded.setpoint(joint, *phase, amplitude);
                self.encoded.limited(joint, asked) != asked
            })
        };
        phases().filter(is_clipped).count() as f64 / PHASES as f64
    }

    /// What each joint is asked for; `servo_deg_s` is what a servo can do.
    #[must_use]
    pub fn demands(&self, amplitude: Amplitude, speed: Speed, servo_deg_s: f64) -> [Demand; JOINT_COUNT] {
        let step = scaled_phase_step(phase_step(self.encoded.period_us()), speed.units());
        let step = (step >> 16) as u16;
        Joint::ALL.map(|joint| {
            let angle_deg = |phase| self.limited(joint, phase, amplitude).deg();
            let mut demand = Demand {
                lowest_deg: f64::INFINITY,
                highest_deg: f64::NEG_INFINITY,
                fastest_deg_s: 0.0,
                too_fast_share: 0.0,
            };
            for phase in phases() {
                let here_deg = angle_deg(phase);
                let change_deg = (angle_deg(phase.wrapping_add(step)) - here_deg).abs();
                let fast_deg_s = change_deg * f64::from(FRAME_RATE_HZ);
                demand.lowest_deg = demand.lowest_deg.min(here_deg);
                demand.highest_deg = demand.highest_deg.max(here_deg);
                demand.fastest_deg_s = demand.fastest_deg_s.max(fast_deg_s);
                if fast_deg_s > servo_deg_s {
                    demand.too_fast_share += 1.0 / PHASES as f64;
                }
            }
            demand
        })
    }

    /// The pulse farthest outside what the calibration of `joint` allows, if there is one.
    #[must_use]
    pub fn beyond_pulses(
        &self,
        joint: Joint,
        calibration: JointCalibration,
        amplitude: Amplitude,
    ) -> Option<BeyondPulses> {
        let range = (calibration.min_counts, calibration.max_counts);
        let free = JointCalibration { min_counts: 0, max_counts: u16::MAX, ..calibration };
        let excess = |counts: i32| (i32::from(range.0) - counts).max(counts - i32::from(range.1));
        phases()
            .map(|phase| self.limited(joint, phase, amplitude))
            .map(|angle| (angle, i32::from(free.counts(angle.units()))))
            .max_by_key(|&(_, counts)| excess(counts))
            .filter(|&(_, counts)| excess(counts) > 0)
            .map(|(angle, counts)| BeyondPulses { joint, angle, counts, range })
    }

    fn limited(&self, joint: Joint, phase: u16, amplitude: Amplitude) -> Angle {
        self.encoded.limited(joint, self.encoded.setpoint(joint, phase, amplitude))
    }

    fn limit_deg(&self, joint: Joint, beyond_deg: i8) -> f64 {
        self.encoded.limited(joint, Angle::from_whole_deg(beyond_deg)).deg()
    }

    /// Phase and value of the highest (`sign` 1) or lowest (-1) deviation at amplitude 1.0.
    fn extreme(&self, joint: Joint, sign: f64) -> (f64, f64) {
        let centre_deg = self.encoded.centre(joint).deg();
        phases()
            .map(|phase| (phase, self.encoded.setpoint(joint, phase, Amplitude::ONE).deg() - centre_deg))
            .max_by(|a, b| (sign * a.1).total_cmp(&(sign * b.1)))
            .map_or((0.0, 0.0), |(phase, deg)| (f64::from(phase) / 65_536.0, deg))
    }
}

fn phases() -> impl Iterator<Item = u16> {
    (0..=u16::MAX).step_by(65_536 / PHASES)
}

#[cfg(test)]
mod tests {
    use super::*;
    use protocol::gait::{MAX_ENCODED_LEN, SampledTable};
    use protocol::{Calibration, Name};

    /// hip1 swings +-20 degrees in a triangle of 4 rows about 5 degrees; all else stands at 0.
    fn triangle() -> Playable {
        let mut centres_deg = [0.0; JOINT_COUNT];
        centres_deg[0] = 5.0;
        let rows_deg = [0.0, 20.0, 0.0, -20.0].map(|deg| {
            let mut row = [0.0; JOINT_COUNT];
            row[0] = deg;
            row
        });
        let name = Name::new("triangle").unwrap();
        let table = SampledTable::quantise(name, 2_000_000, (-30, 45), &centres_deg, &rows_deg).unwrap();
        Playable::from_bytes(table.encode(&mut [0; MAX_ENCODED_LEN]).unwrap()).unwrap()
    }

    fn amplitude(value: f64) -> Amplitude {
        Amplitude::from_f64(value).unwrap()
    }

    /// 5 + 20 A within 45, and 5 - 20 A above -30: 1.75 is the largest.
    #[test]
    fn a_sampled_gait_has_a_largest_amplitude_too() {
        assert_eq!(triangle().check_limits(1.7), Ok(()));

        let refused = triangle().check_limits(2.5).unwrap_err();

        assert_eq!((refused.joint, refused.limit_deg), (Joint::Hip1, -30.0));
        assert!((refused.angle_deg + 45.0).abs() < 0.2, "{refused}");
        assert!(refused.largest.is_some_and(|largest| (largest - 1.75).abs() < 0.02), "{refused:?}");
    }

    /// A stride is 120 frames here; a phase is early by some 2^-32, never late.
    #[test]
    fn frames_go_through_the_stride_and_start_it_anew_within_the_limits() {
        let hip1_deg = |frame, a| triangle().frame(frame, amplitude(a))[0].deg();

        assert_eq!([0, 30, 60, 90].map(|frame| hip1_deg(frame, 1.0).round()), [5.0, 25.0, 5.0, -15.0]);
        assert_eq!(hip1_deg(30, 3.0), 45.0, "held at its limit");
        assert_eq!(hip1_deg(30 + 120 * 1000, 1.0), hip1_deg(30, 1.0));
    }

    /// 5 +- 3 * 20 degrees, within -30 to 45; a triangle's corners are cut by the curve.
    #[test]
    fn what_joints_are_asked_for_ends_at_the_limits_only_where_they_hold() {
        let hip1_deg = |held| triangle().asked_deg(3.0, held)[0];

        assert_eq!(hip1_deg(true), (-30.0, 45.0));
        let (low_deg, high_deg) = hip1_deg(false);
        assert!((low_deg + 55.0).abs() < 0.3 && (high_deg - 65.0).abs() < 0.3, "{low_deg} {high_deg}");
    }

    #[test]
    fn what_is_beyond_the_limits_counts_as_clipped() {
        assert_eq!(triangle().clipped_share(amplitude(1.0)), 0.0);
        // Below -30 degrees between phases 0.75 -+ 0.25 * (1 - 35/60), a fifth of the stride.
        let share = triangle().clipped_share(amplitude(3.0));
        // And above 45 degrees, 0.25 -+ 0.25 * (1 - 40/60).
        assert!((share - 0.5 * (25.0 / 60.0 + 20.0 / 60.0)).abs() < 0.01, "{share}");
    }

    /// 20 degrees in a quarter of 2 s are 40 degrees a second, twice that at speed 2.
    #[test]
    fn joint_speed_goes_with_amplitude_and_speed() {
        let fastest = |a, speed| triangle().demands(amplitude(a), speed, 60.0)[0];

        assert!((fastest(1.0, Speed::ONE).fastest_deg_s - 40.0).abs() < 1.0);
        assert_eq!(fastest(1.0, Speed::ONE).too_fast_share, 0.0);
        assert!((fastest(1.0, Speed::MAX).fastest_deg_s - 80.0).abs() < 1.0);
        assert!(fastest(1.0, Speed::MAX).too_fast_share > 0.9);
        assert_eq!(fastest(1.0, Speed::PAUSED).fastest_deg_s, 0.0);
    }

    #[test]
    fn a_pulse_that_the_servo_is_not_sent_is_named() {
        let wide = Calibration::authors().joint(Joint::Hip1);
        let narrow = JointCalibration { max_counts: 350, ..wide };

        assert_eq!(triangle().beyond_pulses(Joint::Hip1, wide, amplitude(1.5)), None);
        let beyond = triangle().beyond_pulses(Joint::Hip1, narrow, amplitude(1.5)).unwrap();

        // 35 degrees of 5/3 counts beyond 330.
        assert_eq!((beyond.counts, beyond.range), (388, (147, 350)));
    }
}
