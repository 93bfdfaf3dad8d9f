//! The Nano: the real firmware image on an emulated ATmega328P.
//!
//! Holds simavr, the wires between it and the chips, and the serial line with
//! its timing. One thread and no wall clock: the same bytes at the same cycles
//! give the same run, bit by bit. A program that crashed or fell asleep for ever is
//! an error. Does not depend on the body, nor on what the bytes mean. Longer than
//! most files: the board's state and its life from power-on to the end.
//!
//! Where simavr is kinder than the chip, this module is not: a serial byte
//! takes 10 bits instead of 11, the receiver holds 3 bytes instead of 64, a
//! START and an address take their time on the bus, an interrupt is entered in 4
//! cycles instead of 0, and a reset is followed by the start-up time that a
//! Nano's fuses ask for. What stays kinder: a STOP takes no time, and the
//! watchdog's oscillator, which times that start-up too, is exact.

mod hooks;
mod inside;
mod pins;
mod run;
#[cfg(test)]
mod tests;
pub mod trace;
mod wires;

use crate::devices::Bus;
use crate::firmware_image::{FLASH_LEN, FirmwareImage};
use simavr_ffi as ffi;
use std::cell::{Ref, RefMut};
use std::collections::VecDeque;
use std::ptr::NonNull;
use thiserror::Error;
use trace::Trace;
pub use wires::OutputEnable;
use wires::Wires;

/// Cycles a second of the Nano's crystal.
pub const CLOCK_HZ: u64 = 16_000_000;
/// From the end of any reset, a watchdog's too, to the first instruction: 65 ms,
/// then 16 K cycles and 14 of the crystal, with the fuses of every Nano (low fuse
/// 0xFF: SUT 0b11, CKSEL 0b1111; data sheet 9.3 and 11.5).
pub const START_UP_CYCLES: u64 = CLOCK_HZ * 65 / 1000 + 16_384 + 14;
/// From an interrupt to its handler's vector (data sheet 7.7.1); simavr takes none.
pub const ENTRY_CYCLES: u64 = 4;
/// Two bytes of the line, the time that the receiver gives a byte to be read.
pub const RECEIVER_PATIENCE_US: f64 = 2.0 * 10.0 / HOST_BAUD as f64 * 1e6;
/// Bytes of EEPROM in an ATmega328P.
pub const EEPROM_LEN: usize = 1024;

/// Speed of the host's end of the serial line.
const HOST_BAUD: u64 = 115_200;
/// A byte of 10 bits from the host lasts 12,500 / 9 cycles; times are in ninths.
const HOST_BYTE_NINTHS: u64 = CLOCK_HZ * 10 * NINTHS / HOST_BAUD;
const NINTHS: u64 = 9;
/// Two bytes in the receiver's buffer and one in its shift register.
const RECEIVER_DEPTH: u16 = 3;
/// Ends differ by more than this: the receiver samples the wrong bits.
const MAX_BAUD_ERROR: f64 = 0.045;

/// `MCUSR` and its bits, in data space.
const MCUSR: usize = 0x54;
const MCUSR_POWER_ON: u8 = 0x01;
const MCUSR_EXTERNAL: u8 = 0x02;
const MCUSR_BROWN_OUT: u8 = 0x04;
/// First byte of SRAM behind the registers.
const SRAM_START: usize = 0x100;
const SRAM_LEN: usize = 2048;

/// Why the Nano stopped.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum NanoError {
    /// An invalid instruction, or a jump out of the program.
    #[error("the firmware crashed at program address {pc:#06x}, cycle {cycle}")]
    Crashed {
        /// Where, in bytes.
        pc: u32,
        cycle: u64,
    },
    /// Asleep with interrupts disabled: nothing can wake it.
    #[error("the firmware fell asleep with interrupts off at program address {pc:#06x}, cycle {cycle}")]
    AsleepForEver {
        /// Where, in bytes.
        pc: u32,
        cycle: u64,
    },
    /// simavr was built without this chip.
    #[error(
        "simavr was built without the ATmega328P: rebuild simavr-ffi with the package avr-libc installed"
    )]
    UnknownChip,
}

/// What went wrong on the line and in the chip, for tests.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Counters {
    /// Bytes lost because the firmware did not read the ones before in time.
    pub receiver_overruns: u32,
    /// Bytes lost because the ends of the line run at different speeds.
    pub framing_errors: u32,
    /// Resets by the watchdog.
    pub watchdog_resets: u32,
}

