//! Sends setpoints to a robot that plays one a frame.
//!
//! Owns the flow: the robot buffers a few poses, tells with every answer how
//! many, and is never sent more than fit. A buffer that runs dry stops the
//! robot, so this ends it before, with the last pose. Refuses to know where the
//! poses come from.

use crate::device::link::{Heard, Link, LinkError};
use crate::device::trial::{Sample, Trial, TrialStop, Watcher};
use protocol::{
    Angle, Chunk, Command, Event, FRAME_RATE_HZ, JOINT_COUNT, Message, Refusal, Reply, STREAM_CAPACITY,
    State, WalkEnd,
};
use std::io::{Read, Write};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant, UNIX_EPOCH};

/// Eight angles from neutral, in degrees, in [`protocol::Joint::ALL`] order.
pub type PoseDeg = [f64; JOINT_COUNT];

/// One pose a command keeps the buffer fullest; from this round trip on two are
/// sent, for an adapter that holds every answer back for 16 ms, as FTDI's do,
/// takes 60 commands a second at best.
const SLOW_ROUND_TRIP: Duration = Duration::from_millis(9);
/// Share of a new round trip in the mean.
const NEWEST: f64 = 0.25;
/// Between two tries of what found the buffer full.
const RETRY_EVERY: Duration = Duration::from_millis(4);
const FRAME: Duration = Duration::from_nanos(1_000_000_000 / FRAME_RATE_HZ as u64);
/// The slow entry moves 90 degrees in a few seconds; a robot that takes longer hangs.
const ENTRY_TIMEOUT: Duration = Duration::from_secs(30);
/// A robot that hears nothing for a second stops.
const HEARTBEAT_EVERY: Duration = Duration::from_millis(250);
/// What the robot has to say about an end is said within this time.
const LAST_WORDS: Duration = Duration::from_millis(500);

/// Streams `poses` until there are no more, or `stop` is set.
///
/// The trial is returned however it ended; see [`Trial::stop`].
///
/// # Errors
/// [`LinkError`] if the stream could not even begin.
pub fn stream<P: Read + Write>(
    link: &mut Link<P>,
    poses: impl Iterator<Item = PoseDeg>,
    stop: &AtomicBool,
    watcher: impl Watcher,
) -> Result<Trial, LinkError> {
    // Telemetry of before tells of the trial before: none may be under way.
    link.order(Command::StreamTelemetry { every_frames: 0 })?;
    while link.next_unasked(Instant::now())?.is_some() {}
    let capacity = usize::from(link.hello().map_or(STREAM_CAPACITY, |hello| hello.limits.stream_capacity));
    link.order(Command::Stream)?;
    let mut stream = Streaming { link, stop, watcher, samples: Vec::new(), capacity, sent: 0, asked: None };
    let outcome = stream.begin().and_then(|()| stream.send_all(poses)).and_then(|()| stream.drain());
    stream.end(outcome.is_err());
    Ok(Trial { samples: stream.samples, stop: outcome.err() })
}

struct Streaming<'a, P, W> {
    link: &'a mut Link<P>,
    stop: &'a AtomicBool,
    watcher: W,
    samples: Vec<Sample>,
    capacity: usize,
    sent: u32,
    /// Poses in all, once that is known.
    asked: Option<u32>,
}

fn broken(source: LinkError) -> TrialStop {
    TrialStop::Link { source }
}

