//! A robot that moves while this program looks on.
//!
//! Holds the telemetry of one walk, the heartbeats that keep the robot walking,
//! and the order to stop with what the robot still reports after it. Does not
//! depend on where the motion comes from: the robot's own gait
//! ([`super::trial`]), or setpoints from this computer ([`super::stream`]).

use crate::device::link::{Incoming, Link, LinkError};
use protocol::{Command, Message, Refusal, State, Telemetry};
use std::io::{Read, Write};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant, UNIX_EPOCH};

/// The slow entry moves 90 degrees in a few seconds; a robot that takes longer hangs.
pub(super) const ENTRY_TIMEOUT: Duration = Duration::from_secs(30);
/// The robot's final counters and the reason of an end arrive within this time after it.
pub(super) const LAST_WORDS: Duration = Duration::from_millis(500);
/// A robot stops by itself after [`protocol::LINK_TIMEOUT_FRAMES`] without a
/// command, 1 s: three of four may get lost.
const HEARTBEAT_EVERY: Duration = Duration::from_millis(250);

/// One telemetry message and when it arrived.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// By this computer's clock.
    pub unix_time_s: f64,
    /// As the robot sent it.
    pub telemetry: Telemetry,
}

/// Follows a walk, and may ask for a change meanwhile.
pub trait Watcher {
    /// A sample arrived; `played` counts gait frames.
    fn progress(&mut self, state: State, played: u32);

    /// The next change to order while the robot walks, if there is one.
    fn requested_change(&mut self) -> Option<Command> {
        None
    }

    /// The robot's answer to a change that was requested; `None` means that it obeys.
    fn answered(&mut self, _change: Command, _refusal: Option<Refusal>) {}
}

impl<F: FnMut(State, u32)> Watcher for F {
    fn progress(&mut self, state: State, played: u32) {
        self(state, played);
    }
}

/// One walk or stream, from before the order to move until the robot is at rest.
pub(super) struct Session<'a, P, W> {
    pub link: &'a mut Link<P>,
    pub watcher: W,
    pub samples: Vec<Sample>,
    stop: &'a AtomicBool,
    last_command: Instant,
}

impl<'a, P: Read + Write, W: Watcher> Session<'a, P, W> {
    /// Discards telemetry of an earlier walk; the robot may then be ordered to move.
    pub fn open(link: &'a mut Link<P>, stop: &'a AtomicBool, watcher: W) -> Result<Self, LinkError> {
        link.order(Command::StreamTelemetry { every_frames: 0 })?;
        while link.next_unasked(Instant::now())?.is_some() {}
        Ok(Self { link, watcher, samples: Vec::new(), stop, last_command: Instant::now() })
    }

    /// Asks for telemetry of every frame.
    pub fn start_telemetry(&mut self) -> Result<(), LinkError> {
        self.link.order(Command::StreamTelemetry { every_frames: 1 })
    }

    /// Asks for no more telemetry; a robot that does not answer sends none anyway.
    pub fn stop_telemetry(&mut self) {
        let _ = self.link.order(Command::StreamTelemetry { every_frames: 0 });
    }

    /// Whether the user wants to end it.
    pub fn is_interrupted(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }

    /// Notes that a command is being sent, which counts as a heartbeat.
    pub fn command_sent(&mut self) {
        self.last_command = Instant::now();
    }

    /// Sends a heartbeat if one is due.
    pub fn keep_alive(&mut self) -> Result<(), LinkError> {
        if self.last_command.elapsed() >= HEARTBEAT_EVERY {
            self.command_sent();
            self.link.status()?;
        }
        Ok(())
    }

    /// The next message before the deadline; telemetry is kept.
    pub fn next(&mut self, deadline: Instant) -> Result<Option<Incoming>, LinkError> {
        let incoming = self.link.next_unasked(deadline)?;
        if let Some(Incoming { at, message: Message::Telemetry(telemetry) }) = incoming {
            let unix_time_s = at.duration_since(UNIX_EPOCH).map_or(0.0, |age| age.as_secs_f64());
            self.samples.push(Sample { unix_time_s, telemetry });
            self.watcher.progress(telemetry.state, telemetry.trial_frames);
        }
        Ok(incoming)
    }

    /// Gait frames played so far, as the robot counts them.
    pub fn played(&self) -> u32 {
        self.samples.last().map_or(0, |sample| sample.telemetry.trial_frames)
    }

    /// Orders the robot to stop, and keeps the telemetry that follows; `immediately` by the
    /// stop byte first, which needs no answer. Whether the robot obeyed: one that cannot be
    /// reached any more stops by itself, for want of heartbeats.
    pub fn stop(&mut self, immediately: bool) -> bool {
        let byte = if immediately { self.link.send_stop_byte() } else { Ok(()) };
        if byte.and_then(|()| self.link.order(Command::Stop)).is_err() {
            return false;
        }
        let deadline = Instant::now() + LAST_WORDS;
        // The first sample after the end does not count the last frame yet.
        let mut rests = 0;
        while rests < 2
            && let Ok(Some(incoming)) = self.next(deadline)
        {
            let is_over = matches!(&incoming.message, Message::Telemetry(telemetry)
                if !matches!(telemetry.state, State::Entering | State::Walking));
            rests += u32::from(is_over);
        }
        true
    }
}
