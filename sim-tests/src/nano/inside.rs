//! Access to the chip's inside that a user of a Nano does not have.
//!
//! Holds reading and changing of memories and traces, for measurements and faults.
//! Does not depend on the program that runs.

use super::{EEPROM_LEN, Nano, SRAM_LEN, SRAM_START};
use crate::firmware_image::FLASH_LEN;
use crate::nano::trace::Trace;
use simavr_ffi as ffi;
use std::ffi::c_void;

impl Nano {
    #[must_use]
    pub fn eeprom(&self) -> [u8; EEPROM_LEN] {
        let mut bytes = [0; EEPROM_LEN];
        self.eeprom_ioctl(*b"eegp", &mut bytes);
        bytes
    }

    /// Replaces the EEPROM's contents.
    pub fn set_eeprom(&mut self, contents: &[u8; EEPROM_LEN]) {
        let mut bytes = *contents;
        self.eeprom_ioctl(*b"eesp", &mut bytes);
    }

    /// The SRAM's contents, for measuring the stack.
    #[must_use]
    pub fn sram(&self) -> &[u8] {
        // SAFETY: `data` holds `ramend + 1` = 0x900 bytes as long as `avr`
        // lives; nothing writes to it while `self` is borrowed.
        unsafe { std::slice::from_raw_parts((*self.avr.as_ptr()).data.add(SRAM_START), SRAM_LEN) }
    }

    /// A chip holds the data line low, in the middle of sending a byte, until
    /// the clock line has been pulled low by hand so many times.
    pub fn hold_data_line(&mut self, clocks: u8) {
        self.wires().bus.borrow_mut().hold_data(clocks);
    }

    /// Notes every instruction from now on; a previous trace is dropped.
    pub fn start_trace(&mut self, trace: Trace) {
        self.trace = Some(Box::new(trace));
    }

    /// Ends the trace, if there is one.
    pub fn take_trace(&mut self) -> Option<Trace> {
        self.trace.take().map(|trace| *trace)
    }

    /// Replaces the instruction word at this address, in bytes, and returns the
    /// one before; `None`, and nothing happens, beyond the flash.
    pub fn patch(&mut self, address: u32, word: u16) -> Option<u16> {
        if address as usize + 2 > FLASH_LEN {
            return None;
        }
        // SAFETY: simavr's flash has FLASH_LEN bytes, and the program stands.
        unsafe {
            let place = (*self.avr.as_ptr()).flash.add(address as usize).cast::<[u8; 2]>();
            Some(u16::from_le_bytes(place.replace(word.to_le_bytes())))
        }
    }

    fn eeprom_ioctl(&self, name: [u8; 4], bytes: &mut [u8; EEPROM_LEN]) {
        let mut request =
            ffi::avr_eeprom_desc_t { ee: bytes.as_mut_ptr(), offset: 0, size: EEPROM_LEN as u32 };
        // SAFETY: the request describes `bytes`, which outlives the call.
        let result = unsafe {
            ffi::avr_ioctl(self.avr.as_ptr(), u32::from_be_bytes(name), (&raw mut request).cast::<c_void>())
        };
        debug_assert_eq!(result, 0, "the chip has an EEPROM of this size");
    }
}
