//! `bench`: speed of simulation and learner on this machine, against libtorch.
//!
//! Holds flags, rounds and the report. Does not depend on what is timed: that is
//! `slices`. Every figure is the median over rounds in which all kinds of work
//! alternate, so that a machine that slows down slows all of them; ratios are made
//! within a round.

mod plain;
mod slices;

use super::explain::{failure, failure_with_help};
use super::{Cause, Failure};
use crate::env::Env as _;
use crate::learn::preset::Preset;
use crate::learn::run_config::{ConfigError, RunConfig};
use crate::learn::td3::device::DeviceError;
use crate::learn::td3::outcome::TrainError;
use crate::learn::td3::replay::Layout;
use crate::robot::{Robot, RobotError};
use crate::sim::AntEnv;
use indicatif::{ProgressBar, ProgressStyle};
use serde::{Deserialize, Serialize};
use slices::Learners;
use thiserror::Error;

/// Control steps of a simulation slice, and updates of a learning slice: about half a second.
const ENV_STEPS: u32 = 5_000;
const UPDATES: u32 = 400;
/// Updates of the training slice; its evaluation is shortened to the same share.
const TRAIN_UPDATES: u64 = 500;

/// Time simulation, learning and training on this machine.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Training preset
    #[arg(long, value_enum, default_value = "walk")]
    preset: Preset,
    /// Number of rounds, some 4 s each, over which medians are taken
    #[arg(long, default_value_t = 7, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1000))]
    rounds: u32,
    /// Updates of the training run in each round
    #[arg(long, default_value_t = TRAIN_UPDATES, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    updates: u64,
    /// Print the figures as one line of JSON on standard output
    #[arg(long)]
    json: bool,
}