impl<P: Read + Write, W: Watcher> Streaming<'_, P, W> {
    fn begin(&mut self) -> Result<(), TrialStop> {
        self.link.order(Command::StreamTelemetry { every_frames: 1 }).map_err(broken)
    }

    fn send_all(&mut self, poses: impl Iterator<Item = PoseDeg>) -> Result<(), TrialStop> {
        let mut poses = poses.fuse().peekable();
        let mut taken_at = Instant::now();
        let mut round_trip_s = 0.0;
        let mut pending: Vec<PoseDeg> = Vec::new();
        loop {
            let is_slow = round_trip_s > SLOW_ROUND_TRIP.as_secs_f64();
            let batch = if is_slow { 2.min(self.capacity) } else { 1 };
            pending.extend(poses.by_ref().take(batch.saturating_sub(pending.len())));
            if pending.is_empty() {
                self.asked = Some(self.sent);
                return Ok(());
            }
            let sent_at = Instant::now();
            match self.link.request(Command::Setpoints { data: chunk(&pending) }) {
                Ok(Reply::Buffered(waiting)) => {
                    self.sent += pending.len() as u32;
                    pending.clear();
                    taken_at = sent_at;
                    round_trip_s += NEWEST * (sent_at.elapsed().as_secs_f64() - round_trip_s);
                    if poses.peek().is_none() {
                        // Should the robot run dry from now on, it has played all of it.
                        self.asked = Some(self.sent);
                        return Ok(());
                    }
                    // One pose more than there is room for would be refused. The answer may be
                    // late, what it tells was true soon after the question.
                    let ahead = (usize::from(waiting) + batch).saturating_sub(self.capacity);
                    self.listen(sent_at + FRAME * ahead as u32)?;
                }
                Ok(_) => return Err(broken(LinkError::WrongReply { command: "take setpoints" })),
                Err(LinkError::Refused { refusal: Refusal::StreamFull, .. }) => {
                    if taken_at.elapsed() > ENTRY_TIMEOUT {
                        return Err(TrialStop::Entry);
                    }
                    self.listen(Instant::now() + RETRY_EVERY)?;
                }
                Err(LinkError::Refused { refusal: Refusal::NoStream, command }) => {
                    // The event that says why may be on its way.
                    self.listen(Instant::now() + LAST_WORDS)?;
                    return Err(broken(LinkError::Refused { refusal: Refusal::NoStream, command }));
                }
                Err(source) => return Err(broken(source)),
            }
        }
    }

    /// Waits until the last pose is being played.
    fn drain(&mut self) -> Result<(), TrialStop> {
        let deadline = Instant::now() + ENTRY_TIMEOUT;
        let mut last_asked = Instant::now();
        while self.sent > 0 && !self.is_last_playing() {
            if Instant::now() >= deadline {
                return Err(TrialStop::Stuck { frames: self.played(), asked: self.asked });
            }
            match self.hear(Instant::now() + FRAME) {
                // All of it was there in time: so much for the last pose.
                Err(TrialStop::Ended { end: WalkEnd::StreamDry, .. }) => return Ok(()),
                outcome => outcome?,
            };
            // A robot that still goes to the first pose depends on its host.
            if last_asked.elapsed() > HEARTBEAT_EVERY {
                last_asked = Instant::now();
                self.link.status().map_err(broken)?;
            }
        }
        Ok(())
    }

    fn is_last_playing(&self) -> bool {
        // One pose is live and not counted yet, the next is staged: the last
        // one then plays on, and the order to stop comes before the buffer is dry.
        self.samples.last().is_some_and(|sample| {
            sample.telemetry.state != State::Entering && sample.telemetry.trial_frames + 2 >= self.sent
        })
    }

    /// Ends the stream, and hears out what it came to.
    fn end(&mut self, at_once: bool) {
        if at_once {
            let _ = self.link.send_stop_byte();
        }
        if self.link.order(Command::Stop).is_err() {
            return;
        }
        let deadline = Instant::now() + LAST_WORDS;
        // The first sample after the end does not count the last frame yet.
        let mut rests = 0;
        while rests < 2
            && let Ok(Some(heard)) = self.link.next_unasked(deadline)
        {
            let is_over = matches!(&heard.message, Message::Telemetry(telemetry)
                if !matches!(telemetry.state, State::Entering | State::Walking));
            rests += u32::from(is_over);
            self.keep(&heard);
        }
        let _ = self.link.order(Command::StreamTelemetry { every_frames: 0 });
    }

    fn played(&self) -> u32 {
        self.samples.last().map_or(0, |sample| sample.telemetry.trial_frames)
    }

    fn keep(&mut self, heard: &Heard) {
        if let Message::Telemetry(telemetry) = heard.message {
            let unix_time_s = heard.at.duration_since(UNIX_EPOCH).map_or(0.0, |age| age.as_secs_f64());
            self.samples.push(Sample { unix_time_s, telemetry });
            self.watcher.progress(telemetry.state, telemetry.trial_frames);
        }
    }

    /// Hears what there is until the deadline; an end is an error here.
    fn listen(&mut self, deadline: Instant) -> Result<(), TrialStop> {
        while self.hear(deadline)? {}
        Ok(())
    }

    /// Hears one message; whether there was one before the deadline.
    fn hear(&mut self, deadline: Instant) -> Result<bool, TrialStop> {
        if self.stop.load(Ordering::Relaxed) {
            return Err(TrialStop::Interrupted);
        }
        let Some(heard) = self.link.next_unasked(deadline).map_err(broken)? else { return Ok(false) };
        self.keep(&heard);
        match heard.message {
            Message::Event(Event::Fault(fault)) => Err(TrialStop::Fault { fault }),
            Message::Event(Event::WalkEnded(end)) => Err(self.ended(end)),
            _ => Ok(true),
        }
    }

    fn ended(&self, end: WalkEnd) -> TrialStop {
        match end {
            WalkEnd::Fault(fault) => TrialStop::Fault { fault },
            WalkEnd::LinkLost => TrialStop::LinkLost,
            end => TrialStop::Ended { end, frames: self.played(), asked: self.asked },
        }
    }
}

fn chunk(poses: &[PoseDeg]) -> Chunk {
    let bytes: Vec<u8> =
        poses.iter().flatten().flat_map(|&deg| Angle::from_deg(deg).units().to_le_bytes()).collect();
    Chunk::of(&bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn poses_are_angles_in_256ths_little_endian() {
        let mut pose = [0.0; JOINT_COUNT];
        (pose[0], pose[7]) = (1.5, -10.0);

        let bytes = chunk(&[pose, pose]);

        assert_eq!(bytes.as_slice().len(), 32);
        assert_eq!(bytes.as_slice()[..2], 384_i16.to_le_bytes());
        assert_eq!(bytes.as_slice()[30..], (-2560_i16).to_le_bytes());
    }
}
