//! `host sinusoid`: the rival that learned gaits are measured against.
//!
//! Owns the flags, the run's folder and Ctrl-C; the search is
//! [`crate::sinusoid`]'s, the words stand in `report`.

mod report;

use super::explain::{failure, failure_with_help, file_cause};
use super::{Cause, Failure};
use crate::gait_file::{GaitFile, Provenance, Source};
use crate::optimise::basis::Basis;
use crate::robot::Robot;
use crate::run_folder::{self, FileError};
use crate::sim::ant_env::{ACTION_DEG, CONTROL_RATE_HZ};
use crate::sinusoid::search::{Found, Progress, ROUND_STEPS, Search};
use crate::sinusoid::task::{Task, seconds};
use crate::sinusoid::wave::Pairs;
use crate::td3::preset::Preset;
use crate::td3::run_config::RunConfig;
use indicatif::{ProgressBar, ProgressStyle};
use report::Outcome;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;
use thiserror::Error;

/// What a learned gait moves a unit of action by at amplitude 1.0, where its policy has 45
/// degrees: so its own stroke is amplitude 1.875, and a sinusoid's is to be the same.
const UNIT_DEG: f64 = 24.0;
/// A year of walking.
const MOST_BUDGET_S: f64 = 3.2e7;
/// Every evaluation.
const EVALUATIONS: &str = "evaluations.csv";

/// Find a sinusoidal gait by Bayesian optimisation, the rival that the paper measures PSTO
/// against.
///
/// Tunes period, amplitudes, phases and offsets of sine waves for the very reward that `train`
/// learns from, with as many simulated seconds. Like a learned gait, it has the stroke that was
/// tuned at amplitude 1.875. The same seed and budget give the same gait.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Shins: 1.0 is 23 cm, 0.6 is 13.8 cm
    #[arg(long, default_value_t = 1.0, value_name = "SCALE")]
    leg: f64,
    /// Folder of a robot other than the Ant
    #[arg(long, value_name = "FOLDER", conflicts_with = "leg")]
    robot: Option<PathBuf>,
    /// The task, and the budget that learning it has
    #[arg(long, value_enum, default_value = "walk")]
    preset: Preset,
    /// Simulated seconds to search with [default: what `train` learns from with the preset]
    #[arg(long, value_name = "SECONDS")]
    budget_s: Option<f64>,
    /// Legs that swing together
    #[arg(long, value_enum, default_value_t)]
    pairs: Pairs,
    /// Of everything that is drawn
    #[arg(long, default_value_t = 0, value_parser = super::seed())]
    seed: u64,
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
enum SinusoidError {
    #[error(
        "--budget-s is {value}; it must be within {least} to {MOST_BUDGET_S} s of simulation: the \
         least is 22 evaluations of 8 episodes of {episode_s:.1} s"
    )]
    Budget { value: f64, least: f64, episode_s: f64 },
    #[error("--name is {name:?}; a name is 1 to {} printable ASCII characters", protocol::Name::CAPACITY)]
    Name { name: String },
    #[error("{} is there already: name another folder with --out", .path.display())]
    Taken { path: PathBuf },
    #[error("interrupted after {evaluations} evaluations; the best gait so far is in {}", .path.display())]
    Interrupted { evaluations: usize, path: PathBuf },
    #[error("the curves that sines are made of could not be computed")]
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
    let config = RunConfig::preset(args.preset).map_err(|error| failure(Cause::Input, error))?;
    let basis = Basis::new().ok_or_else(|| failure(Cause::Machine, SinusoidError::Basis))?;
    let mut search = Search {
        task: Task { robot: &robot, env: config.env },
        basis,
        pairs: args.pairs,
        seed: args.seed,
        budget: learners_steps(&config),
        round_steps: ROUND_STEPS,
    };
    if let Some(value) = args.budget_s {
        search.budget = budget(value, &search)?;
    }
    let stop = stop_flag()?;
    let folder = folder(&args)?;
    // First, so that a folder that cannot be written costs no search.
    robot.save(&folder.join(run_folder::ROBOT)).map_err(|error| failure(Cause::Machine, error))?;

    let found = watched(&search, &stop);
    let gait = gait(&args, &robot, &found);
    let path = folder.join(run_folder::GAIT);
    gait.save(&path).map_err(|error| failure(Cause::Machine, error))?;
    let outcome = Outcome {
        robot: &robot,
        gait: &gait,
        path: &path,
        found: &found,
        preset: args.preset,
        pairs: args.pairs,
        seed: args.seed,
        wall_s: began.elapsed().as_secs_f64(),
    };
    let table = report::table(&found.evaluations).map_err(|error| failure(Cause::Machine, error))?;
    run_folder::write(&folder.join(EVALUATIONS), &table).map_err(machine)?;
    let json = outcome.to_json();
    let text = format!("{json:#}\n");
    run_folder::write(&folder.join(run_folder::SUMMARY), text.as_bytes()).map_err(machine)?;
    if args.out.is_none() {
        run_folder::make_latest(&folder).map_err(machine)?;
    }
    if args.json {
        println!("{json:#}");
    } else {
        outcome.print();
    }
    if found.stopped {
        let evaluations = found.evaluations.len();
        return Err(failure(Cause::Interrupted, SinusoidError::Interrupted { evaluations, path }));
    }
    Ok(())
}

