//! Several seeds side by side, and the best of their policies.
//!
//! Owns the folder that holds a run for each seed: `seed-0`, `seed-1` and so
//! on, `seeds.json` that says which they are, `seeds.csv` with what they came
//! to, and the files of the best, so that the folder is itself a run to record
//! from. Each seed's run is what it would be alone, bit for bit.

use super::device::Configured;
use super::range::{SEEDS, SeedRange, SeedsFileError};
use super::show::{progress_bar, say, show};
use super::{TrainCliError, write_inputs};
use crate::cli::Cause;
use crate::cli::explain::path_text;
use crate::env::Env;
use crate::learn::td3::POLICY_DESCRIPTION;
use crate::learn::td3::checkpoint;
use crate::learn::td3::device::Device;
use crate::learn::td3::evaluate::{Evaluation, evaluate};
use crate::learn::td3::outcome::{Ending, Outcome, TrainError};
use crate::learn::td3::policy::Policy;
use crate::learn::td3::random::Purpose;
use crate::learn::td3::run_config::RunConfig;
use crate::learn::td3::tensor_file::TensorFileError;
use crate::learn::td3::trainer::Run;
use crate::robot::Robot;
use crate::run_folder::{self, FileError};
use crate::sim::AntEnv;
use indicatif::MultiProgress;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use thiserror::Error;

/// What each came to.
const RESULTS: &str = "seeds.csv";
/// Episodes that choose among the seeds, the paper's "test number".
const COMPARED_EPISODES: usize = 50;
/// The files of the best seed that the folder takes over.
const OF_THE_BEST: [&str; 4] =
    [run_folder::CONFIG, run_folder::POLICY, POLICY_DESCRIPTION, run_folder::LEARNING_CURVE];
