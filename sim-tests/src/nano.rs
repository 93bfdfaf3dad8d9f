//! The Nano: the real firmware image on an emulated ATmega328P.
//!
//! Owns simavr, the wires between it and the chips, and the serial line with
//! its timing. One thread and no wall clock: the same bytes at the same cycles
//! give the same run, bit by bit. Refuses to go on after the program crashed
//! or fell asleep for ever.
//!
//! Where simavr is kinder than the chip, this module is not: a serial byte
//! takes 10 bits instead of 11, the receiver holds 3 bytes instead of 64, and
//! a START and an address take their time on the bus. What stays kinder:
//! interrupts are entered in 0 cycles instead of 4, and a STOP takes none.

#[cfg(test)]
mod tests;
mod wires;

use crate::devices::Bus;
use crate::firmware_image::{FLASH_LEN, FirmwareImage};
use simavr_ffi as ffi;
use std::cell::{Ref, RefMut};
use std::collections::VecDeque;
use std::ffi::c_void;
use std::ptr::NonNull;
use thiserror::Error;
use wires::Wires;

/// Cycles a second of the Nano's crystal.
pub const CLOCK_HZ: u64 = 16_000_000;
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
        /// When.
        cycle: u64,
    },
    /// Asleep with interrupts disabled: nothing can wake it.
    #[error("the firmware fell asleep with interrupts off at program address {pc:#06x}, cycle {cycle}")]
    AsleepForEver {
        /// Where, in bytes.
        pc: u32,
        /// When.
        cycle: u64,
    },
    /// simavr was built without this chip.
    #[error("simavr knows no ATmega328P: rebuild simavr-ffi with the package avr-libc installed")]
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
}

/// One board.
pub struct Nano {
    avr: NonNull<ffi::avr_t>,
    twi: NonNull<ffi::avr_twi_t>,
    uart: NonNull<ffi::avr_uart_t>,
    uart_input: NonNull<ffi::avr_irq_t>,
    wires: NonNull<Wires>,
    /// Bytes on their way in: when each is whole, in cycles, and what it is.
    incoming: VecDeque<(u64, u8)>,
    /// When the line from the host is free again, in ninths of a cycle.
    incoming_free_ninths: u64,
    /// In reset, or in the bootloader, until this cycle.
    held: Option<(u64, ResetKind)>,
    /// The START or address under way has been given its time.
    twi_delayed: bool,
    counters: Counters,
}

// Not among simavr-ffi's bindings, whose generator leaves sim_core.h out.
unsafe extern "C" {
    fn avr_run_one(avr: *mut ffi::avr_t) -> ffi::avr_flashaddr_t;
}