/// Control steps that a policy learns from; those of its evaluations are not counted.
fn learners_steps(config: &RunConfig) -> u64 {
    let schedule = &config.schedule;
    schedule.total_updates() * schedule.env_steps_per_update + schedule.warm_up_env_steps
}

/// Refuses now what would be refused after the search.
fn check(args: &Args) -> Result<(), Failure> {
    let usage = |error: SinusoidError| failure(Cause::Usage, error);
    if let Some(name) = args.name.as_ref().filter(|name| protocol::Name::new(name).is_none()) {
        return Err(usage(SinusoidError::Name { name: name.clone() }));
    }
    // A trained run, too, would no longer be what it says.
    let files = [run_folder::GAIT, run_folder::CONFIG, run_folder::ROBOT];
    let mut taken = args.out.iter().flat_map(|folder| files.map(|file| folder.join(file)));
    taken.find(|path| path.exists()).map_or(Ok(()), |path| Err(usage(SinusoidError::Taken { path })))
}

fn budget(value: f64, search: &Search<'_>) -> Result<u64, Failure> {
    let least = seconds(search.least_budget()).ceil();
    if (least..=MOST_BUDGET_S).contains(&value) {
        return Ok((value * CONTROL_RATE_HZ) as u64);
    }
    let episode_s = seconds(search.task.episode_steps());
    let error = SinusoidError::Budget { value, least, episode_s };
    Err(failure_with_help(Cause::Usage, error, "leave it out for the budget that `train` has"))
}

fn machine(error: FileError) -> Failure {
    failure(file_cause(&error), error)
}

fn folder(args: &Args) -> Result<PathBuf, Failure> {
    let Some(folder) = &args.out else { return run_folder::create("sinusoid").map_err(machine) };
    std::fs::create_dir_all(folder).map_err(FileError::on("create", folder)).map_err(machine)?;
    Ok(folder.clone())
}

fn stop_flag() -> Result<Arc<AtomicBool>, Failure> {
    let stop = Arc::new(AtomicBool::new(false));
    let asked = Arc::clone(&stop);
    ctrlc::set_handler(move || asked.store(true, Ordering::Relaxed))
        .map_err(|source| failure(Cause::Machine, SinusoidError::Signals { source }))?;
    Ok(stop)
}

/// The search, with a bar, or for logs a line a tenth.
fn watched(search: &Search<'_>, stop: &AtomicBool) -> Found {
    let whole_s = seconds(search.budget) as u64;
    let bar = ProgressBar::new(whole_s).with_style(
        ProgressStyle::with_template("{bar:30} {pos}/{len} s simulated, {msg}, {elapsed} gone, {eta} to go")
            .unwrap_or_else(|_| ProgressStyle::default_bar()),
    );
    let mut said_s = 0;
    let found = search.run(&mut |progress: &Progress<'_>| {
        let Progress { evaluations, steps, best } = progress;
        let simulated_s = seconds(*steps) as u64;
        let words = format!(
            "{evaluations} evaluations, best {:.3} a step at {:.3} m/s",
            best.worth.reward_per_step, best.worth.speed_m_s
        );
        bar.set_position(simulated_s);
        if bar.is_hidden() && simulated_s >= said_s + whole_s / 10 {
            said_s = simulated_s;
            eprintln!("{simulated_s} of {whole_s} s simulated, {words}");
        }
        bar.set_message(words);
        !stop.load(Ordering::Relaxed)
    });
    bar.finish_and_clear();
    found
}

fn gait(args: &Args, robot: &Robot, found: &Found) -> GaitFile {
    let usual = || format!("sin-{}L-seed{}", robot.geometry.leg_scale, args.seed);
    let name: String = args.name.clone().unwrap_or_else(usual);
    let arguments = std::env::args_os().skip(1).map(|a| a.to_string_lossy().into_owned());
    let mut joints = found.motion.series(robot.joint_limit_deg.min(robot.servo.end_stop_deg));
    let curves = joints.iter_mut().flat_map(|joint| &mut joint.coefficients_deg);
    curves.for_each(|coefficient_deg| *coefficient_deg *= UNIT_DEG / ACTION_DEG);
    GaitFile {
        name: name.chars().take(protocol::Name::CAPACITY).collect(),
        period_s: found.motion.period_s,
        unit_deg: UNIT_DEG,
        provenance: Provenance {
            seed: Some(args.seed),
            seam: Some("continuous".into()),
            leg_scale: Some(robot.geometry.leg_scale),
            command: Some(std::iter::once("host".to_owned()).chain(arguments).collect::<Vec<_>>().join(" ")),
            ..Provenance::of(Source::Sinusoid)
        },
        joints,
    }
}
