//! `train`: a run folder with the best policy, its learning curve and a checkpoint.
//!
//! Holds the flags and the messages. Does not depend on how a policy learns.

mod device;
mod error;
mod range;
mod seeds;
mod show;

use super::explain::{path_text, warn};
use super::{Cause, Failure, output};
use crate::env::Env;
use crate::learn::preset::Preset;
use crate::learn::run_config::RunConfig;
use crate::learn::td3::device::Device;
use crate::learn::td3::outcome::{Ending, Outcome};
use crate::learn::td3::trainer::Run;
use crate::learn::train_result::TrainResult;
use crate::robot::{LegScale, Robot};
use crate::run_folder::{self, FileError};
use crate::sim::AntEnv;
use device::Configured;
use error::TrainCliError;
use range::{SEEDS, SeedRange};
use show::{progress_bar, say, show};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

#[derive(Debug, clap::Args)]
pub struct Args {
    /// Training preset
    #[arg(long, value_enum, default_value = "walk", conflicts_with_all = ["config", "resume"])]
    preset: Preset,

    /// Your own configuration; it names only what differs from the preset it is `based_on`
    #[arg(long, value_name = "FILE", conflicts_with = "resume")]
    config: Option<PathBuf>,

    /// Length of the shins: 1.0 is 23 cm, 0.6 is 13.8 cm [default: the configuration's]
    #[arg(long, value_name = "SCALE", conflicts_with_all = ["robot", "resume"])]
    leg: Option<LegScale>,

    /// Random seed [default: the configuration's, 0]
    #[arg(long, value_name = "N", conflicts_with = "resume", value_parser = super::seed())]
    seed: Option<u64>,

    /// Train several seeds in parallel and keep the policy that is best on episodes that no run
    /// has seen: 0..10 are ten seeds, 0 to 9
    #[arg(long, value_name = "A..B", conflicts_with_all = ["seed", "resume"])]
    seeds: Option<SeedRange>,

    /// Number of seeds to train at a time [default: as many as there are cores]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1024))]
    jobs: Option<u32>,

    /// Folder of the run, which must not hold a run yet [default: a new one in runs]
    #[arg(long, value_name = "DIR", conflicts_with = "resume")]
    out: Option<PathBuf>,

    /// Device of the updates [default: the configuration's, cpu]. A resumed run keeps its own;
    /// on another device it does not continue bit for bit. `host bench` compares cpu and torch
    #[arg(long, value_enum)]
    device: Option<Device>,

    /// Continue an interrupted run, with the same result as without the interruption
    #[arg(long, value_name = "RUN")]
    resume: Option<PathBuf>,

    /// Folder of a robot other than the built-in Ant
    #[arg(long, value_name = "FOLDER", conflicts_with = "resume")]
    robot: Option<PathBuf>,

    /// Print the result as one line of JSON on standard output
    #[arg(long)]
    json: bool,
}

pub fn run(args: Args) -> Result<(), Failure> {
    Ok(train(args)?)
}

fn train(args: Args) -> Result<(), TrainCliError> {
    let stop = Arc::new(AtomicBool::new(false));
    let jobs = args.jobs.map_or_else(cores, |jobs| jobs as usize);
    if let Some(folder) = &args.resume {
        stop_on_ctrl_c(&stop)?;
        return match SeedRange::of(folder).map_err(error::SeedsError::from)? {
            Some(seeds) => seeds::train(folder, seeds, jobs, args.device, &stop, args.json),
            None => train_one(folder, true, args.device, &stop, args.json),
        };
    }
    let (config, robot) = prepare(&args)?;
    let folder = prepare_folder(&args, &config)?;
    stop_on_ctrl_c(&stop)?;
    match args.seeds {
        Some(seeds) => {
            seeds::prepare(seeds, &folder, &config, &robot)?;
            seeds::train(&folder, seeds, jobs, None, &stop, args.json)
        }
        None => {
            write_inputs(&folder, &config, &robot)?;
            train_one(&folder, false, None, &stop, args.json)
        }
    }
}

fn cores() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}

/// Trains the run whose configuration and robot are in `folder`.
fn train_one(
    folder: &Path,
    resuming: bool,
    device: Option<Device>,
    stop: &AtomicBool,
    json: bool,
) -> Result<(), TrainCliError> {
    let Configured { config, mut change } = Configured::load(folder, device)?;
    let robot = Robot::of_trained_run(folder)?;
    let make_env = || -> Box<dyn Env> { Box::new(AntEnv::new(&robot, config.env)) };
    let learning = config.learning();
    let (seed, device) = (config.seed, config.device);
    let run = Run { learning: &learning, make_env: &make_env, seed, device, folder, stop };
    let updates = learning.schedule.total_updates();
    let bar = progress_bar("", updates);
    say(&bar, &format!("Training in {} (seed {seed}, {device}), {updates} updates.", folder.display()));
    say(&bar, "Press Ctrl-C to save and stop.");
    let mut is_latest = false;
    let outcome = run.train(resuming, &mut |event| {
        show(&bar, &event);
        change.note(&event, &config, folder, &bar);
        // From its first policy on, this run is the default of other commands.
        if !is_latest {
            is_latest = true;
            if let Err(error) = run_folder::make_latest(folder) {
                say(&bar, &format!("warning: {error}: use --run with the next commands"));
            }
        }
    });
    bar.finish_and_clear();
    let outcome = outcome.map_err(|source| TrainCliError::stopped(folder, source))?;
    report(&outcome, &config, change.learned_on(&config), folder, json);
    match outcome.ending {
        Ending::Done => Ok(()),
        Ending::Stopped => {
            Err(TrainCliError::Interrupted { updates: outcome.updates, folder: folder.display().to_string() })
        }
    }
}

