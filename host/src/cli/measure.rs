//! `host measure`: walks a trial and computes its cost of transport.
//!
//! Holds the flags, the checks before anything moves, and the order of things after:
//! numbers are printed before files are written, so a full disk costs no trial. Does
//! not depend on how the robot walks ([`crate::device::trial`]).

mod distance;
mod last;
mod report;

use super::explain::{failure, failure_with_help, file_cause};
use super::ranges::{DURATION_RANGE_S, check_range};
use super::reach::{Port, interruptible, unreachable_robot};
use super::{Cause, Failure, agreement, robots};
use crate::device::link::ports::SerialLink;
use crate::device::link::{LinkError, words};
use crate::device::tracker::top_speed::TopSpeed;
use crate::device::trial::table::{self, Row, TableError};
use crate::device::trial::{self, Order, TrialStop, clock};
use crate::gait::gait_file::limits::as_typed;
use crate::gait::gait_file::{GaitFile, gait_sha256};
use crate::gait::gait_player::Playable;
use crate::robot::{LegScale, Robot};
use crate::run_folder::{self, FileError};
use distance::Source;
use indicatif::{ProgressBar, ProgressStyle};
use protocol::command::{ActiveGait, Record};
use protocol::{Amplitude, FRAME_RATE_HZ, Refusal, State};
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;
use thiserror::Error;

/// Walk a trial and compute cost of transport and speed.
///
/// The trial starts with the first gait frame, after the slow entry; energy,
/// distance and frames cover the same interval. Without --distance and
/// --tracker you are asked for the distance afterwards.
///
/// The robot walks attached: this program sends it a command four times a second, and
/// it stops by itself within a second if the program ends or the cable is unplugged.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Do not walk: show what the robot recorded of its last walk, even one without a host
    #[arg(long, conflicts_with_all = ["duration", "amplitude", "clip"])]
    last: bool,
    /// Duration of the trial in seconds
    #[arg(long, value_name = "S", default_value_t = 12.0)]
    duration: f64,
    /// Amplitude of this trial [default: as uploaded]
    #[arg(long = "amp", value_name = "X")]
    amplitude: Option<f64>,
    /// Walk even if joints are held at their limits at --amp
    #[arg(long)]
    clip: bool,
    /// Net horizontal distance, if it is known before the trial
    #[arg(long, value_name = "M", conflicts_with = "tracker", allow_negative_numbers = true)]
    distance: Option<f64>,
    /// Positions: CSV with time_s,x_m,y_m (Unix time, or 0 = first gait frame; metres on the
    /// floor, z up), or the virtual robot's JSON lines
    #[arg(long, value_name = "FILE")]
    tracker: Option<PathBuf>,
    /// Mass of the robot [default: from --robot]
    #[arg(long, value_name = "KG", conflicts_with = "robot")]
    mass_kg: Option<f64>,
    /// Folder of the robot [default: the run's, else the Ant]
    #[arg(long, value_name = "FOLDER")]
    robot: Option<PathBuf>,
    /// Walk although the robot is calibrated otherwise than its description says; the trial is
    /// marked
    #[arg(long)]
    anyway: bool,
    #[command(flatten)]
    port: Port,
    /// Folder for trials.csv and the telemetry [default: the last run]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Error)]
enum MeasureError {
    #[error("the distance is unknown, and cannot be asked for: standard input is not a terminal")]
    UnknownDistance,
    #[error("no distance was entered; the trial is noted without one")]
    NoAnswer,
    #[error("{distance_m:.3} m in {duration_s:.2} s is {speed_m_s:.3} m/s, and {top}: is it in {unit}?")]
    TooFast { distance_m: f64, duration_s: f64, speed_m_s: f64, top: TopSpeed, unit: &'static str },
    #[error("the INA219 sees current flowing backwards: exchange VIN+ and VIN-")]
    Backwards,
    #[error(
        "the robot walked and measured no energy: the INA219 sees no current, or current flowing backwards: \
         see that the servos' supply goes in at VIN+ and out at VIN-"
    )]
    NoEnergy,
    #[error("no telemetry of the trial arrived, so its place in the tracker's recording is unknown")]
    NoTelemetry,
}

