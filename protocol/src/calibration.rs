//! How one robot is built: servos, PWM, shunt, supply.
//!
//! Holds the layout of the record that robots keep in their EEPROM, and its
//! ranges. Holds what the robot needs, in its own units: a host that thinks in
//! microseconds and ohms converts. Records are refused that would move a servo
//! beyond the pulses they declare, or use an output twice.
//!
//! Layout, little endian: per joint channel and direction (1 byte), neutral (2),
//! scale (2), shortest (2) and longest pulse (2); then the board's prescaler (1),
//! oscillator (2), shunt gain (2), three thresholds (2 each), autostart (1).

use crate::joint::{JOINT_COUNT, Joint};
use serde::{Deserialize, Serialize};

/// Bytes of one joint.
const JOINT_LEN: usize = 9;
/// Bytes of the board.
const BOARD_LEN: usize = 12;
/// Bytes of a record.
pub const CALIBRATION_LEN: usize = JOINT_COUNT * JOINT_LEN + BOARD_LEN;
/// Set in a channel byte where the servo turns against its joint.
const REVERSED: u8 = 0x80;
/// Last count of a PWM period.
pub const MAX_COUNTS: u16 = 4_095;
/// Fastest PWM: 25 MHz / 4096 / (17 + 1) = 339 Hz, for digital servos.
pub const MIN_PRESCALE: u8 = 17;
/// Slowest PWM: 25 MHz / 4096 / (152 + 1) = 39.9 Hz.
pub const MAX_PRESCALE: u8 = 152;
/// The shunt gain that changes nothing, 1.0.
pub const UNITY_GAIN_Q14: u16 = 1 << 14;

/// How one servo is mounted and wired.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct JointCalibration {
    /// PCA9685 output, 0 to 7.
    pub channel: u8,
    /// Whether the servo turns against its joint.
    pub reversed: bool,
    /// Pulse length at the joint's neutral, in PWM counts.
    pub neutral_counts: u16,
    /// PWM counts per 1/256 degree, in 2^-20: up to 16 counts a degree.
    ///
    /// 20 bits make a pulse at 90 degrees wrong by at most 1/90 count.
    pub scale_q20: u16,
    /// Shortest pulse that the servo is sent.
    pub min_counts: u16,
    /// Longest pulse that the servo is sent.
    pub max_counts: u16,
}

impl JointCalibration {
    /// Pulse at `angle_units` / 256 degrees from neutral, in PWM counts, to the nearest.
    #[must_use]
    pub fn counts(self, angle_units: i16) -> u16 {
        // 32767 * 65535 is below 2^31. The floor of a floor is the floor: this
        // rounds as a shift by 20 in one would.
        let product_q4 = (i32::from(angle_units) * i32::from(self.scale_q20)) >> 16;
        let offset = ((product_q4 + 8) >> 4) as i16;
        let offset = if self.reversed { -offset } else { offset };
        // Not `clamp`: it panics where a calibration has its bounds reversed.
        self.neutral_counts.saturating_add_signed(offset).min(self.max_counts).max(self.min_counts)
    }

    const fn is_sound(self) -> bool {
        self.min_counts > 0
            && self.min_counts <= self.neutral_counts
            && self.neutral_counts <= self.max_counts
            && self.max_counts <= MAX_COUNTS
    }
}

/// What holds for the whole board.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BoardCalibration {
    /// PCA9685 prescaler: oscillator / 4096 / (prescale + 1) pulses a second.
    pub prescale: u8,
    /// The PCA9685's own oscillator; the robot keeps it for its host.
    pub oscillator_khz: u16,
    /// Nominal over true resistance of the shunt, in 2^-14.
    pub shunt_gain_q14: u16,
    /// Supply voltage below which a moving robot stops.
    pub undervoltage_mv: u16,
    /// Supply voltage at rest that a walk needs.
    pub start_mv: u16,
    /// Supply current at which a moving robot stops.
    pub overcurrent_ma: u16,
    /// Seconds that the start button lets the robot walk; 0 leaves the button
    /// without effect, 255 walks until it is pressed again.
    pub autostart_s: u8,
}

