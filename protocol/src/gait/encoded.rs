//! A gait as bytes, checked once and evaluated where it lies.
//!
//! Holds the layout of both kinds of gait, which is postcard's: every field has a
//! fixed length, so a robot finds each without decoding the others, and keeps
//! one copy for playing, reading back and saving. Invalid bytes are
//! refused and the gait before them stays.
//!
//! | bytes | polynomial | sampled |
//! |---|---|---|
//! | 0 | kind 0 | kind 1 |
//! | 1..17 | name | name |
//! | 17..21 | period, us | period, us |
//! | 21..23 | unit | step; lowest angle |
//! | 23.. | 8 x (centre, min, max, 11 coefficients) | highest angle; 8 centres; row count; rows of 8 |
//! | last 4 | CRC-32 | CRC-32 |

use super::curve::{self, PlainProduct, Product, are_valid_limits};
use super::layout::{CRC_LEN, Kind, MAX_ROWS, check_header, check_limits, crc32_of};
use super::{Amplitude, Angle, COEFFICIENT_COUNT, GaitError, MAX_ENCODED_LEN, Name};
use crate::crc::crc32;
use crate::joint::{JOINT_COUNT, Joint};

const NAME: usize = 1;
const PERIOD: usize = 17;
/// Everything up to here is the same for both kinds.
const HEADER_LEN: usize = 21;
const UNIT: usize = 21;
const CURVES: usize = 23;
/// Three angles and the coefficients, two bytes each.
const CURVE_LEN: usize = 2 * (3 + COEFFICIENT_COUNT);
const STEP: usize = 21;
const MIN_DEG: usize = 22;
const MAX_DEG: usize = 23;
const CENTRES: usize = 24;
const ROW_COUNT: usize = 40;
const ROWS: usize = 41;

const _: () = assert!(CURVES + JOINT_COUNT * CURVE_LEN + CRC_LEN <= MAX_ENCODED_LEN);
const _: () = assert!(ROWS + MAX_ROWS * JOINT_COUNT + CRC_LEN <= MAX_ENCODED_LEN);

/// A checked gait in its own bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Encoded {
    bytes: [u8; MAX_ENCODED_LEN],
    len: u16,
}

impl Default for Encoded {
    fn default() -> Self {
        Self::EMPTY
    }
}

impl Encoded {
    /// No gait: [`Self::setpoint`] is 0 for it.
    pub const EMPTY: Self = Self { bytes: [0; MAX_ENCODED_LEN], len: 0 };

    /// Takes another gait, or stays as it was.
    ///
    /// # Errors
    /// What is wrong with the bytes.
    pub fn replace(&mut self, bytes: &[u8]) -> Result<(), GaitError> {
        let place = self.bytes.get_mut(..bytes.len()).ok_or(GaitError::Length)?;
        check(bytes)?;
        place.copy_from_slice(bytes);
        self.len = bytes.len() as u16;
        Ok(())
    }

    /// The encoding, CRC included; empty if there is no gait.
    #[must_use]
    pub fn bytes(&self) -> &[u8] {
        self.bytes.get(..usize::from(self.len)).unwrap_or(&[])
    }

    /// Its identity: the CRC-32 at the end.
    #[must_use]
    pub fn crc32(&self) -> u32 {
        crc32_of(self.bytes())
    }

    /// Its name.
    #[must_use]
    pub fn name(&self) -> Name {
        name_in(&self.bytes)
    }

    /// Duration of one stride at speed 1.0.
    #[must_use]
    pub fn period_us(&self) -> u32 {
        period_in(&self.bytes)
    }

    /// Whether it is a row of samples.
    #[must_use]
    pub const fn is_sampled(&self) -> bool {
        self.bytes[0] == Kind::Sampled as u8
    }

    /// Asked angle of `joint` at `phase` (1/65536 of a stride), before any limit.
    #[must_use]
    pub fn setpoint(&self, joint: Joint, phase: u16, amplitude: Amplitude) -> Angle {
        self.setpoint_by::<PlainProduct>(joint, phase, amplitude)
    }

    /// [`Self::setpoint`] with a processor's own way to multiply.
    #[must_use]
    pub fn setpoint_by<P: Product>(&self, joint: Joint, phase: u16, amplitude: Amplitude) -> Angle {
        let deviation_q17 = if self.is_sampled() {
            self.samples_q17(joint, phase)
        } else {
            self.curve_q17::<P>(joint, phase)
        };
        curve::scaled::<P>(self.centre(joint), deviation_q17, amplitude)
    }

    /// Angle that the amplitude scales about.
    #[must_use]
    pub fn centre(&self, joint: Joint) -> Angle {
        let at = if self.is_sampled() { CENTRES + 2 * joint.index() } else { curve_at(joint) };
        Angle(self.word(at))
    }

