//! What embedded-hal lacks: frames, bursts and readings by interrupt, a serial ring, memory, a panel.
//!
//! Holds the traits between logic and board. Nothing here may wait without a
//! bound; where a call can take longer than a few microseconds, it says so. Does
//! not depend on any chip's registers, nor on the processor.

use embedded_hal::delay::DelayNs;
use embedded_hal::i2c::I2c;

use protocol::gait::Product;

use crate::chips::{Reading, ServoBurst};

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
    /// Refused, or aborted at the deadline.
    Failed,
}

/// The servo driver's side of the bus: a burst that the board sends by itself.
pub trait ServoOutput {
    /// Hands over what the servos get at the next frame start.
    ///
    /// Without a new burst a frame repeats the one before.
    fn stage(&mut self, burst: &ServoBurst);

    /// How this frame's burst went.
    fn burst(&mut self) -> BurstState;
}

/// The power sensor's side of the bus: readings that the board takes by itself.
pub trait PowerReadings {
    /// Readings that wait for [`Self::take_reading`]; 7 at most, then some are lost.
    fn readings(&self) -> u8;

    /// The oldest reading that was not taken yet.
    ///
    /// The board makes [`READINGS_PER_FRAME`], evenly, and fewer where the bus was
    /// in use or the sensor did not answer.
    ///
    /// [`READINGS_PER_FRAME`]: crate::power::READINGS_PER_FRAME
    fn take_reading(&mut self) -> Option<Reading>;
}

/// The serial port behind its two rings.
pub trait SerialRing {
    /// Whether there is a frame's end, or a good many bytes, to read: until
    /// then the main loop has better things to do.
    fn is_worth_reading(&mut self) -> bool;

    /// Takes what was received, oldest first; what is not asked for stays.
    fn received(&mut self) -> impl Iterator<Item = u8>;

    /// Bytes that can be queued now.
    fn room(&self) -> u8;

    /// Writes a byte behind what is queued, and `at` bytes more; `at` is less
    /// than [`Self::room`].
    fn place(&mut self, at: u8, byte: u8);

    /// Queues the first `len` bytes placed.
    fn send(&mut self, len: u8);

    /// Whether the stop byte came since the last call, in or between frames.
    fn take_stop(&mut self) -> bool;

    /// Received bytes that were lost: a full ring, or a receiver read too late.
    fn dropped(&self) -> u16;
}

/// Memory that survives power-off; one byte at a time, each taking milliseconds.
pub trait PersistentMemory {
    /// Whether the last write is still going on; nothing may be read meanwhile.
    fn is_busy(&self) -> bool;

    /// The byte at `at`.
    fn read(&mut self, at: u16) -> u8;

    /// Starts writing one byte, and returns immediately.
    fn write(&mut self, at: u16, byte: u8);
}

/// What resets the board when the main loop hangs.
pub trait Watchdog {
    /// Called from the main loop only; `servos_on` is remembered through a reset.
    fn feed(&mut self, servos_on: bool);
}

/// What a person sees and touches, and the servos' common switch.
pub trait Panel {
    /// Switches the light on or off.
    fn light(&mut self, on: bool);

    /// Whether the start button is held down; the caller waits out its bounces.
    fn is_button_pressed(&mut self) -> bool;

    /// Lets pulses out of the servo driver, where its `/OE` is wired at all.
    fn enable_outputs(&mut self, on: bool);
}

/// A board: one of each.
pub trait Board {
    /// The two-wire bus for the main loop's own transfers.
    ///
    /// They end within 3 ms, whatever is connected: half of it may pass until the
    /// frame's burst is over. A transfer that did not end leaves a bus that has
    /// been clocked free.
    type I2c: I2c;
    /// Where the servos' pulses go.
    type Servos: ServoOutput;
    /// Where the power sensor's readings come from.
    type Sensor: PowerReadings;
    /// How its processor multiplies.
    type Product: Product;
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
    type Panel: Panel;

    /// For transfers of the main loop's own.
    fn i2c(&mut self) -> &mut Self::I2c;
    /// Where a frame's burst is handed over.
    fn servos(&mut self) -> &mut Self::Servos;
    /// Where a frame's readings are taken.
    fn sensor(&mut self) -> &mut Self::Sensor;
    /// Where a frame is noticed.
    fn clock(&mut self) -> &mut Self::Clock;
    /// Waits of microseconds; a separate value, because the bus is borrowed meanwhile.
    fn delay(&self) -> Self::Delay;
    /// The port to the host.
    fn serial(&mut self) -> &mut Self::Serial;
    /// Where the gait is kept.
    fn memory(&mut self) -> &mut Self::Memory;
    /// What watches the main loop.
    fn watchdog(&mut self) -> &mut Self::Watchdog;
    /// What shows the state without a host.
    fn panel(&mut self) -> &mut Self::Panel;
    /// Bus transfers of any kind that failed since the start.
    fn bus_errors(&self) -> u16;
    /// Bytes between static memory and the deepest stack so far.
    fn stack_left(&self) -> u16;
}
