//! A recording of joints and its scales: the flags that `fit`, `upload-gait --sampled`
//! and `play` share.
//!
//! Holds the choice of rows, duration, scales and robot. Does not depend on the file
//! format ([`crate::gait::trajectory`]).

use super::explain::{failure, failure_with_help};
use super::ranges::check_range;
use super::{Cause, Failure};
use crate::gait::fit::Scale;
use crate::gait::joint_map::{JointMap, JointMapError};
use crate::gait::scale::{POLICY_DEG_PER_ACTION, TABLE_DEG_PER_ACTION};
use crate::gait::trajectory::loop_finder::{self, Loop};
use crate::gait::trajectory::{Trajectory, TrajectoryError};
use crate::robot::{LegScale, Robot};
use crate::run_folder;
use protocol::gait::{MAX_PERIOD_US, MIN_PERIOD_US};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::str::FromStr;
use thiserror::Error;

/// Joint limit of a robot without a description: as far as a policy asks.
const DEFAULT_LIMIT_DEG: f64 = POLICY_DEG_PER_ACTION;

/// Which recording, and what its numbers mean.
#[derive(Debug, Clone, clap::Args)]
pub struct Recording {
    /// CSV with a column per joint [default: trajectory.csv of the run]
    pub trajectory: Option<PathBuf>,
    /// Run folder whose trajectory is taken where none is named; a flag of its own for some.
    #[arg(skip)]
    pub run: Option<PathBuf>,
    /// Folder of the robot that it is for; a flag of its own for some.
    #[arg(skip)]
    pub robot: Option<PathBuf>,
    /// Data rows of one stride, counted from 0, B excluded: `973..1000`; or `all`
    #[arg(long, value_name = "A..B")]
    rows: Option<Rows>,
    /// Duration of those rows in the recording; needed if it has no time_s
    #[arg(long, value_name = "S")]
    period: Option<f64>,
    /// Play this many times slower than the recording [default: 1]
    #[arg(long, value_name = "X")]
    time_stretch: Option<f64>,
    /// TOML with columns, signs and scales; flags override it
    #[arg(long, value_name = "FILE")]
    map: Option<PathBuf>,
    /// What each column holds: a joint, time_s, or `-` to skip it
    #[arg(long, value_delimiter = ',', value_name = "NAMES", allow_hyphen_values = true)]
    columns: Option<Vec<String>>,
    /// Joints that turn the other way on the robot: `ank3,ank4`
    #[arg(long, value_delimiter = ',', value_name = "JOINTS")]
    negate: Option<Vec<String>>,
    /// Degrees per unit of action at amplitude 1.0; for columns in degrees 1, in radians
    /// --unit-deg 57.2958 --centre-unit-deg 57.2958, in microseconds of a servo at 10 us a degree
    /// 0.1 with --neutral 1500 [default: 24]
    #[arg(long, value_name = "DEG")]
    unit_deg: Option<f64>,
    /// Degrees per unit of the mean action [default: 45, as simulated]
    #[arg(long, value_name = "DEG")]
    centre_unit_deg: Option<f64>,
    /// Degrees between action 0 and neutral [default: 0]
    #[arg(long, value_name = "DEG", allow_negative_numbers = true)]
    centre_offset_deg: Option<f64>,
    /// What the columns hold at neutral, taken off before any scale: 1500 (microseconds), 330
    /// (ticks), 90 (degrees); or eight values, hip1 to knee4 [default: 0]
    #[arg(long, value_delimiter = ',', value_name = "VALUE", allow_negative_numbers = true)]
    neutral: Option<Vec<f64>>,
    /// Joint limit either way [default: that of the run's robot or of --leg's, else 45]
    #[arg(long, value_name = "DEG")]
    limit_deg: Option<f64>,
    /// Leg length the gait is meant for: 1.0 is 23 cm, 0.6 is 13.8 cm
    #[arg(long, value_name = "X")]
    leg: Option<LegScale>,
}

/// Which rows to take.
#[derive(Debug, Clone, PartialEq, Eq)]
enum Rows {
    All,
    Range(Range<usize>),
}

impl FromStr for Rows {
    type Err = BadFlag;

    fn from_str(text: &str) -> Result<Self, BadFlag> {
        if text == "all" {
            return Ok(Self::All);
        }
        let bad = || BadFlag::Rows { text: text.into() };
        let (first, end) = text.split_once("..").ok_or_else(bad)?;
        let (first, end) = (first.trim().parse().map_err(|_| bad())?, end.trim().parse().map_err(|_| bad())?);
        if first < end { Ok(Self::Range(first..end)) } else { Err(bad()) }
    }
}

