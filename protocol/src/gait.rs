//! The gait table, and the one `setpoint` that host and firmware both call.
//!
//! A joint's angle over one stride is a degree-10 Chebyshev series on the
//! normalised phase: `deviation(x) = sum c_k T_k(x)`, `x = 2 phase - 1`. On
//! [-1, 1] no coefficient is larger than 2 max |f|, so 16 bits serve where
//! monomials on [0, 1] would need more than 30. The asked angle is
//! `centre + amplitude * deviation(phase)`: amplitude scales about the joint's
//! own centre, not about neutral.
//!
//! # Error against the unquantised series, amplitude 0.5 to 3.0
//! | source | bound, degrees |
//! |---|---|
//! | 11 coefficients, half of 1/512 degree each, times 3.0 | 0.0323 |
//! | Clenshaw: 10 roundings of half of 2^-15 degree, grown by at most 1 + ... + 10, times 3.0 | 0.0026 |
//! | amplitude, half of 2^-13, times a deviation of at most 64 degrees | 0.0040 |
//! | scaled product, half of 2^-15 | 0.0001 |
//! | centre and result, half of 1/256 degree each | 0.0040 |
//! | sum | 0.0430 |
//!
//! The deviation is limited to 64 degrees by [`MAX_DEVIATION_DEG`], which
//! quantisation enforces. `tests/setpoint.rs` walks all 65,536 phases.
//!
//! Longer than a file should be, because the units' integers are private to the
//! arithmetic above, and the bytes to the table that they belong to.

use crate::FRAME_RATE_HZ;
use crate::crc::crc32;
use crate::joint::{JOINT_COUNT, Joint};
use serde::{Deserialize, Serialize};

/// Degree of the joint polynomials (paper, section 2.3).
pub const DEGREE: usize = 10;
/// Chebyshev coefficients of one joint.
pub const COEFFICIENT_COUNT: usize = DEGREE + 1;
/// Longest encoded table, CRC included.
pub const MAX_ENCODED_LEN: usize = 256;
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

/// An angle from the joint's calibrated neutral, in 1/256 degree.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default, Serialize, Deserialize)]
pub struct Angle(#[serde(with = "postcard::fixint::le")] i16);

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
/// 1.0 moves a joint by [`GaitTable::unit_deg`] degrees per unit of action.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Amplitude(u16);

impl Amplitude {
    /// Units of this type in 1.0.
    pub const UNITS_PER_ONE: u16 = 8192;
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
pub struct Name([u8; Name::CAPACITY]);

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

    /// The name without its padding; empty if the bytes are no name.
    #[must_use]
    pub fn as_str(&self) -> &str {
        let len = self.0.iter().position(|&b| b == 0).unwrap_or(Self::CAPACITY);
        core::str::from_utf8(&self.0[..len]).unwrap_or("")
    }

    fn is_valid(&self) -> bool {
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
            .all(|phase| curve.deviation_q15(phase).unsigned_abs() <= (MAX_DEVIATION_DEG * 32768.0) as u32);
        within.then_some(curve)
    }

    /// Deviation from the centre at amplitude 1.0, in 2^-15 degree.
    ///
    /// Clenshaw's recurrence. The intermediate values stay below
    /// 64 degrees * (1 + ... + 11) = 4,224 degrees, 28 bits: nothing overflows.
    fn deviation_q15(&self, phase: u16) -> i32 {
        // Phase 0..65536 is x = -1..1 in Q15, exactly.
        let x_q15 = (phase ^ 0x8000) as i16;
        let mut b1 = 0_i32;
        let mut b2 = 0_i32;
        for coefficient in self.coefficients[1..].iter().rev() {
            let next = (scale::<14>(b1, x_q15).wrapping_sub(b2)).wrapping_add((coefficient.0 as i32) << 6);
            b2 = b1;
            b1 = next;
        }
        scale::<15>(b1, x_q15).wrapping_sub(b2).wrapping_add((self.coefficients[0].0 as i32) << 6)
    }

    /// Asked angle at `phase` (1/65536 of a stride), before any limit.
    #[must_use]
    pub fn setpoint(&self, phase: u16, amplitude: Amplitude) -> Angle {
        // 3 * 8192 fits an i16, so the same product serves.
        let deviation = scale::<13>(self.deviation_q15(phase), amplitude.0 as i16);
        let sum_q15 = ((self.centre.0 as i32) << 7).wrapping_add(deviation);
        let units = sum_q15.wrapping_add(64) >> 7;
        Angle(units.clamp(i16::MIN as i32, i16::MAX as i32) as i16)
    }

    /// Asked angle held within the joint's limits.
    #[must_use]
    pub fn limited(&self, asked: Angle) -> Angle {
        // Not `clamp`: it panics where min > max, which `validate` refuses.
        asked.min(self.max).max(self.min)
    }

    /// Whether limits are ordered, within +-90 degrees, and hold the centre.
    const fn is_valid(&self) -> bool {
        let bound = MAX_LIMIT_DEG * Angle::UNITS_PER_DEG;
        self.min.0 >= -bound
            && self.max.0 <= bound
            && self.min.0 < self.max.0
            && self.centre.0 >= self.min.0
            && self.centre.0 <= self.max.0
    }
}

/// `value * factor / 2^SHIFT`, rounded to nearest, without a 64-bit product.
///
/// AVR multiplies 8 by 8 bits; two 16 x 16 products cost a third of an `i64`.
#[inline(always)]
fn scale<const SHIFT: u32>(value: i32, factor: i16) -> i32 {
    let high = (value >> 16) as i16 as i32 * factor as i32;
    let low = (value as u16) as i32 * factor as i32;
    // high * 2^16 / 2^SHIFT is exact because SHIFT <= 16.
    (high << (16 - SHIFT)).wrapping_add(low.wrapping_add(1 << (SHIFT - 1)) >> SHIFT)
}

/// Rounds half away from zero and saturates; `core` has no `round`.
fn round_to_i16(value: f64) -> i16 {
    // `as` saturates and sends NaN to 0.
    (if value < 0.0 { value - 0.5 } else { value + 0.5 }) as i16
}

/// A gait: eight curves over one stride.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct GaitTable {
    /// What the robot reports as its gait.
    pub name: Name,
    /// Duration of one stride at normal speed.
    pub period_us: u32,
    /// Degrees a joint moves per unit of action at amplitude 1.0, in 1/256.
    pub unit: Angle,
    /// Curves in [`Joint::ALL`] order.
    pub joints: [JointCurve; JOINT_COUNT],
}

