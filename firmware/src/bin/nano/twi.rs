//! The two-wire bus: a servo burst by interrupt, everything else by bounded polling.
//!
//! Owns TWI and, while the bus is being freed, the pins A4 and A5. The frame
//! timer starts the burst; one interrupt per byte carries it on; the second
//! compare of timer 1 aborts it at its deadline. Two buffers: the one on the
//! wire, and the one being prepared. Refuses to mix: a transaction of the main
//! loop waits for the burst to end, and a burst that falls into a transaction
//! starts right after it.

mod master;

use avr_device::atmega328p::{PORTC, TWI, portc, twi};
use avr_device::interrupt::{self, CriticalSection, Mutex};
use core::cell::Cell;

use firmware::hal::{BurstState, Bus, Reading};
use firmware::servos::{self, ServoBurst};

use super::timer::{self, TICKS_PER_US};
pub use master::Twi;

/// 33 bytes and the address take 0.77 ms, and about 0.1 ms of interrupts.
const BURST_TICKS: u16 = 1_200 * TICKS_PER_US;
/// Three register reads take 0.4 ms.
const TRANSACTION_TICKS: u16 = 1_000 * TICKS_PER_US;
/// 16 MHz / (16 + 2 * 12) = 400 kHz.
const BIT_RATE: u8 = 12;
const BURST_LEN: usize = size_of::<ServoBurst>();

/// Who drives the bus.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Owner {
    Nobody,
    Burst,
    Main,
}

static OWNER: Mutex<Cell<Owner>> = Mutex::new(Cell::new(Owner::Nobody));
static OUTCOME: Mutex<Cell<BurstState>> = Mutex::new(Cell::new(BurstState::Done));
/// A frame started while the main loop had the bus.
static LATE: Mutex<Cell<bool>> = Mutex::new(Cell::new(false));
static BUFFERS: Mutex<Cell<[ServoBurst; 2]>> = Mutex::new(Cell::new([[0; BURST_LEN]; 2]));
/// The buffer on the wire.
static FRONT: Mutex<Cell<bool>> = Mutex::new(Cell::new(false));
/// Whether the other one is complete.
static FRESH: Mutex<Cell<bool>> = Mutex::new(Cell::new(false));
static POSITION: Mutex<Cell<u8>> = Mutex::new(Cell::new(0));

fn registers() -> &'static twi::RegisterBlock {
    // SAFETY: the registers are there for good; who may use them is in `OWNER`.
    unsafe { &*TWI::ptr() }
}

fn pins() -> &'static portc::RegisterBlock {
    // SAFETY: the registers are there for good; nothing else uses port C.
    unsafe { &*PORTC::ptr() }
}

#[inline(always)]
fn buffer<'cs>(cs: CriticalSection<'cs>, which: bool) -> &'cs [Cell<u8>] {
    let both: &Cell<[ServoBurst]> = BUFFERS.borrow(cs);
    let [first, second] = both.as_slice_of_cells() else { return &[] };
    let one: &Cell<[u8]> = if which { second } else { first };
    one.as_slice_of_cells()
}

/// Starts the frame's burst; called by the frame timer.
#[inline(always)]
pub fn start_burst(cs: CriticalSection) {
    if OWNER.borrow(cs).get() == Owner::Nobody {
        registers().twcr().write(|w| w.twint().set_bit().twsta().set_bit().twen().set_bit().twie().set_bit());
        OWNER.borrow(cs).set(Owner::Burst);
        if FRESH.borrow(cs).replace(false) {
            let front = FRONT.borrow(cs);
            front.set(!front.get());
        }
        POSITION.borrow(cs).set(0);
        timer::arm(cs, BURST_TICKS);
    } else {
        LATE.borrow(cs).set(true);
    }
    OUTCOME.borrow(cs).set(BurstState::Running);
}

