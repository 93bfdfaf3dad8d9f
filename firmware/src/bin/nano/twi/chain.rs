//! What interrupts do on the bus within a frame: the burst, then the readings.
//!
//! Holds the order and the deadlines. The frame clock starts the burst, one
//! interrupt a byte carries it on. The second compare of timer 1 ticks from the
//! burst's deadline on through the rest of the frame: a tick that finds a
//! transfer still under way ends it, and then works the bus free, a step a
//! time; every other tick starts a reading, if the bus is free. After a
//! transfer that was ended so, the rest of the frame goes without readings.
//!
//! Nine readings stand 1.85 ms apart, from one frame to the next as well, so
//! that none of the frame counts more than the rest. The last one begins
//! 0.65 ms before the next burst, and takes 0.4 ms.
//!
//! Everything here runs in interrupts, but for [`hand_over`]. Does not depend on
//! the main loop's transfers: it only skips what finds the bus taken.

mod handler;

use avr_device::interrupt::CriticalSection;

use firmware::chips::{PowerSensor, SensorChip, ServoChip, ServoDriver};
use firmware::hal::BurstState;
use firmware::power::READINGS_PER_FRAME;

use super::{
    ADDRESS_R_NACK, ADDRESS_W_NACK, BURST_LEN, BURST_TICKS, DATA_R_NACK, DATA_W_ACK, DATA_W_NACK, FRESH,
    FRONT, HEAD, OUTCOME, OWNER, READING_LEN, READINGS, RING_MASK, TAIL, count_error, free, let_go, owner,
    registers, request_start, send_stop, status,
};
use crate::shared::Shared;
use crate::timer::{self, FRAME_TICKS};

/// Half of the way from one reading to the next.
const TICK_TICKS: u16 = FRAME_TICKS / (2 * READINGS_PER_FRAME as u16);
/// The last tick is the last reading's start.
const TICKS: u8 = 2 * READINGS_PER_FRAME - 1;
/// Between two steps of freeing the bus: the lines need 5 us.
const FREE_TICKS: u16 = 8 * timer::TICKS_PER_US;

// The last reading is over before the next burst.
const _: () =
    assert!(BURST_TICKS + (TICKS as u16 - 1) * TICK_TICKS + 500 * timer::TICKS_PER_US < FRAME_TICKS);

/// What the next START is followed by.
static ADDRESS: Shared = Shared::new(0);
/// The next byte of the bursts to send, or of the ring to fill.
static AT: Shared = Shared::new(0);
/// Where the burst ends.
static END: Shared = Shared::new(0);
/// Ticks of this frame so far.
static TICK: Shared = Shared::new(TICKS);
/// The next step of freeing the bus.
static STEP: Shared = Shared::new(free::BEGIN);
/// A frame started while somebody else had the bus.
static LATE: Shared = Shared::new(0);

/// Starts the frame's burst; the frame interrupt calls it.
#[inline(always)]
pub fn start_burst(cs: CriticalSection<'_>) {
    let user = OWNER.get();
    if user == owner::NOBODY {
        begin_burst();
        TICK.set(0);
        timer::tick_at_frame_plus(cs, BURST_TICKS);
    } else {
        LATE.set(1);
        if user == owner::READING {
            // It hangs, or it would be over.
            timer::tick_in(cs, FREE_TICKS);
        }
    }
    OUTCOME.borrow(cs).set(BurstState::Running);
}

#[inline(always)]
fn begin_burst() {
    request_start();
    OWNER.set(owner::BURST);
    if FRESH.get() != 0 {
        FRESH.set(0);
        FRONT.set(BURST_LEN - FRONT.get());
    }
    let front = FRONT.get();
    ADDRESS.set(ServoChip::ADDRESS << 1);
    AT.set(front);
    END.set(front + BURST_LEN);
}

/// The bus is free: a burst that waited for it begins, and has the frame to itself.
#[inline(never)]
pub fn hand_over(cs: CriticalSection<'_>) {
    OWNER.set(owner::NOBODY);
    if LATE.get() != 0 {
        LATE.set(0);
        begin_burst();
        TICK.set(TICKS);
        timer::tick_in(cs, BURST_TICKS);
    }
}

/// The transfer under way was refused; the bus is free.
#[inline(always)]
fn fail(cs: CriticalSection<'_>) {
    count_error(cs);
    if OWNER.get() == owner::BURST {
        OUTCOME.borrow(cs).set(BurstState::Failed);
    }
    OWNER.set(owner::NOBODY);
}

/// Ends of transfers, good and bad, and their second halves; every other step
/// is the same each time, and [`handler`]'s own.
extern "avr-interrupt" fn step() {
    // SAFETY: interrupts are off inside an interrupt, and stay off.
    let cs = unsafe { CriticalSection::new() };
    match status() {
        // The burst's last byte.
        DATA_W_ACK => {
            send_stop();
            OUTCOME.borrow(cs).set(BurstState::Done);
            OWNER.set(owner::NOBODY);
        }
        // A register's last byte.
        DATA_R_NACK => {
            let at = AT.get();
            if let Some(place) = READINGS.get(usize::from(at)) {
                place.set(registers().twdr().read().bits());
            }
            let next = at + 1;
            if next % READING_LEN != 0 {
                AT.set(next);
                ADDRESS.set(SensorChip::ADDRESS << 1);
                request_start();
            } else {
                send_stop();
                HEAD.set(next & RING_MASK);
                OWNER.set(owner::NOBODY);
            }
        }
        ADDRESS_W_NACK | ADDRESS_R_NACK | DATA_W_NACK => {
            send_stop();
            fail(cs);
        }
        _ => {
            // Something else drives the bus: the next tick ends this.
            let_go();
            timer::tick_in(cs, FREE_TICKS);
        }
    }
}

#[avr_device::interrupt(atmega328p)]
fn TIMER1_COMPB() {
    // SAFETY: interrupts are off inside an interrupt, and stay off.
    let cs = unsafe { CriticalSection::new() };
    let user = OWNER.get();
    if user <= owner::MAIN {
        tick(cs, user);
        return;
    }
    if user != owner::FREEING {
        let_go();
        fail(cs);
        OWNER.set(owner::FREEING);
        STEP.set(free::BEGIN);
        TICK.set(TICKS);
    } else if let Some(next) = free::step(STEP.get()) {
        STEP.set(next);
    } else {
        hand_over(cs);
        return;
    }
    timer::tick_in(cs, FREE_TICKS);
}

/// Starts a reading, if it is time for one and the bus is free.
#[inline(always)]
fn tick(cs: CriticalSection<'_>, user: u8) {
    let tick = TICK.get();
    if tick == TICKS {
        return;
    }
    TICK.set(tick + 1);
    timer::tick_after(cs, TICK_TICKS);
    let head = HEAD.get();
    let has_room = (head + READING_LEN) & RING_MASK != TAIL.get();
    // A STOP may still be on the wire.
    let is_free = user == owner::NOBODY && registers().twcr().read().twsto().bit_is_clear();
    if tick & 1 == 0 && is_free && has_room {
        request_start();
        OWNER.set(owner::READING);
        ADDRESS.set(SensorChip::ADDRESS << 1);
        AT.set(head);
    }
}
