//! What embedded-hal lacks: frames, a prepared burst, a serial ring, memory, a watchdog, a light.
//!
//! Owns the line between logic and board. Nothing here may wait without a
//! bound; where a call can take longer than a few microseconds, it says so.

use embedded_hal::delay::DelayNs;
use embedded_hal::i2c::I2c;

use crate::servos::ServoBurst;

/// The frame timer, 60 frames a second without drift.
pub trait FrameClock {
    /// Frame starts since the last call; more than 1 means that one was missed.
    fn take_frames(&mut self) -> u8;

    /// Time left to the next frame start.
    fn left_us(&mut self) -> u16;
}

/// How the burst of this frame went.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BurstState {
    /// On the wire; it ends or is aborted within the board's deadline.
    Running,
    /// The chip acknowledged every byte.
    Done,
    /// Refused, or aborted at the deadline; the bus may be stuck.
    Failed,
}

/// The I2C bus with a burst that the frame timer starts by itself.
///
/// Transactions through [`I2c`] end within 2.5 ms, whatever hangs on the bus:
/// half of it may pass until the burst is over.
pub trait Bus: I2c {
    /// Hands over what the servos get at the next frame start.
    ///
    /// Without a new burst a frame repeats the one before.
    fn stage(&mut self, burst: &ServoBurst);

    /// How this frame's burst went.
    fn burst(&mut self) -> BurstState;

    /// Clocks a stuck chip free and starts over; takes 0.2 ms once the burst is
    /// over.
    fn recover(&mut self);
}

/// The serial port behind its two rings.
pub trait SerialRing {
    /// The oldest byte received.
    fn read(&mut self) -> Option<u8>;

    /// Bytes that [`Self::write`] can take now.
    fn room(&self) -> usize;

    /// Queues one byte; lost if there is no room, so ask first.
    fn write(&mut self, byte: u8);
}

/// Memory that survives power-off; one byte at a time, each taking milliseconds.
pub trait PersistentMemory {
    /// Whether the last write is still going on; nothing may be read meanwhile.
    fn is_busy(&self) -> bool;

    /// The byte at `at`.
    fn read(&mut self, at: u16) -> u8;

    /// Starts writing one byte, and returns at once.
    fn write(&mut self, at: u16, byte: u8);
}

/// What resets the board when the main loop hangs.
pub trait Watchdog {
    /// Called from the main loop only; `servos_on` is remembered through a reset.
    fn feed(&mut self, servos_on: bool);
}

/// The light on the board.
pub trait Light {
    /// Switches it on or off.
    fn set(&mut self, on: bool);
}

/// A board: one of each.
pub trait Board {
    /// The bus with both chips.
    type Bus: Bus;
    /// The frame timer.
    type Clock: FrameClock;
    /// Waits of microseconds, where a chip asks for them.
    type Delay: DelayNs;
    /// The port to the host.
    type Serial: SerialRing;
    /// Where the gait is kept.
    type Memory: PersistentMemory;
    /// What watches the main loop.
    type Watchdog: Watchdog;
    /// What shows the state without a host.
    type Light: Light;

    /// The bus with both chips.
    fn bus(&mut self) -> &mut Self::Bus;
    /// The frame timer.
    fn clock(&mut self) -> &mut Self::Clock;
    /// Waits of microseconds; a value of its own, because the bus is in use meanwhile.
    fn delay(&self) -> Self::Delay;
    /// The port to the host.
    fn serial(&mut self) -> &mut Self::Serial;
    /// Where the gait is kept.
    fn memory(&mut self) -> &mut Self::Memory;
    /// What watches the main loop.
    fn watchdog(&mut self) -> &mut Self::Watchdog;
    /// What shows the state without a host.
    fn light(&mut self) -> &mut Self::Light;
}