    /// Asked angle held within the limits of `joint`.
    #[must_use]
    pub fn limited(&self, joint: Joint, asked: Angle) -> Angle {
        let (min, max) = if self.is_sampled() {
            (
                Angle::from_whole_deg(self.bytes[MIN_DEG] as i8),
                Angle::from_whole_deg(self.bytes[MAX_DEG] as i8),
            )
        } else {
            let at = curve_at(joint);
            (Angle(self.word(at + 2)), Angle(self.word(at + 4)))
        };
        asked.min(max).max(min)
    }

    fn word(&self, at: usize) -> i16 {
        let word = self.bytes.get(at..).and_then(<[u8]>::first_chunk);
        i16::from_le_bytes(*word.unwrap_or(&[0; 2]))
    }

    fn curve_q17<P: Product>(&self, joint: Joint, phase: u16) -> i32 {
        let coefficients = self.bytes.get(curve_at(joint) + 6..).unwrap_or(&[]);
        let (coefficients, _) = coefficients.as_chunks::<2>();
        let coefficients = coefficients.get(..COEFFICIENT_COUNT).unwrap_or(&[]);
        curve::deviation_q17::<P>(phase, coefficients.iter().rev().map(|&word| i16::from_le_bytes(word)))
    }

    fn samples_q17(&self, joint: Joint, phase: u16) -> i32 {
        let row_count = self.bytes[ROW_COUNT];
        let place = u32::from(phase) * u32::from(row_count);
        let row = (place >> 16) as u8;
        let next = if row + 1 < row_count { row + 1 } else { 0 };
        let sample = |row: u8| {
            let at = ROWS + usize::from(row) * JOINT_COUNT + joint.index();
            self.bytes.get(at).map_or(0, |&byte| i32::from(byte as i8))
        };
        let (from, to) = (sample(row), sample(next));
        // 255 * 65535 and 128 * 65536 are 24 bits; times a step of 8 bits, 31 and the sign.
        let steps_q16 = (from << 16) + (to - from) * i32::from(place as u16);
        (steps_q16 * i32::from(self.bytes[STEP])) >> 8
    }

    /// Degrees a joint moves per unit of action, of a polynomial gait.
    pub(super) fn unit(&self) -> Angle {
        Angle(self.word(UNIT))
    }

    /// Centre, lowest and highest angle (0 to 2), then the coefficients of a polynomial gait.
    pub(super) fn curve_word(&self, joint: Joint, index: usize) -> i16 {
        self.word(curve_at(joint) + 2 * index)
    }

    /// Whether it holds a gait, and that is a polynomial.
    pub(super) const fn is_polynomial(&self) -> bool {
        self.len > 0 && !self.is_sampled()
    }
}

const fn curve_at(joint: Joint) -> usize {
    CURVES + CURVE_LEN * joint.index()
}

fn name_in(bytes: &[u8]) -> Name {
    Name(bytes.get(NAME..).and_then(<[u8]>::first_chunk).copied().unwrap_or_default())
}

fn period_in(bytes: &[u8]) -> u32 {
    let period = bytes.get(PERIOD..).and_then(<[u8]>::first_chunk);
    u32::from_le_bytes(*period.unwrap_or(&[0; 4]))
}

/// Whether `bytes` are one sound gait, and nothing else.
fn check(bytes: &[u8]) -> Result<(), GaitError> {
    let (body, crc) = bytes.split_last_chunk::<CRC_LEN>().ok_or(GaitError::Length)?;
    if crc32(body) != u32::from_le_bytes(*crc) {
        return Err(GaitError::Crc);
    }
    if body.len() < HEADER_LEN {
        return Err(GaitError::Length);
    }
    check_header(name_in(body), period_in(body))?;
    let word = |at: usize| {
        let word = body.get(at..).and_then(<[u8]>::first_chunk);
        Angle(i16::from_le_bytes(*word.unwrap_or(&[0; 2])))
    };
    let (len, centres, pitch, limits) = if body[0] == Kind::Polynomial as u8 {
        (CURVES + JOINT_COUNT * CURVE_LEN, CURVES, CURVE_LEN, None)
    } else if body[0] == Kind::Sampled as u8 {
        let [step, min_deg, max_deg] =
            *body.get(STEP..).and_then(<[u8]>::first_chunk).ok_or(GaitError::Length)?;
        check_limits(step, min_deg as i8, max_deg as i8)?;
        let rows = usize::from(*body.get(ROW_COUNT).ok_or(GaitError::Length)?);
        if !(2..=MAX_ROWS).contains(&rows) {
            return Err(GaitError::Rows);
        }
        let limits = (Angle::from_whole_deg(min_deg as i8), Angle::from_whole_deg(max_deg as i8));
        (ROWS + rows * JOINT_COUNT, CENTRES, 2, Some(limits))
    } else {
        return Err(GaitError::Kind);
    };
    if body.len() != len {
        return Err(GaitError::Length);
    }
    for joint in 0..JOINT_COUNT {
        let at = centres + pitch * joint;
        let (min, max) = limits.unwrap_or((word(at + 2), word(at + 4)));
        if !are_valid_limits(word(at), min, max) {
            return Err(GaitError::JointLimits(joint as u8));
        }
    }
    Ok(())
}
