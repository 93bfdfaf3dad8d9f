//! One joint's polynomial, and the integer arithmetic that evaluates it.
//!
//! Longest deviation, rounding and shifts are argued in [`super`]; nothing here
//! overflows, and hostile coefficients wrap without a panic.

use super::units::round_to_i16;
use super::{Angle, COEFFICIENT_COUNT, COEFFICIENT_UNITS_PER_DEG, MAX_DEVIATION_DEG, MAX_LIMIT_DEG};
use crate::gait::Amplitude;
use serde::{Deserialize, Serialize};

/// One Chebyshev coefficient in 1/512 degree; two bytes on the wire, always.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Coefficient(#[serde(with = "postcard::fixint::le")] pub i16);

/// One joint's curve over a stride, with its centre and limits.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct JointCurve {
    /// Angle that the amplitude scales about.
    pub centre: Angle,
    /// Lowest angle the joint may be sent to.
    pub min: Angle,
    /// Highest angle the joint may be sent to.
    pub max: Angle,
    /// Deviation from the centre at amplitude 1.0, order 0 first.
    pub coefficients: [Coefficient; COEFFICIENT_COUNT],
}

impl JointCurve {
    /// Quantises a series given in degrees, order 0 first; `None` if the
    /// curve leaves +-[`MAX_DEVIATION_DEG`], a coefficient does not fit, or a
    /// number is not finite.
    #[must_use]
    pub fn quantise(
        centre_deg: f64,
        limits_deg: (f64, f64),
        coefficients_deg: &[f64; COEFFICIENT_COUNT],
    ) -> Option<Self> {
        let mut coefficients = [Coefficient::default(); COEFFICIENT_COUNT];
        for (quantised, &deg) in coefficients.iter_mut().zip(coefficients_deg) {
            let units = deg * f64::from(COEFFICIENT_UNITS_PER_DEG);
            if !(-32767.0..=32767.0).contains(&units) {
                return None;
            }
            *quantised = Coefficient(round_to_i16(units));
        }
        let angles = [centre_deg, limits_deg.0, limits_deg.1];
        if !angles.iter().all(|a| (-127.0..=127.0).contains(a)) {
            return None;
        }
        let curve = Self {
            centre: Angle::from_deg(centre_deg),
            min: Angle::from_deg(limits_deg.0),
            max: Angle::from_deg(limits_deg.1),
            coefficients,
        };
        // The series is smooth: 512 points bound it to far less than the
        // margin that MAX_DEVIATION_DEG leaves below 64 degrees.
        let within = (0..=u16::MAX)
            .step_by(128)
            .chain([u16::MAX])
            .all(|phase| curve.deviation_q17(phase).unsigned_abs() <= (MAX_DEVIATION_DEG * 131_072.0) as u32);
        within.then_some(curve)
    }

    fn deviation_q17(&self, phase: u16) -> i32 {
        deviation_q17::<PlainProduct>(phase, self.coefficients.iter().rev().map(|c| c.0))
    }

    /// Asked angle at `phase` (1/65536 of a stride), before any limit.
    #[must_use]
    pub fn setpoint(&self, phase: u16, amplitude: Amplitude) -> Angle {
        scaled::<PlainProduct>(self.centre, self.deviation_q17(phase), amplitude)
    }

    /// Asked angle held within the joint's limits.
    #[must_use]
    pub fn limited(&self, asked: Angle) -> Angle {
        // Not `clamp`: it panics where min > max, which `validate` refuses.
        asked.min(self.max).max(self.min)
    }

    /// Whether limits are ordered, within +-90 degrees, and hold the centre.
    pub(super) const fn is_valid(&self) -> bool {
        are_valid_limits(self.centre, self.min, self.max)
    }
}

/// Whether limits are ordered, within +-90 degrees, and hold the centre.
pub(super) const fn are_valid_limits(centre: Angle, min: Angle, max: Angle) -> bool {
    let bound = MAX_LIMIT_DEG * Angle::UNITS_PER_DEG;
    min.0 >= -bound && max.0 <= bound && min.0 < max.0 && centre.0 >= min.0 && centre.0 <= max.0
}

/// Deviation from the centre at amplitude 1.0, in 2^-17 degree.
///
/// Clenshaw's recurrence over coefficients of 2^-9 degree, the last order first:
/// `b_k = c_k + 2 x b_(k+1) - b_(k+2)`, and the series is `(b_0 + c_0 - b_2) / 2`.
/// The intermediate values stay below 64 degrees * (1 + ... + 12) = 4,992 degrees,
/// 30 bits: nothing overflows.
#[inline(always)]
pub(super) fn deviation_q17<P: Product>(phase: u16, coefficients_reversed: impl Iterator<Item = i16>) -> i32 {
    // Phase 0..65536 is x = -1..1 in Q15, exactly.
    let x_q15 = (phase ^ 0x8000) as i16;
    let (mut b0, mut b1, mut b2, mut last) = (0_i32, 0_i32, 0_i32, 0_i32);
    for coefficient in coefficients_reversed {
        (b2, b1) = (b1, b0);
        last = (coefficient as i32) << 8;
        // b * x / 2^16 is half of x * b: four times that is 2 x b.
        b0 = (P::of(b1, x_q15) << 2).wrapping_sub(b2).wrapping_add(last);
    }
    b0.wrapping_add(last).wrapping_sub(b2) >> 1
}

/// `centre + amplitude * deviation`, to the nearest 1/256 degree.
pub(super) fn scaled<P: Product>(centre: Angle, deviation_q17: i32, amplitude: Amplitude) -> Angle {
    // 3 * 8192 fits an i16, so the same product serves: Q17 * Q13 / 2^16 is Q14.
    let sum_q14 = ((centre.0 as i32) << 6).wrapping_add(P::of(deviation_q17, amplitude.0 as i16));
    let units = sum_q14.wrapping_add(32) >> 6;
    Angle(units.clamp(i16::MIN as i32, i16::MAX as i32) as i16)
}

/// How 32 bits are multiplied by 16: a processor may have a shorter way.
pub trait Product {
    /// `value * factor / 2^16`, rounded to the nearest, up at half.
    ///
    /// The quotient's lowest 32 bits, should it have more.
    fn of(value: i32, factor: i16) -> i32;
}

/// [`Product`] by plain integers, without one of 64 bits.
#[derive(Debug, Clone, Copy)]
pub struct PlainProduct;

impl Product for PlainProduct {
    #[inline(always)]
    fn of(value: i32, factor: i16) -> i32 {
        let high = (value >> 16) as i16 as i32 * factor as i32;
        let low = (value as u16) as i32 * factor as i32;
        // 65,535 * 32,767 + 2^15 is below 2^31.
        high.wrapping_add((low + 0x8000) >> 16)
    }
}