impl BoardCalibration {
    const fn is_sound(self) -> bool {
        self.prescale >= MIN_PRESCALE
            && self.prescale <= MAX_PRESCALE
            && self.oscillator_khz >= 20_000
            && self.oscillator_khz <= 30_000
            && self.shunt_gain_q14 >= UNITY_GAIN_Q14 / 2
            && self.shunt_gain_q14 <= UNITY_GAIN_Q14 / 2 * 3
            && self.undervoltage_mv <= self.start_mv
            && self.start_mv <= 16_000
            && self.overcurrent_ma > 0
            && self.overcurrent_ma <= 3_150
    }
}

/// Why bytes are not a calibration.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum CalibrationError {
    /// Not [`CALIBRATION_LEN`] bytes.
    Length,
    /// The joint's output is not 0 to 7, or another joint has it.
    Channel(u8),
    /// The joint's pulses are not 0 < shortest <= neutral <= longest < 4096.
    Pulse(u8),
    /// A number of the board is out of its range.
    Board,
}

/// A record, in its own bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Calibration([u8; CALIBRATION_LEN]);

impl Calibration {
    /// Zeros, which no robot may move by: for a start value that takes no flash.
    pub const NONE: Self = Self([0; CALIBRATION_LEN]);

    /// The record of these joints, in [`Joint::ALL`] order, and this board.
    #[must_use]
    pub fn new(joints: &[JointCalibration; JOINT_COUNT], board: &BoardCalibration) -> Self {
        let mut record = Self::NONE;
        for (joint, calibration) in Joint::ALL.into_iter().zip(joints) {
            record.set_joint(joint, *calibration);
        }
        record.set_board(*board);
        record
    }

    /// The authors' robot: joint n on channel n, 330 counts at neutral, 5/3
    /// counts a degree, pulses within 0.6 to 2.1 ms, 59.8 Hz of a 25 MHz
    /// oscillator, 0.1 ohm.
    ///
    /// Undervoltage leaves a supply of 5 V 0.8 V for its leads and for stalls,
    /// and stays above the 3.8 V that the Nano needs at 16 MHz (data sheet
    /// 29.3). At rest, 5 V less 8 %: a limp robot draws next to nothing, so what
    /// is lower is another supply, an empty battery, or none. Overcurrent is just
    /// short of 3.2 A, where the sensor's range ends: beyond it, energy is not
    /// measured either.
    #[must_use]
    pub fn authors() -> Self {
        let mut record = Self::NONE;
        record.set_authors();
        record
    }

    /// Becomes [`Self::authors`] in place.
    pub fn set_authors(&mut self) {
        for joint in Joint::ALL {
            self.set_joint(
                joint,
                JointCalibration {
                    channel: joint as u8,
                    reversed: false,
                    neutral_counts: 330,
                    // 5 / 3 / 256 * 2^20 = 6826.67.
                    scale_q20: 6_827,
                    // 147 and 515 counts of 4.08 us.
                    min_counts: 147,
                    max_counts: 515,
                },
            );
        }
        self.set_board(BoardCalibration {
            prescale: 101,
            oscillator_khz: 25_000,
            shunt_gain_q14: UNITY_GAIN_Q14,
            undervoltage_mv: 4_200,
            start_mv: 4_600,
            overcurrent_ma: 3_000,
            autostart_s: 0,
        });
    }

    /// The record in `bytes`.
    ///
    /// # Errors
    /// As [`Self::replace`].
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, CalibrationError> {
        let mut record = Self::NONE;
        record.replace(bytes)?;
        Ok(record)
    }

