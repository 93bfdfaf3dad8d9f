//! How one robot is built, in units that people measure: microseconds, degrees, ohms, volts.
//!
//! Holds the TOML file and the conversion to the robot's own record, which counts in
//! steps of the PCA9685's oscillator. Values that the robot would refuse, and pulses
//! outside the range of servos, are errors that name the value and its limits. Does
//! not depend on a link to a robot.

mod comparison;
mod document;
mod of_robot;

pub use comparison::{Difference, differences};
pub use document::CalibrationFileError;

use crate::pwm::count_us;
use protocol::calibration::{
    BoardCalibration, JointCalibration, MAX_COUNTS, MAX_PRESCALE, MIN_PRESCALE, UNITY_GAIN_Q14,
};
use protocol::{Calibration, JOINT_COUNT, Joint};
use thiserror::Error;

/// The shunt that the firmware's own factor is for.
pub const NOMINAL_SHUNT_OHM: f64 = 0.1;
/// No servo takes a shorter or longer pulse.
pub const PULSE_RANGE_US: (f64, f64) = (300.0, 3000.0);
/// Counts in a PWM period.
const COUNTS_A_PERIOD: f64 = 4096.0;
/// One step of [`JointCalibration::scale_q20`], in counts per degree.
const SCALE_UNIT: f64 = 256.0 / (1 << 20) as f64;

/// A robot's calibration in physical units.
#[derive(Debug, Clone, PartialEq)]
pub struct RobotCalibration {
    /// What holds for all joints.
    pub board: Board,
    /// In [`Joint::ALL`] order.
    pub joints: [JointSetup; JOINT_COUNT],
}

/// PWM, sensor, thresholds.
#[derive(Debug, Clone, PartialEq)]
pub struct Board {
    /// Pulses a second.
    pub pwm_hz: f64,
    /// The PCA9685's own oscillator; nominally 25 MHz.
    pub oscillator_mhz: f64,
    /// The INA219's shunt.
    pub shunt_ohm: f64,
    /// A moving robot stops below this.
    pub undervoltage_v: f64,
    /// A walk does not start below this.
    pub start_v: f64,
    /// A moving robot stops at this.
    pub overcurrent_a: f64,
    /// How long the start button lets it walk; 0 never, 255 until pressed again.
    pub autostart_s: u8,
}

/// One servo.
#[derive(Debug, Clone, PartialEq)]
pub struct JointSetup {
    /// Output of the PCA9685.
    pub channel: u8,
    /// Whether the servo turns against its joint.
    pub reversed: bool,
    /// Pulse at the joint's neutral.
    pub neutral_us: f64,
    /// Change of the pulse per degree.
    pub us_per_degree: f64,
    /// Shortest pulse that it is sent.
    pub min_us: f64,
    /// Longest pulse that it is sent.
    pub max_us: f64,
    /// Whether it was measured, or is still the default.
    pub is_measured: bool,
}

/// A value that no robot accepts.
#[derive(Debug, Clone, PartialEq, Error)]
// The messages say what each field is.
#[allow(missing_docs)]
pub enum BadCalibration {
    /// A number is out of its range.
    #[error("{whose}: {field} is {value}; it must be within {min} to {max} {unit}")]
    Value {
        /// `board`, or the joint.
        whose: &'static str,
        field: &'static str,
        value: f64,
        min: f64,
        max: f64,
        unit: &'static str,
    },
    /// Two joints on one output.
    #[error("{} and {} both have channel {channel}", .joints[0].name(), .joints[1].name())]
    SharedChannel { joints: [Joint; 2], channel: u8 },
}