pub fn run(args: Args) -> Result<(), Failure> {
    let frames = check_flags(&args)?;
    if args.last {
        return last::run(&args);
    }
    let source = Source::choose(args.distance, args.tracker.as_deref())?;
    let folder = folder(&args)?;
    table::load(&folder).map_err(unwritable)?;
    let mass_kg = mass_kg(&args, &folder)?;

    let mut link = args.port.connect()?;
    let gait = Gait::on(&mut link, &args)?;
    let differs = match described(&args, &folder)? {
        Some(robot) => {
            gait.check_robot(&robot, &args, &folder)?;
            agreement::check(&mut link, &robot, args.anyway, &args.port)?
        }
        None => None,
    };
    if let Some(differs) = &differs {
        eprintln!("warning: the robot is {differs}");
    }
    let stop = interruptible()?;
    let bar = progress_bar(frames);
    let order = Order { amplitude: args.amplitude.and_then(Amplitude::from_f64), ..Order::of(frames) };
    let trial = trial::walk(&mut link, &order, &stop, |state: State, played: u32| {
        bar.set_message(words::state(state));
        if state != State::Entering {
            bar.set_position(u64::from(played));
        }
    });
    bar.finish_and_clear();
    let mut trial = trial.map_err(unreachable_robot)?;
    drop(link);
    // Nothing moves any more: from here on Ctrl-C ends the program immediately.
    stop.store(true, Ordering::Relaxed);

    let mut outcome = report::Outcome::of(&trial, &gait, mass_kg);
    outcome.row.remark = differs;
    let telemetry = table::write_telemetry(&folder, &trial.samples);
    if let Ok(path) = &telemetry {
        outcome.row.telemetry = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    }
    let failed = match trial.stop.take() {
        Some(stop) => Some(stopped(stop, &mut outcome.row)),
        None => {
            let interval = clock::interval(&trial.samples);
            outcome.add_distance(&source, interval, top_speed(&args, &folder)).err()
        }
    };
    outcome.row.time = jiff::Zoned::now().strftime("%Y-%m-%dT%H:%M:%S%:z").to_string();
    outcome.print(&args, &folder);
    let noted = table::append(&folder, &outcome.row);
    if let Some(failed) = failed {
        return Err(failed);
    }
    telemetry.map_err(|e| unwritable(e.into()))?;
    noted.map_err(unwritable)?;
    Ok(())
}

/// What the robot is about to walk.
struct Gait {
    active: ActiveGait,
    amplitude: Amplitude,
    sha256: String,
}

impl Gait {
    /// Brings the robot to rest and looks at the gait it has.
    fn on(link: &mut SerialLink, args: &Args) -> Result<Self, Failure> {
        let no_gait = LinkError::Refused { command: "walk", refusal: Refusal::NoGait };
        trial::prepare(link).map_err(unreachable_robot)?;
        let status = link.status().map_err(unreachable_robot)?;
        let Some(active) = status.gait else { return Err(unreachable_robot(no_gait)) };
        let bytes = link.read(Record::Gait).map_err(unreachable_robot)?;
        let amplitude = args.amplitude.and_then(Amplitude::from_f64).unwrap_or(active.amplitude);
        if let (Some(asked), Ok(playable), false) = (args.amplitude, Playable::from_bytes(&bytes), args.clip)
        {
            playable.check_limits(asked).map_err(super::reach::beyond_limits)?;
        }
        Ok(Self { active, amplitude, sha256: gait_sha256(&bytes) })
    }

    /// Refuses a gait whose file says that it is of another robot.
    fn check_robot(&self, robot: &Robot, args: &Args, folder: &Path) -> Result<(), Failure> {
        let file = GaitFile::load(&folder.join(run_folder::GAIT)).ok();
        let is_same = |gait: &GaitFile| gait.encoded().is_ok_and(|bytes| gait_sha256(&bytes) == self.sha256);
        match file.filter(is_same) {
            Some(gait) if !args.anyway && args.robot.is_none() => {
                robots::check_gait(&gait.provenance, robot, &folder.join(run_folder::GAIT))
            }
            _ => Ok(()),
        }
    }

