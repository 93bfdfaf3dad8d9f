//! `record`: the policy's average stride, as `fit` takes it.

use super::explain::path_text;
use super::{Cause, Failure};
use crate::record::{RecordError, record};
use crate::robot::{Robot, RobotError};
use crate::run_folder;
use crate::td3::policy::Policy;
use crate::td3::run_config::{ConfigError, RunConfig};
use crate::td3::tensor_file::TensorFileError;
use miette::Diagnostic;
use protocol::Joint;
use std::path::PathBuf;
use thiserror::Error;

#[derive(Debug, clap::Args)]
pub struct Args {
    /// The run whose policy to play
    #[arg(long, value_name = "RUN", default_value = run_folder::LATEST)]
    run: PathBuf,

    /// Trials from different starts to average
    #[arg(long, value_name = "N", default_value_t = 20, value_parser = clap::value_parser!(u16).range(1..=1000))]
    trials: u16,

    /// Print the result as one line of JSON on standard output
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Error, Diagnostic)]
enum RecordCliError {
    #[error("the run has no usable policy")]
    #[diagnostic(help("train one first: cargo run -p host -- train; or name another with --run"))]
    Policy(#[from] TensorFileError),
    #[error("the run has no usable configuration")]
    #[diagnostic(help("train first: cargo run -p host -- train; or name another run with --run"))]
    Config(#[from] ConfigError),
    #[error("the run has no usable robot description")]
    Robot(#[from] RobotError),
    #[error("this policy's trajectory cannot be recorded")]
    #[diagnostic(help("train longer, or with another --seed: a gait is a motion that repeats"))]
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
    let recording = record(&policy, &robot, config.env, config.seed, args.trials.into())
        .map_err(|source| RecordCliError::NoGait { source })?;
    recording.save(&args.run).map_err(|source| RecordCliError::Write { source })?;
    let trajectory = args.run.join(run_folder::TRAJECTORY);
    if args.json {
        let mut line = serde_json::json!(recording);
        line["trajectory"] = path_text(&trajectory).into();
        println!("{line}");
        return Ok(());
    }
    println!(
        "{} strides of {:.3} s from {} trials ({} unlike the rest, {} trials fell).",
        recording.strides_averaged,
        recording.period_s,
        recording.trials,
        recording.strides_left_out,
        recording.fell
    );
    println!(
        "The policy walks at {:.3} m/s on {:.2} W; reward {:.2} a step.",
        recording.speed_m_s, recording.power_w, recording.reward_per_step
    );
    for joint in Joint::ALL {
        let values = recording.samples.iter().map(|sample| sample[joint.index()]);
        let (least, most) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, m), v| (l.min(v), m.max(v)));
        println!(
            "  {}  {least:+.2} to {most:+.2}, spread {:.3}",
            joint.name(),
            recording.spread[joint.index()]
        );
    }
    println!("{}\nNext: cargo run -p host -- fit", trajectory.display());
    Ok(())
}
