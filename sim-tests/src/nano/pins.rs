//! The pins that the program drives and reads by hand.
//!
//! Holds the two-wire lines while the two-wire unit is off, the start button on D2,
//! and the servo driver's output enable on D4. Has no analog levels: a pin that
//! floats reads as the worse of both. Does not depend on the serial line.

use super::wires::{OutputEnable, Wires};
use super::{Nano, seconds};
use simavr_ffi as ffi;
use std::ffi::c_void;

/// Port C, where a program may drive the two-wire bus by hand.
const PINC: usize = 0x26;
const DDRC: usize = 0x27;
const SDA: u8 = 1 << 4;
const SCL: u8 = 1 << 5;
/// Port D, with the start button and the servo driver's OE.
const PIND: usize = 0x29;
const DDRD: usize = 0x2A;
const PORTD: usize = 0x2B;
const BUTTON: u8 = 1 << 2;
const OUTPUT_ENABLE: u8 = 1 << 4;

impl Nano {
    /// Wires the servo driver's pin OE.
    pub fn wire_output_enable(&mut self, wiring: OutputEnable) {
        self.wires().output_enable.set(wiring);
        self.wires().refresh_output_enable(self.is_held());
    }

    /// Presses the button between D2 and ground, or lets it go.
    pub fn press_button(&mut self, is_pressed: bool) {
        self.wires().button.set(is_pressed);
    }
}

impl Wires {
    /// D4 has this direction and level, and OE follows it.
    pub fn drive_output_enable(&self, directions: u8, levels: u8) {
        let is_output = directions & OUTPUT_ENABLE != 0;
        let is_high = match self.output_enable.get() {
            OutputEnable::Unwired => false,
            // The chip's own pull-up is too weak against the board's resistor.
            _ if is_output => levels & OUTPUT_ENABLE != 0,
            OutputEnable::PulledDown => false,
            OutputEnable::PulledUp => true,
        };
        self.bus.borrow_mut().servo_driver.set_enabled(!is_high, seconds(self.now()));
    }

    /// As the registers stand, or with every pin an input.
    pub fn refresh_output_enable(&self, in_reset: bool) {
        // SAFETY: the registers lie within the data space of 0x900 bytes.
        let [directions, levels] =
            unsafe { [DDRD, PORTD].map(|register| *(*self.avr.as_ptr()).data.add(register)) };
        let directions = if in_reset { 0 } else { directions };
        self.drive_output_enable(directions, levels);
    }
}

/// The program reads port C: pull-ups hold both lines high, unless somebody
/// pulls one down.
pub(super) unsafe extern "C" fn on_pins_read(_signal: *mut ffi::avr_irq_t, _pins: u32, wires: *mut c_void) {
    // SAFETY: registered with a pointer to `Wires` that outlives the chip.
    let wires = unsafe { &*wires.cast::<Wires>() };
    let held = if wires.bus.borrow().is_data_held() { SDA } else { 0 };
    // SAFETY: both registers lie within the data space of 0x900 bytes; simavr
    // hands the program what stands there after this hook.
    unsafe {
        let data = (*wires.avr.as_ptr()).data;
        let pulled_down = *data.add(DDRC) | held;
        *data.add(PINC) = *data.add(PINC) & !(SDA | SCL) | (SDA | SCL) & !pulled_down;
    }
}

/// The program pulls lines down by making pins outputs, and lets them go.
pub(super) unsafe extern "C" fn on_pins_turned(
    _signal: *mut ffi::avr_irq_t,
    outputs: u32,
    wires: *mut c_void,
) {
    // SAFETY: registered with a pointer to `Wires` that outlives the chip.
    let wires = unsafe { &*wires.cast::<Wires>() };
    // SAFETY: within the data space; the register changes after this hook.
    let before = unsafe { *(*wires.avr.as_ptr()).data.add(DDRC) };
    if before & !(outputs as u8) & SCL != 0 {
        wires.bus.borrow_mut().clock();
    }
}

/// The program reads port D: the button pulls its pin down, and a pin without
/// its pull-up floats, which reads as pressed here.
pub(super) unsafe extern "C" fn on_port_d_read(_signal: *mut ffi::avr_irq_t, _pins: u32, wires: *mut c_void) {
    // SAFETY: registered with a pointer to `Wires` that outlives the chip.
    let wires = unsafe { &*wires.cast::<Wires>() };
    // SAFETY: the registers lie within the data space of 0x900 bytes; simavr
    // hands the program what stands there after this hook.
    unsafe {
        let data = (*wires.avr.as_ptr()).data;
        let is_input = *data.add(DDRD) & BUTTON == 0;
        if is_input {
            let is_high = *data.add(PORTD) & BUTTON != 0 && !wires.button.get();
            *data.add(PIND) = *data.add(PIND) & !BUTTON | if is_high { BUTTON } else { 0 };
        }
    }
}

/// The program turns pins of port D; the register changes after this hook.
pub(super) unsafe extern "C" fn on_port_d_turned(
    _signal: *mut ffi::avr_irq_t,
    outputs: u32,
    wires: *mut c_void,
) {
    // SAFETY: registered with a pointer to `Wires` that outlives the chip.
    let wires = unsafe { &*wires.cast::<Wires>() };
    // SAFETY: within the data space.
    let levels = unsafe { *(*wires.avr.as_ptr()).data.add(PORTD) };
    wires.drive_output_enable(outputs as u8, levels);
}

/// The program sets levels of port D.
pub(super) unsafe extern "C" fn on_port_d_set(_signal: *mut ffi::avr_irq_t, levels: u32, wires: *mut c_void) {
    // SAFETY: registered with a pointer to `Wires` that outlives the chip.
    let wires = unsafe { &*wires.cast::<Wires>() };
    // SAFETY: within the data space.
    let directions = unsafe { *(*wires.avr.as_ptr()).data.add(DDRD) };
    wires.drive_output_enable(directions, levels as u8);
}
