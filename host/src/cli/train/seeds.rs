//! Several seeds in parallel, and the best of their policies.
//!
//! Holds the folder with a run for each seed: `seed-0`, `seed-1` and so on, `seeds.json`
//! with the range, `seeds.csv` with the results, and the files of the best, so that
//! `record` can use the folder as a run. Does not depend on how a policy learns. Each
//! seed's run is the same, bit for bit, as if it were trained alone.

use super::device::Configured;
use super::error::SeedsError;
use super::range::{SEEDS, SeedRange};
use super::show::{progress_bar, say, show};
use super::{TrainCliError, write_inputs};
use crate::cli::explain::path_text;
use crate::env::Env;
use crate::learn::run_config::RunConfig;
use crate::learn::td3::checkpoint;
use crate::learn::td3::device::Device;
use crate::learn::td3::evaluate::{Evaluation, evaluate};
use crate::learn::td3::outcome::{Ending, Outcome, TrainError};
use crate::learn::td3::policy::Policy;
use crate::learn::td3::policy_description::POLICY_DESCRIPTION;
use crate::learn::td3::random::Purpose;
use crate::learn::td3::trainer::Run;
use crate::learn::train_result::{SeedEnding, SeedResult, SeedsResult};
use crate::robot::Robot;
use crate::run_folder::{self, FileError};
use crate::sim::AntEnv;
use indicatif::MultiProgress;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

/// The file with the result of each seed.
const RESULTS: &str = "seeds.csv";
/// Episodes that compare the seeds, the paper's "test number".
const COMPARED_EPISODES: usize = 50;
/// The files of the best seed that are copied to the folder above.
const OF_THE_BEST: [&str; 4] =
    [run_folder::CONFIG, run_folder::POLICY, POLICY_DESCRIPTION, run_folder::LEARNING_CURVE];

/// Writes every seed's folder, then `seeds.json`.
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
    // All seeds have the same robot.
    robot.save(&folder.join(run_folder::ROBOT))?;
    let text = serde_json::json!(seeds);
    Ok(run_folder::write(&folder.join(SEEDS), format!("{text}\n").as_bytes())?)
}

/// An existing run where one of these seeds would be trained.
pub fn existing_run(seeds: SeedRange, folder: &Path) -> Option<PathBuf> {
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
    /// `None` if learning or the simulation diverged.
    outcome: Option<Outcome>,
    /// On the same episodes for all seeds, which no run has seen.
    evaluation: Evaluation,
}

/// Trains the seeds that are not complete, then compares all.
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
    eprintln!("Press Ctrl-C to save and stop.");
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
                // Poisoned only if `push` panicked.
                if let Ok(mut results) = results.lock() {
                    results.push((seed, result));
                }
            }
        };
        let threads: Vec<_> = (0..workers).map(|_| scope.spawn(work)).collect();
        // Joined explicitly: the scope would panic if a thread did.
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
            // The others are not affected, and the best policy so far is kept.
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
        let note = if *best == 0 { ", the untrained policy's: nothing was learned" } else { "" };
        say(&bar, &format!("seed {seed:<3} done: reward {:.1}{note}", curve[*best].reward));
    }
    outcome.map_err(|source| TrainCliError::stopped(&folder, source))
}

/// What candidates are compared by; NaN is the worst.
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

/// Copies the best seed's files, and prints the result of every seed.
fn report(folder: &Path, candidates: &[Candidate], json: bool) -> Result<(), TrainCliError> {
    // The first of equals; every range has a seed.
    let Some(best) = candidates.iter().rev().max_by(|a, b| reward(a).total_cmp(&reward(b))) else {
        return Ok(());
    };
    let mut csv = String::from("seed,reward,speed_m_s,episode_steps,updates,wall_s,ending\n");
    let mut results = Vec::new();
    for Candidate { seed, outcome, evaluation } in candidates {
        let (updates, wall_s) = outcome.as_ref().map_or((0, 0.0), |o| (o.updates, o.wall_s));
        let ending = if outcome.is_some() { SeedEnding::Done } else { SeedEnding::Diverged };
        let &Evaluation { reward, speed_m_s, steps } = evaluation;
        let name = serde_json::json!(ending);
        let name = name.as_str().unwrap_or_default();
        csv += &format!("{seed},{reward:.4},{speed_m_s:.5},{steps:.1},{updates},{wall_s:.2},{name}\n");
        results.push(SeedResult { seed: *seed, reward, speed_m_s, updates, wall_s, ending });
    }
    run_folder::write(&folder.join(RESULTS), csv.as_bytes())?;
    for name in OF_THE_BEST {
        let from = run_of(folder, best.seed).join(name);
        let contents = std::fs::read(&from).map_err(FileError::on("read", &from))?;
        run_folder::write(&folder.join(name), &contents)?;
    }
    if let Err(error) = run_folder::make_latest(folder) {
        eprintln!("warning: {error}: use --run with the next commands");
    }
    if json {
        let result = SeedsResult {
            run: path_text(folder),
            policy: path_text(&folder.join(run_folder::POLICY)),
            seed: best.seed,
            reward_trained: best.evaluation.reward,
            speed_m_s: best.evaluation.speed_m_s,
            seeds: results,
        };
        println!("{}", serde_json::json!(result));
        return Ok(());
    }
    println!("On episodes that no run has seen:");
    for Candidate { seed, outcome, evaluation } in candidates {
        let note = match outcome {
            None => "  stopped early",
            Some(_) if *seed == best.seed => "  best",
            Some(_) => "",
        };
        // Plus zero turns -0.000 into 0.000.
        let speed_m_s = (evaluation.speed_m_s * 1000.0).round() / 1000.0 + 0.0;
        println!("seed {seed:<3} reward {:>8.1}  {speed_m_s:>7.3} m/s{note}", evaluation.reward);
    }
    println!("{} is seed {}'s. Next: cargo run -p host -- record", run_folder::POLICY, best.seed);
    Ok(())
}
