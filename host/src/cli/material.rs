//! A gait that commands check, play or send: from its file, or a recording as samples.
//!
//! Holds the gait, the robot that it is for, and what is known of its limits.
//! Does not depend on a subcommand's flags.

use super::explain::{failure, failure_with_help};
use super::recording::{DefaultRows, Recording};
use super::robots::{self, RobotArg};
use super::{Cause, Failure};
use crate::gait::gait_file::limits::{LeavesLimits, as_typed};
use crate::gait::gait_file::{GaitFile, GaitFileError, Provenance, Source};
use crate::gait::gait_player::Playable;
use crate::gait::sampled_gait::{self, SampleError, Sampled};
use crate::robot::Robot;
use protocol::Amplitude;
use protocol::gait::MAX_ENCODED_LEN;
use std::path::{Path, PathBuf};

/// A gait, and what is known about it.
pub struct Material {
    /// The file it comes from.
    pub path: PathBuf,
    /// What the robot takes.
    pub bytes: Vec<u8>,
    /// The same, to look ahead with.
    pub playable: Playable,
    /// As in `gait_source` of results.
    pub source: &'static str,
    /// Of the recording, if it is one.
    pub sampled: Option<Sampled>,
    /// The robot that it is meant for, else the Ant.
    pub robot: Robot,
    /// That this robot is not the one, or has not the legs, that the gait was made for.
    pub other_leg: Option<String>,
    /// Curves as the file has them, more exact than the robot's.
    curves: Option<GaitFile>,
}

impl Material {
    /// Reads a gait, for the robot that was named, or its own.
    ///
    /// # Errors
    /// The file cannot be read, or is of another robot and `anyway` does not allow that.
    pub fn load(path: PathBuf, named: RobotArg, anyway: bool) -> Result<Self, Failure> {
        if let Some((bytes, playable)) = sampled_bytes(&path) {
            let (robot, other_leg) = robots::of_gait(named, &path, None, anyway)?;
            let source = Source::Table.name();
            return Ok(Self { path, bytes, playable, source, sampled: None, robot, other_leg, curves: None });
        }
        let gait = GaitFile::load(&path).map_err(unreadable)?;
        let (robot, other_leg) = robots::of_gait(named, &path, Some(&gait.provenance), anyway)?;
        let bytes = gait.encoded().map_err(|e| failure(Cause::Input, e))?;
        let playable = playable(&bytes)?;
        let source = gait.provenance.source.name();
        Ok(Self { path, bytes, playable, source, sampled: None, robot, other_leg, curves: Some(gait) })
    }

    /// Samples a recording, for the robot that was named, or its own.
    ///
    /// # Errors
    /// The file cannot be read, or no table holds the stride.
    pub fn sampled(recording: &Recording, name: Option<&str>, robot: Option<&Path>) -> Result<Self, Failure> {
        let chosen = recording.choose(DefaultRows::FindStride)?;
        chosen.check_period()?;
        let default_name = || Provenance::of(Source::Fitted).gait_name(&chosen.path);
        let name = name.map_or_else(default_name, str::to_owned);
        let period_us = (chosen.played_s() * 1e6 + 1e-3).floor() as u32;
        let sampled =
            sampled_gait::sample(chosen.actions()?, &chosen.scale, &name, period_us).map_err(unsampled)?;
        let mut buffer = [0; MAX_ENCODED_LEN];
        // A table that was quantised is valid, and the longest fits.
        let bytes = sampled.table.encode(&mut buffer).map(<[u8]>::to_vec).unwrap_or_default();
        let playable = playable(&bytes)?;
        let robot = match (robot, chosen.robot) {
            (None, Some(robot)) => robot,
            (named, _) => robots::beside(named, &chosen.path)?,
        };
        let (path, source) = (chosen.path, "sampled");
        Ok(Self {
            path,
            bytes,
            playable,
            source,
            sampled: Some(sampled),
            robot,
            other_leg: None,
            curves: None,
        })
    }

    /// What to say of the gait itself at an amplitude: other legs than this
    /// robot's, or beyond what it was found safe at.
    pub fn doubts(&self, amplitude: Amplitude) -> Vec<String> {
        let safe = self.curves.as_ref().and_then(|gait| gait.provenance.safe_amplitudes);
        let asked = as_typed(amplitude);
        // A typed 1.1 is held as 9011/8192.
        let beyond = safe.filter(|[least, most]| asked < least - 1e-3 || asked > most + 1e-3);
        let beyond = beyond.map(|[least, most]| {
            format!(
                "the gait was found safe at amplitudes {least} to {most}; at {asked} a joint or a servo exceeds its \
                 limits, or some of the robots fell"
            )
        });
        self.other_leg.iter().cloned().chain(beyond).collect()
    }

    /// Duration of a stride.
    pub fn period_s(&self) -> f64 {
        self.curves.as_ref().map_or(self.playable.period_s(), |gait| gait.period_s)
    }

    /// Whether every joint stays within its limits.
    pub fn check_limits(&self, amplitude: f64) -> Result<(), LeavesLimits> {
        match &self.curves {
            Some(gait) => gait.check_limits(amplitude),
            None => self.playable.check_limits(amplitude),
        }
    }

    /// Share of the stride in which a joint is held at a limit.
    pub fn clipped_share(&self, amplitude: Amplitude) -> f64 {
        match &self.curves {
            Some(gait) => gait.clipped_share(amplitude.value()),
            None => self.playable.clipped_share(amplitude),
        }
    }
}

/// The bytes of a sampled table; for any other file, [`GaitFile::load`] has the better error.
fn sampled_bytes(path: &Path) -> Option<(Vec<u8>, Playable)> {
    let bytes = std::fs::read(path).ok().filter(|_| path.extension().is_some_and(|e| e == "bin"))?;
    let playable = Playable::from_bytes(&bytes).ok().filter(|playable| playable.encoded().is_sampled())?;
    Some((bytes, playable))
}

/// The gait in its bytes, to look ahead with.
pub fn playable(bytes: &[u8]) -> Result<Playable, Failure> {
    Playable::from_bytes(bytes).map_err(|reason| {
        let path = PathBuf::from("the table");
        failure(Cause::Input, GaitFileError::Bytes { path, len: bytes.len(), reason })
    })
}

fn unreadable(error: GaitFileError) -> Failure {
    let help = match &error {
        GaitFileError::File(_) => "`host fit` writes runs/latest/gait.toml; or name another",
        GaitFileError::Bytes { .. } => "copy the file again, or use the gait.toml beside it",
        GaitFileError::Parse { .. } | GaitFileError::Unusable { .. } => "write it again with `host fit`",
    };
    failure_with_help(Cause::Input, error, help)
}

fn unsampled(error: SampleError) -> Failure {
    let help = match &error {
        SampleError::TooFewRows { .. } => "choose the rows of a whole stride: --rows A..B",
        SampleError::Name { .. } => "give it another: --name NAME",
        SampleError::Deviation { .. } => {
            "a joint moves by --unit-deg per unit of action; check the recording's units"
        }
        SampleError::Centre { .. } => {
            "a joint's centre follows from its mean action: see --centre-unit-deg, --centre-offset-deg, \
             --negate and --limit-deg"
        }
        SampleError::Table { .. } => "see --period, --time-stretch and --limit-deg",
    };
    failure_with_help(Cause::Input, error, help)
}