/// The configuration and the robot that the flags ask for.
fn prepare(args: &Args) -> Result<(RunConfig, Robot), TrainCliError> {
    let mut config = match (&args.config, args.preset) {
        (Some(path), _) => RunConfig::load(path)?,
        (None, preset) => RunConfig::preset(preset)?,
    };
    config.seed = args.seed.unwrap_or(config.seed);
    config.device = args.device.unwrap_or(config.device);
    device::check(config.device)?;
    if let Some(leg) = args.leg {
        config.leg_scale = leg;
    }
    let robot = match &args.robot {
        Some(path) => Robot::load(path)?,
        None => Robot::ant(config.leg_scale)?,
    };
    super::robots::warn_of(&robot);
    let random = config.env.randomisation;
    if random.lacks_spread(&robot) {
        return Err(TrainCliError::NoSpread { value: random.twin_spread, robot: robot.name });
    }
    Ok((config, robot))
}

/// The requested folder, if it holds no run, or a new one.
fn prepare_folder(args: &Args, config: &RunConfig) -> Result<PathBuf, TrainCliError> {
    let Some(folder) = &args.out else {
        let seeds = args.seeds.map_or(format!("seed{}", config.seed), |seeds| seeds.label());
        return Ok(run_folder::create(&format!("leg{}-{seeds}", config.leg_scale.value()))?);
    };
    if folder.join(run_folder::CONFIG).exists() || folder.join(SEEDS).exists() {
        return Err(TrainCliError::FolderInUse { folder: folder.display().to_string() });
    }
    if let Some(run) = args.seeds.and_then(|seeds| seeds::existing_run(seeds, folder)) {
        return Err(TrainCliError::FolderInUse { folder: run.display().to_string() });
    }
    std::fs::create_dir_all(folder).map_err(FileError::on("create", folder))?;
    Ok(folder.clone())
}

/// Writes the inputs of a run into its folder: configuration and robot.
fn write_inputs(folder: &Path, config: &RunConfig, robot: &Robot) -> Result<(), TrainCliError> {
    config.save(&folder.join(run_folder::CONFIG))?;
    robot.save(&folder.join(run_folder::ROBOT))?;
    Ok(())
}

/// The first Ctrl-C sets `stop`; the second exits immediately.
fn stop_on_ctrl_c(stop: &Arc<AtomicBool>) -> Result<(), ctrlc::Error> {
    let stop = Arc::clone(stop);
    ctrlc::set_handler(move || {
        if stop.swap(true, Ordering::Relaxed) {
            std::process::exit(Cause::Interrupted as i32);
        }
        eprintln!("\nSaving. Press Ctrl-C again to stop immediately.");
    })
}

fn report(outcome: &Outcome, config: &RunConfig, device: Device, folder: &Path, json: bool) {
    let untrained = &outcome.curve[0];
    let best = &outcome.curve[outcome.best];
    if outcome.ending == Ending::Done && outcome.best == 0 {
        warn(
            "no evaluation beat the untrained policy: nothing was learned, and the policy that was kept is \
             the untrained one. Try smaller learning rates (actor_learning_rate, critic_learning_rate under \
             [td3]), more updates, or another --seed",
        );
    }
    if json {
        let result = TrainResult {
            run: path_text(folder),
            policy: path_text(&folder.join(run_folder::POLICY)),
            seed: config.seed,
            device,
            finished: outcome.ending == Ending::Done,
            reward_untrained: untrained.reward,
            reward_trained: best.reward,
            speed_m_s: best.speed_m_s,
            best_updates: best.updates,
            updates: outcome.updates,
            train_env_steps: outcome.env_steps,
            wall_s: outcome.wall_s,
        };
        println!("{}", output::json(&result));
    } else {
        println!(
            "Reward {:.1} -> {:.1}, {:.3} m/s, best after {} updates.",
            untrained.reward, best.reward, best.speed_m_s, best.updates
        );
        println!(
            "{} updates and {} control steps in {:.0} s ({:.0} updates/s).",
            outcome.updates,
            outcome.env_steps,
            outcome.wall_s,
            outcome.updates as f64 / outcome.wall_s.max(1e-9)
        );
        if outcome.ending == Ending::Done {
            println!("Next: cargo run -p host -- record");
        }
    }
}
