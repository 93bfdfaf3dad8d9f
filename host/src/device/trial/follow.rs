//! Follows a walk to its end, and keeps the robot walking meanwhile.
//!
//! Holds what each message means for the trial. Does not wait for a robot whose
//! frame counter stands still.

use super::TrialStop;
use crate::device::link::LinkError;
use crate::device::session::{ENTRY_TIMEOUT, LAST_WORDS, Session, Watcher};
use protocol::{Event, Message, State, Telemetry, WalkEnd};
use std::io::{Read, Write};
use std::time::{Duration, Instant};

/// Without telemetry for this long the robot is asked for its status.
const SILENCE: Duration = Duration::from_secs(2);
/// A walk that counts no frame for this long will not count another.
const STALL: Duration = Duration::from_secs(5);
/// How often the user's wish to stop is looked at.
const LOOK_EVERY: Duration = Duration::from_millis(50);

/// Returns when all frames are played, or with the reason why they were not.
pub(super) fn follow<P: Read + Write, W: Watcher>(
    session: &mut Session<'_, P, W>,
    frames: Option<u32>,
) -> Result<(), TrialStop> {
    let broken = |source| TrialStop::Link { source };
    let begin = Instant::now();
    let mut moved_on = None;
    // Why it is over, and since when: the counters of its last frame are still on their way.
    let mut end: Option<(WalkEnd, Instant)> = None;
    let mut last_heard = begin;
    session.command_sent();
    loop {
        if session.is_interrupted() {
            return Err(TrialStop::Interrupted);
        }
        let played = session.played();
        if let Some((reason, since)) = end
            && since.elapsed() > LAST_WORDS
        {
            return Err(TrialStop::of(reason, played, frames));
        }
        match moved_on {
            None if begin.elapsed() > ENTRY_TIMEOUT => return Err(TrialStop::Entry),
            Some(moved_on) if Instant::now().duration_since(moved_on) > STALL => {
                return Err(TrialStop::Stuck { frames: played, asked: frames });
            }
            _ => {}
        }
        if last_heard.elapsed() > SILENCE {
            // Either the robot is gone, and this fails, or its telemetry was switched off.
            session.link.status().map_err(broken)?;
            session.start_telemetry().map_err(broken)?;
            last_heard = Instant::now();
        }
        session.keep_alive().map_err(broken)?;
        if let Some(change) = session.watcher.requested_change() {
            session.command_sent();
            match session.link.order(change) {
                Ok(()) => session.watcher.answered(change, None),
                Err(LinkError::Refused { refusal, .. }) => session.watcher.answered(change, Some(refusal)),
                Err(source) => return Err(TrialStop::Link { source }),
            }
        }
        let Some(incoming) = session.next(Instant::now() + LOOK_EVERY).map_err(broken)? else { continue };
        last_heard = Instant::now();
        match incoming.message {
            Message::Event(Event::Fault(fault)) => end = Some((WalkEnd::Fault(fault), last_heard)),
            // The end that was asked for is seen by its counters.
            Message::Event(Event::WalkEnded(WalkEnd::Finished)) => {}
            Message::Event(Event::WalkEnded(reason)) => end = Some((reason, last_heard)),
            Message::Telemetry(telemetry) => {
                // A paused robot holds its pose and counts no frames.
                if telemetry.trial_frames > played
                    || (moved_on.is_some() && telemetry.state == State::Holding)
                {
                    moved_on = Some(last_heard);
                }
                if let Some((reason, _)) = end {
                    return Err(TrialStop::of(reason, session.played(), frames));
                }
                if is_over(&telemetry, frames)? {
                    return Ok(());
                }
            }
            _ => {}
        }
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