impl Board {
    /// Why the robot's energy may be a quarter off, if it may: its sensor is read
    /// at fixed moments of a frame, and servos that pulse in step with the frames
    /// show it the same moments of their current for ever.
    #[must_use]
    pub fn in_step(&self) -> Option<String> {
        const FRAME_HZ: f64 = protocol::FRAME_RATE_HZ as f64;
        let rate_hz = rate_hz(self.oscillator_mhz, self.prescale().clamp(0.0, 255.0) as u8);
        let strides = (rate_hz / FRAME_HZ).round().max(1.0);
        // The Nano's own resonator may be off as much.
        ((rate_hz - strides * FRAME_HZ).abs() < 0.1).then(|| {
            format!(
                "the PWM runs at {rate_hz:.2} Hz, in step with the robot's {FRAME_HZ} frames a second: the \
                 energy it reports may be a quarter off; set pwm_hz to {:.0}, which servos take as well",
                strides * FRAME_HZ - 2.0
            )
        })
    }

    /// The prescaler whose rate is nearest to the asked one.
    fn prescale(&self) -> f64 {
        (self.oscillator_mhz * 1e6 / COUNTS_A_PERIOD / self.pwm_hz).round() - 1.0
    }

    fn check(&self) -> Result<BoardCalibration, BadCalibration> {
        let within = |field, value: f64, min: f64, max: f64, unit| {
            within("board", field, value, min, max, unit).map(|()| value)
        };
        let oscillator_mhz = within("oscillator_mhz", self.oscillator_mhz, 20.0, 30.0, "MHz")?;
        let rate = |prescale: u8| rate_hz(oscillator_mhz, prescale);
        // Half a prescaler step beyond the ends rounds to them.
        let (slowest, fastest) = (rate(MAX_PRESCALE) - 0.1, rate(MIN_PRESCALE) + 0.1);
        within("pwm_hz", self.pwm_hz, round_up(slowest, 1), round_down(fastest, 1), "Hz")?;
        // The robot's gain for it is 0.5 to 1.5.
        let (low, high) = (round_up(NOMINAL_SHUNT_OHM / 1.5, 3), NOMINAL_SHUNT_OHM * 2.0);
        within("shunt_ohm", self.shunt_ohm, low, high, "ohm")?;
        within("start_v", self.start_v, 0.0, 16.0, "V")?;
        within("undervoltage_v", self.undervoltage_v, 0.0, self.start_v, "V (start_v)")?;
        within("overcurrent_a", self.overcurrent_a, 0.001, 3.15, "A")?;
        let gain = NOMINAL_SHUNT_OHM / self.shunt_ohm * f64::from(UNITY_GAIN_Q14);
        Ok(BoardCalibration {
            prescale: self.prescale() as u8,
            oscillator_khz: (oscillator_mhz * 1e3).round() as u16,
            shunt_gain_q14: gain.round() as u16,
            undervoltage_mv: (self.undervoltage_v * 1e3).round() as u16,
            start_mv: (self.start_v * 1e3).round() as u16,
            overcurrent_ma: (self.overcurrent_a * 1e3).round() as u16,
            autostart_s: self.autostart_s,
        })
    }
}

impl JointSetup {
    /// Pulse at an angle, unlimited.
    #[must_use]
    pub fn pulse_us(&self, angle_deg: f64) -> f64 {
        let sign = if self.reversed { -1.0 } else { 1.0 };
        self.neutral_us + sign * self.us_per_degree * angle_deg
    }

    fn check(&self, joint: Joint, count_us: f64) -> Result<JointCalibration, BadCalibration> {
        let within = |field, value, min, max, unit| within(joint.name(), field, value, min, max, unit);
        within("channel", f64::from(self.channel), 0.0, 7.0, "(PCA9685 outputs)")?;
        let period_us = round_down(f64::from(MAX_COUNTS) * count_us, 0);
        let (shortest, longest) = (PULSE_RANGE_US.0, PULSE_RANGE_US.1.min(period_us));
        within("neutral_us", self.neutral_us, shortest, longest, "us")?;
        within("min_us", self.min_us, shortest, self.neutral_us, "us (neutral_us)")?;
        within("max_us", self.max_us, self.neutral_us, longest, "us")?;
        let steepest = round_down(f64::from(u16::MAX) * SCALE_UNIT * count_us, 2).min(30.0);
        within("us_per_degree", self.us_per_degree, 1.0, steepest, "us/degree")?;
        let counts = |us: f64| (us / count_us).round() as u16;
        Ok(JointCalibration {
            channel: self.channel,
            reversed: self.reversed,
            neutral_counts: counts(self.neutral_us),
            scale_q20: (self.us_per_degree / count_us / SCALE_UNIT).round() as u16,
            min_counts: counts(self.min_us),
            max_counts: counts(self.max_us),
        })
    }
}

