//! Walks one trial and keeps everything the robot said meanwhile.
//!
//! A trial is exactly the gait frames after the slow entry. Owns the wait for
//! its end, the telemetry and the two clocks ([`clock`]), and keeps the robot
//! walking, which without a host stops after a second; [`table`] keeps the results. Energy and frames come from the robot's own counters, so lost
//! telemetry costs nothing. Refuses to call a trial whole that was not.

pub mod clock;
pub mod table;

use crate::link::{Heard, Link, LinkError, words};
use protocol::{
    Amplitude, Command, Event, FRAME_RATE_HZ, Fault, LINK_TIMEOUT_FRAMES, Message, State, Telemetry,
};
use std::io::{Read, Write};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant, UNIX_EPOCH};
use thiserror::Error;

/// The slow entry moves 90 degrees in a few seconds; a robot that takes longer hangs.
const ENTRY_TIMEOUT: Duration = Duration::from_secs(30);
/// Without telemetry for this long the robot is asked how it is.
const SILENCE: Duration = Duration::from_secs(2);
/// A robot stops by itself after [`protocol::LINK_TIMEOUT_FRAMES`] without a
/// command, 1 s: three of four may get lost.
const HEARTBEAT_EVERY: Duration = Duration::from_millis(250);
/// An order to stop, or to leave a fault, is carried out within a frame or two.
const STOP_TIMEOUT: Duration = Duration::from_secs(5);
/// How often the user's wish to stop is looked at.
const LOOK_EVERY: Duration = Duration::from_millis(50);

/// One telemetry message and when it arrived.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// Host clock.
    pub unix_time_s: f64,
    /// What the robot said.
    pub telemetry: Telemetry,
}

/// Why a trial ended before its time.
#[derive(Debug, Error)]
pub enum TrialStop {
    /// The robot stopped by itself and latched.
    #[error("the robot stopped by itself: {}", words::fault(*.fault))]
    Fault {
        /// Why.
        fault: Fault,
    },
    /// The robot ended the walk early, without a fault.
    #[error("the robot stopped after {frames} of {asked} gait frames without naming a fault")]
    Early {
        /// Gait frames played.
        frames: u32,
        /// Gait frames asked for.
        asked: u32,
    },
    /// The robot heard no command for too long.
    #[error(
        "the robot heard nothing from this computer for {} s and stopped",
        f64::from(LINK_TIMEOUT_FRAMES) / f64::from(FRAME_RATE_HZ)
    )]
    LinkLost,
    /// The robot does not get into its first pose.
    #[error("the robot has not reached its first pose after {} s", ENTRY_TIMEOUT.as_secs())]
    Entry,
    /// It answers, but sends no telemetry, or counts no frames.
    #[error("the robot answers, but its trial does not end: {frames} of {asked} gait frames are counted")]
    Stuck {
        /// Gait frames it reported last.
        frames: u32,
        /// Gait frames asked for.
        asked: u32,
    },
    /// The link broke, the robot was reset, or it fell silent.
    #[error("the trial was cut short")]
    Link {
        /// What happened.
        source: LinkError,
    },
    /// The user stopped it.
    #[error("the trial was interrupted, and the robot was told to stop")]
    Interrupted,
}

/// What was walked.
#[derive(Debug)]
pub struct Trial {
    /// Gait frames asked for.
    pub asked_frames: u32,
    /// Everything the robot said, from the order to walk until the trial was over.
    pub samples: Vec<Sample>,
    /// Why it is not whole, if it is not.
    pub stop: Option<TrialStop>,
}

impl Trial {
    /// The last sample: the robot's counters freeze with the last gait frame.
    #[must_use]
    pub fn last(&self) -> Option<&Telemetry> {
        self.samples.last().map(|sample| &sample.telemetry)
    }

    /// Gait frames played.
    #[must_use]
    pub fn frames(&self) -> u32 {
        self.last().map_or(0, |t| t.trial_frames)
    }

    /// Battery energy over them.
    #[must_use]
    pub fn energy_j(&self) -> f64 {
        self.last().map_or(0.0, |t| t.trial_energy_uj as f64 / 1e6)
    }

    /// How long they lasted by the robot's clock, which its energy counts on too.
    #[must_use]
    pub fn duration_s(&self) -> f64 {
        f64::from(self.frames()) / f64::from(FRAME_RATE_HZ)
    }

    /// Telemetry of gait frames that never arrived.
    #[must_use]
    pub fn lost_frames(&self) -> u32 {
        let walking = |s: &&Sample| (1..=self.frames()).contains(&s.telemetry.trial_frames);
        let mut seen: Vec<u32> =
            self.samples.iter().filter(walking).map(|s| s.telemetry.trial_frames).collect();
        seen.dedup();
        self.frames().saturating_sub(seen.len() as u32)
    }
}

