//! Reads the firmware's ELF file into a flash image.
//!
//! Holds the part of ELF that an ATmega328P needs: load segments below the data
//! space. Anything but an AVR executable is an error that says what to do; simavr's
//! own loader ends the process on some of them. Does not depend on simavr.

use std::path::{Path, PathBuf};
use thiserror::Error;

/// Flash of an ATmega328P in bytes.
pub const FLASH_LEN: usize = 32_768;
/// Where `make firmware` leaves the image, relative to the workspace.
pub const DEFAULT_ELF: &str = "firmware/target/avr-none/release/nano.elf";

/// `EM_AVR` of the ELF specification.
const MACHINE_AVR: u16 = 83;
/// AVR's linker puts data space from here on; what lies below is flash.
const DATA_SPACE: u32 = 0x0080_0000;

/// Why a file is not a firmware image.
#[derive(Debug, Error)]
pub enum ImageError {
    /// The file is not there.
    #[error("there is no firmware image at {path}: build it with `make firmware`, or name one with --elf")]
    Missing {
        /// Where it was looked for.
        path: PathBuf,
    },
    /// The file is there and cannot be read.
    #[error("cannot read {path}")]
    Read { path: PathBuf, source: std::io::Error },
    /// Another kind of file.
    #[error("{path} is not an AVR executable ({what}): build one with `make firmware`")]
    NotAvr {
        path: PathBuf,
        /// What gave it away.
        what: &'static str,
    },
    /// The program does not fit.
    #[error("{path} asks for flash up to {end:#x}, but an ATmega328P ends at {FLASH_LEN:#x}")]
    TooLarge {
        path: PathBuf,
        /// First address behind the segment.
        end: u64,
    },
}

/// The contents of an ATmega328P's flash.
#[derive(Debug, Clone)]
pub struct FirmwareImage {
    flash: Vec<u8>,
    reset_address: u32,
}

impl FirmwareImage {
    /// Where the image of this checkout is.
    #[must_use]
    pub fn default_path() -> PathBuf {
        Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(DEFAULT_ELF)
    }

    /// Reads an ELF executable.
    ///
    /// # Errors
    /// [`ImageError`] if it is missing, unreadable, of another machine, or too large.
    pub fn load(path: &Path) -> Result<Self, ImageError> {
        let bytes = std::fs::read(path).map_err(|source| match source.kind() {
            std::io::ErrorKind::NotFound => ImageError::Missing { path: path.to_owned() },
            _ => ImageError::Read { path: path.to_owned(), source },
        })?;
        Self::parse(&bytes, path)
    }

    /// A program of these instruction words, for tests.
    #[cfg(test)]
    pub(crate) fn of_words(words: &[u16]) -> Self {
        Self { flash: words.iter().flat_map(|word| word.to_le_bytes()).collect(), reset_address: 0 }
    }

    /// Flash from address 0 to the end of the program.
    #[must_use]
    pub fn flash(&self) -> &[u8] {
        &self.flash
    }

    /// Where the chip starts after a reset, in bytes.
    #[must_use]
    pub fn reset_address(&self) -> u32 {
        self.reset_address
    }

    /// The same program with a bootloader behind it, which a chip with BOOTRST
    /// programmed starts first.
    ///
    /// # Errors
    /// [`ImageError::TooLarge`] if they overlap, or the flash ends before it.
    pub fn with_bootloader(&self, bytes: &[u8], address: u32, path: &Path) -> Result<Self, ImageError> {
        let end = u64::from(address) + bytes.len() as u64;
        if end > FLASH_LEN as u64 || self.flash.len() > address as usize {
            return Err(ImageError::TooLarge { path: path.to_owned(), end });
        }
        let mut flash = self.flash.clone();
        flash.resize(FLASH_LEN, 0xFF);
        flash[address as usize..end as usize].copy_from_slice(bytes);
        Ok(Self { flash, reset_address: address })
    }

