//! Timer 1: the frame clock, and the ticks of the two-wire bus within a frame.
//!
//! Owns TC1. It counts freely at 2 MHz; each frame moves the compare value on
//! instead of clearing the counter, so interrupt latency never adds up. 16 MHz
//! / 8 / 60 is 33,333 1/3: every third frame is one tick longer, and nothing
//! drifts but the crystal.

use avr_device::atmega328p::{TC1, tc1};
use avr_device::interrupt::{self, CriticalSection, Mutex};
use core::cell::Cell;

use embedded_hal::delay::DelayNs;
use firmware::hal::FrameClock;

/// Ticks of 0.5 us.
pub const TICKS_PER_US: u16 = 2;
/// A frame, but for the third of a tick.
pub const FRAME_TICKS: u16 = 33_333;

static FRAMES: Mutex<Cell<u8>> = Mutex::new(Cell::new(0));
static THIRD: Mutex<Cell<u8>> = Mutex::new(Cell::new(0));

fn registers() -> &'static tc1::RegisterBlock {
    // SAFETY: the registers are there for good; every 16-bit access is made
    // with interrupts off, so their shared high byte is never mixed up.
    unsafe { &*TC1::ptr() }
}

/// The tick count.
pub fn now(_: CriticalSection) -> u16 {
    registers().tcnt1().read().bits()
}

/// Interrupts [`super::twi`] in `ticks`, instead of whatever was to come.
#[inline(always)]
pub fn tick_in(cs: CriticalSection, ticks: u16) {
    set_tick(now(cs).wrapping_add(ticks));
}

/// As [`tick_in`], from the beginning of the frame; for its own handler only.
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

#[avr_device::interrupt(atmega328p)]
fn TIMER1_COMPA() {
    // SAFETY: interrupts are off inside an interrupt, and stay off.
    let cs = unsafe { CriticalSection::new() };
    // First of all: what the servos see is as regular as this line.
    super::twi::start_burst(cs);
    let third = THIRD.borrow(cs);
    let longer = third.get() == 2;
    third.set(if longer { 0 } else { third.get() + 1 });
    let timer = registers();
    let next = timer.ocr1a().read().bits().wrapping_add(FRAME_TICKS).wrapping_add(u16::from(longer));
    timer.ocr1a().write(|w| w.set(next));
    let frames = FRAMES.borrow(cs);
    frames.set(frames.get().saturating_add(1));
}

/// The frame clock.
pub struct Timer(());

impl Timer {
    /// Starts counting; the first frame is one frame away.
    pub fn start() -> Self {
        let timer = registers();
        timer.tccr1a().reset();
        timer.tccr1b().reset();
        timer.tcnt1().write(|w| w.set(0));
        timer.ocr1a().write(|w| w.set(FRAME_TICKS));
        timer.tifr1().write(|w| w.ocf1a().set_bit().ocf1b().set_bit());
        timer.timsk1().write(|w| w.ocie1a().set_bit().ocie1b().set_bit());
        timer.tccr1b().write(|w| w.cs1().prescale_8());
        Self(())
    }
}

impl FrameClock for Timer {
    fn take_frames(&mut self) -> u8 {
        let frames = interrupt::free(|cs| FRAMES.borrow(cs).replace(0));
        if frames > 0 {
            super::stack::age();
        }
        frames
    }

    fn left_us(&mut self) -> u16 {
        let left = interrupt::free(|cs| registers().ocr1a().read().bits().wrapping_sub(now(cs)));
        // Just past the compare value, its interrupt still pending: none left.
        if left > FRAME_TICKS + 1 { 0 } else { left / TICKS_PER_US }
    }
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
