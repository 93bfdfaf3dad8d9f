//! The two checksums of the project, bitwise: an AVR has no flash for tables.

/// CRC-16/IBM-SDLC (X.25) of `bytes`: guards one frame on the wire.
///
/// # Source
/// ITU-T V.42, 8.1.1.6.1; check value of "123456789" is 0x906E.
#[must_use]
pub fn crc16(bytes: &[u8]) -> u16 {
    let mut crc = Crc16::new();
    crc.update(bytes);
    crc.value()
}

/// [`crc16`] of bytes that are not in one piece.
///
/// In two bytes: an AVR shifts those in fewer steps than a word.
#[derive(Debug, Clone, Copy)]
pub struct Crc16 {
    low: u8,
    high: u8,
}

impl Default for Crc16 {
    fn default() -> Self {
        Self::new()
    }
}

impl Crc16 {
    /// The checksum of nothing.
    #[must_use]
    pub const fn new() -> Self {
        Self { low: u8::MAX, high: u8::MAX }
    }

    /// Adds `bytes`.
    pub fn update(&mut self, bytes: &[u8]) {
        let mut crc = *self;
        for &byte in bytes {
            crc.add(byte);
        }
        *self = crc;
    }

    /// Adds one byte, in the caller's own code.
    #[inline(always)]
    pub(crate) const fn add(&mut self, byte: u8) {
        // Byte-wise form of the reflected 0x8408 polynomial.
        let mut mixed = self.low ^ byte;
        mixed ^= mixed << 4;
        self.low = self.high ^ (mixed >> 4) ^ (mixed << 3);
        self.high = mixed ^ (mixed >> 5);
    }

    /// The checksum of what was added.
    #[must_use]
    pub const fn value(self) -> u16 {
        !u16::from_le_bytes([self.low, self.high])
    }
}

/// CRC-32 (IEEE 802.3) of `bytes`: identifies a gait table.
///
/// # Source
/// IEEE 802.3, 3.2.9; check value of "123456789" is 0xCBF4_3926.
#[must_use]
pub fn crc32(bytes: &[u8]) -> u32 {
    let mut crc = u32::MAX;
    for &byte in bytes {
        crc ^= byte as u32;
        for _ in 0..8 {
            crc = if crc & 1 == 1 { crc >> 1 ^ 0xEDB8_8320 } else { crc >> 1 };
        }
    }
    !crc
}