/// How long a level on the reset pin is to be seen as.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum ResetKind {
    PowerOn,
    External,
    BrownOut,
    /// The core has reset itself.
    Watchdog,
}

pub struct Nano {
    avr: NonNull<ffi::avr_t>,
    twi: NonNull<ffi::avr_twi_t>,
    uart: NonNull<ffi::avr_uart_t>,
    uart_input: NonNull<ffi::avr_irq_t>,
    wires: NonNull<Wires>,
    /// Bytes on their way in: when each is whole, in cycles, and what it is.
    incoming: VecDeque<(u64, u8)>,
    /// When each byte arrived that the receiver holds.
    held_since: VecDeque<u64>,
    /// When the line from the host is free again, in ninths of a cycle.
    incoming_free_ninths: u64,
    /// In reset, or in the bootloader, until this cycle.
    held: Option<(u64, ResetKind)>,
    /// The START or address under way has been given its time.
    twi_delayed: bool,
    counters: Counters,
    trace: Option<Box<Trace>>,
}

impl Nano {
    /// A board powered on, its start-up time over, with this program and an erased
    /// EEPROM.
    ///
    /// # Errors
    /// [`NanoError::UnknownChip`] if simavr was built without the ATmega328P.
    pub fn new(image: &FirmwareImage, bus: Bus) -> Result<Self, NanoError> {
        // SAFETY: the name is a C string; a null result is handled.
        let avr = unsafe { ffi::avr_make_mcu_by_name(c"atmega328p".as_ptr()) };
        let avr = NonNull::new(avr).ok_or(NanoError::UnknownChip)?;
        // SAFETY: `avr` was just made, and nothing else refers to it. The flash
        // is allocated by `avr_init` with `flashend + 1` = FLASH_LEN bytes,
        // and an image is never longer.
        let found = unsafe {
            ffi::avr_init(avr.as_ptr());
            (*avr.as_ptr()).frequency = CLOCK_HZ as u32;
            for millivolts in [&mut (*avr.as_ptr()).vcc, &mut (*avr.as_ptr()).avcc] {
                *millivolts = 5000;
            }
            assert!((*avr.as_ptr()).flashend as usize + 1 == FLASH_LEN, "the wrong chip");
            let flash = image.flash();
            std::ptr::copy_nonoverlapping(flash.as_ptr(), (*avr.as_ptr()).flash, flash.len());
            (*avr.as_ptr()).codeend = flash.len() as u32;
            (*avr.as_ptr()).reset_pc = image.reset_address();
            (*avr.as_ptr()).pc = image.reset_address();
            wires::find_units(avr)
        };
        let units = found.ok_or(NanoError::UnknownChip)?;
        let wires = Box::new(Wires::new(avr, units.uart, units.twi_input, bus));
        let wires = NonNull::from(Box::leak(wires));
        // SAFETY: the units belong to `avr`; `wires` lives as long as `avr`,
        // see `drop`.
        unsafe { hooks::connect(&units, wires) };
        let nano = Self {
            avr,
            twi: units.twi,
            uart: units.uart,
            uart_input: units.uart_input,
            wires,
            incoming: VecDeque::new(),
            held_since: VecDeque::new(),
            incoming_free_ninths: 0,
            held: None,
            twi_delayed: false,
            counters: Counters::default(),
            trace: None,
        };
        Ok(nano)
    }

    /// Cycles since power was first switched on, resets and all.
    #[must_use]
    pub fn now(&self) -> u64 {
        self.wires().now()
    }

    /// Emulated seconds since power was first switched on.
    #[must_use]
    pub fn now_s(&self) -> f64 {
        seconds(self.now())
    }

    /// Runs up to `cycle`, or a few cycles past it: instructions are whole.
    ///
    /// # Errors
    /// [`NanoError`] if the program came to an end.
    pub fn run_until(&mut self, cycle: u64) -> Result<(), NanoError> {
        loop {
            let now = self.now();
            if let Some((until, kind)) = self.held {
                // Time passes; the program does not.
                let skip_to = until.min(cycle);
                self.wires().skip(skip_to.saturating_sub(now));
                self.incoming.retain(|(whole, _)| *whole > skip_to);
                if until > cycle {
                    return Ok(());
                }
                self.held = None;
                self.reset_core(kind);
                continue;
            }
            if now >= cycle {
                return Ok(());
            }
            let next_byte = self.incoming.front().map_or(u64::MAX, |(whole, _)| *whole);
            if now >= next_byte {
                self.deliver();
                continue;
            }
            self.step(next_byte.min(cycle) - now)?;
        }
    }

