//! Walks one trial and keeps all telemetry of it.
//!
//! A trial is exactly the gait frames after the slow entry. Energy and frames come
//! from the robot's own counters, so lost telemetry costs nothing; [`clock`] places
//! the trial on the host's clock, [`table`] writes the results. A trial that ended
//! early says why ([`Trial::stop`]). Does not depend on what the results are for.

pub mod clock;
mod follow;
pub mod measure_result;
pub mod table;

use crate::device::link::{Link, LinkError, words};
use crate::device::session::{ENTRY_TIMEOUT, Sample, Session, Watcher};
use protocol::{
    Amplitude, Command, FRAME_RATE_HZ, Fault, LINK_TIMEOUT_FRAMES, Refusal, Speed, State, Telemetry, WalkEnd,
};
use std::io::{Read, Write};
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};
use thiserror::Error;

/// An order to stop, or to leave a fault, is carried out within a frame or two.
const STOP_TIMEOUT: Duration = Duration::from_secs(5);
/// Between two looks at a robot that comes to rest.
const LOOK_EVERY: Duration = Duration::from_millis(50);

/// How a walk is ordered.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Order {
    /// Gait frames; `None` walks until it is stopped.
    pub frames: Option<u32>,
    /// `None` walks with the stored amplitude.
    pub amplitude: Option<Amplitude>,
    /// As a share of the gait's own speed.
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

/// Why a trial ended before its time.
#[derive(Debug, Error)]
// The messages say what each field is.
#[allow(missing_docs)]
pub enum TrialStop {
    /// The robot stopped by itself and latched.
    #[error("the robot stopped by itself: {}", words::fault(*.fault))]
    Fault { fault: Fault },
    /// The robot ended the walk early, without a fault.
    #[error("the robot stopped after {}", words_of_frames(*.frames, *.asked))]
    Early { frames: u32, asked: Option<u32> },
    /// The walk was ended from outside: by the button, or another command.
    #[error("the robot stopped after {}: {}", words_of_frames(*.frames, *.asked), words::walk_end(*.end))]
    Ended { end: WalkEnd, frames: u32, asked: Option<u32> },
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
        asked: Option<u32>,
    },
    /// The link broke, or the robot was reset or stopped answering.
    #[error("the trial was cut short")]
    Link { source: LinkError },
    /// The user stopped it.
    #[error("the trial was interrupted, and the robot was ordered to stop")]
    Interrupted,
}

impl TrialStop {
    /// The robot's report of the end of a walk, after so many gait frames of those asked for.
    pub(super) const fn of(end: WalkEnd, frames: u32, asked: Option<u32>) -> Self {
        match end {
            WalkEnd::LinkLost => Self::LinkLost,
            WalkEnd::Fault(fault) => Self::Fault { fault },
            end => Self::Ended { end, frames, asked },
        }
    }
}

fn words_of_frames(frames: u32, asked: Option<u32>) -> String {
    match asked {
        Some(asked) => format!("{frames} of {asked} gait frames"),
        None => format!("{frames} gait frames"),
    }
}

/// The telemetry of a trial, and how it ended.
#[derive(Debug)]
pub struct Trial {
    /// All telemetry, from the order to walk until the trial was over.
    pub samples: Vec<Sample>,
    /// Why it ended early, if it did.
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

/// Brings the robot to rest, so that it accepts an order to walk: ends a walk
/// that is still going on.
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
            // The robot's refusal of the next command says why.
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
    watcher: impl Watcher,
) -> Result<Trial, LinkError> {
    let Order { frames, amplitude, speed, dry_run } = *order;
    let mut session = Session::open(link, stop, watcher)?;
    session.link.order(Command::Walk { amplitude, frames, detached: false, dry_run })?;
    // A walk that has begun is ordered to stop, whatever fails from here on.
    let begun = begin(&mut session, speed).map_err(|source| TrialStop::Link { source });
    let stop = begun.and_then(|()| follow::follow(&mut session, frames)).err();
    if let Some(
        TrialStop::Interrupted | TrialStop::Entry | TrialStop::Stuck { .. } | TrialStop::Link { .. },
    ) = stop
    {
        session.stop(true);
    }
    session.stop_telemetry();
    Ok(Trial { samples: session.samples, stop })
}

fn begin<P: Read + Write>(session: &mut Session<'_, P, impl Watcher>, speed: Speed) -> Result<(), LinkError> {
    // A new walk has the gait's own speed.
    if speed != Speed::ONE {
        session.link.order(Command::SetSpeed(speed))?;
    }
    session.start_telemetry()
}
