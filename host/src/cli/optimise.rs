//! `host optimise`: search the trajectory itself, in the fitted twin.
//!
//! Owns the flags, the run's folder and Ctrl-C; the search is
//! [`crate::optimise`]'s, the words stand in `report`.

mod budget;
mod front;
mod hunt;
mod report;
mod start;

use super::explain::failure;
use super::{Cause, Failure};
use crate::gait_file::{GaitFile, Provenance, Source};
use crate::optimise::basis::Basis;
use crate::optimise::figure;
use crate::optimise::report::safe_range;
use crate::optimise::score::{Aim, usual_speed_m_s};
use crate::optimise::space::Motion;
use crate::optimise::tolerances::Tolerances;
use crate::plot::PlotError;
use crate::robot::Robot;
use crate::run_folder;
use budget::Budget;
use clap::ValueEnum;
use hunt::Hunt;
use report::Outcome;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;
use thiserror::Error;

/// Searched for a little more than what is asked for: the median must reach it.
const SPEED_RESERVE: f64 = 1.05;
/// Cost and speed over amplitudes.
const AMPLITUDES_FIGURE: &str = "amplitudes.svg";

/// What is wanted of a gait.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Objective {
    /// The least cost of transport, at --min-speed or more
    Cot,
    /// The most speed, whatever it costs
    Speed,
    /// The cheapest gaits of eight speeds, in a table and a picture
    Pareto,
}

/// Search a gait in the simulated robot itself, without learning.
///
/// Looks among all gaits that the firmware plays for the cheapest or the fastest one, over
/// robots that differ from the fitted one as robots, floors and batteries do. What it finds is
/// a gait file like any other. The same seed and budget give the same gait.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Shins: 1.0 is 23 cm, 0.6 is 13.8 cm
    #[arg(long, default_value_t = 1.0, value_name = "SCALE")]
    leg: f64,
    /// Folder of a robot other than the Ant
    #[arg(long, value_name = "FOLDER", conflicts_with = "leg")]
    robot: Option<PathBuf>,
    /// What is wanted
    #[arg(long, value_enum, default_value_t = Objective::Cot)]
    objective: Objective,
    /// Least speed of a cheap gait, in m/s [default: 0.25 for the Ant's long legs, 0.2 for its
    /// short ones]
    #[arg(long, value_name = "M_S")]
    min_speed: Option<f64>,
    /// Where to begin: `nothing`, `sinusoid`, a gait file, or a run folder with one
    #[arg(long, default_value = "sinusoid", value_name = "nothing|sinusoid|GAIT|RUN")]
    start: String,
    /// Amplitude of a gait that is begun from [default: 1.875, a policy's own stroke; 1 for a
    /// searched gait]
    #[arg(long, value_name = "X")]
    start_amp: Option<f64>,
    /// How long to search: 10m or 600s by the clock of two cores, or a number of trials
    #[arg(long, default_value = "10m", value_name = "TIME|TRIALS")]
    budget: Budget,
    /// Of everything that is drawn
    #[arg(long, default_value_t = 0, value_parser = super::seed())]
    seed: u64,
    /// Robots that the report is made on, which the search has not seen
    #[arg(long, default_value_t = 32, value_name = "N", value_parser = clap::value_parser!(u16).range(8..=1000))]
    draws: u16,
    /// What the robot will call the gait, up to 16 characters [default: from leg and seed]
    #[arg(long)]
    name: Option<String>,
    /// Folder for gait and report [default: a new one in runs]
    #[arg(long, value_name = "FOLDER")]
    out: Option<PathBuf>,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Error)]
enum OptimiseError {
    #[error("--min-speed is {value}; it must be within 0.02 to 2 m/s")]
    MinSpeed { value: f64 },
    #[error("--start-amp is {value}; it must be within 0.1 to 3")]
    StartAmplitude { value: f64 },
    #[error("--name is {name:?}; a name is 1 to {} printable ASCII characters", protocol::Name::CAPACITY)]
    Name { name: String },
    #[error("{} is there already: name another folder with --out", .path.display())]
    Taken { path: PathBuf },
    #[error("interrupted after {trials} trials; the best gait so far is in {}", .path.display())]
    Interrupted { trials: u64, path: PathBuf },
    #[error("the curves to search among could not be computed")]
    Basis,
    #[error("cannot catch Ctrl-C")]
    Signals { source: ctrlc::Error },
}

