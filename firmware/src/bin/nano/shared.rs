//! A byte that interrupts and the main loop share.
//!
//! Holds one type. An AVR loads and stores a byte in one instruction, so code that
//! only does that needs no critical section; core's atomics have one all the same, 4
//! cycles and two registers each. What is read, changed and written back has one
//! writer, or interrupts off. Does not depend on who shares it.

use core::cell::UnsafeCell;

#[repr(transparent)]
pub struct Shared(UnsafeCell<u8>);

// SAFETY: there is one core, and each access is one instruction that no
// interrupt can divide.
unsafe impl Sync for Shared {}

impl Shared {
    pub const fn new(value: u8) -> Self {
        Self(UnsafeCell::new(value))
    }

    #[inline(always)]
    pub fn get(&self) -> u8 {
        // SAFETY: valid for as long as `self`; volatile, for it changes behind
        // the compiler's back.
        unsafe { self.0.get().read_volatile() }
    }

    /// Writes it, after every access before in the program's order.
    #[inline(always)]
    pub fn set(&self, value: u8) {
        // SAFETY: as above.
        unsafe { self.0.get().write_volatile(value) };
    }
}

/// Two of them as a number, the low byte first; interrupts must be off if they
/// belong to one.
pub fn word(low: &Shared, high: &Shared) -> u16 {
    u16::from_le_bytes([low.get(), high.get()])
}

/// The general-purpose I/O registers, at their I/O addresses: scratch of the
/// handlers written by hand. Nothing else uses them, and no handler is ever
/// interrupted.
pub const GPIOR0: u8 = 0x1E;
/// As [`GPIOR0`].
pub const GPIOR1: u8 = 0x2A;
/// As [`GPIOR0`].
pub const GPIOR2: u8 = 0x2B;