    /// Its provenance, if the folder's gait file is the same gait.
    fn source(&self, folder: &Path) -> Option<&'static str> {
        let gait = GaitFile::load(&folder.join(run_folder::GAIT)).ok()?;
        (gait_sha256(&gait.encoded().ok()?) == self.sha256).then(|| gait.provenance.source.name())
    }
}

fn check_flags(args: &Args) -> Result<u32, Failure> {
    check_range("duration", Some(args.duration), DURATION_RANGE_S.0, DURATION_RANGE_S.1)?;
    check_range("amp", args.amplitude, Amplitude::MIN.value(), Amplitude::MAX.value())?;
    check_range("distance", args.distance, 0.0, 1e4)?;
    check_range("mass-kg", args.mass_kg, 0.01, 1e3)?;
    Ok((args.duration * f64::from(FRAME_RATE_HZ)).round() as u32)
}

fn folder(args: &Args) -> Result<PathBuf, Failure> {
    let machine = |e: FileError| failure(file_cause(&e), e);
    let latest = Path::new(run_folder::LATEST);
    match &args.out {
        Some(out) => {
            std::fs::create_dir_all(out).map_err(FileError::on("create", out)).map_err(machine)?;
            Ok(out.clone())
        }
        None if latest.is_dir() => Ok(latest.to_owned()),
        None => {
            let folder = run_folder::create("measure").map_err(machine)?;
            run_folder::make_latest(&folder).map_err(machine)?;
            Ok(folder)
        }
    }
}

fn mass_kg(args: &Args, folder: &Path) -> Result<f64, Failure> {
    if let Some(mass_kg) = args.mass_kg {
        return Ok(mass_kg);
    }
    robots::of(args.robot.as_deref(), folder)
        // A sum of parts: 0.8999999999999999 would be printed as such.
        .map(|robot| (robot.mass_kg() * 1e9).round() / 1e9)
        .map_err(|e| failure_with_help(Cause::Input, e, "or give the robot's mass: --mass-kg KG"))
}

/// The robot that should be connected; of one with a mass only, nothing else is known.
fn described(args: &Args, folder: &Path) -> Result<Option<Robot>, Failure> {
    let robot = match (&args.robot, args.mass_kg) {
        (None, Some(_)) => Robot::of_run(folder),
        (named, _) => robots::of(named.as_deref(), folder).map(Some),
    };
    robot.map_err(|e| failure(Cause::Input, e))
}

/// By the robot's legs; the Ant's where its description cannot be read.
fn top_speed(args: &Args, folder: &Path) -> TopSpeed {
    let robot = robots::of(args.robot.as_deref(), folder).or_else(|_| Robot::ant(LegScale::LONG));
    robot.map_or(TopSpeed::of_legs(1e6), |robot| distance::top_speed(&robot))
}

fn unwritable(error: TableError) -> Failure {
    match &error {
        TableError::File(file) => {
            let cause = file_cause(file);
            failure_with_help(cause, error, "free some space, or choose another folder: --out DIR")
        }
        TableError::Columns { .. } => {
            failure_with_help(Cause::Input, error, "move it away, or choose another folder: --out DIR")
        }
    }
}

/// Writes into the row why the trial does not count.
fn stopped(stop: TrialStop, row: &mut Row) -> Failure {
    row.reason = Some(match &stop {
        TrialStop::Link { source } => source.to_string(),
        other => other.to_string(),
    });
    super::reach::stopped(stop, "repeat the trial. It is noted as not valid")
}

/// On standard error, and only at a terminal: JSON has standard output to itself.
fn progress_bar(frames: u32) -> ProgressBar {
    let bar = ProgressBar::new(u64::from(frames));
    let style = ProgressStyle::with_template("{msg:9} {bar:40} {pos}/{len} frames, {eta} left");
    bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
    bar
}
