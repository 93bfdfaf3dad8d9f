//! What the board shares with simavr's hooks: the bus, the serial line out, the pins' wiring.
//!
//! Holds the state behind shared references only; what changes is in cells. Does
//! not depend on the hooks: those are in [`super::hooks`] and [`super::pins`].

use crate::devices::Bus;
use simavr_ffi as ffi;
use std::cell::{Cell, RefCell};
use std::collections::VecDeque;
use std::ffi::CStr;
use std::ptr::NonNull;

const UCSR0A: usize = 0xC0;
const U2X0: u8 = 0x02;
const UBRR0L: usize = 0xC4;
const UBRR0H: usize = 0xC5;

/// What the servo driver's pin OE is connected to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum OutputEnable {
    /// To ground through the driver board's own resistor, and to nothing else:
    /// outputs are enabled for ever.
    #[default]
    Unwired,
    /// To D4 too: enabled while the Nano is in reset.
    PulledDown,
    /// To D4, and to 5 V through a resistor that wins against the board's own:
    /// a Nano in reset, or in its bootloader, enables nothing.
    PulledUp,
}

/// The peripherals that the wires are soldered to.
pub(super) struct Units {
    pub twi: NonNull<ffi::avr_twi_t>,
    pub uart: NonNull<ffi::avr_uart_t>,
    pub uart_input: NonNull<ffi::avr_irq_t>,
    pub twi_input: NonNull<ffi::avr_irq_t>,
    pub uart_output: NonNull<ffi::avr_irq_t>,
    pub twi_output: NonNull<ffi::avr_irq_t>,
    pub pins_read: NonNull<ffi::avr_irq_t>,
    pub pins_turned: NonNull<ffi::avr_irq_t>,
    pub port_d_read: NonNull<ffi::avr_irq_t>,
    pub port_d_turned: NonNull<ffi::avr_irq_t>,
    pub port_d_set: NonNull<ffi::avr_irq_t>,
    pub bad_opcode: NonNull<ffi::avr_irq_t>,
}

/// State shared between the board and simavr's hooks.
pub(super) struct Wires {
    pub avr: NonNull<ffi::avr_t>,
    pub uart: NonNull<ffi::avr_uart_t>,
    pub twi_input: NonNull<ffi::avr_irq_t>,
    /// Our cycle at which simavr's clock was last zero.
    base: Cell<u64>,
    pub bus: RefCell<Bus>,
    /// Bytes on their way out: when each is whole, and what it is.
    pub outgoing: RefCell<VecDeque<(u64, u8)>>,
    pub outgoing_free: Cell<u64>,
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
