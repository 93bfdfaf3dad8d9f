//! Timer 1 as a clock: its ticks, and the second compare that times the two-wire bus.
//!
//! Holds the registers of TC1, which counts freely at 2 MHz. Does not depend on
//! what its interrupts do: the first compare is [`super::frame_clock`]'s, the
//! second [`super::twi`]'s.

use avr_device::atmega328p::{TC1, tc1};
use avr_device::interrupt::CriticalSection;

use embedded_hal::delay::DelayNs;

/// Ticks of 0.5 us.
pub const TICKS_PER_US: u16 = 2;
/// A frame, but for the third of a tick that [`super::frame_clock`] makes up for.
pub const FRAME_TICKS: u16 = 33_333;

pub(super) fn registers() -> &'static tc1::RegisterBlock {
    // SAFETY: the registers are there for good; every 16-bit access is made
    // with interrupts off, so their shared high byte is never mixed up.
    unsafe { &*TC1::ptr() }
}

/// The counter; it wraps every 32.8 ms.
pub fn now(_: CriticalSection) -> u16 {
    registers().tcnt1().read().bits()
}

/// Interrupts [`super::twi`] in `ticks`, in place of a tick that was set before.
#[inline(always)]
pub fn tick_in(cs: CriticalSection, ticks: u16) {
    set_tick(now(cs).wrapping_add(ticks));
}

/// As [`tick_in`], from the beginning of the frame; only within the frame interrupt.
#[inline(always)]
pub fn tick_at_frame_plus(_: CriticalSection, ticks: u16) {
    set_tick(registers().ocr1a().read().bits().wrapping_add(ticks));
}

/// As [`tick_in`], from the last tick.
#[inline(always)]
pub fn tick_after(_: CriticalSection, ticks: u16) {
    set_tick(registers().ocr1b().read().bits().wrapping_add(ticks));
}

#[inline(always)]
fn set_tick(at: u16) {
    let timer = registers();
    timer.ocr1b().write(|w| w.set(at));
    // A compare match from before is not this tick's; flags clear by writing 1.
    timer.tifr1().write(|w| w.ocf1b().set_bit());
}

/// Counts cycles; interrupts make it longer.
pub struct Delay;

impl DelayNs for Delay {
    fn delay_ns(&mut self, ns: u32) {
        // 62.5 ns a cycle, that is 1/64 + 1/2560 of a nanosecond; rounded up, and
        // without a division.
        avr_device::asm::delay_cycles((ns >> 6) + (ns >> 11) + 1);
    }

    fn delay_us(&mut self, us: u32) {
        avr_device::asm::delay_cycles(us << 4);
    }
}
