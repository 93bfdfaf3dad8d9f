//! The Nano's bootloaders, from Debian's package arduino-core-avr.
//!
//! Holds their addresses in flash, and the reader of Intel's hex format. None of
//! them is part of this project: where the package is not installed, they are
//! left out and that is said. A stand-in of our own does what Optiboot does
//! after a watchdog reset, for Debian's own build of it fits no Nano.

use super::rig::RigError;
use crate::firmware_image::{FLASH_LEN, FirmwareImage};
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Where the package puts them.
const FOLDER: &str = "/usr/share/arduino/hardware/arduino/avr/bootloaders";
/// Name, file, and the start that the fuses BOOTSZ give it on a Nano.
const KNOWN: [(&str, &str, u32); 2] = [
    ("old (ATmegaBOOT)", "atmega/ATmegaBOOT_168_atmega328.hex", 0x7800),
    ("new (Optiboot)", "optiboot/optiboot_atmega328.hex", 0x7E00),
];

/// Why there is no bootloader.
#[derive(Debug, Error)]
pub enum BootloaderError {
    /// The package is not there.
    #[error("no bootloader at {path}: install Debian's package arduino-core-avr")]
    Missing {
        /// Where it was looked for.
        path: PathBuf,
    },
    /// A line of the file is no record.
    #[error("{path}, line {line}: no record of Intel's hex format")]
    Record { path: PathBuf, line: usize },
    /// No chip can hold it.
    #[error("{path} ends at {end:#x}, beyond the chip's flash: no Nano can run this build of it")]
    TooLong {
        path: PathBuf,
        /// First address behind it.
        end: usize,
    },
}

#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Bootloader {
    pub name: &'static str,
    path: PathBuf,
    /// Where the chip starts after a reset.
    start: u32,
    bytes: Vec<u8>,
}

impl Bootloader {
    /// A chip with this bootloader and that program.
    ///
    /// # Errors
    /// [`RigError::Image`] if they overlap.
    pub fn with(&self, image: &FirmwareImage) -> Result<FirmwareImage, RigError> {
        Ok(image.with_bootloader(&self.bytes, self.start, &self.path)?)
    }
}

/// What Optiboot does after a watchdog reset, in a few words of our own: takes
/// the reset's cause away, turns the watchdog off, starts the program at once.
#[must_use]
pub fn stand_in() -> Bootloader {
    // in r24,MCUSR; eor r1,r1; out MCUSR,r1; ldi r24,WDCE|WDE; sts WDTCSR,r24;
    // sts WDTCSR,r1; jmp 0.
    const WORDS: [u16; 10] = [0xB784, 0x2411, 0xBE14, 0xE188, 0x9380, 0x0060, 0x9210, 0x0060, 0x940C, 0x0000];
    Bootloader {
        name: "stand-in for Optiboot",
        path: PathBuf::from("(built in)"),
        start: 0x7E00,
        bytes: WORDS.iter().flat_map(|word| word.to_le_bytes()).collect(),
    }
}

/// Both of the Nano's bootloaders, or why not.
#[must_use]
pub fn installed() -> Vec<Result<Bootloader, BootloaderError>> {
    in_folder(Path::new(FOLDER))
}

fn in_folder(folder: &Path) -> Vec<Result<Bootloader, BootloaderError>> {
    let load = |(name, file, start)| {
        let path = folder.join(file);
        let text =
            std::fs::read_to_string(&path).map_err(|_| BootloaderError::Missing { path: path.clone() })?;
        let bytes =
            parse_hex(&text, start).map_err(|line| BootloaderError::Record { path: path.clone(), line })?;
        let end = start as usize + bytes.len();
        if end > FLASH_LEN {
            return Err(BootloaderError::TooLong { path, end });
        }
        Ok(Bootloader { name, path, start, bytes })
    };
    KNOWN.into_iter().map(load).collect()
}

/// The bytes from `start` on; an error is the number of the bad line.
fn parse_hex(text: &str, start: u32) -> Result<Vec<u8>, usize> {
    let mut bytes = Vec::new();
    for (index, line) in text.lines().map(str::trim).enumerate().filter(|(_, line)| !line.is_empty()) {
        let bad = || index + 1;
        let record = line.strip_prefix(':').and_then(hex_bytes).ok_or_else(bad)?;
        let sum = record.iter().fold(0_u8, |sum, byte| sum.wrapping_add(*byte));
        let [len, high, low, kind, data @ .., _] = record.as_slice() else { return Err(bad()) };
        if sum != 0 || usize::from(*len) != data.len() {
            return Err(bad());
        }
        match kind {
            0 => {
                let address = u32::from(u16::from_be_bytes([*high, *low]));
                let at = address.checked_sub(start).ok_or_else(bad)? as usize;
                if bytes.len() < at + data.len() {
                    bytes.resize(at + data.len(), 0xFF);
                }
                bytes[at..at + data.len()].copy_from_slice(data);
            }
            1 => break,
            // Start addresses; segments do not occur below 64 KB.
            _ => {}
        }
    }
    Ok(bytes)
}

fn hex_bytes(digits: &str) -> Option<Vec<u8>> {
    let pair = |pair: &[u8]| u8::from_str_radix(std::str::from_utf8(pair).ok()?, 16).ok();
    digits.len().is_multiple_of(2).then(|| digits.as_bytes().chunks(2).map(pair).collect())?
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn records_land_at_their_addresses() {
        let text = ":02780200AABB1F\n:0178000007 80\n";
        let good = ":02780200AABB1F\n:017800000780\n:0400000300007800 81\n".replace(' ', "");

        assert_eq!(parse_hex(text, 0x7800), Err(2));
        assert_eq!(parse_hex(&good, 0x7800), Ok(vec![7, 0xFF, 0xAA, 0xBB]));
    }

    #[test]
    fn without_the_package_each_is_named_with_the_next_move() {
        let missing = in_folder(Path::new("/nowhere"));

        assert_eq!(missing.len(), KNOWN.len());
        for (error, (_, file, _)) in missing.into_iter().map(Result::unwrap_err).zip(KNOWN) {
            let text = error.to_string();
            assert!(text.contains(file) && text.contains("arduino-core-avr"), "{text}");
        }
    }

    #[test]
    fn a_wrong_sum_a_short_record_and_an_address_below_the_start_are_refused() {
        assert_eq!(parse_hex(":02780200AABB00", 0x7800), Err(1));
        assert_eq!(parse_hex(":03780200AABB1E", 0x7800), Err(1));
        assert_eq!(parse_hex(":02780200AABB1F", 0x7E00), Err(1));
    }
}
