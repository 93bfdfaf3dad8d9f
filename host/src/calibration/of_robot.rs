//! The calibration that a robot's description implies.
//!
//! Holds the conversion of `[servo]` in `robot.toml` to a calibration. Does not depend
//! on a measured robot.

use super::{Board, JointSetup, PULSE_RANGE_US, RobotCalibration};
use crate::pwm::count_us;
use crate::robot::Robot;
use protocol::calibration::MAX_COUNTS;
use protocol::{Calibration, JOINT_COUNT};

/// Shares of the supply's nominal voltage at which a walk may start, and below which it
/// ends; the firmware's own thresholds are for 5 V.
const START_SHARE: f64 = 0.92;
const UNDERVOLTAGE_SHARE: f64 = 0.84;

impl RobotCalibration {
    /// What a robot built as its description says has after `host calibrate`: pulses,
    /// scale, directions and outputs of `[servo]`, every joint marked as measured.
    ///
    /// The end stops limit the pulses, unless `pulse_range_us` does. A supply of less than
    /// 5 V lowers the two thresholds of the supply voltage in proportion.
    #[must_use]
    pub fn of_robot(robot: &Robot) -> Self {
        let firmware = Calibration::authors();
        let Self { board, .. } = Self::from_record(&firmware);
        let servo = &robot.servo;
        let longest_us = PULSE_RANGE_US.1.min((f64::from(MAX_COUNTS) * count_us(&firmware.board())).floor());
        let neutral_us = servo.neutral_pulse_us;
        let [min_us, max_us] = servo.pulse_range_us();
        let (channels, reversed) = (servo.channels(), servo.reversed());
        let joints: [JointSetup; JOINT_COUNT] = core::array::from_fn(|joint| JointSetup {
            channel: channels[joint],
            reversed: reversed[joint],
            neutral_us,
            us_per_degree: servo.pulse_us_per_deg,
            min_us: min_us.clamp(PULSE_RANGE_US.0, neutral_us),
            max_us: max_us.clamp(neutral_us, longest_us),
            is_measured: true,
        });
        let lowered =
            |default_v: f64, share: f64| default_v.min((share * robot.supply.nominal_v * 1e3).round() / 1e3);
        let board = Board {
            start_v: lowered(board.start_v, START_SHARE),
            undervoltage_v: lowered(board.undervoltage_v, UNDERVOLTAGE_SHARE),
            ..board
        };
        Self { board, joints }
    }
}
