//! What simavr calls when the program uses the serial line, the two-wire bus, or no instruction.
//!
//! Holds the hooks of those units, and connects all hooks, those of [`super::pins`]
//! included. Does not depend on [`super::Nano`]: hooks get [`Wires`] only.

use super::wires::{Units, Wires};
use super::{CLOCK_HZ, pins, seconds};
use simavr_ffi as ffi;
use std::ffi::c_void;
use std::ptr::NonNull;

/// Registers the hooks, and silences simavr's own serial console.
///
/// # Safety
/// The units' chip is alive, and `wires` stays where it is until that chip is
/// terminated.
pub(super) unsafe fn connect(units: &Units, wires: NonNull<Wires>) {
    let wires = wires.as_ptr().cast::<c_void>();
    // SAFETY: as above; the hooks' signatures are simavr's.
    unsafe {
        // The console would print what the Nano sends, and sleep when it polls.
        (*units.uart.as_ptr()).flags = 0;
        // Filtered, a hook would miss a write of what was written before a reset,
        // and a read of what a hook of ours has changed.
        for pins in
            [units.pins_read, units.pins_turned, units.port_d_read, units.port_d_turned, units.port_d_set]
        {
            (*pins.as_ptr()).flags &= !(ffi::IRQ_FLAG_FILTERED as u8);
        }
        ffi::avr_irq_register_notify(units.uart_output.as_ptr(), Some(on_serial_byte), wires);
        ffi::avr_irq_register_notify(units.twi_output.as_ptr(), Some(on_twi), wires);
        ffi::avr_irq_register_notify(units.pins_read.as_ptr(), Some(pins::on_pins_read), wires);
        ffi::avr_irq_register_notify(units.pins_turned.as_ptr(), Some(pins::on_pins_turned), wires);
        ffi::avr_irq_register_notify(units.port_d_read.as_ptr(), Some(pins::on_port_d_read), wires);
        ffi::avr_irq_register_notify(units.port_d_turned.as_ptr(), Some(pins::on_port_d_turned), wires);
        ffi::avr_irq_register_notify(units.port_d_set.as_ptr(), Some(pins::on_port_d_set), wires);
        ffi::avr_irq_register_notify(units.bad_opcode.as_ptr(), Some(on_bad_opcode), wires);
    }
}

/// The program wrote a byte to UDR0.
unsafe extern "C" fn on_serial_byte(_signal: *mut ffi::avr_irq_t, byte: u32, wires: *mut c_void) {
    // SAFETY: registered with a pointer to `Wires` that outlives the chip.
    let wires = unsafe { &*wires.cast::<Wires>() };
    let byte_cycles = 10 * wires.bit_cycles();
    // SAFETY: simavr raises this signal before it starts its own timer for the
    // byte, with 11 bits; this thread is the only one.
    unsafe { (*wires.uart.as_ptr()).cycles_per_byte = byte_cycles };
    let whole = wires.outgoing_free.get().max(wires.now()) + byte_cycles;
    wires.outgoing_free.set(whole);
    // The host hears garbage at another speed; a lost byte is as good.
    let error = byte_cycles as f64 * 11_520.0 / CLOCK_HZ as f64 - 1.0;
    if error.abs() <= super::MAX_BAUD_ERROR {
        wires.outgoing.borrow_mut().push_back((whole, byte as u8));
    }
}

/// The program ran into an instruction that the chip does not have.
unsafe extern "C" fn on_bad_opcode(_signal: *mut ffi::avr_irq_t, _opcode: u32, wires: *mut c_void) {
    // SAFETY: registered with a pointer to `Wires` that outlives the chip.
    let wires = unsafe { &*wires.cast::<Wires>() };
    // SAFETY: simavr asks the hook what to do next through this very field.
    unsafe { (*wires.avr.as_ptr()).state = ffi::cpu_Crashed as i32 };
}

/// Something happened on the two-wire bus.
unsafe extern "C" fn on_twi(_signal: *mut ffi::avr_irq_t, message: u32, wires: *mut c_void) {
    // SAFETY: registered with a pointer to `Wires` that outlives the chip.
    let wires = unsafe { &*wires.cast::<Wires>() };
    let [_, kind, address, data] = message.to_le_bytes();
    let is = |condition: u32| u32::from(kind) & condition != 0;
    let now_s = seconds(wires.now());
    let mut bus = wires.bus.borrow_mut();
    let answer = if is(ffi::TWI_COND_STOP) {
        bus.stop(now_s);
        None
    } else if is(ffi::TWI_COND_START) {
        bus.start(address >> 1, address & 1 == 1, now_s).then_some((ffi::TWI_COND_ACK, 1))
    } else if is(ffi::TWI_COND_WRITE) {
        bus.write(data, now_s).then_some((ffi::TWI_COND_ACK, 1))
    } else if is(ffi::TWI_COND_READ) {
        Some((ffi::TWI_COND_READ, bus.read(now_s)))
    } else {
        None
    };
    drop(bus);
    if let Some((condition, value)) = answer {
        let answer = u32::from_le_bytes([0, condition as u8, address, value]);
        // SAFETY: the unit waits for its answer within this call; its input
        // raises no signal that would come back here.
        unsafe { ffi::avr_raise_irq(wires.twi_input.as_ptr(), answer) };
    }
}
