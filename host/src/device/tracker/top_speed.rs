//! The highest speed that a robot's legs can make.
//!
//! Holds the limit, and the guess at a unit where it is passed. Does not depend on
//! tracks.

use std::fmt;

/// No legged robot with servos is faster, and hardly any other.
const TOP_LEG_LENGTHS_PER_S: f64 = 10.0;
/// A speed of a usual gait, to guess a unit by.
const USUAL_LEG_LENGTHS_PER_S: f64 = 0.5;
/// What one metre is in other units.
const UNITS: [(f64, &str); 3] = [(1000.0, "millimetres"), (100.0, "centimetres"), (39.37, "inches")];

/// The highest speed that is believed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TopSpeed {
    pub(super) leg_length_m: f64,
}

impl TopSpeed {
    /// Of a robot whose legs have this length, from hip to foot.
    #[must_use]
    pub const fn of_legs(leg_length_m: f64) -> Self {
        Self { leg_length_m }
    }

    /// In metres a second.
    #[must_use]
    pub fn m_s(self) -> f64 {
        TOP_LEG_LENGTHS_PER_S * self.leg_length_m
    }

    /// Whether legs can make this speed.
    #[must_use]
    pub fn allows(self, speed_m_s: f64) -> bool {
        speed_m_s <= self.m_s()
    }

    /// The unit that a position is in if a speed like this comes out in metres a second.
    #[must_use]
    pub fn likely_unit(self, speed: f64) -> &'static str {
        let usual_m_s = USUAL_LEG_LENGTHS_PER_S * self.leg_length_m;
        let off = |factor: f64| (speed / factor / usual_m_s).ln().abs();
        UNITS.into_iter().min_by(|a, b| off(a.0).total_cmp(&off(b.0))).map_or("metres", |(_, unit)| unit)
    }
}

impl fmt::Display for TopSpeed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "no robot of this size is faster than {:.1} m/s ({TOP_LEG_LENGTHS_PER_S} leg lengths a second)",
            self.m_s()
        )
    }
}
