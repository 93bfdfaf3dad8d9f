//! `record`: the policy's average stride, the input of `fit`.
//!
//! Holds the flags and the table. Does not depend on how trials are averaged.

use super::explain::{path_text, warn};
use super::{Cause, Failure};
use crate::gait::policy_record::RecordSummary;
use crate::gait::stride::{MAX_PERIOD_S, MIN_WINDOW_S, window};
use crate::learn::record::{FIGURE, Part, RECORDED_S, RecordError, Recording, record};
use crate::learn::run_config::{ConfigError, RunConfig};
use crate::learn::td3::policy::Policy;
use crate::learn::td3::tensor_file::TensorFileError;
use crate::robot::{Robot, RobotError};
use crate::run_folder;
use crate::sim::ant_env::ACTION_DEG;
use miette::Diagnostic;
use protocol::Joint;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use std::str::FromStr;
use thiserror::Error;

#[derive(Debug, clap::Args)]
pub struct Args {
    /// Run whose policy is played
    #[arg(long, value_name = "RUN", default_value = run_folder::LATEST)]
    run: PathBuf,

    /// Number of trials, from different starts
    #[arg(long, value_name = "N", default_value_t = 20, value_parser = clap::value_parser!(u16).range(1..=1000))]
    trials: u16,

    /// Average a fixed window instead of the stride, 4 s long as in the paper if no length is given.
    /// It may hold any number of strides, and its ends need not meet
    #[arg(long, value_name = "S")]
    #[expect(clippy::option_option, reason = "the flag, and its value, may be left out")]
    window: Option<Option<Window>>,

    /// Print the result as one line of JSON on standard output
    #[arg(long)]
    json: bool,
}

/// Length of a window in seconds, within what a recorded trial allows.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Window(f64);

impl Window {
    /// A trial is longer than the window by at least a stride, in which the window is placed.
    const MOST_S: f64 = RECORDED_S - MAX_PERIOD_S;
}

#[derive(Debug, PartialEq, Error)]
#[error("a window must be {} to {} s long, got {text:?}", MIN_WINDOW_S, Window::MOST_S)]
struct BadWindow {
    text: String,
}

impl FromStr for Window {
    type Err = BadWindow;

    fn from_str(text: &str) -> Result<Self, BadWindow> {
        let seconds = text.parse().ok().filter(|s| (MIN_WINDOW_S..=Self::MOST_S).contains(s));
        seconds.map(Self).ok_or_else(|| BadWindow { text: text.into() })
    }
}

/// What `record --json` prints.
#[derive(Debug, Serialize, Deserialize)]
struct RecordResult {
    #[serde(flatten)]
    summary: RecordSummary,
    /// Path of `trajectory.csv`.
    trajectory: String,
    /// Path of `trajectory.svg`.
    figure: String,
}

#[derive(Debug, Error, Diagnostic)]
enum RecordCliError {
    #[error("the run has no usable policy")]
    #[diagnostic(help("train one first: cargo run -p host -- train; or name another run with --run"))]
    Policy(#[from] TensorFileError),
    #[error("the run has no usable configuration")]
    #[diagnostic(help("train first: cargo run -p host -- train; or name another run with --run"))]
    Config(#[from] ConfigError),
    #[error("the run has no usable robot description")]
    Robot(#[from] RobotError),
    #[error("this policy's trajectory cannot be recorded")]
    #[diagnostic(help("train longer, or with another --seed"))]
    NoGait { source: RecordError },
    #[error("cannot write the recording")]
    Write { source: RecordError },
}

impl From<RecordCliError> for Failure {
    fn from(error: RecordCliError) -> Self {
        let cause = if matches!(error, RecordCliError::Write { .. }) { Cause::Machine } else { Cause::Input };
        Self::new(cause, error)
    }
}

pub fn run(args: Args) -> Result<(), Failure> {
    Ok(play(&args)?)
}

fn play(args: &Args) -> Result<(), RecordCliError> {
    let config = RunConfig::load(&args.run.join(run_folder::CONFIG))?;
    let robot = Robot::of_trained_run(&args.run)?;
    let policy = Policy::load(&args.run.join(run_folder::POLICY))?;
    eprintln!("Playing {} trials of {}.", args.trials, args.run.display());
    let part = args.window.map_or(Part::Strides, |given| Part::Window {
        window_s: given.map_or(window::PAPER_WINDOW_S, |Window(window_s)| window_s),
    });
    let recording = record(&policy, &robot, config.env, config.seed, args.trials.into(), part)
        .map_err(|source| RecordCliError::NoGait { source })?;
    recording.save(&args.run).map_err(|source| RecordCliError::Write { source })?;
    if let Err(error) = &recording.fits {
        warn(&format!("no curve in {FIGURE}: {error}"));
    }
    let (trajectory, figure) = (args.run.join(run_folder::TRAJECTORY), args.run.join(FIGURE));
    if args.json {
        let result = RecordResult {
            summary: recording.summary,
            trajectory: path_text(&trajectory),
            figure: path_text(&figure),
        };
        println!("{}", serde_json::json!(result));
        return Ok(());
    }
    print(&recording, &trajectory, &figure);
    Ok(())
}

fn print(recording: &Recording, trajectory: &Path, figure: &Path) {
    let summary = &recording.summary;
    let RecordSummary { period_s, trials, fell, strides_averaged, strides_left_out, .. } = summary;
    match summary.window_s {
        None => println!(
            "{strides_averaged} strides of {period_s:.3} s from {trials} trials ({strides_left_out} left \
             out as too different, {fell} trials fell)."
        ),
        Some(_) => {
            let held = summary.strides_in_window.map(|count| format!(", {count:.1} strides"));
            println!(
                "{strides_averaged} windows of {period_s:.3} s{} from {trials} trials ({strides_left_out} \
                 left out as too different, {fell} trials fell).",
                held.unwrap_or_default()
            );
        }
    }
    println!(
        "The policy walks at {:.3} m/s on {:.2} W; reward {:.2} a step.",
        summary.speed_m_s, summary.power_w, summary.reward_per_step
    );
    println!("\njoint          action    spread      degrees    spread   R2 of the curve");
    for joint in Joint::ALL {
        let index = joint.index();
        let values = recording.samples.iter().map(|sample| sample[index]);
        let (least, most) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, m), v| (l.min(v), m.max(v)));
        let r2 = summary.polynomial_r2[index].map_or("still".into(), |r2| format!("{r2:.3}"));
        println!(
            "{:5}  {least:+.2} to {most:+.2}  {:8.3}  {:+3.0} to {:+3.0}  {:8.1}   {r2:>15}",
            joint.name(),
            summary.spread[index],
            least * ACTION_DEG,
            most * ACTION_DEG,
            summary.spread_deg[index],
        );
    }
    if let Some(strides) = summary.crowded_strides() {
        warn(&format!(
            "one curve cannot follow {strides:.1} strides: a window is for a picture like the paper's; for a \
             gait, record without --window"
        ));
    }
    println!("\n{}\n{}\nNext: cargo run -p host -- fit", trajectory.display(), figure.display());
}
