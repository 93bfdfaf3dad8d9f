//! The layout that both kinds of encoded gait share, and its checks.
//!
//! Holds the first byte, the header, the limits of a sampled gait and the CRC-32
//! at the end. Does not depend on how a gait is evaluated.

use super::{GaitError, MAX_LIMIT_DEG, MAX_PERIOD_US, MIN_PERIOD_US, Name};
use crate::crc::crc32;

/// Most rows of a sampled gait: the authors' loop of 27 fits.
pub const MAX_ROWS: usize = 27;
/// Bytes of the CRC-32 that ends an encoding, little endian.
pub(super) const CRC_LEN: usize = 4;

/// First byte of an encoding.
#[repr(u8)]
pub(super) enum Kind {
    Polynomial = 0,
    Sampled = 1,
}

/// Checks the name and the period, which both kinds begin with.
pub(super) fn check_header(name: Name, period_us: u32) -> Result<(), GaitError> {
    if !name.is_valid() {
        return Err(GaitError::Name);
    }
    if !(MIN_PERIOD_US..=MAX_PERIOD_US).contains(&period_us) {
        return Err(GaitError::Period);
    }
    Ok(())
}

/// Checks a sampled gait's step (1/512 degree) and limits (degrees from neutral).
pub(super) const fn check_limits(step: u8, min_deg: i8, max_deg: i8) -> Result<(), GaitError> {
    let bound = MAX_LIMIT_DEG as i8;
    if step == 0 {
        return Err(GaitError::Step);
    }
    if min_deg < -bound || max_deg > bound || min_deg >= max_deg {
        return Err(GaitError::JointLimits(0));
    }
    Ok(())
}

/// Ends an encoding of `len` bytes with its CRC-32.
pub(super) fn close(buffer: &mut [u8], len: usize) -> Result<&[u8], GaitError> {
    let (body, rest) = buffer.split_at_mut(len);
    let crc = crc32(body).to_le_bytes();
    rest.get_mut(..CRC_LEN).ok_or(GaitError::Length)?.copy_from_slice(&crc);
    Ok(&buffer[..len + CRC_LEN])
}

/// The CRC-32 at the end of an encoding; 0 of fewer than 4 bytes.
pub(super) fn crc32_of(bytes: &[u8]) -> u32 {
    bytes.last_chunk().copied().map_or(0, u32::from_le_bytes)
}
