//! One servo that is moved on its own, all others being limp.
//!
//! Holds the repeated commands, without which the robot lets go after a second, and
//! moves from one pulse to another in small steps. Does not depend on the questions.

use crate::calibration::PULSE_RANGE_US;
use crate::device::link::ports::SerialLink;
use crate::device::link::{Link, LinkError};
use protocol::Command;
use std::io::{Read, Write};
use std::time::Duration;

/// A robot lets go after a second; three of four pulses may get lost.
pub const HEARTBEAT_EVERY: Duration = Duration::from_millis(250);
/// Largest step of a move, in microseconds: some 2 degrees, each taking a request's 10 ms.
const STEP_US: f64 = 14.0;

/// A servo that is being moved.
#[derive(Debug)]
pub struct Servo<'a, P = Box<dyn serialport::SerialPort>> {
    link: &'a mut Link<P>,
    channel: u8,
    count_us: f64,
    counts: u16,
}

/// A servo of a robot on a serial port.
pub type SerialServo<'a> = Servo<'a>;

impl<'a, P: Read + Write> Servo<'a, P> {
    /// Switches a servo on; it jumps to `pulse_us` from wherever it is.
    ///
    /// # Errors
    /// A [`LinkError`]: the robot moves, is in a fault, or is gone.
    pub fn on(link: &'a mut Link<P>, channel: u8, count_us: f64, pulse_us: f64) -> Result<Self, LinkError> {
        let mut servo = Self { link, channel, count_us, counts: 0 };
        servo.counts = servo.counts_of(pulse_us);
        servo.repeat()?;
        Ok(servo)
    }

    /// The pulse that it gets.
    pub fn pulse_us(&self) -> f64 {
        f64::from(self.counts) * self.count_us
    }

    /// The same in counts of the PWM.
    pub const fn counts(&self) -> u16 {
        self.counts
    }

    /// Keeps it on.
    pub fn repeat(&mut self) -> Result<(), LinkError> {
        self.link.order(Command::Nudge { channel: self.channel, counts: self.counts })
    }

    /// Moves by so many counts, within what servos take.
    pub fn step(&mut self, counts: i32) -> Result<(), LinkError> {
        let target_us = (f64::from(self.counts) + f64::from(counts)) * self.count_us;
        self.glide(target_us)
    }

    /// Moves there in small steps.
    pub fn glide(&mut self, pulse_us: f64) -> Result<(), LinkError> {
        let target = self.counts_of(pulse_us);
        let step = ((STEP_US / self.count_us) as u16).max(1);
        while self.counts != target {
            self.counts = if target > self.counts {
                target.min(self.counts + step)
            } else {
                target.max(self.counts - step)
            };
            self.repeat()?;
        }
        self.repeat()
    }

    /// Lets it go limp.
    pub fn off(self) -> Result<(), LinkError> {
        self.link.order(Command::Nudge { channel: self.channel, counts: 0 })
    }

    fn counts_of(&self, pulse_us: f64) -> u16 {
        let (shortest, longest) = PULSE_RANGE_US;
        let longest = longest.min(f64::from(protocol::calibration::MAX_COUNTS) * self.count_us);
        (pulse_us.clamp(shortest, longest) / self.count_us).round() as u16
    }
}

/// Switches the servo off; a robot that cannot be reached does so itself after a second.
pub fn let_go(link: &mut SerialLink, channel: u8) {
    let _ = link.order(Command::Nudge { channel, counts: 0 });
}
