//! `host optimise`: search the trajectory itself, in the simulated robot.
//!
//! Holds the flags, the run's folder and Ctrl-C. Does not depend on how gaits
//! are searched, which is [`crate::search::optimise`]'s; `report` has the words.

mod budget;
mod front;
mod report;
mod session;
mod start;

use super::explain::failure;
use super::new_gait::{NewGait, machine};
use super::reach::interruptible;
use super::{Cause, Failure};
use crate::gait::gait_file::{GaitFile, Source};
use crate::gait::scale::TABLE_DEG_PER_ACTION;
use crate::plot::PlotError;
use crate::robot::Robot;
use crate::run_folder;
use crate::search::optimise::basis::Basis;
use crate::search::optimise::figure;
use crate::search::optimise::report::safe_range;
use crate::search::optimise::score::{Aim, Counted, usual_speed_m_s};
use crate::search::optimise::space::Motion;
use crate::search::optimise::tolerances::Tolerances;
use budget::Budget;
use clap::ValueEnum;
use report::Outcome;
use session::SearchSession;
use std::path::{Path, PathBuf};
use std::time::Instant;
use thiserror::Error;

/// The search aims a little higher than what is asked for, so that the median reaches it.
const SPEED_RESERVE: f64 = 1.05;
/// Beginning of the name of a gait without `--name`.
const NAME_PREFIX: &str = "opt";
/// Cost and speed over amplitudes.
const AMPLITUDES_FIGURE: &str = "amplitudes.svg";

/// What is optimised.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Objective {
    /// The lowest cost of transport, at --min-speed or faster
    Cot,
    /// The highest speed, at any cost of transport
    Speed,
    /// The most efficient gaits from 0.6 to 2 times --min-speed, as a table and a picture
    Pareto,
}

/// Search for a gait in simulation, without learning.
///
/// Searches all gaits that the firmware can play for the most efficient or the fastest one,
/// tested on robots that vary as real robots, floors and batteries do. The result is a gait
/// file like any other. The same seed and budget give the same gait.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    new: NewGait,
    /// What to optimise
    #[arg(long, value_enum, default_value_t = Objective::Cot)]
    objective: Objective,
    /// Minimum speed in m/s, not with `--objective speed` [default: 0.25 for the Ant's long legs,
    /// 0.2 for its short ones]
    #[arg(long, value_name = "M_S")]
    min_speed: Option<f64>,
    /// Where to start: `nothing`, `sinusoid`, a gait file, or a run folder with one
    #[arg(long, default_value = "sinusoid", value_name = "nothing|sinusoid|GAIT|RUN")]
    start: String,
    /// Amplitude of the gait to start from [default: 1.875, a policy's own stroke; 1 for a
    /// searched gait]
    #[arg(long, value_name = "X")]
    start_amp: Option<f64>,
    /// How long to search: 10m or 600s (time on two cores), or a number of trials; a front of
    /// eight speeds needs several times as long
    #[arg(long, default_value = "10m", value_name = "TIME|TRIALS")]
    budget: Budget,
    /// Number of robots in the report, none of which the search has seen
    #[arg(long, default_value_t = 32, value_name = "N", value_parser = clap::value_parser!(u16).range(8..=1000))]
    draws: u16,
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
    #[error("--min-speed is for --objective cot and pareto; --objective speed searches for the fastest gait")]
    MinSpeedOfSpeed,
    #[error("--start-amp is for a gait to start from; --start {start} has no amplitude")]
    AmplitudeOfNoGait { start: String },
    #[error("--budget is {trials} trials; a front needs at least {least} ({}s), for the searches of its speeds", Budget::seconds(*.least))]
    FrontBudget { trials: u64, least: u64 },
    #[error("interrupted after {trials} trials; the best gait so far is in {}", .path.display())]
    Interrupted { trials: u64, path: PathBuf },
    #[error("interrupted while the report was made, after a whole search of {trials} trials; the gait is in {}", .path.display())]
    ReportInterrupted { trials: u64, path: PathBuf },
    #[error("the curves to search among could not be computed")]
    Basis,
}

