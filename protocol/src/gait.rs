//! The gait table, and the one `setpoint` that host and firmware both call.
//!
//! A joint's angle over one stride is a degree-10 Chebyshev series on the
//! normalised phase: `deviation(x) = sum c_k T_k(x)`, `x = 2 phase - 1`. On
//! [-1, 1] no coefficient is larger than 2 max |f|, so 16 bits serve where
//! monomials on [0, 1] would need more than 30. The asked angle is
//! `centre + amplitude * deviation(phase)`: amplitude scales about the joint's
//! own centre, not about neutral. A trajectory that no polynomial holds is sent
//! as rows of samples instead ([`SampledTable`]).
//!
//! # Error against the unquantised series, amplitude 0.5 to 3.0
//! | source | bound, degrees |
//! |---|---|
//! | 11 coefficients, half of 1/512 degree each, times 3.0 | 0.0323 |
//! | Clenshaw: 10 roundings of half of 2^-15 degree, grown by at most 1 + ... + 10, times 3.0 | 0.0026 |
//! | amplitude, half of 2^-13, times a deviation of at most 64 degrees | 0.0040 |
//! | scaled product, half of 2^-14 | 0.0001 |
//! | centre and result, half of 1/256 degree each | 0.0040 |
//! | sum | 0.0430 |
//!
//! The deviation is limited to 64 degrees by [`MAX_DEVIATION_DEG`], which
//! quantisation enforces. `tests/setpoint.rs` walks all 65,536 phases.

mod curve;
mod encoded;
mod layout;
mod sampled;
mod table;
mod units;

pub use curve::{Coefficient, JointCurve, PlainProduct, Product};
pub use encoded::Encoded;
pub use layout::MAX_ROWS;
pub use sampled::{Rows, STEP_UNITS_PER_DEG, SampledTable};
pub use table::GaitTable;
pub use units::{Amplitude, Angle, Name, Speed};

use crate::FRAME_RATE_HZ;
use serde::{Deserialize, Serialize};

/// Degree of the joint polynomials (paper, section 2.3).
pub const DEGREE: usize = 10;
/// Chebyshev coefficients of one joint.
pub const COEFFICIENT_COUNT: usize = DEGREE + 1;
/// Longest encoded gait, CRC included.
pub const MAX_ENCODED_LEN: usize = 264;
/// Coefficients are in 1/512 degree.
pub const COEFFICIENT_UNITS_PER_DEG: i32 = 512;
/// Largest deviation from the centre at amplitude 1.0.
pub const MAX_DEVIATION_DEG: f64 = 63.9;
/// No joint limit may lie farther from neutral than this.
pub const MAX_LIMIT_DEG: i16 = 90;
/// Shortest stride a table may ask for.
pub const MIN_PERIOD_US: u32 = 100_000;
/// Longest stride a table may ask for.
pub const MAX_PERIOD_US: u32 = 60_000_000;

/// Why bytes are not a gait.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum GaitError {
    /// Shorter than a gait, longer than [`MAX_ENCODED_LEN`], or the encoding ends early.
    Length,
    /// The CRC does not match: the bytes were damaged.
    Crc,
    /// The name is empty or not printable ASCII.
    Name,
    /// The period is outside [`MIN_PERIOD_US`] to [`MAX_PERIOD_US`].
    Period,
    /// The joint's limits are reversed, beyond +-90 degrees, or exclude its centre.
    JointLimits(u8),
    /// Neither a polynomial nor a row of samples.
    Kind,
    /// Fewer than 2 or more than [`MAX_ROWS`] rows of samples.
    Rows,
    /// The step of a sample is 0.
    Step,
}

/// Phase advance of one frame at speed 1.0, in 2^-32 of a stride, rounded up,
/// of a valid period; of others some number.
///
/// Up, so that a stride of a whole number of frames lands on the next one's
/// start: rounded down it would land on its own end, on the other side of
/// the jump that a seam may have. The phase is early by at most 2^-32 of a
/// stride per frame played.
#[must_use]
pub fn phase_step(period_us: u32) -> u32 {
    // A frame in microseconds, whole part and fraction.
    const WHOLE: u32 = 1_000_000 / FRAME_RATE_HZ;
    const FRACTION_Q32: u32 = ((((1_000_000 % FRAME_RATE_HZ) as u64) << 32) / FRAME_RATE_HZ as u64) as u32;
    // Long division by hand: a u64 quotient costs an AVR 2.8 KB of flash.
    // The whole part is below any period, so the quotient is a fraction of
    // 32 bits; twice the longest period fits the remainder.
    let (mut remainder, mut digits, mut quotient) = (WHOLE, FRACTION_Q32, 0_u32);
    for _ in 0..u32::BITS {
        remainder = remainder << 1 | digits >> 31;
        digits <<= 1;
        quotient <<= 1;
        if remainder >= period_us {
            remainder -= period_us;
            quotient |= 1;
        }
    }
    // Shorter than a frame's share of the shortest period, so no overflow.
    quotient.wrapping_add(1)
}

/// `phase_step` at another speed, rounded down; exact at speed 1.0.
#[must_use]
pub const fn scaled_phase_step(phase_step: u32, speed_units: u16) -> u32 {
    // A frame is at most 1/6 of a stride, so both products keep to 32 bits.
    let high = (phase_step >> 16) * speed_units as u32;
    let low = (phase_step & 0xFFFF) * speed_units as u32;
    (high << 3).wrapping_add(low >> 13)
}
