//! `host fit`: a trajectory in, a gait out.
//!
//! Owns the flags and the choice of rows, scales and provenance; the reading,
//! the fit and the file are the library's.

mod history;
mod refusal;
mod report;

use super::explain::{failure, failure_with_help};
use super::{Cause, Failure};
use crate::fit::{self, Scale, Seam};
use crate::gait_file::GaitFile;
use crate::joint_map::{JointMap, JointMapError};
use crate::robot::Robot;
use crate::run_folder;
use crate::trajectory::Trajectory;
use crate::trajectory::loop_finder::{self, Loop};
use protocol::gait::{MAX_PERIOD_US, MIN_PERIOD_US};
use refusal::{unplayable, unreadable, unsaved};
use std::ops::Range;
use std::path::PathBuf;
use std::str::FromStr;
use thiserror::Error;

/// Degrees per unit of action in simulation, where our centres come from.
const SIMULATED_UNIT_DEG: f64 = 45.0;
/// Degrees per unit of action on the authors' robot: 40 ticks of 0.6 degree.
const ROBOT_UNIT_DEG: f64 = 24.0;
/// Joint limit of a robot that nobody described.
const DEFAULT_LIMIT_DEG: f64 = 45.0;

/// Fit a degree-10 polynomial per joint and write the gait.
///
/// Without --rows, a file as `record` writes it is one stride, and in any other
/// the stride is looked for. Columns hold actions, and the scales are degrees:
/// angle = centre-offset + centre-unit * mean action + amplitude * unit *
/// (action - mean action). Columns in degrees: --unit-deg 1 --centre-unit-deg 1.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// CSV with a column per joint [default: trajectory.csv of the run]
    trajectory: Option<PathBuf>,
    /// Run folder whose trajectory is fitted
    #[arg(long, value_name = "DIR", default_value = run_folder::LATEST, conflicts_with = "trajectory")]
    run: PathBuf,
    /// Data rows of one stride, counted from 0, B excluded: `973..1000`; or `all`
    #[arg(long, value_name = "A..B")]
    rows: Option<Rows>,
    /// How long those rows last in the recording; needed if it has no time_s
    #[arg(long, value_name = "S")]
    period: Option<f64>,
    /// Play this many times slower than the recording
    #[arg(long, value_name = "X", default_value_t = 1.0)]
    time_stretch: f64,
    /// TOML with columns, signs and scales; flags override it
    #[arg(long, value_name = "FILE")]
    map: Option<PathBuf>,
    /// What each column holds: a joint, time_s, or `-` to skip it
    #[arg(long, value_delimiter = ',', value_name = "NAMES")]
    columns: Option<Vec<String>>,
    /// Joints that turn the other way on the robot: `ank3,ank4`
    #[arg(long, value_delimiter = ',', value_name = "JOINTS")]
    negate: Option<Vec<String>>,
    /// Degrees per unit of action at amplitude 1.0 [default: 24]
    #[arg(long, value_name = "DEG")]
    unit_deg: Option<f64>,
    /// Degrees per unit of the mean action [default: 45, as simulated]
    #[arg(long, value_name = "DEG")]
    centre_unit_deg: Option<f64>,
    /// Degrees between action 0 and neutral [default: 0]
    #[arg(long, value_name = "DEG", allow_negative_numbers = true)]
    centre_offset_deg: Option<f64>,
    /// Joint limit either way [default: that of the run's robot or of --leg's, else 45]
    #[arg(long, value_name = "DEG")]
    limit_deg: Option<f64>,
    /// Leg length the gait is meant for: 1.0 is 23 cm, 0.6 is 13.8 cm
    #[arg(long, value_name = "X")]
    leg: Option<f64>,
    /// How strides join [default: continuous for a whole stride as `record` writes it, else free as in the paper]
    #[arg(long, value_name = "free|continuous")]
    seam: Option<Seam>,
    /// What the robot will call it, up to 16 characters [default: from the file or the seed]
    #[arg(long)]
    name: Option<String>,
    /// Seed to note in the gait [default: from the run's configuration]
    #[arg(long, value_parser = super::seed())]
    seed: Option<u64>,
    /// Gait file to write; the robot's bytes go beside it as .bin [default: gait.toml beside a
    /// trajectory with time_s, else in a new run folder]
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
}

/// Which rows to fit.
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

/// A flag that clap cannot judge.
#[derive(Debug, Error)]
enum BadFlag {
    #[error("{text:?} are no rows: write A..B with A below B, counted from 0, or `all`")]
    Rows { text: String },
    #[error("--{flag} is {value}; it must be within {min} to {max}")]
    Range { flag: &'static str, value: f64, min: f64, max: f64 },
    #[error("--out {} does not end in .toml", .path.display())]
    Out { path: PathBuf },
    #[error("{} has no time_s column, so the duration of its rows is unknown", .path.display())]
    NoPeriod { path: PathBuf },
    #[error(
        "the stride would last {played_s:.3} s ({recorded_s:.3} s recorded, times {stretch}); a robot plays {} to {} s",
        f64::from(MIN_PERIOD_US) / 1e6, f64::from(MAX_PERIOD_US) / 1e6
    )]
    Period { recorded_s: f64, stretch: f64, played_s: f64 },
}

/// What was fitted, for the report.
struct Chosen {
    rows: Range<usize>,
    found: Option<Loop>,
    recorded_s: f64,
    seam: Seam,
}

impl Args {
    fn trajectory(&self) -> PathBuf {
        self.trajectory.clone().unwrap_or_else(|| self.run.join(run_folder::TRAJECTORY))
    }
}

