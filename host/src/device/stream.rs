//! Streams setpoints to a robot that plays one a frame.
//!
//! The robot buffers a few poses and says with every reply how many wait, and never
//! gets more than fit. A buffer that runs dry stops the robot, so the order to stop
//! comes first, with the last pose. Does not depend on where the poses come from.

use crate::device::link::{Link, LinkError};
use crate::device::session::{ENTRY_TIMEOUT, LAST_WORDS, Session, Watcher};
use crate::device::trial::{Trial, TrialStop};
use protocol::{
    Angle, Chunk, Command, Event, FRAME_RATE_HZ, JOINT_COUNT, Message, Refusal, Reply, STREAM_CAPACITY,
    State, WalkEnd,
};
use std::io::{Read, Write};
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

/// Eight angles from neutral, in degrees, in [`protocol::Joint::ALL`] order.
pub type PoseDeg = [f64; JOINT_COUNT];

/// One pose a command keeps the buffer fullest. From this round trip on two are sent:
/// an adapter that delays every answer by 16 ms, as FTDI's do, takes at best 60
/// commands a second.
const SLOW_ROUND_TRIP: Duration = Duration::from_millis(9);
/// Share of a new round trip in the mean.
const NEWEST: f64 = 0.25;
/// Between two tries of what found the buffer full.
const RETRY_EVERY: Duration = Duration::from_millis(4);
const FRAME: Duration = Duration::from_nanos(1_000_000_000 / FRAME_RATE_HZ as u64);

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
    let session = Session::open(link, stop, watcher)?;
    let hello = session.link.hello();
    let capacity = usize::from(hello.map_or(STREAM_CAPACITY, |hello| hello.limits.stream_capacity));
    session.link.order(Command::Stream)?;
    let mut stream = Streaming { session, capacity, sent: 0, asked: None };
    let outcome = stream.begin().and_then(|()| stream.send_all(poses)).and_then(|()| stream.drain());
    let Streaming { mut session, .. } = stream;
    if session.stop(outcome.is_err()) {
        session.stop_telemetry();
    }
    Ok(Trial { samples: session.samples, stop: outcome.err() })
}

struct Streaming<'a, P, W> {
    session: Session<'a, P, W>,
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
        self.session.start_telemetry().map_err(broken)
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
            match self.session.link.request(Command::Setpoints { data: chunk(&pending) }) {
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
                    // late, but what it says was true soon after the question.
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
        self.session.command_sent();
        while self.sent > 0 && !self.is_last_playing() {
            if Instant::now() >= deadline {
                return Err(TrialStop::Stuck { frames: self.session.played(), asked: self.asked });
            }
            match self.hear(Instant::now() + FRAME) {
                // All of it was there in time: so much for the last pose.
                Err(TrialStop::Ended { end: WalkEnd::StreamDry, .. }) => return Ok(()),
                outcome => outcome?,
            };
            // A robot that still goes to the first pose depends on its host.
            self.session.keep_alive().map_err(broken)?;
        }
        Ok(())
    }

    fn is_last_playing(&self) -> bool {
        // One pose is live and not counted yet, the next is staged: the last
        // one then plays on, and the order to stop comes before the buffer is dry.
        self.session.samples.last().is_some_and(|sample| {
            sample.telemetry.state != State::Entering && sample.telemetry.trial_frames + 2 >= self.sent
        })
    }

    /// Takes the messages that arrive until the deadline; an end is an error here.
    fn listen(&mut self, deadline: Instant) -> Result<(), TrialStop> {
        while self.hear(deadline)? {}
        Ok(())
    }

    /// Takes one message; whether there was one before the deadline.
    fn hear(&mut self, deadline: Instant) -> Result<bool, TrialStop> {
        if self.session.is_interrupted() {
            return Err(TrialStop::Interrupted);
        }
        let Some(incoming) = self.session.next(deadline).map_err(broken)? else { return Ok(false) };
        match incoming.message {
            Message::Event(Event::Fault(fault)) => Err(TrialStop::Fault { fault }),
            Message::Event(Event::WalkEnded(end)) => {
                Err(TrialStop::of(end, self.session.played(), self.asked))
            }
            _ => Ok(true),
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
