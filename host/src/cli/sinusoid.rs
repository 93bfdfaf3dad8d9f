//! `host sinusoid`: the rival that learned gaits are measured against.
//!
//! Owns the flags, the budget and Ctrl-C; the search is
//! [`crate::search::sinusoid`]'s, the words stand in `report`.

mod report;

use super::explain::{failure, failure_with_help};
use super::new_gait::{NewGait, machine};
use super::reach::interruptible;
use super::{Cause, Failure};
use crate::gait::gait_file::{GaitFile, Source};
use crate::learn::td3::preset::Preset;
use crate::learn::td3::run_config::RunConfig;
use crate::robot::Robot;
use crate::run_folder;
use crate::search::optimise::basis::Basis;
use crate::search::sinusoid::search::{Found, Progress, ROUND_STEPS, Search};
use crate::search::sinusoid::task::{Task, seconds};
use crate::search::sinusoid::wave::Pairs;
use crate::sim::ant_env::{ACTION_DEG, CONTROL_RATE_HZ};
use indicatif::{ProgressBar, ProgressStyle};
use report::Outcome;
use std::path::PathBuf;
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
    #[command(flatten)]
    new: NewGait,
    /// The task, and the budget that learning it has
    #[arg(long, value_enum, default_value = "walk")]
    preset: Preset,
    /// Simulated seconds to search with [default: what `train` learns from with the preset]
    #[arg(long, value_name = "SECONDS")]
    budget_s: Option<f64>,
    /// Legs that swing together
    #[arg(long, value_enum, default_value_t)]
    pairs: Pairs,
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
    #[error("interrupted after {evaluations} evaluations; the best gait so far is in {}", .path.display())]
    Interrupted { evaluations: usize, path: PathBuf },
    #[error("the curves that sines are made of could not be computed")]
    Basis,
}

pub fn run(args: Args) -> Result<(), Failure> {
    let began = Instant::now();
    args.new.check()?;
    let robot = args.new.robot()?;
    let config = RunConfig::preset(args.preset).map_err(|error| failure(Cause::Input, error))?;
    let basis = Basis::new().ok_or_else(|| failure(Cause::Machine, SinusoidError::Basis))?;
    let mut search = Search {
        task: Task { robot: &robot, env: config.env },
        basis,
        pairs: args.pairs,
        seed: args.new.seed,
        budget: learners_steps(&config),
        round_steps: ROUND_STEPS,
    };
    if let Some(value) = args.budget_s {
        search.budget = budget(value, &search)?;
    }
    let stop = interruptible()?;
    let folder = args.new.folder("sinusoid", &robot)?;

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
        seed: args.new.seed,
        wall_s: began.elapsed().as_secs_f64(),
    };
    let table = report::table(&found.evaluations).map_err(|error| failure(Cause::Machine, error))?;
    run_folder::write(&folder.join(EVALUATIONS), &table).map_err(machine)?;
    let json = outcome.to_json();
    let text = format!("{json:#}\n");
    run_folder::write(&folder.join(run_folder::SUMMARY), text.as_bytes()).map_err(machine)?;
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

fn budget(value: f64, search: &Search<'_>) -> Result<u64, Failure> {
    let least = seconds(search.least_budget()).ceil();
    if (least..=MOST_BUDGET_S).contains(&value) {
        return Ok((value * CONTROL_RATE_HZ) as u64);
    }
    let episode_s = seconds(search.task.episode_steps());
    let error = SinusoidError::Budget { value, least, episode_s };
    Err(failure_with_help(Cause::Usage, error, "leave it out for the budget that `train` has"))
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
    let mut joints = found.motion.series(robot.joint_limit_deg.min(robot.servo.end_stop_deg));
    let curves = joints.iter_mut().flat_map(|joint| &mut joint.coefficients_deg);
    curves.for_each(|coefficient_deg| *coefficient_deg *= UNIT_DEG / ACTION_DEG);
    let name = args.new.name_or("sin", robot);
    args.new.file(robot, &name, Source::Sinusoid, found.motion.period_s, UNIT_DEG, joints)
}
