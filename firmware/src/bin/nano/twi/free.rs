//! Unlocks a bus that a transfer left stuck.
//!
//! Holds the pins A4 and A5 while it does. A chip that lost its master in the
//! middle of a byte holds SDA until it has been clocked to the byte's end:
//! nine clocks at most, then a STOP. Step by step, so that an interrupt never
//! waits. A clock line that is held stays so; the steps end all the same.
//! Does not depend on TWI, which has to be off.

use avr_device::atmega328p::{PORTC, portc};

/// The first step.
pub const BEGIN: u8 = 0;
/// Two steps each.
const CLOCKS: u8 = 9;
const STOP: u8 = 2 * CLOCKS;

fn pins() -> &'static portc::RegisterBlock {
    // SAFETY: the registers are there for good; nothing else uses port C.
    unsafe { &*PORTC::ptr() }
}

// Driving low is output, letting go is input: the lines are never driven high.
fn scl_low(low: bool) {
    pins().ddrc().modify(|_, w| w.pc5().bit(low));
}

fn sda_low(low: bool) {
    pins().ddrc().modify(|_, w| w.pc4().bit(low));
}

/// Takes a step; the next one is due 5 us later at the earliest. `None`: done.
pub fn step(step: u8) -> Option<u8> {
    let pins = pins();
    let mut step = step;
    if step == BEGIN {
        pins.portc().modify(|_, w| w.pc4().clear_bit().pc5().clear_bit());
    }
    let is_clock = step < STOP;
    if is_clock && step & 1 == 0 && pins.pinc().read().pc4().bit_is_set() {
        step = STOP;
    }
    match step {
        // STOP: SDA rises while SCL is high.
        19 => sda_low(true),
        21 => {
            sda_low(false);
            return None;
        }
        step => scl_low(step & 1 == 0 && step != 20),
    }
    Some(step + 1)
}
