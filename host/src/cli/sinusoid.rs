//! `host sinusoid`: the baseline that learned gaits are compared with.
//!
//! Holds the flags, the budget and Ctrl-C. Does not depend on how gaits are
//! searched, which is [`crate::search::sinusoid`]'s; `report` has the words.

mod report;

use super::explain::{failure, failure_with_help};
use super::new_gait::{NewGait, machine};
use super::reach::interruptible;
use super::{Cause, Failure};
use crate::gait::gait_file::{GaitFile, Source};
use crate::gait::scale::TABLE_DEG_PER_ACTION;
use crate::learn::preset::Preset;
use crate::learn::run_config::RunConfig;
use crate::robot::Robot;
use crate::run_folder;
use crate::search::optimise::basis::Basis;
use crate::search::optimise::heading;
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

/// A year of simulated walking.
const MOST_BUDGET_S: f64 = 3.2e7;
/// Table of all evaluations.
const EVALUATIONS: &str = "evaluations.csv";

/// Find a sinusoidal gait by Bayesian optimisation, the baseline that the paper compares PSTO
/// with.
///
/// Tunes period, amplitudes, phases and offsets of sine waves for the same reward that `train`
/// learns from, with as many simulated seconds. As with a learned gait, amplitude 1.875 is the
/// stroke that was tuned. The same seed and budget give the same gait.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    new: NewGait,
    /// Training preset that gives the task and the default budget
    #[arg(long, value_enum, default_value = "walk")]
    preset: Preset,
    /// Simulated seconds to search with [default: as many as `train` uses with the preset]
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
         minimum is 22 evaluations of 8 episodes of {episode_s:.1} s"
    )]
    Budget { value: f64, least: f64, episode_s: f64 },
    #[error("interrupted after {evaluations} evaluations; the best gait so far is in {}", .path.display())]
    Interrupted { evaluations: usize, path: PathBuf },
    #[error("the curves that approximate sines could not be computed")]
    Basis,
}

pub fn run(args: Args) -> Result<(), Failure> {
    let began = Instant::now();
    args.new.check()?;
    let robot = args.new.robot()?;
    super::robots::warn_of(&robot);
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
        displacement_m: heading::displacement_m(&robot, &found.motion),
    };
    let table = report::table(&found.evaluations).map_err(|error| failure(Cause::Machine, error))?;
    run_folder::write(&folder.join(EVALUATIONS), &table).map_err(machine)?;
    let json = serde_json::to_value(outcome.result()).map_err(|error| failure(Cause::Machine, error))?;
    let text = format!("{json:#}\n");
    run_folder::write(&folder.join(run_folder::SUMMARY), text.as_bytes()).map_err(machine)?;
    outcome.warn();
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

/// Control steps that a policy learns from, without those of its evaluations.
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
    Err(failure_with_help(Cause::Usage, error, "without --budget-s the search has the budget of `train`"))
}

/// Searches with a progress bar; in logs, with one line for each tenth.
fn watched(search: &Search<'_>, stop: &AtomicBool) -> Found {
    let whole_s = seconds(search.budget) as u64;
    let bar = ProgressBar::new(whole_s).with_style(
        ProgressStyle::with_template(
            "{bar:30} {pos}/{len} s simulated, {msg}, {elapsed} elapsed, {eta} left",
        )
        .unwrap_or_else(|_| ProgressStyle::default_bar()),
    );
    let mut said_s = 0;
    let found = search.run(&mut |progress: &Progress<'_>| {
        let Progress { evaluations, steps, best } = progress;
        let simulated_s = seconds(*steps) as u64;
        let words = format!(
            "{evaluations} evaluations, best reward {:.3} per step at {:.3} m/s",
            best.score.reward_per_step, best.score.speed_m_s
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
    let mut joints = found.motion.series(&robot.joint_reaches_deg());
    let curves = joints.iter_mut().flat_map(|joint| &mut joint.coefficients_deg);
    curves.for_each(|coefficient_deg| *coefficient_deg *= TABLE_DEG_PER_ACTION / ACTION_DEG);
    let name = args.new.name_or("sin", robot);
    args.new.file(robot, &name, Source::Sinusoid, found.motion.period_s, TABLE_DEG_PER_ACTION, joints)
}