    fn parse(bytes: &[u8], path: &Path) -> Result<Self, ImageError> {
        let not_avr = |what| ImageError::NotAvr { path: path.to_owned(), what };
        // Offsets from the ELF specification, 32 bits, little endian.
        if bytes.get(..6) != Some(b"\x7fELF\x01\x01") {
            return Err(not_avr("no 32-bit little-endian ELF header"));
        }
        if u16_at(bytes, 18) != Some(MACHINE_AVR) {
            return Err(not_avr("built for another machine"));
        }
        let header = || Some((u32_at(bytes, 28)? as usize, u16_at(bytes, 42)?, u16_at(bytes, 44)?));
        let (table_at, entry_len, entry_count) =
            header().ok_or_else(|| not_avr("the header is cut short"))?;

        let mut flash = Vec::new();
        for index in 0..usize::from(entry_count) {
            let at = table_at.saturating_add(index * usize::from(entry_len));
            let field = |i: usize| u32_at(bytes, at.saturating_add(4 * i));
            let (Some(kind), Some(offset), Some(address), Some(len)) =
                (field(0), field(1), field(3), field(4))
            else {
                return Err(not_avr("the segment table is cut short"));
            };
            const LOAD: u32 = 1;
            if kind != LOAD || len == 0 || address >= DATA_SPACE {
                continue;
            }
            let end = u64::from(address) + u64::from(len);
            if end > FLASH_LEN as u64 {
                return Err(ImageError::TooLarge { path: path.to_owned(), end });
            }
            let source = (offset as usize)
                .checked_add(len as usize)
                .and_then(|source_end| bytes.get(offset as usize..source_end))
                .ok_or_else(|| not_avr("a segment is cut short"))?;
            if flash.len() < end as usize {
                flash.resize(end as usize, 0xFF);
            }
            flash[address as usize..end as usize].copy_from_slice(source);
        }
        if flash.is_empty() {
            return Err(not_avr("it holds no program"));
        }
        Ok(Self { flash, reset_address: 0 })
    }
}

fn u16_at(bytes: &[u8], at: usize) -> Option<u16> {
    Some(u16::from_le_bytes(*bytes.get(at..)?.first_chunk()?))
}

fn u32_at(bytes: &[u8], at: usize) -> Option<u32> {
    Some(u32::from_le_bytes(*bytes.get(at..)?.first_chunk()?))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One segment of `program` at `address`.
    fn elf(machine: u16, address: u32, program: &[u8]) -> Vec<u8> {
        let mut bytes = vec![0; 84];
        bytes[..6].copy_from_slice(b"\x7fELF\x01\x01");
        bytes[18..20].copy_from_slice(&machine.to_le_bytes());
        bytes[28..32].copy_from_slice(&52_u32.to_le_bytes());
        bytes[42..44].copy_from_slice(&32_u16.to_le_bytes());
        bytes[44..46].copy_from_slice(&1_u16.to_le_bytes());
        for (i, value) in [1, 84, address, address, program.len() as u32].into_iter().enumerate() {
            bytes[52 + 4 * i..56 + 4 * i].copy_from_slice(&value.to_le_bytes());
        }
        bytes.extend_from_slice(program);
        bytes
    }

    #[test]
    fn a_program_lands_at_its_address() {
        let image = FirmwareImage::parse(&elf(MACHINE_AVR, 2, &[7, 8]), Path::new("a.elf")).unwrap();

        assert_eq!(image.flash(), [0xFF, 0xFF, 7, 8]);
    }

    #[test]
    fn every_truncation_is_refused_and_none_panics() {
        let whole = elf(MACHINE_AVR, 0, &[1, 2, 3, 4]);

        for len in 0..whole.len() {
            assert!(FirmwareImage::parse(&whole[..len], Path::new("a.elf")).is_err(), "{len} bytes");
        }
    }

    #[test]
    fn other_machines_and_programs_beyond_the_flash_are_refused() {
        let x86 = FirmwareImage::parse(&elf(62, 0, &[1]), Path::new("a.elf"));
        let large = FirmwareImage::parse(&elf(MACHINE_AVR, 32_767, &[1, 2]), Path::new("a.elf"));

        assert!(matches!(x86, Err(ImageError::NotAvr { .. })));
        assert!(matches!(large, Err(ImageError::TooLarge { end: 32_769, .. })));
    }

    #[test]
    fn a_missing_image_names_the_next_move() {
        let error = FirmwareImage::load(Path::new("no/such/nano.elf")).unwrap_err();

        assert!(error.to_string().contains("make firmware"), "{error}");
    }
}
