//! Walks one trial and keeps everything the robot said meanwhile.
//!
//! A trial is exactly the gait frames after the slow entry. Owns the wait for
//! its end, the telemetry and the two clocks ([`clock`]), and keeps the robot
//! walking, which without a host stops after a second; [`table`] keeps the
//! results. Energy and frames come from the robot's own counters, so lost
//! telemetry costs nothing. Refuses to call a trial whole that was not.

pub mod clock;
mod follow;
pub mod table;

use crate::device::link::{Heard, Link, LinkError, words};
use protocol::{
    Amplitude, Command, FRAME_RATE_HZ, Fault, LINK_TIMEOUT_FRAMES, Message, Refusal, Speed, State, Telemetry,
    WalkEnd,
};
use std::io::{Read, Write};
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant, UNIX_EPOCH};
use thiserror::Error;

/// The slow entry moves 90 degrees in a few seconds; a robot that takes longer hangs.
const ENTRY_TIMEOUT: Duration = Duration::from_secs(30);
/// An order to stop, or to leave a fault, is carried out within a frame or two.
const STOP_TIMEOUT: Duration = Duration::from_secs(5);
/// How often the user's wish to stop is looked at.
const LOOK_EVERY: Duration = Duration::from_millis(50);
/// What a walk came to is known a frame or two after it was told to end.
const LAST_WORDS: Duration = Duration::from_millis(500);

/// What is asked of a walk.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Order {
    /// Gait frames; `None` walks until somebody stops it.
    pub frames: Option<u32>,
    /// `None` walks with the stored amplitude.
    pub amplitude: Option<Amplitude>,
    /// Of the gait's own.
    pub speed: Speed,
    /// A rehearsal with limp servos.
    pub dry_run: bool,
}

impl Order {
    /// `frames` at the stored amplitude and the gait's own speed.
    #[must_use]
    pub const fn of(frames: u32) -> Self {
        Self { frames: Some(frames), amplitude: None, speed: Speed::ONE, dry_run: false }
    }
}

/// Who looks on while a robot walks, and may wish for something else meanwhile.
pub trait Watcher {
    /// A sample arrived.
    fn progress(&mut self, state: State, played: u32);

    /// The next change that is wished for.
    fn wish(&mut self) -> Option<Command> {
        None
    }

    /// What became of it.
    fn granted(&mut self, _wish: Command, _refusal: Option<Refusal>) {}
}

impl<F: FnMut(State, u32)> Watcher for F {
    fn progress(&mut self, state: State, played: u32) {
        self(state, played);
    }
}

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
    #[error("the robot stopped after {}", words_of_frames(*.frames, *.asked))]
    Early {
        /// Gait frames played.
        frames: u32,
        /// Gait frames asked for.
        asked: Option<u32>,
    },
    /// Somebody else ended the walk.
    #[error("the robot stopped after {}: {}", words_of_frames(*.frames, *.asked), words::walk_end(*.end))]
    Ended {
        /// How.
        end: WalkEnd,
        /// Gait frames played.
        frames: u32,
        /// Gait frames asked for.
        asked: Option<u32>,
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
    #[error("the robot answers, but its trial does not end: {} are counted", words_of_frames(*.frames, *.asked))]
    Stuck {
        /// Gait frames it reported last.
        frames: u32,
        /// Gait frames asked for.
        asked: Option<u32>,
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

fn words_of_frames(frames: u32, asked: Option<u32>) -> String {
    match asked {
        Some(asked) => format!("{frames} of {asked} gait frames"),
        None => format!("{frames} gait frames"),
    }
}

/// What was walked.
#[derive(Debug)]
pub struct Trial {
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

/// Brings the robot to rest, so that a walk can be asked for: ends one that
/// still goes on.
///
/// # Errors
/// [`LinkError`]; [`LinkError::Refused`] if a fault is latched, which only
/// the user clears.
pub fn prepare<P: Read + Write>(link: &mut Link<P>) -> Result<(), LinkError> {
    let deadline = Instant::now() + STOP_TIMEOUT;
    loop {
        match link.status()?.state {
            // Holding is the end of a walk: the next one may begin there.
            State::Idle | State::Holding => return Ok(()),
            State::Fault(fault) => {
                return Err(LinkError::Refused { command: "walk", refusal: Refusal::Faulted(fault) });
            }
            State::Entering | State::Walking => link.order(Command::Stop)?,
            State::Booting | State::Stopping => {}
        }
        if Instant::now() >= deadline {
            // What the robot thinks of it will say more than we could.
            return Ok(());
        }
        std::thread::sleep(LOOK_EVERY);
    }
}

/// Walks attached, until the frames are played or `stop` is set.
///
/// The trial is returned however it ended; see [`Trial::stop`].
///
/// # Errors
/// [`LinkError`] if the walk could not even begin.
pub fn walk<P: Read + Write>(
    link: &mut Link<P>,
    order: &Order,
    stop: &AtomicBool,
    mut watcher: impl Watcher,
) -> Result<Trial, LinkError> {
    let Order { frames, amplitude, speed, dry_run } = *order;
    // Telemetry of before the walk tells of the trial before: none may be under way.
    link.order(Command::StreamTelemetry { every_frames: 0 })?;
    while link.next_unasked(Instant::now())?.is_some() {}
    link.order(Command::Walk { amplitude, frames, detached: false, dry_run })?;
    let mut trial = Trial { samples: Vec::new(), stop: None };
    // A walk that has begun is told to stop, whatever fails from here on.
    let begun = begin(link, speed).map_err(|source| TrialStop::Link { source });
    trial.stop =
        begun.and_then(|()| follow::follow(link, &mut trial.samples, frames, stop, &mut watcher)).err();
    if let Some(
        TrialStop::Interrupted | TrialStop::Entry | TrialStop::Stuck { .. } | TrialStop::Link { .. },
    ) = trial.stop
    {
        stop_now(link, &mut trial.samples);
    }
    let _ = link.order(Command::StreamTelemetry { every_frames: 0 });
    Ok(trial)
}

fn begin<P: Read + Write>(link: &mut Link<P>, speed: Speed) -> Result<(), LinkError> {
    // A new walk has the gait's own speed.
    if speed != Speed::ONE {
        link.order(Command::SetSpeed(speed))?;
    }
    link.order(Command::StreamTelemetry { every_frames: 1 })
}

/// Ends the walk by the stop byte, which needs no answer, and hears out what it came to.
///
/// A robot that cannot be reached any more stops by itself, for want of heartbeats.
fn stop_now<P: Read + Write>(link: &mut Link<P>, samples: &mut Vec<Sample>) {
    if link.send_stop_byte().and_then(|()| link.order(Command::Stop)).is_err() {
        return;
    }
    let deadline = Instant::now() + LAST_WORDS;
    // The first sample after the end does not count the last frame yet.
    let mut rests = 0;
    while rests < 2
        && let Ok(Some(heard)) = link.next_unasked(deadline)
    {
        if let Message::Telemetry(telemetry) = heard.message {
            samples.push(Sample { unix_time_s: unix_time_s(&heard), telemetry });
            rests += u32::from(!matches!(telemetry.state, State::Entering | State::Walking));
        }
    }
}

fn unix_time_s(heard: &Heard) -> f64 {
    heard.at.duration_since(UNIX_EPOCH).map_or(0.0, |age| age.as_secs_f64())
}