pub fn run(args: Args) -> Result<(), Failure> {
    let map = joint_map(&args)?;
    check_flags(&args)?;
    let trajectory = Trajectory::read(&args.trajectory(), map.columns.as_deref()).map_err(unreadable)?;
    let chosen = choose(&args, &trajectory)?;
    let robot = robot(&args)?;
    let scale = scale(&map, robot.as_ref())?;
    let rows = trajectory.rows(chosen.rows.start, chosen.rows.end).map_err(unreadable)?;
    let fits = fit::fit(rows, &scale, chosen.seam).map_err(|e| failure(Cause::Input, e))?;

    let provenance = history::provenance(&args, &trajectory, &chosen, robot.as_ref());
    let gait = GaitFile {
        name: args.name.clone().unwrap_or_else(|| history::default_name(&args.trajectory(), &provenance)),
        period_s: chosen.recorded_s * args.time_stretch,
        unit_deg: scale.unit_deg,
        provenance,
        joints: fits.clone().map(|fit| fit.series),
    };
    gait.check().map_err(unplayable)?;
    let out = history::out_path(&args, &trajectory)?;
    gait.save(&out).map_err(unsaved)?;
    report::print(&args, &out, &gait, &fits, &chosen);
    Ok(())
}

fn joint_map(args: &Args) -> Result<JointMap, Failure> {
    let flags = JointMap {
        columns: args.columns.clone(),
        negate: args.negate.clone(),
        unit_deg: args.unit_deg,
        centre_unit_deg: args.centre_unit_deg,
        centre_offset_deg: args.centre_offset_deg,
        limit_deg: args.limit_deg,
    };
    let Some(path) = &args.map else { return Ok(flags) };
    let file = JointMap::load(path).map_err(|e| failure(Cause::Input, e))?;
    Ok(flags.or(file))
}

fn check_flags(args: &Args) -> Result<(), Failure> {
    let ranges =
        [("time-stretch", Some(args.time_stretch), 0.01, 1000.0), ("period", args.period, 1e-3, 1e4)];
    for (flag, value, min, max) in ranges {
        check_range(flag, value, min, max)?;
    }
    match &args.out {
        Some(path) if path.extension().is_none_or(|e| e != "toml") => {
            Err(failure(Cause::Usage, BadFlag::Out { path: path.clone() }))
        }
        _ => Ok(()),
    }
}

fn check_range(flag: &'static str, value: Option<f64>, min: f64, max: f64) -> Result<(), Failure> {
    match value {
        Some(value) if !(min..=max).contains(&value) => {
            Err(failure(Cause::Usage, BadFlag::Range { flag, value, min, max }))
        }
        _ => Ok(()),
    }
}

/// Which rows make the stride, and how long they last.
fn choose(args: &Args, trajectory: &Trajectory) -> Result<Chosen, Failure> {
    let whole = 0..trajectory.actions.len();
    let (rows, found) = match &args.rows {
        Some(Rows::Range(rows)) => (rows.clone(), None),
        Some(Rows::All) => (whole, None),
        None if trajectory.is_own_stride => (whole, None),
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
    let recorded_s = match args.period {
        Some(period_s) => period_s,
        None => {
            let interval_s = trajectory.interval_s(rows.start, rows.end).map_err(unreadable)?;
            let interval_s = interval_s.ok_or_else(|| {
                let help = "--period S says how long the chosen rows last in the recording";
                failure_with_help(Cause::Usage, BadFlag::NoPeriod { path: args.trajectory() }, help)
            })?;
            interval_s * rows.len() as f64
        }
    };
    let played_s = recorded_s * args.time_stretch;
    if !(f64::from(MIN_PERIOD_US)..=f64::from(MAX_PERIOD_US)).contains(&(played_s * 1e6)) {
        let error = BadFlag::Period { recorded_s, stretch: args.time_stretch, played_s };
        return Err(failure_with_help(Cause::Input, error, "see --period and --time-stretch"));
    }
    let is_whole_stride = trajectory.is_own_stride && args.rows.is_none();
    let default_seam = if is_whole_stride { Seam::Continuous } else { Seam::Free };
    Ok(Chosen { rows, found, recorded_s, seam: args.seam.unwrap_or(default_seam) })
}

/// The robot that the gait is meant for, as far as it is known.
fn robot(args: &Args) -> Result<Option<Robot>, Failure> {
    let beside = args.trajectory().with_file_name(run_folder::ROBOT);
    let robot = match args.leg {
        Some(leg) => Some(Robot::ant(leg)),
        None if beside.is_file() => Some(Robot::load(&beside)),
        None => None,
    };
    robot.transpose().map_err(|e| failure(Cause::Input, e))
}

fn scale(map: &JointMap, robot: Option<&Robot>) -> Result<Scale, Failure> {
    let scale = Scale {
        signs: map.signs().map_err(|e: JointMapError| failure(Cause::Usage, e))?,
        unit_deg: map.unit_deg.unwrap_or(ROBOT_UNIT_DEG),
        centre_unit_deg: map.centre_unit_deg.unwrap_or(SIMULATED_UNIT_DEG),
        centre_offset_deg: map.centre_offset_deg.unwrap_or(0.0),
        limit_deg: map.limit_deg.or(robot.map(|r| r.joint_limit_deg)).unwrap_or(DEFAULT_LIMIT_DEG),
    };
    check_range("unit-deg", Some(scale.unit_deg), 0.1, 120.0)?;
    check_range("centre-unit-deg", Some(scale.centre_unit_deg), -180.0, 180.0)?;
    check_range("centre-offset-deg", Some(scale.centre_offset_deg), -90.0, 90.0)?;
    check_range("limit-deg", Some(scale.limit_deg), 1.0, 90.0)?;
    Ok(scale)
}