/// A flag whose value clap cannot check.
#[derive(Debug, Error)]
pub enum BadFlag {
    #[error("{text:?} is not a range of rows: write A..B with A below B, counted from 0, or `all`")]
    Rows { text: String },
    #[cfg(feature = "train")]
    #[error("{flag} is for recordings, not for a policy")]
    NotForPolicies { flag: &'static str },
    #[error("{} has no time_s column, so the duration of its rows is unknown", .path.display())]
    NoPeriod { path: PathBuf },
    #[error(
        "the stride would last {played_s:.3} s ({recorded_s:.3} s recorded, times {stretch}); a robot plays {} to {} s",
        f64::from(MIN_PERIOD_US) / 1e6, f64::from(MAX_PERIOD_US) / 1e6
    )]
    Played { recorded_s: f64, stretch: f64, played_s: f64 },
}

/// The rows that are used without --rows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DefaultRows {
    /// One stride, which is searched for unless the file is one.
    FindStride,
    /// The whole file.
    All,
}

/// The rows that were chosen.
#[derive(Debug)]
pub struct Chosen {
    pub path: PathBuf,
    pub trajectory: Trajectory,
    pub rows: Range<usize>,
    pub found: Option<Loop>,
    /// Whether the file is one whole stride, and all of it was taken.
    pub is_whole_stride: bool,
    pub recorded_s: f64,
    pub time_stretch: f64,
    pub scale: Scale,
    /// The robot that it is meant for, as far as it is known.
    pub robot: Option<Robot>,
}

impl Chosen {
    pub fn actions(&self) -> Result<&[[f64; protocol::JOINT_COUNT]], Failure> {
        self.trajectory.rows(self.rows.start, self.rows.end).map_err(unreadable)
    }

    /// How long they last when played.
    pub fn played_s(&self) -> f64 {
        self.recorded_s * self.time_stretch
    }

    /// Refuses strides that no robot plays.
    pub fn check_period(&self) -> Result<(), Failure> {
        let (recorded_s, stretch, played_s) = (self.recorded_s, self.time_stretch, self.played_s());
        if !(f64::from(MIN_PERIOD_US)..=f64::from(MAX_PERIOD_US)).contains(&(played_s * 1e6)) {
            let error = BadFlag::Played { recorded_s, stretch, played_s };
            return Err(failure_with_help(Cause::Input, error, "see --period and --time-stretch"));
        }
        Ok(())
    }
}

impl Recording {
    pub fn path(&self) -> PathBuf {
        let run = || self.run.clone().unwrap_or_else(|| run_folder::LATEST.into());
        self.trajectory.clone().unwrap_or_else(|| run().join(run_folder::TRAJECTORY))
    }