/// What only several seeds can meet.
#[derive(Debug, Error)]
pub enum SeedsError {
    #[error(transparent)]
    Range(#[from] SeedsFileError),
    #[error("cannot compare the policies")]
    Policy(#[from] TensorFileError),
    #[error(transparent)]
    File(#[from] FileError),
    #[error("the thread that trained a seed panicked; its message stands above")]
    Panicked,
}

impl SeedsError {
    /// What a script is told.
    pub fn cause(&self) -> Cause {
        match self {
            Self::Range(_) => Cause::Input,
            Self::File(error) => crate::cli::explain::file_cause(error),
            Self::Policy(_) | Self::Panicked => Cause::Machine,
        }
    }
}

/// Makes every seed's folder, then says which they are.
pub fn prepare(
    seeds: SeedRange,
    folder: &Path,
    config: &RunConfig,
    robot: &Robot,
) -> Result<(), TrainCliError> {
    for seed in seeds.first..seeds.end {
        let run = run_of(folder, seed);
        std::fs::create_dir_all(&run).map_err(FileError::on("create", &run))?;
        write_inputs(&run, &RunConfig { seed, ..config.clone() }, robot)?;
    }
    // One robot for all of them: it need not be taken over from the best.
    robot.save(&folder.join(run_folder::ROBOT))?;
    let text = serde_json::json!({ "first": seeds.first, "end": seeds.end });
    Ok(run_folder::write(&folder.join(SEEDS), format!("{text}\n").as_bytes())?)
}

/// A run that stands where one of these seeds would be trained.
pub fn taken(seeds: SeedRange, folder: &Path) -> Option<PathBuf> {
    (seeds.first..seeds.end)
        .map(|seed| run_of(folder, seed))
        .find(|run| run.join(run_folder::CONFIG).exists() || checkpoint::exists(run))
}

fn run_of(folder: &Path, seed: u64) -> PathBuf {
    folder.join(format!("seed-{seed}"))
}

/// A seed that has a policy.
struct Candidate {
    seed: u64,
    /// Nothing where learning diverged or the simulation blew up.
    outcome: Option<Outcome>,
    /// On episodes that are the same for all, and that no run has seen.
    evaluation: Evaluation,
}

/// Trains what is not trained yet, then chooses.
pub fn train(
    folder: &Path,
    seeds: SeedRange,
    jobs: usize,
    device: Option<Device>,
    stop: &AtomicBool,
    json: bool,
) -> Result<(), TrainCliError> {
    let count = seeds.count();
    let bars = MultiProgress::new();
    let workers = jobs.min(count);
    eprintln!(
        "Training seeds {} to {} in {}, {workers} at a time.",
        seeds.first,
        seeds.end - 1,
        folder.display()
    );
    eprintln!("Ctrl-C saves and stops.");
    let next = AtomicU64::new(seeds.first);
    let results = Mutex::new(Vec::new());
    let whole = std::thread::scope(|scope| {
        let work = || {
            loop {
                let seed = next.fetch_add(1, Ordering::Relaxed);
                if seed >= seeds.end || stop.load(Ordering::Relaxed) {
                    return;
                }
                let result = train_seed(folder, seed, device, stop, &bars);
                // Poisoned only by a panic in `push`.
                if let Ok(mut results) = results.lock() {
                    results.push((seed, result));
                }
            }
        };
        let threads: Vec<_> = (0..workers).map(|_| scope.spawn(work)).collect();
        // Joined by hand: a scope would pass a panic on to us.
        threads.into_iter().map(std::thread::ScopedJoinHandle::join).all(|joined| joined.is_ok())
    });
    let _ = bars.clear();
    let mut results = results.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner);
    if !whole {
        return Err(SeedsError::Panicked.into());
    }
    results.sort_by_key(|(seed, _)| *seed);
    let mut updates = 0;
    let mut stopped = results.len() < count;
    let mut ended = Vec::new();
    let mut failed = Vec::new();
    for (seed, result) in results {
        let outcome = match result {
            Ok(outcome) => {
                updates += outcome.updates;
                stopped |= outcome.ending == Ending::Stopped;
                Some(outcome)
            }
            // The others are none the worse for it, and its best policy so far is there.
            Err(TrainCliError::Train {
                folder,
                source: source @ (TrainError::Diverged { .. } | TrainError::Collect(_)),
            }) => {
                eprintln!("warning: seed {seed}: {source}");
                failed.push(TrainCliError::Train { folder, source });
                None
            }
            Err(error) => return Err(error),
        };
        ended.push((seed, outcome));
    }
    if stopped {
        return Err(TrainCliError::Interrupted { updates, folder: folder.display().to_string() });
    }
    if failed.len() == count
        && let Some(error) = failed.pop()
    {
        return Err(error);
    }
    let candidates = compare(folder, ended)?;
    report(folder, &candidates, json)
}

/// One seed's run, from its checkpoint if there is one.
fn train_seed(
    folder: &Path,
    seed: u64,
    device: Option<Device>,
    stop: &AtomicBool,
    bars: &MultiProgress,
) -> Result<Outcome, TrainCliError> {
    let folder = run_of(folder, seed);
    let Configured { config, mut change } = Configured::load(&folder, device)?;
    let robot = Robot::of_trained_run(&folder)?;
    let learning = config.learning();
    let make_env = || -> Box<dyn Env> { Box::new(AntEnv::new(&robot, config.env)) };
    let bar = bars.add(progress_bar(&format!("seed {seed:<3} "), learning.schedule.total_updates()));
    let resume = checkpoint::exists(&folder);
    let device = config.device;
    let run = Run { learning: &learning, make_env: &make_env, seed, device, folder: &folder, stop };
    let outcome = run.train(resume, &mut |event| {
        show(&bar, &event);
        change.note(&event, &config, &folder, &bar);
    });
    bar.finish_and_clear();
    if let Ok(Outcome { ending: Ending::Done, curve, best, .. }) = &outcome {
        say(&bar, &format!("seed {seed:<3} done: reward {:.1}", curve[*best].reward));
    }
    outcome.map_err(|source| TrainCliError::Train { folder: folder.display().to_string(), source })
}

/// What candidates are compared by; one that is no number is the worst.
fn reward(candidate: &Candidate) -> f64 {
    let reward = candidate.evaluation.reward;
    if reward.is_nan() { f64::NEG_INFINITY } else { reward }
}

/// Plays every seed's best policy on the same episodes.
fn compare(folder: &Path, ended: Vec<(u64, Option<Outcome>)>) -> Result<Vec<Candidate>, TrainCliError> {
    let mut candidates = Vec::new();
    for (seed, outcome) in ended {
        let run = run_of(folder, seed);
        let config = RunConfig::load(&run.join(run_folder::CONFIG))?;
        let robot = Robot::of_trained_run(&run)?;
        let policy = Policy::load(&run.join(run_folder::POLICY)).map_err(SeedsError::Policy)?;
        let make_env = || -> Box<dyn Env> { Box::new(AntEnv::new(&robot, config.env)) };
        let evaluation = evaluate(&policy, &make_env, (0, Purpose::CompareEpisode), COMPARED_EPISODES);
        candidates.push(Candidate { seed, outcome, evaluation });
    }
    Ok(candidates)
}

/// Takes over the best seed's files, and says what every seed came to.
fn report(folder: &Path, candidates: &[Candidate], json: bool) -> Result<(), TrainCliError> {
    // The first of several that are alike; every range has a seed.
    let Some(best) = candidates.iter().rev().max_by(|a, b| reward(a).total_cmp(&reward(b))) else {
        return Ok(());
    };
    let mut csv = String::from("seed,reward,speed_m_s,episode_steps,updates,wall_s,ending\n");
    let mut lines = Vec::new();
    for Candidate { seed, outcome, evaluation } in candidates {
        let (updates, wall_s) = outcome.as_ref().map_or((0, 0.0), |o| (o.updates, o.wall_s));
        let ending = if outcome.is_some() { "done" } else { "diverged" };
        let Evaluation { reward, speed_m_s, steps } = evaluation;
        csv += &format!("{seed},{reward:.4},{speed_m_s:.5},{steps:.1},{updates},{wall_s:.2},{ending}\n");
        lines.push(serde_json::json!({
            "seed": seed, "reward": reward, "speed_m_s": speed_m_s, "updates": updates, "wall_s": wall_s,
            "ending": ending,
        }));
    }
    run_folder::write(&folder.join(RESULTS), csv.as_bytes())?;
    for name in OF_THE_BEST {
        let from = run_of(folder, best.seed).join(name);
        let contents = std::fs::read(&from).map_err(FileError::on("read", &from))?;
        run_folder::write(&folder.join(name), &contents)?;
    }
    if let Err(error) = run_folder::make_latest(folder) {
        eprintln!("warning: {error}: name the run with --run in the next steps");
    }
    if json {
        let line = serde_json::json!({
            "run": path_text(folder),
            "policy": path_text(&folder.join(run_folder::POLICY)),
            "seed": best.seed,
            "reward_trained": best.evaluation.reward,
            "speed_m_s": best.evaluation.speed_m_s,
            "seeds": lines,
        });
        println!("{line}");
        return Ok(());
    }
    println!("On episodes that no run has seen:");
    for Candidate { seed, outcome, evaluation } in candidates {
        let note = match outcome {
            None => "  stopped early",
            Some(_) if *seed == best.seed => "  best",
            Some(_) => "",
        };
        // Plus zero: a robot that stands still does not do so at -0.000 m/s.
        let speed_m_s = (evaluation.speed_m_s * 1000.0).round() / 1000.0 + 0.0;
        println!("seed {seed:<3} reward {:>8.1}  {speed_m_s:>7.3} m/s{note}", evaluation.reward);
    }
    println!("{} is seed {}'s. Next: cargo run -p host -- record", run_folder::POLICY, best.seed);
    Ok(())
}