/// Why bytes are no gait table.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum GaitError {
    /// Shorter than a table, longer than [`MAX_ENCODED_LEN`], or the encoding ends early.
    Length,
    /// The CRC does not match: the bytes were damaged.
    Crc,
    /// The name is empty or not printable ASCII.
    Name,
    /// The period is outside [`MIN_PERIOD_US`] to [`MAX_PERIOD_US`].
    Period,
    /// The joint's limits are reversed, beyond +-90 degrees, or exclude its centre.
    JointLimits(u8),
}

/// Length of one encoded joint: every field of it has two bytes, always.
const JOINT_LEN: usize = 2 * (3 + COEFFICIENT_COUNT);

/// What stands before the joints in an encoded table, in the same order.
struct Header {
    name: Name,
    period_us: u32,
    unit: Angle,
}

impl Header {
    fn validate(&self) -> Result<(), GaitError> {
        if !self.name.is_valid() {
            return Err(GaitError::Name);
        }
        if self.period_us < MIN_PERIOD_US || self.period_us > MAX_PERIOD_US {
            return Err(GaitError::Period);
        }
        Ok(())
    }
}

/// The postcard bytes of an encoded table whose length and CRC are right.
fn checked_body(bytes: &[u8]) -> Result<&[u8], GaitError> {
    if bytes.len() > MAX_ENCODED_LEN {
        return Err(GaitError::Length);
    }
    let (body, crc) = bytes.split_last_chunk::<4>().ok_or(GaitError::Length)?;
    if crc32(body) != u32::from_le_bytes(*crc) {
        return Err(GaitError::Crc);
    }
    Ok(body)
}

/// Splits a body into its header and joints, for postcard concatenates fields
/// and array items; an AVR pays 2 KB less for this than for the derived code.
///
/// # Errors
/// [`GaitError::Length`] unless the body is exactly one table.
fn split_body(body: &[u8]) -> Result<(Header, &[[u8; JOINT_LEN]; JOINT_COUNT]), GaitError> {
    let (&name, rest) = body.split_first_chunk().ok_or(GaitError::Length)?;
    let (period_us, rest) = postcard::take_from_bytes::<u32>(rest).map_err(|_| GaitError::Length)?;
    let (&unit, rest) = rest.split_first_chunk().ok_or(GaitError::Length)?;
    let (joints, rest) = rest.as_chunks();
    let joints = joints.try_into().map_err(|_| GaitError::Length)?;
    if !rest.is_empty() {
        return Err(GaitError::Length);
    }
    Ok((Header { name: Name(name), period_us, unit: Angle(i16::from_le_bytes(unit)) }, joints))
}

impl JointCurve {
    fn read(&mut self, bytes: &[u8; JOINT_LEN]) {
        let mut words = bytes.as_chunks().0.iter().map(|&word| i16::from_le_bytes(word));
        for angle in [&mut self.centre, &mut self.min, &mut self.max] {
            angle.0 = words.next().unwrap_or(0);
        }
        for coefficient in &mut self.coefficients {
            coefficient.0 = words.next().unwrap_or(0);
        }
    }
}

