//! The frame clock: 60 frames a second on timer 1's first compare.
//!
//! Holds the frame interrupt and the count of frames that the main loop has not
//! taken yet. Each frame moves the compare value on instead of clearing the
//! counter, so interrupt latency never adds up. 16 MHz / 8 / 60 is 33,333 1/3
//! ticks: every third frame is one tick longer, and nothing drifts but the
//! crystal. Does not depend on what a frame does beyond starting its burst.

use avr_device::interrupt::{self, CriticalSection, Mutex};
use core::cell::Cell;

use firmware::hal::FrameClock;

use super::timer::{FRAME_TICKS, TICKS_PER_US, now, registers};

/// Frames that have started since the main loop asked last.
static FRAMES: Mutex<Cell<u8>> = Mutex::new(Cell::new(0));
/// Thirds of a tick that the frames so far are short of.
static THIRD: Mutex<Cell<u8>> = Mutex::new(Cell::new(0));

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

/// Timer 1, started.
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