/// Brings the robot to rest, so that a walk can be asked for: clears a fault
/// whose cause is gone, and ends a walk that still goes on.
///
/// # Errors
/// [`LinkError`]; [`LinkError::Refused`] if the fault is still there.
pub fn prepare<P: Read + Write>(link: &mut Link<P>) -> Result<(), LinkError> {
    let deadline = Instant::now() + STOP_TIMEOUT;
    loop {
        match link.status()?.state {
            // Holding is the end of a walk: the next one may begin there.
            State::Idle | State::Holding => return Ok(()),
            State::Fault(_) => link.order(Command::ClearFault)?,
            State::Entering | State::Walking => link.order(Command::Stop)?,
            State::Booting => {}
        }
        if Instant::now() >= deadline {
            // What the robot thinks of it will say more than we could.
            return Ok(());
        }
        std::thread::sleep(LOOK_EVERY);
    }
}

/// Walks `frames` gait frames; `progress` is told the frames played so far.
///
/// The trial is returned however it ended; see [`Trial::stop`].
///
/// # Errors
/// [`LinkError`] if the walk could not even begin.
pub fn walk<P: Read + Write>(
    link: &mut Link<P>,
    frames: u32,
    amplitude: Option<Amplitude>,
    stop: &AtomicBool,
    mut progress: impl FnMut(State, u32),
) -> Result<Trial, LinkError> {
    // Telemetry of before the walk tells of the trial before: none may be under way.
    link.order(Command::StreamTelemetry { every_frames: 0 })?;
    while link.next_unasked(Instant::now())?.is_some() {}
    link.order(Command::Walk { amplitude, frames: Some(frames), detached: false })?;
    link.order(Command::StreamTelemetry { every_frames: 1 })?;
    let mut trial = Trial { asked_frames: frames, samples: Vec::new(), stop: None };
    trial.stop = follow(link, &mut trial.samples, frames, stop, &mut progress).err();
    if matches!(trial.stop, Some(TrialStop::Interrupted | TrialStop::Entry | TrialStop::Stuck { .. })) {
        // A robot that cannot be reached any more stops by itself, for want of heartbeats.
        let _ = link.order(Command::Stop);
    }
    let _ = link.order(Command::StreamTelemetry { every_frames: 0 });
    Ok(trial)
}

fn follow<P: Read + Write>(
    link: &mut Link<P>,
    samples: &mut Vec<Sample>,
    frames: u32,
    stop: &AtomicBool,
    progress: &mut impl FnMut(State, u32),
) -> Result<(), TrialStop> {
    let broken = |source| TrialStop::Link { source };
    let begin = Instant::now();
    let walk_timeout = Duration::from_secs_f64(1.5 * f64::from(frames) / f64::from(FRAME_RATE_HZ) + 5.0);
    let mut walking_since = None;
    let mut last_heard = begin;
    let mut last_asked = begin;
    loop {
        if stop.load(Ordering::Relaxed) {
            return Err(TrialStop::Interrupted);
        }
        let played = samples.last().map_or(0, |s| s.telemetry.trial_frames);
        match walking_since {
            None if begin.elapsed() > ENTRY_TIMEOUT => return Err(TrialStop::Entry),
            Some(since) if last_heard.duration_since(since) > walk_timeout => {
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
        let Some(heard) = link.next_unasked(Instant::now() + LOOK_EVERY).map_err(broken)? else { continue };
        last_heard = Instant::now();
        match heard.message {
            Message::Event(Event::Fault(fault)) => return Err(TrialStop::Fault { fault }),
            Message::Event(Event::LinkLost) => return Err(TrialStop::LinkLost),
            Message::Telemetry(telemetry) => {
                samples.push(Sample { unix_time_s: unix_time_s(&heard), telemetry });
                progress(telemetry.state, telemetry.trial_frames);
                if telemetry.trial_frames > 0 {
                    walking_since.get_or_insert(last_heard);
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
fn is_over(telemetry: &Telemetry, frames: u32) -> Result<bool, TrialStop> {
    match telemetry.state {
        State::Fault(fault) => Err(TrialStop::Fault { fault }),
        _ if telemetry.trial_frames >= frames => Ok(true),
        // The order to walk was answered before this sample was taken; the
        // player is one frame ahead of its counters, so only idle means over.
        State::Idle => Err(TrialStop::Early { frames: telemetry.trial_frames, asked: frames }),
        _ => Ok(false),
    }
}

fn unix_time_s(heard: &Heard) -> f64 {
    heard.at.duration_since(UNIX_EPOCH).map_or(0.0, |age| age.as_secs_f64())
}