impl GaitTable {
    /// The table of zeros, the same as the default, for constants.
    pub const EMPTY: Self = Self {
        name: Name([0; Name::CAPACITY]),
        period_us: 0,
        unit: Angle::NEUTRAL,
        joints: [JointCurve {
            centre: Angle::NEUTRAL,
            min: Angle::NEUTRAL,
            max: Angle::NEUTRAL,
            coefficients: [Coefficient(0); COEFFICIENT_COUNT],
        }; JOINT_COUNT],
    };

    /// The CRC-32 at the end of an encoded table: its identity.
    #[must_use]
    pub fn crc32_of(bytes: &[u8]) -> u32 {
        bytes.last_chunk().copied().map_or(0, u32::from_le_bytes)
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
        Header { name: self.name, period_us: self.period_us, unit: self.unit }.validate()?;
        match self.joints.iter().position(|joint| !joint.is_valid()) {
            Some(index) => Err(GaitError::JointLimits(index as u8)),
            None => Ok(()),
        }
    }

    /// Writes postcard bytes followed by their CRC-32, little endian.
    ///
    /// # Errors
    /// [`GaitError::Length`] if `buffer` is too short; else as [`Self::validate`].
    pub fn encode<'b>(&self, buffer: &'b mut [u8]) -> Result<&'b [u8], GaitError> {
        self.validate()?;
        let body_len = postcard::to_slice(self, buffer).map_err(|_| GaitError::Length)?.len();
        let (body, rest) = buffer.split_at_mut(body_len);
        let crc = crc32(body).to_le_bytes();
        rest.get_mut(..crc.len()).ok_or(GaitError::Length)?.copy_from_slice(&crc);
        Ok(&buffer[..body_len + crc.len()])
    }

    /// Reads what [`Self::encode`] wrote, and trusts nothing.
    ///
    /// # Errors
    /// What is wrong with the bytes.
    pub fn decode(bytes: &[u8]) -> Result<Self, GaitError> {
        let mut table = Self::default();
        table.decode_into(bytes)?;
        Ok(table)
    }

    /// [`Self::decode`] in place: replaces the table, or leaves it as it was.
    ///
    /// Holds one joint at a time, where a whole table on its way through the
    /// stack would take a quarter of the robot's memory.
    ///
    /// # Errors
    /// What is wrong with the bytes.
    pub fn decode_into(&mut self, bytes: &[u8]) -> Result<(), GaitError> {
        let (header, joints) = split_body(checked_body(bytes)?)?;
        // Everything is judged before the first field is replaced.
        header.validate()?;
        let mut judged = JointCurve::default();
        for (index, bytes) in (0..).zip(joints) {
            judged.read(bytes);
            if !judged.is_valid() {
                return Err(GaitError::JointLimits(index));
            }
        }
        for (joint, bytes) in self.joints.iter_mut().zip(joints) {
            joint.read(bytes);
        }
        Header { name: self.name, period_us: self.period_us, unit: self.unit } = header;
        Ok(())
    }

    /// The bytes that [`Self::encode`] puts before the CRC, one after the other:
    /// for a robot without room for them.
    pub fn for_each_byte(&self, mut take: impl FnMut(u8)) {
        self.name.0.into_iter().for_each(&mut take);
        let mut period = self.period_us;
        while period >= 0x80 {
            take(period as u8 | 0x80);
            period >>= 7;
        }
        take(period as u8);
        let mut take = |word: i16| word.to_le_bytes().into_iter().for_each(&mut take);
        take(self.unit.0);
        for joint in &self.joints {
            take(joint.centre.0);
            take(joint.min.0);
            take(joint.max.0);
            joint.coefficients.iter().for_each(|coefficient| take(coefficient.0));
        }
    }

    /// Asked angle of `joint` at `phase` (1/65536 of a stride), before limits.
    #[must_use]
    pub fn setpoint(&self, joint: Joint, phase: u16, amplitude: Amplitude) -> Angle {
        self.joints[joint.index()].setpoint(phase, amplitude)
    }

    /// Phase advance of one frame, in 2^-32 of a stride, rounded up.
    ///
    /// Up, so that a stride of a whole number of frames lands on the next one's
    /// start: rounded down it would land on its own end, on the other side of
    /// the jump that a seam may have. The phase is early by at most 2^-32 of a
    /// stride per frame played.
    #[must_use]
    pub fn phase_step(&self) -> u32 {
        // A frame in microseconds, whole part and fraction.
        const WHOLE: u32 = 1_000_000 / FRAME_RATE_HZ;
        const FRACTION_Q32: u32 =
            ((((1_000_000 % FRAME_RATE_HZ) as u64) << 32) / FRAME_RATE_HZ as u64) as u32;
        // Long division by hand: a u64 quotient costs an AVR 2.8 KB of flash.
        // The whole part is below any period, so the quotient is a fraction of
        // 32 bits; twice the longest period fits the remainder.
        let period_us = self.period_us.clamp(MIN_PERIOD_US, MAX_PERIOD_US);
        let (mut remainder, mut digits, mut quotient) = (WHOLE, FRACTION_Q32, 0);
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
        quotient + 1
    }
}