impl Nano {
    /// A board just powered on, with this program and an erased EEPROM.
    ///
    /// # Errors
    /// [`NanoError::UnknownChip`] if simavr was built without the ATmega328P.
    pub fn new(image: &FirmwareImage, bus: Bus) -> Result<Self, NanoError> {
        // SAFETY: the name is a C string; a null result is handled.
        let avr = unsafe { ffi::avr_make_mcu_by_name(c"atmega328p".as_ptr()) };
        let avr = NonNull::new(avr).ok_or(NanoError::UnknownChip)?;
        // SAFETY: `avr` was just made, and nobody else knows of it. The flash
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
            wires::find_units(avr)
        };
        let units = found.ok_or(NanoError::UnknownChip)?;
        let wires = Box::new(Wires::new(avr, units.uart, units.twi_input, bus));
        let wires = NonNull::from(Box::leak(wires));
        // SAFETY: the units belong to `avr`; `wires` lives as long as `avr`,
        // see `drop`.
        unsafe { wires::connect(&units, wires) };
        let nano = Self {
            avr,
            twi: units.twi,
            uart: units.uart,
            uart_input: units.uart_input,
            wires,
            incoming: VecDeque::new(),
            incoming_free_ninths: 0,
            held: None,
            twi_delayed: false,
            counters: Counters::default(),
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

    /// The EEPROM's contents.
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

    fn wires(&self) -> &Wires {
        // SAFETY: leaked in `new`, freed in `drop`; only shared references are
        // ever made of it.
        unsafe { self.wires.as_ref() }
    }

    fn hold(&mut self, cycles: u64, kind: ResetKind) {
        let now = self.now();
        self.held = Some((now + cycles, kind));
        self.wires().bus.borrow_mut().abandon();
        self.wires().cut_outgoing();
    }

    fn reset_core(&mut self, kind: ResetKind) {
        let cycle = self.now();
        // SAFETY: `avr` is alive; MCUSR and SRAM lie within its data space of
        // 0x900 bytes.
        unsafe {
            let data = (*self.avr.as_ptr()).data;
            let mcusr = data.add(MCUSR);
            match kind {
                ResetKind::External => *mcusr |= MCUSR_EXTERNAL,
                ResetKind::BrownOut => *mcusr |= MCUSR_BROWN_OUT,
                ResetKind::PowerOn => {
                    *mcusr = MCUSR_POWER_ON;
                    // Contents are undefined on the chip; 0xA5 finds whoever relies on zeros.
                    data.add(SRAM_START).write_bytes(0xA5, SRAM_LEN);
                }
            }
            ffi::avr_reset(self.avr.as_ptr());
        }
        self.after_reset(cycle);
    }

    /// `avr_reset` zeroed simavr's clock at this cycle of ours.
    fn after_reset(&mut self, cycle: u64) {
        self.wires().set_base(cycle);
        self.wires().bus.borrow_mut().abandon();
        self.twi_delayed = false;
    }

    /// One round of simavr's main loop, for at most about `room` cycles.
    fn step(&mut self, room: u64) -> Result<(), NanoError> {
        let avr = self.avr.as_ptr();
        // SAFETY: `avr` and its units live until `drop`. The hooks that run in
        // here get at `Wires` alone, of which `self` holds no reference.
        unsafe {
            if (*avr).state == ffi::cpu_Running as i32 {
                // simavr runs on until the next timer or interrupt by itself.
                (*avr).run_cycle_limit = u64::MAX;
                (*avr).run_cycle_count = (*avr).run_cycle_count.min(room);
                (*avr).pc = avr_run_one(avr);
            }
            let pending = (*self.twi.as_ptr()).next_twstate;
            if pending == 0 {
                self.twi_delayed = false;
            } else if !self.twi_delayed {
                self.delay_twi(pending);
            }

            let before = (*avr).cycle;
            let sleep = ffi::avr_cycle_timer_process(avr);
            if (*avr).cycle < before {
                self.counters.watchdog_resets += 1;
                let cycle = self.wires().base() + before;
                self.wires().cut_outgoing_at(cycle);
                self.after_reset(cycle);
                return Ok(());
            }
            if (*avr).state == ffi::cpu_Sleeping as i32 {
                if (*avr).sreg[ffi::S_I as usize] == 0 {
                    return Err(NanoError::AsleepForEver { pc: (*avr).pc, cycle: self.now() });
                }
                (*avr).cycle += sleep.min(room).max(1);
            }
            let state = (*avr).state;
            let running = state == ffi::cpu_Running as i32 || state == ffi::cpu_Sleeping as i32;
            if state == ffi::cpu_Crashed as i32 || (running && (*avr).pc >= (*avr).codeend) {
                return Err(NanoError::Crashed { pc: (*avr).pc, cycle: self.now() });
            }
            if !running {
                return Err(NanoError::AsleepForEver { pc: (*avr).pc, cycle: self.now() });
            }
            if (*avr).interrupt_state != 0 {
                ffi::avr_service_interrupts(avr);
            }
        }
        Ok(())
    }

    /// Gives the START or address under way the time it takes on the bus, and
    /// a bus that is stuck all the time in the world.
    fn delay_twi(&mut self, pending: u8) {
        const START: u8 = 0x08;
        const REPEATED_START: u8 = 0x10;
        const ADDRESS_ACK: u8 = 0x18;
        const ADDRESS_NACK: u8 = 0x20;

        let bits = match pending {
            START | REPEATED_START => 1,
            ADDRESS_ACK | ADDRESS_NACK => 9,
            _ => 0,
        };
        let stuck = self.wires().bus.borrow().is_stuck();
        self.twi_delayed = true;
        if bits == 0 && !stuck {
            return;
        }
        let avr = self.avr.as_ptr();
        // SAFETY: the timer list belongs to `avr` and is walked only while
        // simavr stands; registering and cancelling are its own functions.
        unsafe {
            let mut slot = (*avr).cycle_timers.timer;
            while !slot.is_null() && (*slot).param != self.twi.as_ptr().cast::<c_void>() {
                slot = (*slot).next;
            }
            if slot.is_null() {
                return;
            }
            let (timer, param) = ((*slot).timer, (*slot).param);
            if stuck {
                ffi::avr_cycle_timer_cancel(avr, timer, param);
                (*self.twi.as_ptr()).next_twstate = 0;
            } else {
                // Section 21.5.2: 16 + 2 TWBR 4^TWPS cycles a bit.
                const TWBR: usize = 0xB8;
                const TWSR: usize = 0xB9;
                let divider = u64::from(*(*avr).data.add(TWBR)) << (2 * (*(*avr).data.add(TWSR) & 3));
                ffi::avr_cycle_timer_register(avr, bits * (16 + 2 * divider), timer, param);
            }
        }
    }

    /// Hands the first byte on the line, whole by now, to the receiver.
    fn deliver(&mut self) {
        let Some((_, byte)) = self.incoming.pop_front() else { return };
        let bit_cycles = self.wires().bit_cycles() as f64;
        let error = bit_cycles * HOST_BAUD as f64 / CLOCK_HZ as f64 - 1.0;
        if error.abs() > MAX_BAUD_ERROR {
            self.counters.framing_errors += 1;
            return;
        }
        let uart = self.uart.as_ptr();
        // SAFETY: `uart` and its input belong to `avr`, which is alive and not
        // running.
        unsafe {
            let held = (*uart).input.write.wrapping_sub((*uart).input.read) % 64;
            if held >= RECEIVER_DEPTH {
                self.counters.receiver_overruns += 1;
                return;
            }
            // simavr counts from the start bit; ours has been on the line already.
            let byte_cycles = std::mem::replace(&mut (*uart).cycles_per_byte, 1);
            ffi::avr_raise_irq(self.uart_input.as_ptr(), u32::from(byte));
            (*uart).cycles_per_byte = byte_cycles;
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