pub fn run(args: Args) -> Result<(), Failure> {
    let began = Instant::now();
    check(&args)?;
    let robot = match &args.robot {
        Some(folder) => Robot::load(folder),
        None => Robot::ant(args.leg),
    }
    .map_err(|error| failure(Cause::Input, error))?;
    let start = start::read(&args.start, args.start_amp)?;
    let basis = Basis::new().ok_or_else(|| failure(Cause::Machine, OptimiseError::Basis))?;
    let stop = stop_flag()?;
    let folder = folder(&args)?;
    // First, so that a folder that cannot be written costs no search.
    robot.save(&folder.join(run_folder::ROBOT)).map_err(|error| failure(Cause::Machine, error))?;

    let at_least_m_s = args.min_speed.unwrap_or_else(|| usual_speed_m_s(&robot));
    let aim = match args.objective {
        Objective::Cot | Objective::Pareto => Aim::Cost { at_least_m_s: SPEED_RESERVE * at_least_m_s },
        Objective::Speed => Aim::Speed,
    };
    let hunt =
        Hunt { args: &args, robot: &robot, basis: &basis, stop: &stop, tolerances: Tolerances::default() };
    let whole = args.budget.trials;
    let is_front = args.objective == Objective::Pareto;
    let budget = if is_front { (front::FIRST_SHARE * whole as f64) as u64 } else { whole };
    let mut found = hunt.first(aim, &start, budget);
    let front = if is_front { front::search(&hunt, &mut found, at_least_m_s) } else { Vec::new() };

    let amplitudes = hunt.over_amplitudes(&found.motion);
    let gait = gait(&args, &robot, &found.motion, safe_range(&amplitudes));
    let path = folder.join(run_folder::GAIT);
    let outcome = Outcome {
        robot: &robot,
        gait: &gait,
        path: &path,
        motion: &found.motion,
        walks: &hunt.over_draws(&found.motion),
        amplitudes: &amplitudes,
        trials: found.trials,
        at_least_m_s: matches!(aim, Aim::Cost { .. }).then_some(at_least_m_s),
        seed: args.seed,
        wall_s: began.elapsed().as_secs_f64(),
    };
    let json = save(&hunt, &outcome, &front, &folder)?;
    let median_m_s = outcome.walks.speed_m_s.median;
    if outcome.at_least_m_s.is_some_and(|asked_m_s| median_m_s < asked_m_s) {
        eprintln!(
            "warning: it walks at {median_m_s:.3} m/s, slower than the {at_least_m_s} m/s that were asked for; \
             search longer (--budget) or ask for less (--min-speed)"
        );
    }
    if args.json {
        println!("{json:#}");
    } else {
        outcome.print();
        front::print(&front, &robot, &folder);
    }
    if found.stopped {
        return Err(failure(Cause::Interrupted, OptimiseError::Interrupted { trials: found.trials, path }));
    }
    Ok(())
}

/// Refuses now what would be refused after the search.
fn check(args: &Args) -> Result<(), Failure> {
    let usage = |error: OptimiseError| failure(Cause::Usage, error);
    if let Some(value) = args.min_speed.filter(|speed| !(0.02..=2.0).contains(speed)) {
        return Err(usage(OptimiseError::MinSpeed { value }));
    }
    if let Some(value) = args.start_amp.filter(|amplitude| !(0.1..=3.0).contains(amplitude)) {
        return Err(usage(OptimiseError::StartAmplitude { value }));
    }
    if let Some(name) = args.name.as_ref().filter(|name| protocol::Name::new(name).is_none()) {
        return Err(usage(OptimiseError::Name { name: name.clone() }));
    }
    // A trained run, too, would no longer be what it says.
    let files = [run_folder::GAIT, run_folder::CONFIG, run_folder::ROBOT];
    let mut taken = args.out.iter().flat_map(|folder| files.map(|file| folder.join(file)));
    taken.find(|path| path.exists()).map_or(Ok(()), |path| Err(usage(OptimiseError::Taken { path })))
}

fn machine(error: run_folder::FileError) -> Failure {
    failure(super::explain::file_cause(&error), error)
}

fn folder(args: &Args) -> Result<PathBuf, Failure> {
    let Some(folder) = &args.out else { return run_folder::create("optimise").map_err(machine) };
    std::fs::create_dir_all(folder).map_err(run_folder::FileError::on("create", folder)).map_err(machine)?;
    Ok(folder.clone())
}

/// Writes everything; the result for scripts.
fn save(
    hunt: &Hunt<'_>,
    outcome: &Outcome<'_>,
    front: &[front::Point],
    folder: &Path,
) -> Result<serde_json::Value, Failure> {
    outcome.gait.save(outcome.path).map_err(|error| failure(Cause::Machine, error))?;
    let mut json = outcome.to_json();
    write_figure(&folder.join(AMPLITUDES_FIGURE), figure::of_amplitudes(outcome.amplitudes).to_svg())?;
    if !front.is_empty() {
        json["front"] = front::save(front, hunt, folder)?;
    }
    let text = format!("{json:#}\n");
    run_folder::write(&folder.join(run_folder::SUMMARY), text.as_bytes()).map_err(machine)?;
    if hunt.args.out.is_none() {
        run_folder::make_latest(folder).map_err(machine)?;
    }
    Ok(json)
}

fn write_figure(path: &Path, drawn: Result<String, PlotError>) -> Result<(), Failure> {
    let svg = drawn.map_err(|error| failure(Cause::Machine, error))?;
    run_folder::write(path, svg.as_bytes()).map_err(|error| failure(Cause::Machine, error))
}

fn stop_flag() -> Result<Arc<AtomicBool>, Failure> {
    let stop = Arc::new(AtomicBool::new(false));
    let asked = Arc::clone(&stop);
    ctrlc::set_handler(move || asked.store(true, Ordering::Relaxed))
        .map_err(|source| failure(Cause::Machine, OptimiseError::Signals { source }))?;
    Ok(stop)
}

fn gait(args: &Args, robot: &Robot, motion: &Motion, safe: Option<(f64, f64)>) -> GaitFile {
    let usual = || format!("opt-{}L-seed{}", robot.geometry.leg_scale, args.seed);
    let name: String = args.name.clone().unwrap_or_else(usual);
    let arguments = std::env::args_os().skip(1).map(|a| a.to_string_lossy().into_owned());
    GaitFile {
        name: name.chars().take(protocol::Name::CAPACITY).collect(),
        period_s: motion.period_s,
        unit_deg: 24.0,
        provenance: Provenance {
            seed: Some(args.seed),
            seam: Some("continuous".into()),
            leg_scale: Some(robot.geometry.leg_scale),
            command: Some(std::iter::once("host".to_owned()).chain(arguments).collect::<Vec<_>>().join(" ")),
            safe_amplitudes: safe.map(|(least, most)| [least, most]),
            ..Provenance::of(Source::Searched)
        },
        joints: motion.series(robot.joint_limit_deg.min(robot.servo.end_stop_deg)),
    }
}
