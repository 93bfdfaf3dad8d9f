//! The light on the board: PB5, D13.
//!
//! Owns that pin and nothing else of port B. It is SPI's clock too, which this
//! robot does not use. Off until the main loop runs, and frozen if it hangs.

use avr_device::atmega328p::{PORTB, portb};

fn registers() -> &'static portb::RegisterBlock {
    // SAFETY: the registers are there for good; nothing else uses port B.
    unsafe { &*PORTB::ptr() }
}

/// The yellow light marked L.
pub struct Light(());

impl Light {
    /// Off.
    pub fn start() -> Self {
        registers().ddrb().write(|w| w.pb5().set_bit());
        Self(())
    }
}

impl firmware::hal::Light for Light {
    fn set(&mut self, on: bool) {
        registers().portb().write(|w| w.pb5().bit(on));
    }
}
