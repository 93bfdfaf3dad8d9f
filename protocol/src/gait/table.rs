//! The polynomial gait: eight curves over one stride.
//!
//! Holds the table as the host handles it, field by field. The robot keeps the
//! bytes of [`GaitTable::encode`] and evaluates those: see [`super::Encoded`].

use super::layout::{Kind, check_header, close, crc32_of};
use super::{Angle, Coefficient, Encoded, GaitError, JointCurve, Name};
use crate::JOINT_COUNT;
use crate::crc::crc32;
use crate::gait::Amplitude;
use crate::joint::Joint;
use serde::{Deserialize, Serialize};

/// A gait: eight curves over one stride.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct GaitTable {
    /// What the robot reports as its gait.
    pub name: Name,
    /// Duration of one stride at speed 1.0.
    #[serde(with = "postcard::fixint::le")]
    pub period_us: u32,
    /// Degrees a joint moves per unit of action at amplitude 1.0, in 1/256.
    pub unit: Angle,
    /// Curves in [`Joint::ALL`] order.
    pub joints: [JointCurve; JOINT_COUNT],
}

impl GaitTable {
    /// The CRC-32 at the end of an encoded table: its identity.
    #[must_use]
    pub fn crc32_of(bytes: &[u8]) -> u32 {
        crc32_of(bytes)
    }

    /// Degrees a joint moves per unit of action at amplitude 1.0.
    #[must_use]
    pub fn unit_deg(&self) -> f64 {
        self.unit.deg()
    }

    /// Checks every field that the types leave open.
    ///
    /// # Errors
    /// The first field that is out of its range.
    pub fn validate(&self) -> Result<(), GaitError> {
        check_header(self.name, self.period_us)?;
        match self.joints.iter().position(|joint| !joint.is_valid()) {
            Some(index) => Err(GaitError::JointLimits(index as u8)),
            None => Ok(()),
        }
    }

    /// Writes the kind of gait, postcard bytes, and their CRC-32, little endian.
    ///
    /// # Errors
    /// [`GaitError::Length`] if `buffer` is too short; else as [`Self::validate`].
    pub fn encode<'b>(&self, buffer: &'b mut [u8]) -> Result<&'b [u8], GaitError> {
        self.validate()?;
        let (kind, rest) = buffer.split_first_mut().ok_or(GaitError::Length)?;
        *kind = Kind::Polynomial as u8;
        let len = postcard::to_slice(self, rest).map_err(|_| GaitError::Length)?.len();
        close(buffer, 1 + len)
    }

    /// Reads what [`Self::encode`] wrote, and trusts nothing.
    ///
    /// # Errors
    /// What is wrong with the bytes; [`GaitError::Kind`] for a sampled gait.
    pub fn decode(bytes: &[u8]) -> Result<Self, GaitError> {
        let mut encoded = Encoded::EMPTY;
        encoded.replace(bytes)?;
        if encoded.is_polynomial() { Ok(Self::of_encoded(&encoded)) } else { Err(GaitError::Kind) }
    }

    /// Asked angle of `joint` at `phase` (1/65536 of a stride), before limits.
    #[must_use]
    pub fn setpoint(&self, joint: Joint, phase: u16, amplitude: Amplitude) -> Angle {
        self.joints[joint.index()].setpoint(phase, amplitude)
    }

    /// Phase advance of one frame at speed 1.0: see [`super::phase_step`].
    #[must_use]
    pub fn phase_step(&self) -> u32 {
        super::phase_step(self.period_us.clamp(super::MIN_PERIOD_US, super::MAX_PERIOD_US))
    }

    /// The table that a checked encoding of a polynomial gait holds.
    fn of_encoded(encoded: &Encoded) -> Self {
        let joints = Joint::ALL.map(|joint| JointCurve {
            centre: Angle(encoded.curve_word(joint, 0)),
            min: Angle(encoded.curve_word(joint, 1)),
            max: Angle(encoded.curve_word(joint, 2)),
            coefficients: core::array::from_fn(|order| Coefficient(encoded.curve_word(joint, 3 + order))),
        });
        Self { name: encoded.name(), period_us: encoded.period_us(), unit: encoded.unit(), joints }
    }

    /// The CRC-32 that [`Self::encode`] ends with, if the table is valid.
    #[must_use]
    pub fn crc32(&self) -> Option<u32> {
        let mut buffer = [0; super::MAX_ENCODED_LEN];
        let bytes = self.encode(&mut buffer).ok()?;
        bytes.split_last_chunk::<4>().map(|(body, _)| crc32(body))
    }
}