fn end_burst(cs: CriticalSection, outcome: BurstState) {
    timer::disarm(cs);
    OUTCOME.borrow(cs).set(outcome);
    OWNER.borrow(cs).set(Owner::Nobody);
}

fn carry_on() {
    registers().twcr().write(|w| w.twint().set_bit().twen().set_bit().twie().set_bit());
}

fn send_stop() {
    registers().twcr().write(|w| w.twint().set_bit().twsto().set_bit().twen().set_bit());
}

/// Lets go of both lines, whatever the state.
fn let_go() {
    registers().twcr().reset();
}

#[avr_device::interrupt(atmega328p)]
fn TWI() {
    // SAFETY: interrupts are off inside an interrupt, and stay off.
    let cs = unsafe { CriticalSection::new() };
    let twi = registers();
    match status() {
        START => {
            twi.twdr().write(|w| w.set(servos::ADDRESS << 1));
            carry_on();
        }
        ADDRESS_W_ACK | DATA_W_ACK => {
            let position = POSITION.borrow(cs);
            let front = FRONT.borrow(cs).get();
            if let Some(byte) = buffer(cs, front).get(usize::from(position.get())) {
                twi.twdr().write(|w| w.set(byte.get()));
                carry_on();
                position.set(position.get() + 1);
            } else {
                send_stop();
                end_burst(cs, BurstState::Done);
            }
        }
        ADDRESS_W_NACK | DATA_W_NACK => {
            send_stop();
            end_burst(cs, BurstState::Failed);
        }
        _ => {
            let_go();
            end_burst(cs, BurstState::Failed);
        }
    }
}

// The burst's deadline.
#[avr_device::interrupt(atmega328p)]
fn TIMER1_COMPB() {
    // SAFETY: interrupts are off inside an interrupt, and stay off.
    let cs = unsafe { CriticalSection::new() };
    if OWNER.borrow(cs).get() == Owner::Burst {
        let_go();
        end_burst(cs, BurstState::Failed);
    } else {
        timer::disarm(cs);
    }
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

fn status() -> u8 {
    registers().twsr().read().bits() & 0xF8
}

impl Bus for Twi {
    fn stage(&mut self, burst: &ServoBurst) {
        // A frame that starts while this is copied repeats the burst before.
        let back = interrupt::free(|cs| {
            FRESH.borrow(cs).set(false);
            !FRONT.borrow(cs).get()
        });
        for (index, &byte) in burst.iter().enumerate() {
            interrupt::free(|cs| {
                if let Some(place) = buffer(cs, back).get(index) {
                    place.set(byte);
                }
            });
        }
        interrupt::free(|cs| FRESH.borrow(cs).set(true));
    }

    fn burst(&mut self) -> BurstState {
        interrupt::free(|cs| OUTCOME.borrow(cs).get())
    }

    fn recover(&mut self) {
        if self.claim().is_err() {
            return;
        }
        let_go();
        // Driving low is output, letting go is input: the lines are never driven high.
        let pins = pins();
        pins.portc().modify(|_, w| w.pc4().clear_bit().pc5().clear_bit());
        let scl_low = |low: bool| {
            pins.ddrc().modify(|_, w| w.pc5().bit(low));
            avr_device::asm::delay_cycles(5 * 16);
        };
        let sda_low = |low: bool| {
            pins.ddrc().modify(|_, w| w.pc4().bit(low));
            avr_device::asm::delay_cycles(5 * 16);
        };
        // A chip in the middle of a byte lets go of SDA after at most 9 clocks.
        for _ in 0..9 {
            if pins.pinc().read().pc4().bit_is_set() {
                break;
            }
            scl_low(true);
            scl_low(false);
        }
        // STOP: SDA rises while SCL is high.
        scl_low(true);
        sda_low(true);
        scl_low(false);
        sda_low(false);
        self.release();
    }

    fn take_reading(&mut self) -> Option<Reading> {
        None
    }

    fn errors(&self) -> u16 {
        0
    }
}