    /// Puts bytes on the line; they arrive no faster than 115,200 baud allow.
    pub fn send(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            let start = self.incoming_free_ninths.max(self.now() * NINTHS);
            self.incoming_free_ninths = start + HOST_BYTE_NINTHS;
            self.incoming.push_back((self.incoming_free_ninths.div_ceil(NINTHS), byte));
        }
    }

    /// Bytes that are still on the line to the Nano.
    #[must_use]
    pub fn unsent(&self) -> usize {
        self.incoming.len()
    }

    /// When the last byte put on the line to the Nano is whole, in cycles.
    #[must_use]
    pub fn line_free_at(&self) -> u64 {
        self.incoming_free_ninths.div_ceil(NINTHS)
    }

    /// Bytes whose last bit has left the Nano, with the cycle at which it did.
    pub fn receive(&mut self) -> Vec<(u64, u8)> {
        self.wires().take_outgoing()
    }

    /// Pulls the reset pin, and lets the bootloader have the chip for a while.
    ///
    /// SRAM and EEPROM keep their contents, and the servo driver its pulses;
    /// bytes that arrive meanwhile are the bootloader's.
    pub fn reset(&mut self, bootloader_cycles: u64) {
        self.hold(bootloader_cycles, ResetKind::External);
    }

    /// Switches the Nano's own supply off and on again: SRAM is lost.
    pub fn power_cycle(&mut self) {
        self.hold(0, ResetKind::PowerOn);
    }

    /// Lets the supply sag below the brown-out level for a moment.
    pub fn brown_out(&mut self) {
        self.hold(0, ResetKind::BrownOut);
    }

    /// Sends the program into its own first endless loop, interrupts as they
    /// are; false if it has none.
    pub fn hang(&mut self) -> bool {
        /// `rjmp .`
        const ENDLESS_LOOP: [u8; 2] = 0xCFFF_u16.to_le_bytes();
        // SAFETY: `flash` holds `codeend` bytes and more as long as `avr` lives.
        unsafe {
            let avr = &mut *self.avr.as_ptr();
            let program = std::slice::from_raw_parts(avr.flash, avr.codeend as usize);
            let found = program.chunks_exact(2).position(|word| word == ENDLESS_LOOP);
            avr.pc = found.map_or(avr.pc, |index| 2 * index as u32);
            found.is_some()
        }
    }

    /// Whether the program is not running because of a reset.
    #[must_use]
    pub fn is_held(&self) -> bool {
        self.held.is_some()
    }

    /// The chips on the bus.
    ///
    /// # Panics
    /// Never: nothing else holds the bus while the program stands.
    #[must_use]
    pub fn bus(&self) -> Ref<'_, Bus> {
        self.wires().bus.borrow()
    }

    /// The chips on the bus, to break them.
    ///
    /// # Panics
    /// Never while no result of [`Self::bus`] is alive.
    pub fn bus_mut(&mut self) -> RefMut<'_, Bus> {
        self.wires().bus.borrow_mut()
    }

    /// What went wrong so far.
    #[must_use]
    pub fn counters(&self) -> Counters {
        self.counters
    }

    fn wires(&self) -> &Wires {
        // SAFETY: leaked in `new`, freed in `drop`; only shared references are
        // ever made of it.
        unsafe { self.wires.as_ref() }
    }

    fn hold(&mut self, cycles: u64, kind: ResetKind) {
        let now = self.now();
        self.held = Some((now + START_UP_CYCLES + cycles, kind));
        self.wires().bus.borrow_mut().abandon();
        self.wires().refresh_output_enable(true);
        self.wires().cut_outgoing();
    }
}

impl Drop for Nano {
    fn drop(&mut self) {
        // SAFETY: after this nothing refers to either; simavr is terminated
        // first, so no hook can find its wires gone. `avr` itself comes from
        // malloc behind simavr's back and stays: 60 KB a board.
        unsafe {
            ffi::avr_terminate(self.avr.as_ptr());
            drop(Box::from_raw(self.wires.as_ptr()));
        }
    }
}

/// Emulated seconds at a cycle.
#[must_use]
pub fn seconds(cycle: u64) -> f64 {
    cycle as f64 / CLOCK_HZ as f64
}
