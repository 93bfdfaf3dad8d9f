//! Light, button, and the servo driver's output enable.
//!
//! Holds the pins PB5 (D13), PD2 and PD4; the serial port has the rest of port D
//! that is used at all. The light is SPI's clock too, which this robot does not use:
//! off until the main loop runs, and frozen if it hangs. `/OE` is high, outputs
//! off, from the program's first instructions on; before them, in reset and in
//! the bootloader, the pin floats, and a resistor to 5 V holds it.
//! Does not depend on what the light shows or the button starts.

use avr_device::atmega328p::{PORTB, PORTD, portb, portd};

fn lights() -> &'static portb::RegisterBlock {
    // SAFETY: the registers are there for good; nothing else uses port B.
    unsafe { &*PORTB::ptr() }
}

fn switches() -> &'static portd::RegisterBlock {
    // SAFETY: the registers are there for good; nothing else writes to port D,
    // no interrupt either, and the serial port overrides its own two pins.
    unsafe { &*PORTD::ptr() }
}

/// The yellow light marked L, the button on D2, and `/OE` on D4.
pub struct Panel(());

impl Panel {
    /// Light off, button pulled up, outputs off.
    #[inline(always)]
    pub fn start() -> Self {
        let switches = switches();
        // High before it drives: never low in between.
        switches.portd().write(|w| w.pd4().set_bit().pd2().set_bit());
        switches.ddrd().write(|w| w.pd4().set_bit());
        lights().ddrb().write(|w| w.pb5().set_bit());
        Self(())
    }
}

impl firmware::hal::Panel for Panel {
    fn light(&mut self, on: bool) {
        lights().portb().write(|w| w.pb5().bit(on));
    }

    fn is_button_pressed(&mut self) -> bool {
        switches().pind().read().pd2().bit_is_clear()
    }

    fn enable_outputs(&mut self, on: bool) {
        switches().portd().write(|w| w.pd4().bit(!on).pd2().set_bit());
    }
}
