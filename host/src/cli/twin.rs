//! `host twin`: fit the simulated robot to measured trials, or validate it against them.
//!
//! Holds the flags and what is printed. Does not depend on how a fit is searched
//! or scored: see [`crate::twin`].

mod report;

use super::explain::{failure, failure_with_help, file_cause};
use super::{Cause, Failure};
use crate::energy::STANDARD_GRAVITY_M_S2;
use crate::robot::{LegScale, Robot};
use crate::run_folder;
use crate::twin::{self, Begin, Budget, Fit, Options, Parameter, Progress, Tables, Trials, TwinError};
use indicatif::{ProgressBar, ProgressStyle};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use thiserror::Error;

/// The best so far is written each time so many sets have been tried.
const SAVED_EVERY: u64 = 100;

/// Fit or validate the simulation against measured trials.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(subcommand)]
    command: Twin,
}

#[derive(Debug, clap::Subcommand)]
enum Twin {
    /// Fit the robot's parameters to the tables that it played and its measured trials
    Fit(FitArgs),
    /// Predict measured trials, and print the errors
    Validate(ValidateArgs),
}

/// Which measurements, of which robot.
#[derive(Debug, clap::Args)]
struct Data {
    /// What the robot played: method, amplification, sample, hip1..hip4, ank1..ank4, in ticks
    #[arg(long, value_name = "FILE")]
    tables: PathBuf,
    /// What was measured: leg_length, method, amplification, power_w, speed_m_s, cost_of_transport,
    /// and duration_s if trials were not 12 s long
    #[arg(long, value_name = "FILE")]
    trials: PathBuf,
    /// Length of the legs: selects the trials and the robot
    #[arg(long, default_value = "1", value_name = "SCALE")]
    leg: LegScale,
    /// Folder of the robot [default: the Ant's]
    #[arg(long, value_name = "FOLDER")]
    robot: Option<PathBuf>,
    /// Cores to use [default: all]
    #[arg(long, value_name = "N")]
    threads: Option<usize>,
}

/// Fit the robot's parameters to the tables that it played and its measured trials.
#[derive(Debug, clap::Args)]
struct FitArgs {
    #[command(flatten)]
    data: Data,
    /// Gaits to fit; may be given more than once [default: all that have trials]
    #[arg(long, value_name = "NAME")]
    method: Vec<String>,
    /// Random seed: the same seed finds the same robot
    #[arg(long, default_value_t = 0, value_parser = super::seed())]
    seed: u64,
    /// Sets of parameters to try
    #[arg(long, default_value_t = Budget::default().evaluations, value_name = "EVALUATIONS",
          value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    budget: u64,
    /// Parameters to fit, by their name in the description, each with a range if not the
    /// Ant's; may be given more than once
    #[arg(long, value_name = "NAME[=MIN:MAX]")]
    vary: Vec<String>,
    /// Start from the description's own values only
    #[arg(long)]
    go_on: bool,
    /// Share of each parameter's range over which the last search's first sets are spread
    #[arg(long, default_value_t = Budget::default().first_step, value_name = "SHARE")]
    first_step: f64,
    /// Folder to write the fitted robot to [default: robot in a new run folder]
    #[arg(long, value_name = "FOLDER")]
    out: Option<PathBuf>,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
}

/// Predict measured trials, and print the errors.
#[derive(Debug, clap::Args)]
struct ValidateArgs {
    #[command(flatten)]
    data: Data,
    /// Gaits to predict; may be given more than once [default: all that have trials]
    #[arg(long, value_name = "NAME")]
    method: Vec<String>,
    /// How long the robot held a sample, in seconds [default: as fitted]
    #[arg(long, value_name = "SECONDS", value_parser = sample_time)]
    sample_time: Option<f64>,
    /// Also play all tables with half the physics step, and print the difference
    #[arg(long)]
    half_step: bool,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Error)]
enum TwinCliError {
    #[error("interrupted after {evaluations} sets of parameters; the best is in {}", .path.display())]
    Interrupted { evaluations: u64, path: PathBuf },
    #[error("interrupted before the first sets of parameters were tried; nothing is written")]
    TooEarly,
    #[error("--first-step must be within 0.001 to 1, got {value}")]
    FirstStep { value: f64 },
    #[error("{count} threads cannot be started")]
    Threads { count: usize, source: rayon::ThreadPoolBuildError },
    #[error("cannot handle Ctrl-C")]
    Signals { source: ctrlc::Error },
}

fn sample_time(text: &str) -> Result<f64, String> {
    let value: f64 = text.parse().map_err(|_| format!("{text:?} is not a number"))?;
    if (0.02..=1.0).contains(&value) {
        Ok(value)
    } else {
        Err(format!("must be within 0.02 to 1 s, got {value}"))
    }
}

pub fn run(args: Args) -> Result<(), Failure> {
    match args.command {
        Twin::Fit(args) => run_fit(&args),
        Twin::Validate(args) => run_validate(&args),
    }
}

