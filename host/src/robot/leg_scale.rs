//! How long a robot's legs are, as a multiple of the drawn ones.
//!
//! Holds the range of valid scales and the one rule by which two are equal.
//! Does not depend on the robot.

use core::fmt;
use core::hash::{Hash, Hasher};
use core::str::FromStr;
use serde::{Deserialize, Serialize};
use thiserror::Error;

/// Smallest and largest scale: the Ant's servos lift no longer legs.
pub const LEG_SCALE_RANGE: (f64, f64) = (0.3, 2.0);
/// Scales that round to the same multiple of this are equal: files keep fewer digits than a sum may have.
const TOLERANCE: f64 = 1e-6;

/// Length of the scaled limbs over the drawn length, within [`LEG_SCALE_RANGE`].
///
/// In files and JSON a plain number; in text "1 L", as the paper writes it.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
#[serde(try_from = "f64", into = "f64")]
pub struct LegScale(f64);

/// Why a number or a text is not a leg scale.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum LegScaleError {
    /// Outside [`LEG_SCALE_RANGE`], or NaN.
    #[error("leg_scale is {value}, but must be within {} to {}", LEG_SCALE_RANGE.0, LEG_SCALE_RANGE.1)]
    OutOfRange {
        /// The number.
        value: f64,
    },
    /// Text that is not a number.
    #[error("{text:?} is not a number")]
    NotANumber {
        /// As it was typed.
        text: String,
    },
}

impl LegScale {
    /// The paper's long legs, "1 L": shins of 0.23 m.
    pub const LONG: Self = Self(1.0);
    /// The paper's short legs, "0.6 L": shins of 0.138 m.
    pub const SHORT: Self = Self(0.6);

    /// The scale of that value.
    ///
    /// # Errors
    /// [`LegScaleError::OutOfRange`] unless it lies within [`LEG_SCALE_RANGE`].
    pub fn new(value: f64) -> Result<Self, LegScaleError> {
        let (least, most) = LEG_SCALE_RANGE;
        if (least..=most).contains(&value) {
            Ok(Self(value))
        } else {
            Err(LegScaleError::OutOfRange { value })
        }
    }

    /// The scale nearest to `value`.
    pub(super) const fn clamped(value: f64) -> Self {
        // `max` and `min` instead of `clamp`: NaN becomes the smallest scale.
        Self(value.max(LEG_SCALE_RANGE.0).min(LEG_SCALE_RANGE.1))
    }

    /// The factor.
    #[must_use]
    pub const fn value(self) -> f64 {
        self.0
    }

    /// What equality, order and hash go by: the value in units of the tolerance.
    fn key(self) -> i64 {
        (self.0 / TOLERANCE).round() as i64
    }
}

impl Default for LegScale {
    fn default() -> Self {
        Self::LONG
    }
}

impl PartialEq for LegScale {
    fn eq(&self, other: &Self) -> bool {
        self.key() == other.key()
    }
}

impl Eq for LegScale {}

impl PartialOrd for LegScale {
    fn partial_cmp(&self, other: &Self) -> Option<core::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for LegScale {
    fn cmp(&self, other: &Self) -> core::cmp::Ordering {
        self.key().cmp(&other.key())
    }
}

impl Hash for LegScale {
    fn hash<H: Hasher>(&self, state: &mut H) {
        self.key().hash(state);
    }
}

impl fmt::Display for LegScale {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(&format!("{} L", self.0))
    }
}

impl FromStr for LegScale {
    type Err = LegScaleError;

    fn from_str(text: &str) -> Result<Self, LegScaleError> {
        let value = text.trim().parse().map_err(|_| LegScaleError::NotANumber { text: text.to_owned() })?;
        Self::new(value)
    }
}

impl TryFrom<f64> for LegScale {
    type Error = LegScaleError;

    fn try_from(value: f64) -> Result<Self, LegScaleError> {
        Self::new(value)
    }
}

impl From<LegScale> for f64 {
    fn from(scale: LegScale) -> Self {
        scale.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_scale_that_no_robot_has_is_refused_with_its_value_and_the_range() {
        for text in ["0.29", "2.01", "NaN", "inf", "-1"] {
            let error = text.parse::<LegScale>().unwrap_err().to_string();
            let value = text.parse::<f64>().unwrap();
            assert_eq!(error, format!("leg_scale is {value}, but must be within 0.3 to 2"));
        }
        assert_eq!("long".parse::<LegScale>().unwrap_err().to_string(), "\"long\" is not a number");
        assert!(serde_json::from_str::<LegScale>("9").unwrap_err().to_string().contains("leg_scale is 9"));
    }

    #[test]
    fn a_scale_is_a_plain_number_in_files_and_the_papers_name_in_text() {
        for (scale, number, text) in [(LegScale::LONG, "1.0", "1 L"), (LegScale::SHORT, "0.6", "0.6 L")] {
            assert_eq!(serde_json::to_string(&scale).unwrap(), number);
            assert_eq!(serde_json::from_str::<LegScale>(number).unwrap(), scale);
            assert_eq!(scale.to_string(), text);
        }
    }

    #[test]
    fn scales_that_differ_by_a_rounding_error_are_equal_and_others_are_ordered() {
        let sum = LegScale::new(0.1 + 0.2 + 0.3).unwrap();

        assert_ne!(sum.value(), LegScale::SHORT.value());
        assert_eq!(sum, LegScale::SHORT);
        assert_eq!(sum.cmp(&LegScale::SHORT), core::cmp::Ordering::Equal);
        assert!(LegScale::SHORT < LegScale::new(0.61).unwrap());
    }
}