impl RobotCalibration {
    /// From a robot's record, which does not say which joints were measured.
    #[must_use]
    pub fn from_record(record: &Calibration) -> Self {
        let board = record.board();
        let count_us = count_us(&board);
        let joints = Joint::ALL.map(|joint| {
            let joint = record.joint(joint);
            let us = |counts: u16| rounded(f64::from(counts) * count_us, 2);
            JointSetup {
                channel: joint.channel,
                reversed: joint.reversed,
                neutral_us: us(joint.neutral_counts),
                us_per_degree: rounded(f64::from(joint.scale_q20) * SCALE_UNIT * count_us, 4),
                min_us: us(joint.min_counts),
                max_us: us(joint.max_counts),
                is_measured: false,
            }
        });
        let oscillator_mhz = f64::from(board.oscillator_khz) / 1e3;
        let gain = f64::from(board.shunt_gain_q14) / f64::from(UNITY_GAIN_Q14);
        let board = Board {
            pwm_hz: rounded(rate_hz(oscillator_mhz, board.prescale), 2),
            oscillator_mhz,
            shunt_ohm: rounded(NOMINAL_SHUNT_OHM / gain, 7),
            undervoltage_v: f64::from(board.undervoltage_mv) / 1e3,
            start_v: f64::from(board.start_mv) / 1e3,
            overcurrent_a: f64::from(board.overcurrent_ma) / 1e3,
            autostart_s: board.autostart_s,
        };
        Self { board, joints }
    }

    /// The record that the robot keeps.
    ///
    /// # Errors
    /// The first value that no robot takes, with its limits.
    pub fn record(&self) -> Result<Calibration, BadCalibration> {
        let board = self.board.check()?;
        let count_us = count_us(&board);
        let mut joints = [Calibration::authors().joint(Joint::Hip1); JOINT_COUNT];
        for joint in Joint::ALL {
            joints[joint.index()] = self.joints[joint.index()].check(joint, count_us)?;
        }
        for (i, &first) in Joint::ALL.iter().enumerate() {
            for &second in &Joint::ALL[i + 1..] {
                let channel = self.joints[first.index()].channel;
                if channel == self.joints[second.index()].channel {
                    return Err(BadCalibration::SharedChannel { joints: [first, second], channel });
                }
            }
        }
        Ok(Calibration::new(&joints, &board))
    }
}

fn within(
    whose: &'static str,
    field: &'static str,
    value: f64,
    min: f64,
    max: f64,
    unit: &'static str,
) -> Result<(), BadCalibration> {
    // NaN lies within nothing.
    if (min..=max).contains(&value) {
        Ok(())
    } else {
        Err(BadCalibration::Value { whose, field, value, min, max, unit })
    }
}

/// Pulses a second at a prescaler.
fn rate_hz(oscillator_mhz: f64, prescale: u8) -> f64 {
    oscillator_mhz * 1e6 / COUNTS_A_PERIOD / (f64::from(prescale) + 1.0)
}

/// The oscillator that makes `measured_hz` of the prescaler in use.
#[must_use]
pub fn oscillator_mhz(measured_hz: f64, prescale: u8) -> f64 {
    rounded(measured_hz * COUNTS_A_PERIOD * (f64::from(prescale) + 1.0) / 1e6, 3)
}

fn rounded(value: f64, decimals: i32) -> f64 {
    let scale = 10_f64.powi(decimals);
    (value * scale).round() / scale
}

fn round_down(value: f64, decimals: i32) -> f64 {
    let scale = 10_f64.powi(decimals);
    (value * scale).floor() / scale
}

fn round_up(value: f64, decimals: i32) -> f64 {
    let scale = 10_f64.powi(decimals);
    (value * scale).ceil() / scale
}

#[cfg(test)]
mod tests;