    /// A flag or a file of it that was given, for commands that take it at times.
    pub fn given(&self) -> Option<&'static str> {
        let given = [
            ("a trajectory", self.trajectory.is_some()),
            ("--rows", self.rows.is_some()),
            ("--period", self.period.is_some()),
            ("--time-stretch", self.time_stretch.is_some()),
            ("--map", self.map.is_some()),
            ("--columns", self.columns.is_some()),
            ("--negate", self.negate.is_some()),
            ("--unit-deg", self.unit_deg.is_some()),
            ("--centre-unit-deg", self.centre_unit_deg.is_some()),
            ("--centre-offset-deg", self.centre_offset_deg.is_some()),
            ("--neutral", self.neutral.is_some()),
            ("--limit-deg", self.limit_deg.is_some()),
            ("--leg", self.leg.is_some()),
        ];
        given.into_iter().find(|(_, is_given)| *is_given).map(|(flag, _)| flag)
    }

    /// Columns are degrees from neutral, not actions.
    pub fn in_degrees(&mut self) {
        (self.unit_deg, self.centre_unit_deg) = (Some(1.0), Some(1.0));
    }

    /// Reads the file, and chooses rows, duration and scales.
    pub fn choose(&self, default: DefaultRows) -> Result<Chosen, Failure> {
        let map = self.joint_map()?;
        let time_stretch = self.time_stretch.unwrap_or(1.0);
        check_range("time-stretch", Some(time_stretch), 0.01, 1000.0)?;
        check_range("period", self.period, 1e-3, 1e4)?;
        let path = self.path();
        let mut trajectory = Trajectory::read(&path, map.columns.as_deref()).map_err(unreadable)?;
        if let Some(neutrals) = map.neutrals().map_err(|e| failure(Cause::Usage, e))? {
            for (value, neutral) in trajectory.actions.iter_mut().flat_map(|row| row.iter_mut().zip(neutrals))
            {
                *value -= neutral;
            }
        }
        let (rows, found) = self.rows(&trajectory, default)?;
        let recorded_s = self.recorded_s(&trajectory, &rows)?;
        let robot = self.robot()?;
        let scale = scale(&map, robot.as_ref())?;
        let is_whole_stride = trajectory.is_own_stride && self.rows.is_none() && found.is_none();
        Ok(Chosen { path, trajectory, rows, found, is_whole_stride, recorded_s, time_stretch, scale, robot })
    }

    fn joint_map(&self) -> Result<JointMap, Failure> {
        let flags = JointMap {
            columns: self.columns.clone(),
            negate: self.negate.clone(),
            unit_deg: self.unit_deg,
            centre_unit_deg: self.centre_unit_deg,
            centre_offset_deg: self.centre_offset_deg,
            neutral: self.neutral.clone(),
            limit_deg: self.limit_deg,
        };
        let Some(path) = &self.map else { return Ok(flags) };
        let file = JointMap::load(path).map_err(|e| failure(Cause::Input, e))?;
        Ok(flags.or(file))
    }

    fn rows(
        &self,
        trajectory: &Trajectory,
        default: DefaultRows,
    ) -> Result<(Range<usize>, Option<Loop>), Failure> {
        let whole = 0..trajectory.actions.len();
        let (rows, found) = match &self.rows {
            Some(Rows::Range(rows)) => (rows.clone(), None),
            Some(Rows::All) => (whole, None),
            None if default == DefaultRows::All => (whole, None),
            None if trajectory.is_own_stride && !holds_more_than_a_stride(trajectory) => (whole, None),
            None => {
                let found = loop_finder::find_loop(&trajectory.actions).map_err(|e| {
                    failure_with_help(
                        Cause::Input,
                        e,
                        "name the rows of one stride yourself: --rows A..B, or --rows all",
                    )
                })?;
                (found.rows.clone(), Some(found))
            }
        };
        trajectory.rows(rows.start, rows.end).map_err(unreadable)?;
        Ok((rows, found))
    }

    fn recorded_s(&self, trajectory: &Trajectory, rows: &Range<usize>) -> Result<f64, Failure> {
        if let Some(period_s) = self.period {
            return Ok(period_s);
        }
        let interval_s = trajectory.interval_s(rows.start, rows.end).map_err(unreadable)?;
        let interval_s = interval_s.ok_or_else(|| {
            let help = "--period S gives the duration of the chosen rows in the recording";
            failure_with_help(Cause::Usage, BadFlag::NoPeriod { path: self.path() }, help)
        })?;
        Ok(interval_s * rows.len() as f64)
    }

    fn robot(&self) -> Result<Option<Robot>, Failure> {
        let path = self.path();
        let robot = match (&self.robot, self.leg) {
            (Some(folder), _) => Robot::load(folder).map(Some),
            (None, Some(leg)) => Robot::ant(leg).map(Some),
            (None, None) => Robot::of_run(path.parent().unwrap_or(Path::new(""))),
        };
        robot.map_err(|e| failure(Cause::Input, e))
    }
}

/// Whether a file with the columns of one stride lasts longer than any stride.
fn holds_more_than_a_stride(trajectory: &Trajectory) -> bool {
    let times = trajectory.times_s.as_deref().unwrap_or_default();
    let lasts_s = times.last().zip(times.first()).map_or(0.0, |(last, first)| last - first);
    lasts_s * 1e6 > f64::from(MAX_PERIOD_US)
}

fn scale(map: &JointMap, robot: Option<&Robot>) -> Result<Scale, Failure> {
    let scale = Scale {
        signs: map.signs().map_err(|e: JointMapError| failure(Cause::Usage, e))?,
        unit_deg: map.unit_deg.unwrap_or(TABLE_DEG_PER_ACTION),
        centre_unit_deg: map.centre_unit_deg.unwrap_or(POLICY_DEG_PER_ACTION),
        centre_offset_deg: map.centre_offset_deg.unwrap_or(0.0),
        limit_deg: map.limit_deg.or(robot.map(|r| r.joint_limit_deg)).unwrap_or(DEFAULT_LIMIT_DEG),
    };
    check_range("unit-deg", Some(scale.unit_deg), 0.001, 120.0)?;
    check_range("centre-unit-deg", Some(scale.centre_unit_deg), -180.0, 180.0)?;
    check_range("centre-offset-deg", Some(scale.centre_offset_deg), -90.0, 90.0)?;
    check_range("limit-deg", Some(scale.limit_deg), 1.0, 90.0)?;
    Ok(scale)
}

/// The failure to read a recording, with its help.
pub fn unreadable(error: TrajectoryError) -> Failure {
    let help = match &error {
        TrajectoryError::File(_) => {
            "`host record` writes runs/latest/trajectory.csv; or name a CSV of your own"
        }
        TrajectoryError::NoHeader { .. } | TrajectoryError::MissingJoints { .. } => {
            "name the columns, left to right: --columns time_s,hip1,ank1,-,... (or `columns` in --map FILE)"
        }
        TrajectoryError::UnevenTime { .. } => {
            "choose rows without a gap (--rows A..B), or give the duration yourself (--period S)"
        }
        TrajectoryError::Number { .. } | TrajectoryError::RowLength { .. } => {
            "correct the line, or skip a column of no interest with `-` in --columns"
        }
        _ => return failure(Cause::Input, error),
    };
    failure_with_help(Cause::Input, error, help)
}