    /// Takes the record in `bytes`, or stays as it was.
    ///
    /// # Errors
    /// The first field that is out of its range.
    pub fn replace(&mut self, bytes: &[u8]) -> Result<(), CalibrationError> {
        let bytes = bytes.try_into().map_err(|_| CalibrationError::Length)?;
        check(bytes)?;
        self.0 = *bytes;
        Ok(())
    }

    /// The record.
    #[must_use]
    pub const fn bytes(&self) -> &[u8; CALIBRATION_LEN] {
        &self.0
    }

    /// How `joint` is mounted and wired.
    #[must_use]
    pub fn joint(&self, joint: Joint) -> JointCalibration {
        joint_in(&self.0, joint)
    }

    /// What holds for the whole board.
    #[must_use]
    pub fn board(&self) -> BoardCalibration {
        board_in(&self.0)
    }

    fn put(&mut self, at: usize, words: &[u16]) {
        for (place, word) in self.0.get_mut(at..).unwrap_or_default().chunks_exact_mut(2).zip(words) {
            place.copy_from_slice(&word.to_le_bytes());
        }
    }

    fn set_joint(&mut self, joint: Joint, calibration: JointCalibration) {
        let JointCalibration { channel, reversed, neutral_counts, scale_q20, min_counts, max_counts } =
            calibration;
        let at = JOINT_LEN * joint.index();
        self.0[at] = channel | if reversed { REVERSED } else { 0 };
        self.put(at + 1, &[neutral_counts, scale_q20, min_counts, max_counts]);
    }

    fn set_board(&mut self, board: BoardCalibration) {
        const AT: usize = JOINT_COUNT * JOINT_LEN;
        self.0[AT] = board.prescale;
        let BoardCalibration {
            oscillator_khz,
            shunt_gain_q14,
            undervoltage_mv,
            start_mv,
            overcurrent_ma,
            ..
        } = board;
        self.put(AT + 1, &[oscillator_khz, shunt_gain_q14, undervoltage_mv, start_mv, overcurrent_ma]);
        self.0[AT + 11] = board.autostart_s;
    }
}

fn word_at(bytes: &[u8; CALIBRATION_LEN], at: usize) -> u16 {
    let word = bytes.get(at..).and_then(<[u8]>::first_chunk);
    u16::from_le_bytes(*word.unwrap_or(&[0; 2]))
}

fn joint_in(bytes: &[u8; CALIBRATION_LEN], joint: Joint) -> JointCalibration {
    let at = JOINT_LEN * joint.index();
    JointCalibration {
        channel: bytes[at] & !REVERSED,
        reversed: bytes[at] & REVERSED != 0,
        neutral_counts: word_at(bytes, at + 1),
        scale_q20: word_at(bytes, at + 3),
        min_counts: word_at(bytes, at + 5),
        max_counts: word_at(bytes, at + 7),
    }
}

fn board_in(bytes: &[u8; CALIBRATION_LEN]) -> BoardCalibration {
    const AT: usize = JOINT_COUNT * JOINT_LEN;
    BoardCalibration {
        prescale: bytes[AT],
        oscillator_khz: word_at(bytes, AT + 1),
        shunt_gain_q14: word_at(bytes, AT + 3),
        undervoltage_mv: word_at(bytes, AT + 5),
        start_mv: word_at(bytes, AT + 7),
        overcurrent_ma: word_at(bytes, AT + 9),
        autostart_s: bytes[AT + 11],
    }
}

fn check(bytes: &[u8; CALIBRATION_LEN]) -> Result<(), CalibrationError> {
    let mut outputs = 0_u8;
    for joint in Joint::ALL {
        let calibration = joint_in(bytes, joint);
        let output = 1_u8.checked_shl(u32::from(calibration.channel)).unwrap_or(0);
        if output == 0 || outputs & output != 0 {
            return Err(CalibrationError::Channel(joint as u8));
        }
        outputs |= output;
        if !calibration.is_sound() {
            return Err(CalibrationError::Pulse(joint as u8));
        }
    }
    if board_in(bytes).is_sound() { Ok(()) } else { Err(CalibrationError::Board) }
}