pub fn run(args: Args) -> Result<(), Failure> {
    let began = Instant::now();
    check(&args)?;
    let robot = args.new.robot()?;
    super::robots::warn_of(&robot);
    let start = start::read(&args.start, args.start_amp)?;
    let basis = Basis::new().ok_or_else(|| failure(Cause::Machine, OptimiseError::Basis))?;
    let stop = interruptible()?;
    let folder = args.new.folder("optimise", &robot)?;

    let at_least_m_s = args.min_speed.unwrap_or_else(|| usual_speed_m_s(&robot));
    let aim = match args.objective {
        Objective::Cot | Objective::Pareto => front::aim(at_least_m_s),
        Objective::Speed => Aim::Speed,
    };
    let session = SearchSession {
        args: &args,
        robot: &robot,
        basis: &basis,
        stop: &stop,
        tolerances: Tolerances::default(),
        counted: Counted::of(&robot),
    };
    let whole = args.budget.trials;
    let is_front = args.objective == Objective::Pareto;
    let mut found = session.first(aim, &start, if is_front { front::first_budget(whole) } else { whole });
    if is_front {
        front::search(&session, &mut found, at_least_m_s);
    }
    found.motion = session.forward(found.motion);

    let name = args.new.name_or(NAME_PREFIX, &robot);
    let path = folder.join(run_folder::GAIT);
    let mut gait = gait(&args, &robot, &name, &found.motion, None);
    // Now, so that whatever happens to the report leaves the gait.
    gait.save(&path).map_err(|error| failure(Cause::Machine, error))?;
    eprintln!("search done; testing the gait on {} robots that the search has not seen", args.draws);
    let walks = session.over_draws(&found.motion);
    let amplitudes = session.over_amplitudes(&found.motion);
    let front = is_front.then(|| front::of(&session, &found, at_least_m_s));
    let interrupted = found.stopped || session.stopped();
    gait.provenance.safe_amplitudes = safe_range(&amplitudes).map(|(least, most)| [least, most]);
    let outcome = Outcome {
        robot: &robot,
        gait: &gait,
        path: &path,
        motion: &found.motion,
        walks: &walks,
        amplitudes: &amplitudes,
        trials: found.trials,
        at_least_m_s: matches!(aim, Aim::Cost { .. }).then_some(at_least_m_s),
        seed: args.new.seed,
        wall_s: began.elapsed().as_secs_f64(),
        interrupted,
    };
    let json = save(&session, &outcome, front.as_ref(), &folder)?;
    outcome.warn();
    if args.json {
        println!("{json:#}");
    } else {
        outcome.print();
        if let Some(front) = &front {
            front::print(front, &robot, &folder);
        }
    }
    let trials = found.trials;
    match (found.stopped, interrupted) {
        (true, _) => Err(failure(Cause::Interrupted, OptimiseError::Interrupted { trials, path })),
        (_, true) => Err(failure(Cause::Interrupted, OptimiseError::ReportInterrupted { trials, path })),
        _ => Ok(()),
    }
}

/// Checks before the search what would be refused after it.
fn check(args: &Args) -> Result<(), Failure> {
    let usage = |error: OptimiseError| failure(Cause::Usage, error);
    if let Some(value) = args.min_speed.filter(|speed| !(0.02..=2.0).contains(speed)) {
        return Err(usage(OptimiseError::MinSpeed { value }));
    }
    if let Some(value) = args.start_amp.filter(|amplitude| !(0.1..=3.0).contains(amplitude)) {
        return Err(usage(OptimiseError::StartAmplitude { value }));
    }
    if args.min_speed.is_some() && args.objective == Objective::Speed {
        return Err(usage(OptimiseError::MinSpeedOfSpeed));
    }
    if args.start_amp.is_some() && !start::is_a_gait(&args.start) {
        return Err(usage(OptimiseError::AmplitudeOfNoGait { start: args.start.clone() }));
    }
    let (trials, least) = (args.budget.trials, front::least_budget());
    if args.objective == Objective::Pareto && trials < least {
        return Err(usage(OptimiseError::FrontBudget { trials, least }));
    }
    args.new.check()
}

/// Writes everything; returns the result for scripts.
fn save(
    session: &SearchSession<'_>,
    outcome: &Outcome<'_>,
    front: Option<&front::Front>,
    folder: &Path,
) -> Result<serde_json::Value, Failure> {
    outcome.gait.save(outcome.path).map_err(|error| failure(Cause::Machine, error))?;
    if !outcome.amplitudes.is_empty() {
        write_figure(&folder.join(AMPLITUDES_FIGURE), figure::of_amplitudes(outcome.amplitudes).to_svg())?;
    }
    let front = front.map(|front| front::save(front, session, folder)).transpose()?;
    let json = serde_json::to_value(outcome.result(front)).map_err(|error| failure(Cause::Machine, error))?;
    let text = format!("{json:#}\n");
    run_folder::write(&folder.join(run_folder::SUMMARY), text.as_bytes()).map_err(machine)?;
    Ok(json)
}

fn write_figure(path: &Path, drawn: Result<String, PlotError>) -> Result<(), Failure> {
    let svg = drawn.map_err(|error| failure(Cause::Machine, error))?;
    run_folder::write(path, svg.as_bytes()).map_err(|error| failure(Cause::Machine, error))
}

fn gait(args: &Args, robot: &Robot, name: &str, motion: &Motion, safe: Option<(f64, f64)>) -> GaitFile {
    let joints = motion.series(&robot.joint_reaches_deg());
    let mut gait =
        args.new.file(robot, name, Source::Searched, motion.period_s, TABLE_DEG_PER_ACTION, joints);
    gait.provenance.safe_amplitudes = safe.map(|(least, most)| [least, most]);
    gait
}
