//! The two-wire bus: bursts and readings by interrupt, everything else by bounded polling.
//!
//! Owns TWI, who may use it, and what goes over it by itself: two buffers for
//! the servo burst, the one on the wire and the one being prepared, and a ring
//! of power readings. [`chain`] moves the bytes, [`free`] unlocks a stuck bus,
//! [`master`] has the main loop's transfers. Refuses to mix: whoever finds the
//! bus taken waits for its end, which a deadline bounds, or does without.

mod chain;
mod free;
mod master;

use avr_device::atmega328p::{TWI, twi};
use avr_device::interrupt::{self, CriticalSection, Mutex};
use core::cell::Cell;

use firmware::hal::{BurstState, Bus, Reading};
use firmware::servos::ServoBurst;

use super::timer::TICKS_PER_US;
pub use chain::start_burst;
pub use master::Twi;

/// 33 bytes and the address take 0.77 ms, about 0.1 ms of interrupts, and as
/// much again if the line to the host is busy both ways.
const BURST_TICKS: u16 = 1_200 * TICKS_PER_US;
/// 16 MHz / (16 + 2 * 12) = 400 kHz.
const BIT_RATE: u8 = 12;
const BURST_LEN: u8 = size_of::<ServoBurst>() as u8;

/// Who drives the bus.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Owner {
    Nobody,
    Main,
    Burst,
    Reading,
    /// A transfer did not end; the lines are being clocked free.
    Freeing,
}

static OWNER: Mutex<Cell<Owner>> = Mutex::new(Cell::new(Owner::Nobody));
static OUTCOME: Mutex<Cell<BurstState>> = Mutex::new(Cell::new(BurstState::Done));
/// A frame started while somebody else had the bus.
static LATE: Mutex<Cell<bool>> = Mutex::new(Cell::new(false));
static ERRORS: Mutex<Cell<u16>> = Mutex::new(Cell::new(0));

/// Both bursts, one behind the other.
static BURSTS: Mutex<Cell<[u8; 2 * BURST_LEN as usize]>> = Mutex::new(Cell::new([0; 2 * BURST_LEN as usize]));
/// Where the one on the wire begins.
static FRONT: Mutex<Cell<u8>> = Mutex::new(Cell::new(0));
/// Whether the other one is complete.
static FRESH: Mutex<Cell<bool>> = Mutex::new(Cell::new(false));

/// Four bytes a reading, as they came: the bus voltage, then the shunt's.
const READING_LEN: u8 = 4;
/// Eight readings are a frame's less one: the main loop may be away as long.
const RING_LEN: u8 = 8 * READING_LEN;
const RING_MASK: u8 = RING_LEN - 1;
const _: () = assert!(RING_LEN.is_power_of_two());

static READINGS: Mutex<Cell<[u8; RING_LEN as usize]>> = Mutex::new(Cell::new([0; RING_LEN as usize]));
/// Where the next reading goes.
static HEAD: Mutex<Cell<u8>> = Mutex::new(Cell::new(0));
/// The oldest that nobody has seen.
static TAIL: Mutex<Cell<u8>> = Mutex::new(Cell::new(0));

fn registers() -> &'static twi::RegisterBlock {
    // SAFETY: the registers are there for good; who may use them is in `OWNER`.
    unsafe { &*TWI::ptr() }
}

#[inline(always)]
fn bursts(cs: CriticalSection<'_>) -> &[Cell<u8>] {
    let bytes: &Cell<[u8]> = BURSTS.borrow(cs);
    bytes.as_slice_of_cells()
}

#[inline(always)]
fn readings(cs: CriticalSection<'_>) -> &[Cell<u8>] {
    let bytes: &Cell<[u8]> = READINGS.borrow(cs);
    bytes.as_slice_of_cells()
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

impl Bus for Twi {
    fn stage(&mut self, burst: &ServoBurst) {
        // A frame that starts while this is copied repeats the burst before.
        let back = interrupt::free(|cs| {
            FRESH.borrow(cs).set(false);
            BURST_LEN - FRONT.borrow(cs).get()
        });
        for (index, &byte) in (back..).zip(burst) {
            interrupt::free(|cs| {
                if let Some(place) = bursts(cs).get(usize::from(index)) {
                    place.set(byte);
                }
            });
        }
        interrupt::free(|cs| FRESH.borrow(cs).set(true));
    }

    fn burst(&mut self) -> BurstState {
        interrupt::free(|cs| OUTCOME.borrow(cs).get())
    }

    fn readings(&self) -> u8 {
        let (head, tail) = interrupt::free(|cs| (HEAD.borrow(cs).get(), TAIL.borrow(cs).get()));
        (head.wrapping_sub(tail) & RING_MASK) / READING_LEN
    }

    fn take_reading(&mut self) -> Option<Reading> {
        let at = interrupt::free(|cs| TAIL.borrow(cs).get());
        if at == interrupt::free(|cs| HEAD.borrow(cs).get()) {
            return None;
        }
        let byte =
            |index: u8| interrupt::free(|cs| readings(cs).get(usize::from(at + index)).map_or(0, Cell::get));
        let reading = Reading {
            bus: u16::from_be_bytes([byte(0), byte(1)]),
            shunt: i16::from_be_bytes([byte(2), byte(3)]),
        };
        interrupt::free(|cs| TAIL.borrow(cs).set((at + READING_LEN) & RING_MASK));
        Some(reading)
    }

    fn errors(&self) -> u16 {
        interrupt::free(|cs| ERRORS.borrow(cs).get())
    }
}