/// Why nothing was measured.
#[derive(Debug, Error)]
enum BenchError {
    #[error(transparent)]
    Config(#[from] ConfigError),
    #[error("--updates {updates}: this preset has rounds of {round} updates; use a multiple of that")]
    Updates { updates: u64, round: u64 },
    #[error(transparent)]
    Robot(#[from] RobotError),
    #[error("libtorch failed")]
    Torch(#[from] tch::TchError),
    #[error(transparent)]
    Device(#[from] DeviceError),
    #[error("cannot make a temporary folder for the training run")]
    Folder { source: std::io::Error },
    #[error("the training run stopped")]
    Train(#[from] TrainError),
}

/// A value for each figure; its fields are the keys of `bench --json`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
struct Figures<T> {
    /// Control steps a second of a walking robot, one thread.
    env_steps_per_s: T,
    /// The same with two threads.
    env_steps_per_s_2: T,
    /// TD3 updates a second, batches sampled.
    updates_per_s: T,
    /// Time of an update over that of the same losses in plain tch.
    update_vs_plain_tch: T,
    /// Time of an update over that of `train --device torch`.
    update_vs_device_torch: T,
    /// Gflop/s of large matrix products, the better of `gemm` and libtorch.
    gemm_gflops: T,
    /// The same by libtorch.
    gemm_gflops_libtorch: T,
    /// Gflop/s of an update over `gemm_gflops`.
    update_fraction_of_gemm: T,
    /// Control steps a second of a training run, evaluation included.
    train_steps_per_s: T,
    /// The same without the evaluation.
    learn_steps_per_s: T,
    /// Control steps of an episode of that evaluation.
    evaluation_episode_steps: T,
    /// Time to gather a round's steps over that of its updates.
    collect_over_learn: T,
}

/// Decimals and description of each figure, in the order of [`Figures`].
const FIGURES: [(usize, &str); 12] = [
    (0, "control steps/s walking, one thread"),
    (0, "control steps/s walking, two threads"),
    (0, "TD3 updates/s, one thread"),
    (3, "time of an update, over the same losses in plain tch"),
    (3, "time of an update, over that of train --device torch"),
    (1, "Gflop/s of large matrix products, one thread"),
    (1, "the same by libtorch"),
    (3, "an update's Gflop/s over that"),
    (0, "control steps/s of a training run, evaluation included"),
    (0, "the same, without the evaluation"),
    (0, "control steps of an episode of that evaluation"),
    (3, "time to gather a round's steps, over that of its updates"),
];

impl<T> Figures<T> {
    fn into_array(self) -> [T; FIGURES.len()] {
        [
            self.env_steps_per_s,
            self.env_steps_per_s_2,
            self.updates_per_s,
            self.update_vs_plain_tch,
            self.update_vs_device_torch,
            self.gemm_gflops,
            self.gemm_gflops_libtorch,
            self.update_fraction_of_gemm,
            self.train_steps_per_s,
            self.learn_steps_per_s,
            self.evaluation_episode_steps,
            self.collect_over_learn,
        ]
    }

    fn from_array(values: [T; FIGURES.len()]) -> Self {
        let [
            env_steps_per_s,
            env_steps_per_s_2,
            updates_per_s,
            update_vs_plain_tch,
            update_vs_device_torch,
            gemm_gflops,
            gemm_gflops_libtorch,
            update_fraction_of_gemm,
            train_steps_per_s,
            learn_steps_per_s,
            evaluation_episode_steps,
            collect_over_learn,
        ] = values;
        Self {
            env_steps_per_s,
            env_steps_per_s_2,
            updates_per_s,
            update_vs_plain_tch,
            update_vs_device_torch,
            gemm_gflops,
            gemm_gflops_libtorch,
            update_fraction_of_gemm,
            train_steps_per_s,
            learn_steps_per_s,
            evaluation_episode_steps,
            collect_over_learn,
        }
    }
}

/// What `bench --json` prints.
#[derive(Debug, Serialize, Deserialize)]
struct BenchResult {
    /// Medians over the rounds.
    #[serde(flatten)]
    medians: Figures<f64>,
    /// `None` where the system does not tell.
    peak_memory_bytes: Option<u64>,
    rounds: u32,
    preset: Preset,
    /// Minimum and maximum over the rounds.
    spread: Figures<[f64; 2]>,
}

/// Minimum, median and maximum of each figure over the rounds.
fn spreads(rounds: &[Figures<f64>]) -> [[f64; 3]; FIGURES.len()] {
    let rounds: Vec<_> = rounds.iter().map(|round| round.into_array()).collect();
    core::array::from_fn(|figure| {
        let mut sorted: Vec<f64> = rounds.iter().map(|round| round[figure]).collect();
        sorted.sort_by(f64::total_cmp);
        let at = |index: usize| sorted.get(index).copied().unwrap_or(f64::NAN);
        let last = sorted.len().saturating_sub(1);
        let median = (at(last / 2) + at(sorted.len() / 2)) / 2.0;
        [at(0), median, at(last)]
    })
}

pub fn run(args: Args) -> Result<(), Failure> {
    let figures = measure(&args).map_err(|error| match error {
        BenchError::Config(_) | BenchError::Updates { .. } | BenchError::Robot(_) => {
            failure(Cause::Input, error)
        }
        BenchError::Torch(_) => failure_with_help(Cause::Machine, error, "make setup installs libtorch"),
        BenchError::Device(_) | BenchError::Folder { .. } | BenchError::Train(_) => {
            failure(Cause::Machine, error)
        }
    })?;
    report(&args, &figures);
    Ok(())
}

fn measure(args: &Args) -> Result<Vec<Figures<f64>>, BenchError> {
    tch::set_num_threads(1);
    let config = RunConfig::preset(args.preset)?;
    let round = config.schedule.round_updates;
    if !args.updates.is_multiple_of(round) {
        return Err(BenchError::Updates { updates: args.updates, round });
    }
    let robot = Robot::ant(config.leg_scale)?;
    let env = AntEnv::new(&robot, config.env);
    let layout = Layout { observation_len: env.observation_len(), action_len: env.action_len() };
    let mut learners = Learners::new(&config, layout)?;
    let arithmetic = learners.arithmetic();

    let bar = ProgressBar::new(u64::from(args.rounds) * 5);
    // The template is a constant; if it were invalid, indicatif's default would be used.
    let style = ProgressStyle::with_template("{bar:20} {pos}/{len}, done in {eta}  {wide_msg}")
        .unwrap_or(ProgressStyle::default_bar());
    bar.set_style(style);
    let begin = |what: &'static str| {
        bar.set_message(what);
        // Drawn before the work, so that drawing is not timed.
        bar.tick();
    };
    // A warm-up of caches, clocks and memory pages, which is not counted.
    slices::env_steps_per_s(&config, &robot, 1, ENV_STEPS / 5);
    learners.updates_per_s(UPDATES / 5)?;
    let mut rounds = Vec::new();
    for _ in 0..args.rounds {
        begin("walking");
        let one = slices::env_steps_per_s(&config, &robot, 1, ENV_STEPS);
        bar.inc(1);
        begin("walking, twice");
        let two = slices::env_steps_per_s(&config, &robot, 2, ENV_STEPS);
        bar.inc(1);
        begin("updates");
        let slices::UpdatesPerS { ours, plain, torch } = learners.updates_per_s(UPDATES)?;
        bar.inc(1);
        begin("matrix products");
        let (gemm, libtorch) = slices::gemm_gflops();
        bar.inc(1);
        begin("training");
        let training = slices::training(&config, &robot, args.updates)?;
        bar.inc(1);
        let slices::Training { steps_per_s, learn_steps_per_s, episode_steps } = training;
        rounds.push(Figures {
            env_steps_per_s: one,
            env_steps_per_s_2: two,
            updates_per_s: ours,
            update_vs_plain_tch: plain / ours,
            update_vs_device_torch: torch / ours,
            gemm_gflops: gemm,
            gemm_gflops_libtorch: libtorch,
            update_fraction_of_gemm: ours * arithmetic / 1e9 / gemm,
            train_steps_per_s: steps_per_s,
            learn_steps_per_s,
            evaluation_episode_steps: episode_steps,
            collect_over_learn: config.schedule.env_steps_per_update as f64 * ours / one,
        });
    }
    bar.finish_and_clear();
    Ok(rounds)
}

fn report(args: &Args, rounds: &[Figures<f64>]) {
    let spreads = spreads(rounds);
    let peak_memory_bytes = peak_memory_bytes();
    if args.json {
        let rounded: [[f64; 3]; FIGURES.len()] = core::array::from_fn(|figure| {
            let scale = 10_f64.powi(FIGURES[figure].0 as i32);
            spreads[figure].map(|value| (value * scale).round() / scale)
        });
        let result = BenchResult {
            medians: Figures::from_array(rounded.map(|[_, median, _]| median)),
            peak_memory_bytes,
            rounds: args.rounds,
            preset: args.preset,
            spread: Figures::from_array(rounded.map(|[min, _, max]| [min, max])),
        };
        println!("{}", serde_json::json!(result));
        return;
    }
    println!("Medians of {} rounds (minimum to maximum):", args.rounds);
    for ((decimals, words), [min, median, max]) in FIGURES.into_iter().zip(spreads) {
        println!("{median:>10.decimals$}  {words} ({min:.decimals$} to {max:.decimals$})");
    }
    match peak_memory_bytes {
        Some(bytes) => println!("{:>10.0}  MiB of peak memory", bytes as f64 / (1 << 20) as f64),
        None => println!("         ?  peak memory: not known on this system"),
    }
}

/// Peak memory of this process, libtorch included.
fn peak_memory_bytes() -> Option<u64> {
    #[cfg(unix)]
    {
        use nix::sys::resource::{UsageWho, getrusage};
        let usage = getrusage(UsageWho::RUSAGE_SELF).ok()?;
        // macOS counts bytes, everybody else kilobytes.
        let unit = if cfg!(target_os = "macos") { 1 } else { 1024 };
        u64::try_from(usage.max_rss()).ok().map(|size| size * unit)
    }
    #[cfg(not(unix))]
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_figure_is_the_median_of_its_rounds_with_the_extremes_beside_it() {
        let rounds = [5.0, 1.0, 2.0, 9.0].map(|value| Figures::from_array([value; FIGURES.len()]));

        assert_eq!(spreads(&rounds), [[1.0, 3.5, 9.0]; FIGURES.len()]);
    }
}