/// Files, robot and threads, as the flags say.
fn prepare(data: &Data) -> Result<(Robot, Tables, Trials, rayon::ThreadPool), Failure> {
    let input = |error: TwinError| match &error {
        TwinError::File(file) => failure(file_cause(file), error),
        _ => failure(Cause::Input, error),
    };
    // First what is cheapest to correct.
    let mut robot = match &data.robot {
        Some(path) => Robot::load(path),
        None => Robot::ant(data.leg),
    }
    .map_err(|error| failure(Cause::Input, error))?;
    robot.geometry.leg_scale = data.leg;
    robot.check().map_err(|error| failure(Cause::Input, error))?;
    let tables = Tables::read(&data.tables).map_err(input)?;
    let trials = Trials::read(&data.trials, data.leg).map_err(input)?;
    trials.check_weight(&data.trials, robot.mass_kg() * STANDARD_GRAVITY_M_S2).map_err(input)?;
    let count = data.threads.unwrap_or(0);
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(count)
        .build()
        .map_err(|source| failure(Cause::Machine, TwinCliError::Threads { count, source }))?;
    Ok((robot, tables, trials, pool))
}

fn bad(error: TwinError) -> Failure {
    failure(Cause::Input, error)
}

fn run_validate(args: &ValidateArgs) -> Result<(), Failure> {
    let (robot, tables, trials, pool) = prepare(&args.data)?;
    let trials = trials.of(&args.method).map_err(bad)?;
    let options = Options { sample_s: args.sample_time, half_step: args.half_step };
    let report = pool.install(|| twin::validate(&robot, &tables, &trials, &options)).map_err(bad)?;
    report::print(&report, args.json);
    Ok(())
}

fn run_fit(args: &FitArgs) -> Result<(), Failure> {
    if !(0.001..=1.0).contains(&args.first_step) {
        return Err(failure(Cause::Usage, TwinCliError::FirstStep { value: args.first_step }));
    }
    let (robot, tables, trials, pool) = prepare(&args.data)?;
    let trials = trials.of(&args.method).map_err(bad)?;
    let parameters = Parameter::choose(&args.vary).map_err(|error| failure(Cause::Usage, error))?;
    let unwritten = |error: run_folder::FileError| {
        failure_with_help(Cause::Machine, error, "name another folder with --out")
    };
    let path = match &args.out {
        Some(path) => path.clone(),
        None => run_folder::create("twin").map_err(unwritten)?.join(run_folder::ROBOT),
    };
    let stop = Arc::new(AtomicBool::new(false));
    let asked = Arc::clone(&stop);
    ctrlc::set_handler(move || asked.store(true, Ordering::Relaxed))
        .map_err(|source| failure(Cause::Machine, TwinCliError::Signals { source }))?;

    let bar = ProgressBar::new(args.budget).with_style(
        ProgressStyle::with_template("{bar:30} {pos}/{len} sets, {msg}, {elapsed} elapsed, {eta} left")
            .unwrap_or_else(|_| ProgressStyle::default_bar()),
    );
    let mut saved = 0;
    let mut lost = None;
    let mut progress = |progress: &Progress<'_>| {
        bar.set_position(progress.evaluations);
        bar.set_message(format!("score {:.2} %", 100.0 * progress.score));
        if progress.evaluations >= saved + SAVED_EVERY {
            saved = progress.evaluations;
            if bar.is_hidden() {
                eprintln!("{saved} of {} sets, score {:.2} %", args.budget, 100.0 * progress.score);
            }
            lost = progress.best.save(&path).err();
        }
        !stop.load(Ordering::Relaxed) && lost.is_none()
    };
    let budget = Budget {
        seed: args.seed,
        evaluations: args.budget,
        first_step: args.first_step,
        begin: if args.go_on { Begin::Description } else { Begin::Anywhere },
    };
    let found: Result<Fit, _> =
        pool.install(|| twin::fit(&robot, &tables, &trials, &parameters, &budget, &mut progress));
    bar.finish_and_clear();
    let Fit { robot, stopped } = found.map_err(bad)?;
    let evaluations = robot.twin.as_ref().map_or(0, |twin| twin.evaluations);
    if robot.twin.as_ref().is_none_or(|twin| !twin.score.is_finite()) {
        return Err(failure(Cause::Interrupted, TwinCliError::TooEarly));
    }
    robot.save(&path).map_err(unwritten)?;
    let report =
        pool.install(|| twin::validate(&robot, &tables, &trials, &Options::default())).map_err(bad)?;
    report::print_fit(&robot, &parameters, &path, &report, args.json);
    if stopped {
        return Err(failure_with_help(
            Cause::Interrupted,
            TwinCliError::Interrupted { evaluations, path: path.clone() },
            format!("resume with --robot {} --go-on", path.display()),
        ));
    }
    Ok(())
}
