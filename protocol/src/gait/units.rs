//! The integers that angles, amplitudes, speeds and names are made of.
//!
//! Holds their ranges. Uses floating point only where the host quantises.

use serde::{Deserialize, Serialize};

/// An angle from the joint's calibrated neutral, in 1/256 degree.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default, Serialize, Deserialize)]
pub struct Angle(#[serde(with = "postcard::fixint::le")] pub(super) i16);

impl Angle {
    /// Units of this type in one degree.
    pub const UNITS_PER_DEG: i16 = 256;
    /// The calibrated neutral.
    pub const NEUTRAL: Self = Self(0);

    /// The angle of `units` / 256 degree.
    #[must_use]
    pub const fn from_units(units: i16) -> Self {
        Self(units)
    }

    /// The angle of a whole number of degrees within +-127.
    #[must_use]
    pub const fn from_whole_deg(deg: i8) -> Self {
        Self(deg as i16 * Self::UNITS_PER_DEG)
    }

    /// Nearest representable angle, saturating at +-127.996 degrees.
    #[must_use]
    pub fn from_deg(deg: f64) -> Self {
        Self(round_to_i16(deg * f64::from(Self::UNITS_PER_DEG)))
    }

    /// The angle in 1/256 degree.
    #[must_use]
    pub const fn units(self) -> i16 {
        self.0
    }

    /// The angle in degrees.
    #[must_use]
    pub fn deg(self) -> f64 {
        f64::from(self.0) / f64::from(Self::UNITS_PER_DEG)
    }
}

/// How far the gait is scaled about each joint's centre, in 1/8192.
///
/// 1.0 moves a joint by [`super::GaitTable::unit_deg`] degrees per unit of action.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Amplitude(pub(super) u16);

impl Amplitude {
    /// Units of this type in 1.0.
    pub const UNITS_PER_ONE: u16 = 8192;
    /// No amplitude: zeros, for a start value that takes no flash. Not valid.
    pub const UNSET: Self = Self(0);
    /// The gait as recorded, at the robot's own scale.
    pub const ONE: Self = Self(Self::UNITS_PER_ONE);
    /// Smallest amplitude that setpoints are proven for, 0.5.
    pub const MIN: Self = Self(Self::UNITS_PER_ONE / 2);
    /// Largest amplitude that setpoints are proven for, 3.0.
    pub const MAX: Self = Self(Self::UNITS_PER_ONE * 3);

    /// The amplitude of `units` / 8192, if within [`Self::MIN`] to [`Self::MAX`].
    #[must_use]
    pub const fn from_units(units: u16) -> Option<Self> {
        if units >= Self::MIN.0 && units <= Self::MAX.0 { Some(Self(units)) } else { None }
    }

    /// Nearest representable amplitude, if `value` is within 0.5 to 3.0.
    #[must_use]
    pub fn from_f64(value: f64) -> Option<Self> {
        if !(0.5..=3.0).contains(&value) {
            return None;
        }
        Self::from_units(round_to_i16(value * f64::from(Self::UNITS_PER_ONE)) as u16)
    }

    /// The amplitude in 1/8192.
    #[must_use]
    pub const fn units(self) -> u16 {
        self.0
    }

    /// The amplitude as a factor.
    #[must_use]
    pub fn value(self) -> f64 {
        f64::from(self.0) / f64::from(Self::UNITS_PER_ONE)
    }

    /// Whether the value lies in the proven range; false only off the wire.
    #[must_use]
    pub const fn is_valid(self) -> bool {
        Self::from_units(self.0).is_some()
    }
}

/// A gait's name: up to 16 printable ASCII characters.
#[derive(Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Name(pub(super) [u8; Name::CAPACITY]);

impl Name {
    /// Longest name in bytes.
    pub const CAPACITY: usize = 16;

    /// The name, if it is 1 to 16 printable ASCII characters.
    #[must_use]
    pub fn new(text: &str) -> Option<Self> {
        let mut bytes = [0; Self::CAPACITY];
        bytes.get_mut(..text.len())?.copy_from_slice(text.as_bytes());
        let name = Self(bytes);
        name.is_valid().then_some(name)
    }

    /// A name out of memory; [`Self::as_str`] is empty for bytes that are none.
    #[must_use]
    pub const fn from_bytes(bytes: [u8; Self::CAPACITY]) -> Self {
        Self(bytes)
    }

    /// The name without its padding; empty if the bytes are not a name.
    #[must_use]
    pub fn as_str(&self) -> &str {
        let len = self.0.iter().position(|&b| b == 0).unwrap_or(Self::CAPACITY);
        core::str::from_utf8(&self.0[..len]).unwrap_or("")
    }

    pub(super) fn is_valid(&self) -> bool {
        let len = self.0.iter().position(|&b| b == 0).unwrap_or(Self::CAPACITY);
        let (text, padding) = self.0.split_at(len);
        len > 0 && text.iter().all(|b| (0x20..0x7F).contains(b)) && padding.iter().all(|&b| b == 0)
    }
}

impl core::fmt::Debug for Name {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        core::fmt::Debug::fmt(self.as_str(), f)
    }
}

/// How fast a stride is played, in 1/8192 of the gait's own speed; 0 is a pause.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Speed(u16);

impl Speed {
    /// Units of this type in 1.0.
    pub const UNITS_PER_ONE: u16 = 8192;
    /// Standing still in mid stride, servos on.
    pub const PAUSED: Self = Self(0);
    /// The gait's own period.
    pub const ONE: Self = Self(Self::UNITS_PER_ONE);
    /// Twice as fast.
    pub const MAX: Self = Self(Self::UNITS_PER_ONE * 2);

    /// The speed of `units` / 8192, if it is at most [`Self::MAX`].
    #[must_use]
    pub const fn from_units(units: u16) -> Option<Self> {
        if units <= Self::MAX.0 { Some(Self(units)) } else { None }
    }

    /// Nearest representable speed, if `value` is within 0 to 2.
    #[must_use]
    pub fn from_f64(value: f64) -> Option<Self> {
        if !(0.0..=2.0).contains(&value) {
            return None;
        }
        Self::from_units(round_to_i16(value * f64::from(Self::UNITS_PER_ONE)) as u16)
    }

    /// The speed in 1/8192.
    #[must_use]
    pub const fn units(self) -> u16 {
        self.0
    }

    /// The speed as a factor.
    #[must_use]
    pub fn value(self) -> f64 {
        f64::from(self.0) / f64::from(Self::UNITS_PER_ONE)
    }

    /// Whether it is within range; false only off the wire.
    #[must_use]
    pub const fn is_valid(self) -> bool {
        self.0 <= Self::MAX.0
    }
}

/// Rounds half away from zero and saturates; `core` has no `round`.
pub(super) fn round_to_i16(value: f64) -> i16 {
    // `as` saturates and sends NaN to 0.
    (if value < 0.0 { value - 0.5 } else { value + 0.5 }) as i16
}
