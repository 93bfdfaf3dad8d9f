//! The sampled gait: a trajectory that no polynomial holds, as it was recorded.
//!
//! Holds up to [`MAX_ROWS`] evenly spaced rows over one stride, a byte a joint,
//! with straight lines between them; the last row leads back to the first.
//! One step size serves all joints, so the largest stroke sets the resolution:
//! 1/127 of it, 0.2 degree for the 24 degrees that an action of 1 makes.

use super::layout::{Kind, MAX_ROWS, check_header, check_limits, close};
use super::{Angle, GaitError, Name};
use crate::JOINT_COUNT;
use serde::ser::SerializeSeq;
use serde::{Serialize, Serializer};

/// Steps are in 1/512 degree.
pub const STEP_UNITS_PER_DEG: f64 = 512.0;

/// Up to [`MAX_ROWS`] rows of deviations, in steps.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Rows {
    rows: [[i8; JOINT_COUNT]; MAX_ROWS],
    len: u8,
}

impl Rows {
    /// The rows, if there are 2 to [`MAX_ROWS`] of them.
    #[must_use]
    pub fn new(rows: &[[i8; JOINT_COUNT]]) -> Option<Self> {
        let mut all = [[0; JOINT_COUNT]; MAX_ROWS];
        all.get_mut(..rows.len()).filter(|rows| rows.len() >= 2)?.copy_from_slice(rows);
        Some(Self { rows: all, len: rows.len() as u8 })
    }

    /// The rows, in order.
    #[must_use]
    pub fn as_slice(&self) -> &[[i8; JOINT_COUNT]] {
        &self.rows[..usize::from(self.len)]
    }
}

impl Serialize for Rows {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut seq = serializer.serialize_seq(Some(usize::from(self.len)))?;
        self.as_slice().iter().try_for_each(|row| seq.serialize_element(row))?;
        seq.end()
    }
}

/// A gait of evenly spaced samples over one stride.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct SampledTable {
    /// What the robot reports as its gait.
    pub name: Name,
    /// Duration of one stride at speed 1.0.
    #[serde(with = "postcard::fixint::le")]
    pub period_us: u32,
    /// One step of a sample, in 1/512 degree.
    pub step: u8,
    /// Lowest angle that any joint may be sent to, in degrees.
    pub min_deg: i8,
    /// Highest angle that any joint may be sent to, in degrees.
    pub max_deg: i8,
    /// Angles that the amplitude scales about, in [`crate::Joint::ALL`] order.
    pub centres: [Angle; JOINT_COUNT],
    /// Deviations from the centres at amplitude 1.0.
    pub rows: Rows,
}

impl SampledTable {
    /// Quantises rows of deviations in degrees at amplitude 1.0.
    ///
    /// `None` if there are fewer than 2 or more than [`MAX_ROWS`], a deviation is
    /// beyond 63.2 degrees, or a number is not finite.
    #[must_use]
    pub fn quantise(
        name: Name,
        period_us: u32,
        limits_deg: (i8, i8),
        centres_deg: &[f64; JOINT_COUNT],
        rows_deg: &[[f64; JOINT_COUNT]],
    ) -> Option<Self> {
        if !centres_deg.iter().chain(rows_deg.iter().flatten()).all(|deg| deg.is_finite()) {
            return None;
        }
        let largest_deg = rows_deg.iter().flatten().fold(0.0, |largest: f64, deg| largest.max(deg.abs()));
        // Up, so that the largest deviation is at most 127 steps.
        let step = largest_deg * STEP_UNITS_PER_DEG / 127.0;
        let whole = step as u8;
        let step = if f64::from(whole) < step { whole.checked_add(1)? } else { whole.max(1) };
        if f64::from(step) * 127.0 < largest_deg * STEP_UNITS_PER_DEG {
            return None;
        }
        let mut rows = [[0; JOINT_COUNT]; MAX_ROWS];
        for (row, row_deg) in rows.get_mut(..rows_deg.len())?.iter_mut().zip(rows_deg) {
            for (sample, deg) in row.iter_mut().zip(row_deg) {
                let steps = deg * STEP_UNITS_PER_DEG / f64::from(step);
                *sample = super::units::round_to_i16(steps).clamp(-127, 127) as i8;
            }
        }
        let table = Self {
            name,
            period_us,
            step,
            min_deg: limits_deg.0,
            max_deg: limits_deg.1,
            centres: centres_deg.map(Angle::from_deg),
            rows: Rows::new(&rows[..rows_deg.len()])?,
        };
        table.validate().is_ok().then_some(table)
    }

    /// Checks every field that the types leave open.
    ///
    /// # Errors
    /// The first field that is out of its range.
    pub fn validate(&self) -> Result<(), GaitError> {
        check_header(self.name, self.period_us)?;
        check_limits(self.step, self.min_deg, self.max_deg)?;
        let (min, max) = (Angle::from_whole_deg(self.min_deg), Angle::from_whole_deg(self.max_deg));
        match self.centres.iter().position(|centre| !(min..=max).contains(centre)) {
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
        *kind = Kind::Sampled as u8;
        let len = postcard::to_slice(self, rest).map_err(|_| GaitError::Length)?.len();
        close(buffer, 1 + len)
    }
}
