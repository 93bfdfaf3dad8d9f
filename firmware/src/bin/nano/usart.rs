//! The serial port behind two rings.
//!
//! Holds the registers of USART0. Bytes come and go by interrupt; a full receive
//! ring drops the byte, and the frame's CRC tells. The stop byte goes past the
//! ring: it works however much waits there. The rings are arrays with 8-bit
//! indices instead of `heapless::spsc`, whose 16-bit ones an AVR cannot move in
//! one instruction: an interrupt for every byte has 87 us to spare. Each index
//! has one writer, so neither side has to hold off the other. Does not depend on
//! what the bytes mean, but for the stop byte and the end of a frame.

mod handlers;

use avr_device::atmega328p::{USART0, usart0};
use avr_device::interrupt;

use super::shared::{Shared, word};
use firmware::hal::SerialRing;

/// The longest turn of the main loop under a flood is 3 ms: 35 bytes. Committing a
/// gait takes 7 ms, but then the host waits for the answer.
const RECEIVED_LEN: usize = 64;
/// A long answer and a telemetry frame.
const TO_SEND_LEN: usize = 128;
/// Bytes that are worth reading without the end of a frame among them.
const MANY: u8 = RECEIVED_LEN as u8 / 2;

/// 16 MHz / (8 * (16 + 1)) = 117,647 baud: 2.1 % fast.
const BAUD_DIVISOR: u16 = 16;

/// One side pushes, the other pops; one place always stays empty.
#[repr(C)]
struct Ring<const LEN: usize> {
    bytes: [Shared; LEN],
    head: Shared,
    tail: Shared,
}

impl<const LEN: usize> Ring<LEN> {
    const MASK: u8 = {
        assert!(LEN.is_power_of_two() && LEN <= 128);
        (LEN - 1) as u8
    };

    const fn new() -> Self {
        Self { bytes: [const { Shared::new(0) }; LEN], head: Shared::new(0), tail: Shared::new(0) }
    }

    fn len(&self) -> u8 {
        self.head.get().wrapping_sub(self.tail.get()) & Self::MASK
    }

    /// The place at `index`, which is always within.
    #[inline(always)]
    fn place(&self, index: u8) -> &Shared {
        &self.bytes[usize::from(index & Self::MASK)]
    }
}

static RECEIVED: Ring<RECEIVED_LEN> = Ring::new();
static TO_SEND: Ring<TO_SEND_LEN> = Ring::new();
/// Ends of frames among the bytes received: put in by the interrupt, and taken
/// out by the main loop.
static ENDS_IN: Shared = Shared::new(0);
static ENDS_OUT: Shared = Shared::new(0);
/// Whether the stop byte came.
static STOPPED: Shared = Shared::new(0);
/// Bytes lost, low and high.
static DROPPED: [Shared; 2] = [const { Shared::new(0) }; 2];

fn registers() -> &'static usart0::RegisterBlock {
    // SAFETY: the registers are there for good; UCSR0B is only ever written
    // whole, so interrupt and main loop cannot lose each other's bits.
    unsafe { &*USART0::ptr() }
}

/// UCSR0B: receiver and transmitter on, an interrupt for every byte received.
const RECEIVE_ONLY: u8 = 0b1001_1000;

/// As [`RECEIVE_ONLY`], and an interrupt for the empty transmit register while
/// there is something to send.
fn enable(sending: bool) {
    registers()
        .ucsr0b()
        .write(|w| w.rxen0().set_bit().txen0().set_bit().rxcie0().set_bit().udrie0().bit(sending));
}

/// The port to the host.
pub struct Usart(());

impl Usart {
    /// 115,200 baud, 8 data bits, no parity, 1 stop bit.
    pub fn start() -> Self {
        let usart = registers();
        usart.ubrr0().write(|w| w.set(BAUD_DIVISOR));
        usart.ucsr0a().write(|w| w.u2x0().set_bit());
        usart.ucsr0c().write(|w| w.ucsz0().chr8());
        enable(false);
        Self(())
    }
}

impl SerialRing for Usart {
    fn is_worth_reading(&mut self) -> bool {
        ENDS_IN.get() != ENDS_OUT.get() || RECEIVED.len() >= MANY
    }

    fn received(&mut self) -> impl Iterator<Item = u8> {
        let head = RECEIVED.head.get();
        let mut tail = RECEIVED.tail.get();
        core::iter::from_fn(move || {
            if tail == head {
                return None;
            }
            let byte = RECEIVED.place(tail).get();
            tail = tail.wrapping_add(1) & Ring::<RECEIVED_LEN>::MASK;
            RECEIVED.tail.set(tail);
            if byte == 0 {
                ENDS_OUT.set(ENDS_OUT.get().wrapping_add(1));
            }
            Some(byte)
        })
    }

    fn room(&self) -> u8 {
        Ring::<TO_SEND_LEN>::MASK - TO_SEND.len()
    }

    fn place(&mut self, at: u8, byte: u8) {
        TO_SEND.place(TO_SEND.head.get().wrapping_add(at)).set(byte);
    }

    fn send(&mut self, len: u8) {
        TO_SEND.head.set(TO_SEND.head.get().wrapping_add(len) & Ring::<TO_SEND_LEN>::MASK);
        enable(true);
    }

    fn take_stop(&mut self) -> bool {
        // One that comes in between is the same stop.
        let is_stopped = STOPPED.get() != 0;
        if is_stopped {
            STOPPED.set(0);
        }
        is_stopped
    }

    fn dropped(&self) -> u16 {
        interrupt::free(|_| word(&DROPPED[0], &DROPPED[1]))
    }
}
