//! Looks on while the robot walks, and keeps it walking.
//!
//! Owns the heartbeats and the judgement of everything that the robot says
//! meanwhile. Refuses to wait for a robot whose trial does not move on.

use super::{ENTRY_TIMEOUT, LAST_WORDS, LOOK_EVERY, Sample, TrialStop, Watcher, unix_time_s};
use crate::device::link::{Link, LinkError};
use protocol::{Command, Event, Message, State, Telemetry, WalkEnd};
use std::io::{Read, Write};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Without telemetry for this long the robot is asked how it is.
const SILENCE: Duration = Duration::from_secs(2);
/// A robot stops by itself after [`protocol::LINK_TIMEOUT_FRAMES`] without a
/// command, 1 s: three of four may get lost.
const HEARTBEAT_EVERY: Duration = Duration::from_millis(250);
/// A walk that counts no frame for this long will not count another.
const STALL: Duration = Duration::from_secs(5);

/// Returns when all frames are played, or with what came between.
pub(super) fn follow<P: Read + Write>(
    link: &mut Link<P>,
    samples: &mut Vec<Sample>,
    frames: Option<u32>,
    stop: &AtomicBool,
    watcher: &mut impl Watcher,
) -> Result<(), TrialStop> {
    let broken = |source| TrialStop::Link { source };
    let begin = Instant::now();
    let mut moved_on = None;
    // Why it is over, and since when: the counters of its last frame are still on their way.
    let mut end: Option<(WalkEnd, Instant)> = None;
    let mut last_heard = begin;
    let mut last_asked = begin;
    loop {
        if stop.load(Ordering::Relaxed) {
            return Err(TrialStop::Interrupted);
        }
        if let Some((reason, since)) = end
            && since.elapsed() > LAST_WORDS
        {
            return Err(ended(reason, samples, frames));
        }
        let played = samples.last().map_or(0, |s| s.telemetry.trial_frames);
        match moved_on {
            None if begin.elapsed() > ENTRY_TIMEOUT => return Err(TrialStop::Entry),
            Some(moved_on) if Instant::now().duration_since(moved_on) > STALL => {
                return Err(TrialStop::Stuck { frames: played, asked: frames });
            }
            _ => {}
        }
        if last_heard.elapsed() > SILENCE {
            // Either it is gone, which the error tells, or its stream was lost with a reset of the setting.
            link.status().map_err(broken)?;
            link.order(Command::StreamTelemetry { every_frames: 1 }).map_err(broken)?;
            last_heard = Instant::now();
        }
        if last_asked.elapsed() >= HEARTBEAT_EVERY {
            last_asked = Instant::now();
            link.status().map_err(broken)?;
        }
        if let Some(wish) = watcher.wish() {
            last_asked = Instant::now();
            match link.order(wish) {
                Ok(()) => watcher.granted(wish, None),
                Err(LinkError::Refused { refusal, .. }) => watcher.granted(wish, Some(refusal)),
                Err(source) => return Err(TrialStop::Link { source }),
            }
        }
        let Some(heard) = link.next_unasked(Instant::now() + LOOK_EVERY).map_err(broken)? else { continue };
        last_heard = Instant::now();
        match heard.message {
            Message::Event(Event::Fault(fault)) => end = Some((WalkEnd::Fault(fault), last_heard)),
            // What was asked for is seen by its counters.
            Message::Event(Event::WalkEnded(WalkEnd::Finished)) => {}
            Message::Event(Event::WalkEnded(reason)) => end = Some((reason, last_heard)),
            Message::Telemetry(telemetry) => {
                samples.push(Sample { unix_time_s: unix_time_s(&heard), telemetry });
                watcher.progress(telemetry.state, telemetry.trial_frames);
                // A robot that was told to pause holds, and counts nothing.
                if telemetry.trial_frames > played
                    || (moved_on.is_some() && telemetry.state == State::Holding)
                {
                    moved_on = Some(last_heard);
                }
                if let Some((reason, _)) = end {
                    return Err(ended(reason, samples, frames));
                }
                if is_over(&telemetry, frames)? {
                    return Ok(());
                }
            }
            _ => {}
        }
    }
}

/// What the robot's word on the end of its walk means for the trial.
fn ended(end: WalkEnd, samples: &[Sample], asked: Option<u32>) -> TrialStop {
    let frames = samples.last().map_or(0, |s| s.telemetry.trial_frames);
    match end {
        WalkEnd::LinkLost => TrialStop::LinkLost,
        WalkEnd::Fault(fault) => TrialStop::Fault { fault },
        end => TrialStop::Ended { end, frames, asked },
    }
}

/// Whether the counters are those of the whole trial.
fn is_over(telemetry: &Telemetry, frames: Option<u32>) -> Result<bool, TrialStop> {
    match telemetry.state {
        State::Fault(fault) => Err(TrialStop::Fault { fault }),
        _ if frames.is_some_and(|frames| telemetry.trial_frames >= frames) => Ok(true),
        // The order to walk was answered before this sample was taken; the
        // player is one frame ahead of its counters, so only idle means over.
        State::Idle => Err(TrialStop::Early { frames: telemetry.trial_frames, asked: frames }),
        _ => Ok(false),
    }
}
