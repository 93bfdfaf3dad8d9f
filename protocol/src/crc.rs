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
#[derive(Debug, Clone, Copy)]
pub struct Crc16(u16);

impl Default for Crc16 {
    fn default() -> Self {
        Self::new()
    }
}

impl Crc16 {
    /// The checksum of nothing.
    #[must_use]
    pub const fn new() -> Self {
        Self(u16::MAX)
    }

    /// Adds `bytes`.
    pub fn update(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            // Nibble-free byte-wise form of the reflected 0x8408 polynomial.
            let mut mixed = (self.0 as u8) ^ byte;
            mixed ^= mixed << 4;
            let wide = mixed as u16;
            self.0 = (wide << 8 | self.0 >> 8) ^ (wide >> 4) ^ (wide << 3);
        }
    }

    /// The checksum of what was added.
    #[must_use]
    pub const fn value(self) -> u16 {
        !self.0
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
