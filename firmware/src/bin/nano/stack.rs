//! Paints the free memory, so that the deepest stack can be measured.
//!
//! Holds the pattern and the count. A stack that runs into data is silent on an
//! AVR: the memory between `_end` and the stack has [`PAINT`] in every byte that was
//! never used, and [`left`] and `sim-tests/tests/nano/stack.rs` look for it. Does not
//! depend on what uses the stack.

use core::arch::asm;

use super::shared::{Shared, word};

/// What an unused byte holds.
const PAINT: u8 = 0xC5;

unsafe extern "C" {
    /// First byte after all static data; the linker's.
    static mut _end: u8;
}

/// Paints from the end of the static data to a little below the stack pointer.
#[inline(always)]
pub fn paint() {
    let stack: u16;
    // SAFETY: reads the stack pointer; interrupts are off at start-up.
    unsafe { asm!("in {0:l}, 0x3D", "in {0:h}, 0x3E", out(reg_iw) stack, options(nomem, nostack)) };
    let mut at = &raw mut _end;
    // Calls made while painting stay within the margin.
    while (at as u16) < stack.wrapping_sub(32) {
        // SAFETY: free memory: above the last static, below the stack pointer.
        unsafe {
            at.write_volatile(PAINT);
            at = at.add(1);
        }
    }
}

/// What [`left`] found last, and for how many frames that is new enough.
static LAST: [Shared; 2] = [const { Shared::new(0) }; 2];
static FRESH_FRAMES: Shared = Shared::new(0);
/// Looking takes 0.2 ms, a fifth of what a host can make of a second by asking.
const GOOD_FOR_FRAMES: u8 = 16;

/// Frames have passed since the last call; for the main loop only.
pub fn age() {
    FRESH_FRAMES.set(FRESH_FRAMES.get().saturating_sub(1));
}

/// Bytes above the static data that were never used; for the main loop only.
pub fn left() -> u16 {
    if FRESH_FRAMES.get() == 0 {
        FRESH_FRAMES.set(GOOD_FOR_FRAMES);
        for (place, byte) in LAST.iter().zip(count().to_le_bytes()) {
            place.set(byte);
        }
    }
    word(&LAST[0], &LAST[1])
}

#[inline(never)]
fn count() -> u16 {
    let first = &raw const _end;
    let mut at = first;
    // The loop ends at the latest where the stack of this very call begins.
    // SAFETY: memory between the statics and the stack; volatile, because the
    // compiler sees no code that writes there.
    while unsafe { at.read_volatile() } == PAINT {
        at = at.wrapping_add(1);
    }
    at as u16 - first as u16
}
