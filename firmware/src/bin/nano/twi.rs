//! The two-wire bus: bursts and readings by interrupt, everything else by bounded polling.
//!
//! Holds the registers of TWI, who may use them, and what interrupts send and read:
//! two buffers for the servo burst, the one on the wire and the one being prepared,
//! and a ring of power readings. [`chain`] moves the bytes, [`free`] unlocks a stuck
//! bus, [`master`] has the main loop's transfers. Transfers never mix: code that
//! finds the bus taken waits for its end, which a deadline bounds, or does without.
//! Does not depend on the chips but for their addresses, the length of a burst and
//! the two registers of a reading.

mod chain;
mod free;
mod master;

use avr_device::atmega328p::{TWI, twi};
use avr_device::interrupt::{self, CriticalSection, Mutex};
use core::cell::Cell;

use firmware::chips::{Reading, ServoBurst};
use firmware::hal::{BurstState, PowerReadings, ServoOutput};

use super::shared::{Shared, word};
use super::timer::TICKS_PER_US;
pub use chain::start_burst;
pub use master::Twi;

/// 33 bytes and the address take 0.77 ms, about 0.1 ms of interrupts, and as
/// much again if the line to the host is busy both ways.
const BURST_TICKS: u16 = 1_200 * TICKS_PER_US;
/// 16 MHz / (16 + 2 * 12) = 400 kHz.
const BIT_RATE: u8 = 12;
const BURST_LEN: u8 = size_of::<ServoBurst>() as u8;
// A burst of another servo driver has to end in time too: 35 us a byte, of which 9
// bits are 22.5, and the address is one.
const _: () = assert!((1 + size_of::<ServoBurst>()) * 35 * TICKS_PER_US as usize <= BURST_TICKS as usize);

/// Who drives the bus; up to `MAIN`, it is not the handlers.
mod owner {
    pub const NOBODY: u8 = 0;
    pub const MAIN: u8 = 1;
    pub const BURST: u8 = 2;
    pub const READING: u8 = 3;
    /// A transfer did not end; the lines are being clocked free.
    pub const FREEING: u8 = 4;
}

static OWNER: Shared = Shared::new(owner::NOBODY);
static OUTCOME: Mutex<Cell<BurstState>> = Mutex::new(Cell::new(BurstState::Done));
static ERRORS: Mutex<Cell<u16>> = Mutex::new(Cell::new(0));

/// Both bursts, one behind the other.
static BURSTS: [Shared; 2 * BURST_LEN as usize] = [const { Shared::new(0) }; 2 * BURST_LEN as usize];
/// Where the one on the wire begins; the handlers' own.
static FRONT: Shared = Shared::new(0);
/// Whether the other one is complete.
static FRESH: Shared = Shared::new(0);

/// Four bytes a reading, as they came: the voltage, then the current.
const READING_LEN: u8 = 4;
/// Eight readings are a frame's less one: the main loop may be away as long.
const RING_LEN: u8 = 8 * READING_LEN;
const RING_MASK: u8 = RING_LEN - 1;
const _: () = assert!(RING_LEN.is_power_of_two());

static READINGS: [Shared; RING_LEN as usize] = [const { Shared::new(0) }; RING_LEN as usize];
/// Where the next reading goes; the handlers' own.
static HEAD: Shared = Shared::new(0);
/// The oldest that was not taken; only the main loop writes it.
static TAIL: Shared = Shared::new(0);

fn registers() -> &'static twi::RegisterBlock {
    // SAFETY: the registers are there for good; who may use them is in `OWNER`.
    unsafe { &*TWI::ptr() }
}

#[inline(always)]
fn count_error(cs: CriticalSection<'_>) {
    let errors = ERRORS.borrow(cs);
    errors.set(errors.get().saturating_add(1));
}

/// Asks for a START, first or repeated; the interrupt goes on with it.
#[inline(always)]
fn request_start() {
    registers().twcr().write(|w| w.twint().set_bit().twsta().set_bit().twen().set_bit().twie().set_bit());
}

#[inline(always)]
fn send_stop() {
    registers().twcr().write(|w| w.twint().set_bit().twsto().set_bit().twen().set_bit());
}

/// Lets go of both lines, whatever the state.
#[inline(always)]
fn let_go() {
    registers().twcr().reset();
}

// Status codes, data sheet tables 21-3 and 21-4.
const START: u8 = 0x08;
const REPEATED_START: u8 = 0x10;
const ADDRESS_W_ACK: u8 = 0x18;
const ADDRESS_W_NACK: u8 = 0x20;
const DATA_W_ACK: u8 = 0x28;
const DATA_W_NACK: u8 = 0x30;
const ADDRESS_R_ACK: u8 = 0x40;
const ADDRESS_R_NACK: u8 = 0x48;
const DATA_R_ACK: u8 = 0x50;
const DATA_R_NACK: u8 = 0x58;

#[inline(always)]
fn status() -> u8 {
    registers().twsr().read().bits() & 0xF8
}

/// The bus at 400 kHz, in the three ways that the main loop uses it.
pub fn start() -> (Twi, Bursts, Readings) {
    (Twi::start(), Bursts(()), Readings(()))
}

/// Transfers that failed since the start, the interrupts' own included.
pub fn errors() -> u16 {
    interrupt::free(|cs| ERRORS.borrow(cs).get())
}

/// The servo bursts, as the main loop sees them.
pub struct Bursts(());

impl ServoOutput for Bursts {
    fn stage(&mut self, burst: &ServoBurst) {
        // A frame that starts while this is copied repeats the burst before.
        FRESH.set(0);
        let back = BURST_LEN - FRONT.get();
        for (place, &byte) in BURSTS.iter().skip(usize::from(back)).zip(burst) {
            place.set(byte);
        }
        FRESH.set(1);
    }

    fn burst(&mut self) -> BurstState {
        interrupt::free(|cs| OUTCOME.borrow(cs).get())
    }
}

/// The power sensor's readings, as the main loop sees them.
pub struct Readings(());

impl PowerReadings for Readings {
    fn readings(&self) -> u8 {
        (HEAD.get().wrapping_sub(TAIL.get()) & RING_MASK) / READING_LEN
    }

    fn take_reading(&mut self) -> Option<Reading> {
        let at = TAIL.get();
        if at == HEAD.get() {
            return None;
        }
        let bytes = READINGS.get(usize::from(at)..)?.first_chunk::<{ READING_LEN as usize }>()?;
        let [voltage_high, voltage_low, current_high, current_low] = bytes;
        let reading =
            Reading { voltage: word(voltage_low, voltage_high), current: word(current_low, current_high) };
        TAIL.set((at + READING_LEN) & RING_MASK);
        Some(reading)
    }
}
