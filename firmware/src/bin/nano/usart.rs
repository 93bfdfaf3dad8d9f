//! The serial port behind two rings.
//!
//! Owns USART0. Bytes come and go by interrupt; a full receive ring drops
//! the byte, and the frame's CRC tells. The rings are arrays with 8-bit indices
//! instead of `heapless::spsc`, whose 16-bit ones an AVR cannot move in one
//! instruction: an interrupt for every byte has 87 us to spare.

use avr_device::atmega328p::{USART0, usart0};
use avr_device::interrupt::{self, CriticalSection, Mutex};
use core::cell::Cell;

use firmware::hal::SerialRing;

const RING_LEN: usize = 128;
const MASK: u8 = (RING_LEN - 1) as u8;
const _: () = assert!(RING_LEN.is_power_of_two() && RING_LEN <= 128);

/// 16 MHz / (8 * (16 + 1)) = 117,647 baud: 2.1 % fast.
const BAUD_DIVISOR: u16 = 16;

struct Ring {
    bytes: Cell<[u8; RING_LEN]>,
    head: Cell<u8>,
    tail: Cell<u8>,
}

impl Ring {
    const fn new() -> Self {
        Self { bytes: Cell::new([0; RING_LEN]), head: Cell::new(0), tail: Cell::new(0) }
    }

    fn places(&self) -> &[Cell<u8>] {
        let bytes: &Cell<[u8]> = &self.bytes;
        bytes.as_slice_of_cells()
    }

    fn len(&self) -> u8 {
        self.head.get().wrapping_sub(self.tail.get()) & MASK
    }

    #[inline(always)]
    fn push(&self, byte: u8) -> bool {
        let head = self.head.get();
        let next = head.wrapping_add(1) & MASK;
        let has_room = next != self.tail.get();
        if has_room {
            self.places()[usize::from(head & MASK)].set(byte);
            self.head.set(next);
        }
        has_room
    }

    #[inline(always)]
    fn pop(&self) -> Option<u8> {
        let tail = self.tail.get();
        if tail == self.head.get() {
            return None;
        }
        let byte = self.places()[usize::from(tail & MASK)].get();
        self.tail.set(tail.wrapping_add(1) & MASK);
        Some(byte)
    }
}

static RECEIVED: Mutex<Ring> = Mutex::new(Ring::new());
static TO_SEND: Mutex<Ring> = Mutex::new(Ring::new());

fn registers() -> &'static usart0::RegisterBlock {
    // SAFETY: the registers are there for good; UCSR0B is only ever written
    // whole, so interrupt and main loop cannot lose each other's bits.
    unsafe { &*USART0::ptr() }
}

/// Receiver and transmitter on; interrupts for received bytes and, while there
/// is something to send, for the empty transmit register.
fn enable(sending: bool) {
    registers()
        .ucsr0b()
        .write(|w| w.rxen0().set_bit().txen0().set_bit().rxcie0().set_bit().udrie0().bit(sending));
}

#[avr_device::interrupt(atmega328p)]
fn USART_RX() {
    // SAFETY: interrupts are off inside an interrupt, and stay off.
    let cs = unsafe { CriticalSection::new() };
    let byte = registers().udr0().read().bits();
    RECEIVED.borrow(cs).push(byte);
}

#[avr_device::interrupt(atmega328p)]
fn USART_UDRE() {
    // SAFETY: interrupts are off inside an interrupt, and stay off.
    let cs = unsafe { CriticalSection::new() };
    match TO_SEND.borrow(cs).pop() {
        Some(byte) => {
            registers().udr0().write(|w| w.set(byte));
        }
        None => enable(false),
    }
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
    fn read(&mut self) -> Option<u8> {
        interrupt::free(|cs| RECEIVED.borrow(cs).pop())
    }

    fn room(&self) -> usize {
        let len = interrupt::free(|cs| TO_SEND.borrow(cs).len());
        RING_LEN - 1 - usize::from(len)
    }

    fn write(&mut self, byte: u8) {
        interrupt::free(|cs| TO_SEND.borrow(cs).push(byte));
        enable(true);
    }

    fn is_worth_reading(&mut self) -> bool {
        interrupt::free(|cs| RECEIVED.borrow(cs).len()) > 0
    }

    fn take_stop(&mut self) -> bool {
        false
    }

    fn dropped(&self) -> u16 {
        0
    }
}
