//! What simavr calls: the two-wire bus and the serial line out; pins are in
//! [`super::pins`].
//!
//! Owns the state that hooks share with [`super::Nano`]. Hooks get a shared
//! reference only; what changes is in cells.

use super::pins::{self, OutputEnable};
use super::{CLOCK_HZ, seconds};
use crate::devices::Bus;
use simavr_ffi as ffi;
use std::cell::{Cell, RefCell};
use std::collections::VecDeque;
use std::ffi::{CStr, c_void};
use std::ptr::NonNull;

const UCSR0A: usize = 0xC0;
const U2X0: u8 = 0x02;
const UBRR0L: usize = 0xC4;
const UBRR0H: usize = 0xC5;
/// The peripherals that the wires are soldered to.
pub(super) struct Units {
    pub twi: NonNull<ffi::avr_twi_t>,
    pub uart: NonNull<ffi::avr_uart_t>,
    pub uart_input: NonNull<ffi::avr_irq_t>,
    pub twi_input: NonNull<ffi::avr_irq_t>,
    uart_output: NonNull<ffi::avr_irq_t>,
    twi_output: NonNull<ffi::avr_irq_t>,
    pins_read: NonNull<ffi::avr_irq_t>,
    pins_turned: NonNull<ffi::avr_irq_t>,
    port_d_read: NonNull<ffi::avr_irq_t>,
    port_d_turned: NonNull<ffi::avr_irq_t>,
    port_d_set: NonNull<ffi::avr_irq_t>,
    bad_opcode: NonNull<ffi::avr_irq_t>,
}

/// State shared between the board and simavr's hooks.
pub(super) struct Wires {
    pub avr: NonNull<ffi::avr_t>,
    uart: NonNull<ffi::avr_uart_t>,
    twi_input: NonNull<ffi::avr_irq_t>,
    /// Our cycle at which simavr's clock was last zero.
    base: Cell<u64>,
    pub bus: RefCell<Bus>,
    /// Bytes on their way out: when each is whole, and what it is.
    outgoing: RefCell<VecDeque<(u64, u8)>>,
    outgoing_free: Cell<u64>,
    /// The button to ground is pressed.
    pub button: Cell<bool>,
    pub output_enable: Cell<OutputEnable>,
}

impl Wires {
    pub fn new(
        avr: NonNull<ffi::avr_t>,
        uart: NonNull<ffi::avr_uart_t>,
        twi_input: NonNull<ffi::avr_irq_t>,
        bus: Bus,
    ) -> Self {
        Self {
            avr,
            uart,
            twi_input,
            base: Cell::new(0),
            bus: RefCell::new(bus),
            outgoing: RefCell::default(),
            outgoing_free: Cell::new(0),
            button: Cell::new(false),
            output_enable: Cell::new(OutputEnable::Unwired),
        }
    }

    pub fn now(&self) -> u64 {
        // SAFETY: `avr` outlives its wires, and this thread is the only one.
        self.base.get() + unsafe { (*self.avr.as_ptr()).cycle }
    }

    pub fn base(&self) -> u64 {
        self.base.get()
    }

    /// simavr's clock is zero at this cycle of ours.
    pub fn set_base(&self, cycle: u64) {
        self.base.set(cycle);
    }

    /// Lets time pass without the program.
    pub fn skip(&self, cycles: u64) {
        self.base.set(self.base.get() + cycles);
    }

    /// Cycles of one bit as the serial unit is set up.
    pub fn bit_cycles(&self) -> u64 {
        // SAFETY: the registers lie within the data space of 0x900 bytes.
        let [status, low, high] =
            unsafe { [UCSR0A, UBRR0L, UBRR0H].map(|register| *(*self.avr.as_ptr()).data.add(register)) };
        let divider = u64::from(u16::from_le_bytes([low, high & 0x0F])) + 1;
        divider * if status & U2X0 == 0 { 16 } else { 8 }
    }

    /// Bytes that are whole by now.
    pub fn take_outgoing(&self) -> Vec<(u64, u8)> {
        let mut outgoing = self.outgoing.borrow_mut();
        let now = self.now();
        let whole = outgoing.iter().take_while(|(cycle, _)| *cycle <= now).count();
        outgoing.drain(..whole).collect()
    }

    /// A reset cuts off what is still being sent.
    pub fn cut_outgoing(&self) {
        self.cut_outgoing_at(self.now());
    }

    /// As [`Self::cut_outgoing`], at a cycle that the clock no longer shows.
    pub fn cut_outgoing_at(&self, now: u64) {
        self.outgoing.borrow_mut().retain(|(cycle, _)| *cycle <= now);
        self.outgoing_free.set(now);
    }
}

/// Finds the units of an initialised chip.
///
/// # Safety
/// `avr` is initialised and alive.
pub(super) unsafe fn find_units(avr: NonNull<ffi::avr_t>) -> Option<Units> {
    let unit = |kind: &CStr| {
        // SAFETY: simavr links its units in a list that ends with null; each
        // has a C string for its kind.
        unsafe {
            let mut unit = (*avr.as_ptr()).io_port;
            while !unit.is_null() && CStr::from_ptr((*unit).kind) != kind {
                unit = (*unit).next;
            }
            NonNull::new(unit)
        }
    };
    let signal = |name: [u8; 4], index: u32| {
        // SAFETY: `avr` is initialised; an unknown name gives null.
        NonNull::new(unsafe {
            ffi::avr_io_getirq(avr.as_ptr(), u32::from_be_bytes(name), index as std::ffi::c_int)
        })
    };
    // The unit's header is the first field of either structure.
    let uart: NonNull<ffi::avr_uart_t> = unit(c"uart")?.cast();
    let twi: NonNull<ffi::avr_twi_t> = unit(c"twi")?.cast();
    Some(Units {
        twi,
        uart,
        uart_input: signal(*b"uar0", ffi::UART_IRQ_INPUT)?,
        uart_output: signal(*b"uar0", ffi::UART_IRQ_OUTPUT)?,
        twi_input: signal(*b"twi\0", ffi::TWI_IRQ_INPUT)?,
        twi_output: signal(*b"twi\0", ffi::TWI_IRQ_OUTPUT)?,
        pins_read: signal(*b"iogC", ffi::IOPORT_IRQ_REG_PIN)?,
        pins_turned: signal(*b"iogC", ffi::IOPORT_IRQ_DIRECTION_ALL)?,
        port_d_read: signal(*b"iogD", ffi::IOPORT_IRQ_REG_PIN)?,
        port_d_turned: signal(*b"iogD", ffi::IOPORT_IRQ_DIRECTION_ALL)?,
        port_d_set: signal(*b"iogD", ffi::IOPORT_IRQ_REG_PORT)?,
        // SAFETY: `avr` is initialised, and this is one of the core's own.
        bad_opcode: NonNull::new(unsafe {
            ffi::avr_get_core_irq(avr.as_ptr(), ffi::AVR_CORE_BAD_OPCODE as std::ffi::c_int)
        })?,
    })
}

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
