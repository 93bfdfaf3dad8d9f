//! `bench`: how fast this machine simulates and learns, and against what.
//!
//! Owns flags, turns and the report. Every figure is the median over rounds in
//! which all kinds of work take turns, so that a machine that slows down slows
//! all of them; ratios are made within a round.

mod plain;
mod slices;

use super::explain::{failure, failure_with_help};
use super::{Cause, Failure};
use crate::env::Env as _;
use crate::learn::td3::device::DeviceError;
use crate::learn::td3::outcome::TrainError;
use crate::learn::td3::preset::Preset;
use crate::learn::td3::replay::Layout;
use crate::learn::td3::run_config::{ConfigError, RunConfig};
use crate::robot::{Robot, RobotError};
use crate::sim::AntEnv;
use indicatif::{ProgressBar, ProgressStyle};
use serde_json::{Map, Value, json};
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
    /// Numbers to train with
    #[arg(long, value_enum, default_value = "walk")]
    preset: Preset,
    /// Turns that every kind of work gets; some 4 s each
    #[arg(long, default_value_t = 7, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1000))]
    rounds: u32,
    /// Updates of the training run that every round makes
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
    #[error("--updates {updates}: this preset learns {round} updates at a time; take a multiple of that")]
    Updates { updates: u64, round: u64 },
    #[error(transparent)]
    Robot(#[from] RobotError),
    #[error("libtorch refuses to compare")]
    Torch(#[from] tch::TchError),
    #[error(transparent)]
    Device(#[from] DeviceError),
    #[error("cannot make a temporary folder for the training run")]
    Folder { source: std::io::Error },
    #[error("the training run stopped")]
    Train(#[from] TrainError),
}

/// The report's figures in their order: name, decimals, what a reader calls it.
const FIGURES: [(&str, usize, &str); 12] = [
    ("env_steps_per_s", 0, "control steps/s walking, one thread"),
    ("env_steps_per_s_2", 0, "control steps/s walking, two threads"),
    ("updates_per_s", 0, "TD3 updates/s, one thread"),
    ("update_vs_plain_tch", 3, "time of an update, over the same losses in plain tch"),
    ("update_vs_device_torch", 3, "time of an update, over that of train --device torch"),
    ("gemm_gflops", 1, "Gflop/s of large matrix products, one thread"),
    ("gemm_gflops_libtorch", 1, "the same by libtorch"),
    ("update_fraction_of_gemm", 3, "an update's Gflop/s over that"),
    ("train_steps_per_s", 0, "control steps/s of a training run, evaluation included"),
    ("learn_steps_per_s", 0, "the same, up to its evaluation"),
    ("evaluation_episode_steps", 0, "control steps that an episode of it lasted"),
    ("collect_over_learn", 3, "time to gather a round's steps, over its updates'"),
];

/// A figure's value in every round.
#[derive(Debug, Default)]
struct Figures([Vec<f64>; FIGURES.len()]);

impl Figures {
    fn add(&mut self, round: [f64; FIGURES.len()]) {
        for (values, value) in self.0.iter_mut().zip(round) {
            values.push(value);
        }
    }

    /// Name, decimals, words; least, median, largest.
    fn spreads(&self) -> impl Iterator<Item = (&'static str, usize, &'static str, [f64; 3])> {
        FIGURES.iter().zip(&self.0).map(|(&(name, decimals, words), values)| {
            let mut sorted = values.clone();
            sorted.sort_by(f64::total_cmp);
            let at = |index: usize| sorted.get(index).copied().unwrap_or(f64::NAN);
            let last = sorted.len().saturating_sub(1);
            let median = (at(last / 2) + at(sorted.len() / 2)) / 2.0;
            (name, decimals, words, [at(0), median, at(last)])
        })
    }
}

pub fn run(args: Args) -> Result<(), Failure> {
    let figures = measure(&args).map_err(|error| match error {
        BenchError::Config(_) | BenchError::Updates { .. } | BenchError::Robot(_) => {
            failure(Cause::Input, error)
        }
        BenchError::Torch(_) => failure_with_help(Cause::Machine, error, "make setup unpacks libtorch"),
        BenchError::Device(_) | BenchError::Folder { .. } | BenchError::Train(_) => {
            failure(Cause::Machine, error)
        }
    })?;
    report(&args, &figures);
    Ok(())
}

fn measure(args: &Args) -> Result<Figures, BenchError> {
    tch::set_num_threads(1);
    let config = RunConfig::preset(args.preset)?;
    let round = config.schedule.round_updates;
    if !args.updates.is_multiple_of(round) {
        return Err(BenchError::Updates { updates: args.updates, round });
    }
    let robot = Robot::ant(config.leg_scale.0)?;
    let env = AntEnv::new(&robot, config.env);
    let layout = Layout { observation_len: env.observation_len(), action_len: env.action_len() };
    let mut learners = Learners::new(&config, layout)?;
    let arithmetic = learners.arithmetic();

    let bar = ProgressBar::new(u64::from(args.rounds) * 5);
    // The template is a constant: if it were wrong, indicatif's own would do.
    let style = ProgressStyle::with_template("{bar:20} {pos}/{len}, done in {eta}  {wide_msg}")
        .unwrap_or(ProgressStyle::default_bar());
    bar.set_style(style);
    let begin = |what: &'static str| {
        bar.set_message(what);
        // Drawn before the work, not within it.
        bar.tick();
    };
    // Caches, clocks and pages: nobody's first turn counts.
    slices::env_steps_per_s(&config, &robot, 1, ENV_STEPS / 5);
    learners.updates_per_s(UPDATES / 5)?;
    let mut figures = Figures::default();
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
        let balance = config.schedule.env_steps_per_update as f64 * ours / one;
        let fraction = ours * arithmetic / 1e9 / gemm;
        let ratios = (plain / ours, torch / ours);
        let slices::Training { steps_per_s: train, learn_steps_per_s: learn, episode_steps } = training;
        figures.add([
            one,
            two,
            ours,
            ratios.0,
            ratios.1,
            gemm,
            libtorch,
            fraction,
            train,
            learn,
            episode_steps,
            balance,
        ]);
    }
    bar.finish_and_clear();
    Ok(figures)
}

fn report(args: &Args, figures: &Figures) {
    let memory = peak_memory_bytes();
    if args.json {
        let rounded = |value: f64, decimals: usize| {
            let scale = 10_f64.powi(decimals as i32);
            json!((value * scale).round() / scale)
        };
        let mut line = Map::new();
        let mut spread = Map::new();
        for (name, decimals, _, [least, median, most]) in figures.spreads() {
            line.insert(name.to_owned(), rounded(median, decimals));
            spread.insert(name.to_owned(), json!([rounded(least, decimals), rounded(most, decimals)]));
        }
        line.insert("peak_memory_bytes".to_owned(), json!(memory));
        line.insert("rounds".to_owned(), json!(args.rounds));
        line.insert("preset".to_owned(), json!(args.preset));
        line.insert("spread".to_owned(), Value::Object(spread));
        println!("{}", Value::Object(line));
        return;
    }
    println!("Medians of {} rounds (least to largest):", args.rounds);
    for (_, decimals, words, [least, median, most]) in figures.spreads() {
        println!("{median:>10.decimals$}  {words} ({least:.decimals$} to {most:.decimals$})");
    }
    match memory {
        Some(bytes) => println!("{:>10.0}  MiB of memory at most", bytes as f64 / (1 << 20) as f64),
        None => println!("         ?  peak memory: not known on this system"),
    }
}

/// The most memory that this process ever held, libtorch included.
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
        let mut figures = Figures::default();
        for value in [5.0, 1.0, 2.0, 9.0] {
            figures.add([value; FIGURES.len()]);
        }

        assert!(figures.spreads().all(|(_, _, _, spread)| spread == [1.0, 3.5, 9.0]));
    }
}
