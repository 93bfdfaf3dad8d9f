//! `host demo`: train, record, fit, upload and measure on the virtual robot.
//!
//! Holds the order of the steps and `summary.json`. Each step is a process of its
//! own, as a user would type it, and every number comes from a step's own `--json`.
//! Does not depend on how a step works.

use super::output;
use super::ranges::{self, DURATION_RANGE_S, OutOfRange};
use super::steps::{StepError, Steps, rounded_s};
use super::virtual_robot::VirtualRobot;
use super::{Cause, Failure};
use crate::device::trial::measure_result::MeasureResult;
use crate::device::upload::upload_result::UploadResult;
use crate::learn::train_result::TrainResult;
use crate::robot::Robot;
use crate::run_folder::{self, FileError};
use protocol::Amplitude;
use serde::Serialize;
use serde::de::IgnoredAny;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::Instant;
use thiserror::Error;

/// Folder of the second trial, in the run's.
const SEARCHED: &str = "searched";

/// Flags of `host demo`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Seed of training, recording and the robot's start; another seed gives another gait
    #[arg(long, default_value_t = 0, value_parser = super::seed())]
    seed: u64,
    /// Training preset
    #[arg(long, default_value = "quick")]
    preset: String,
    /// Amplitude to upload the gait at
    #[arg(long = "amp", default_value_t = 2.2)]
    amplitude: f64,
    /// Length of the trial in seconds
    #[arg(long = "duration", default_value_t = 12.0, value_name = "S")]
    duration_s: f64,
    /// Folder of the robot that learns and walks [default: the Ant]
    #[arg(long, value_name = "FOLDER")]
    robot: Option<PathBuf>,
    /// The virtual robot's program; by default the one built beside this one
    #[arg(long, value_name = "FILE")]
    virtual_robot: Option<PathBuf>,
    /// Also print summary.json on standard output
    #[arg(long)]
    json: bool,
}

/// Why the demo stopped.
#[derive(Debug, Error)]
enum DemoError {
    #[error(transparent)]
    Flag(#[from] OutOfRange),
    #[error(transparent)]
    Step(#[from] StepError),
    #[error("the gait that was searched cannot be read or written")]
    Gait { source: crate::gait::gait_file::GaitFileError },
    #[error(transparent)]
    Robot(#[from] crate::robot::RobotError),
    #[error(transparent)]
    File(#[from] FileError),
}

impl DemoError {
    fn into_failure(self) -> Failure {
        let this = match self {
            Self::Step(error) => return error.into_failure(),
            this => this,
        };
        let (cause, help) = match &this {
            Self::Flag(_) => (Cause::Usage, "nothing was trained yet"),
            Self::File(_) | Self::Gait { .. } | Self::Robot(_) | Self::Step(_) => {
                (Cause::Machine, "is the disk full, or the folder read-only?")
            }
        };
        Failure::new(cause, miette::miette!(help = help, "{this}"))
    }
}

/// `summary.json` of the run: the trial of the gait that was learned.
#[derive(Debug, Serialize)]
struct Summary {
    seed: u64,
    reward_untrained: f64,
    reward_trained: f64,
    train_env_steps: u64,
    gait_sha256: String,
    gait_source: String,
    clipped_share: f64,
    cost_of_transport: Option<f64>,
    speed_m_s: Option<f64>,
    mean_power_w: Option<f64>,
    energy_j: f64,
    distance_m: Option<f64>,
    amplitude: f64,
    frames_played: u32,
    #[serde(skip_serializing_if = "Option::is_none")]
    searched: Option<Searched>,
    run: String,
    wall_s: BTreeMap<String, f64>,
}

/// The trial of the gait that comes with the program.
#[derive(Debug, Serialize)]
struct Searched {
    cost_of_transport: Option<f64>,
    speed_m_s: Option<f64>,
    mean_power_w: Option<f64>,
    gait_sha256: String,
    amplitude: f64,
}

/// Refuses now what a later step would refuse after minutes of training.
fn check(args: &Args, virtual_robot: &Path) -> Result<(), DemoError> {
    let (least, most) = DURATION_RANGE_S;
    ranges::check("amp", Some(args.amplitude), Amplitude::MIN.value(), Amplitude::MAX.value())?;
    ranges::check("duration", Some(args.duration_s), least, most)?;
    if !virtual_robot.is_file() {
        return Err(StepError::NoVirtualRobot { program: virtual_robot.to_owned() }.into());
    }
    Ok(())
}

/// A second trial: the gait that `host optimise` found for this robot, if it did for one.
fn searched(
    steps: &mut Steps,
    args: &Args,
    run: &Path,
    virtual_robot: &Path,
) -> Result<Option<Searched>, DemoError> {
    let trained_on = Robot::of_run(run)?;
    let leg_scale =
        trained_on.as_ref().map_or(crate::robot::LegScale::LONG, |robot| robot.geometry.leg_scale);
    let is_ant = Robot::ant(leg_scale).is_ok_and(|ant| Some(ant) == trained_on);
    let found = crate::search::bundled_gaits::gait(leg_scale).map_err(|source| DemoError::Gait { source })?;
    let Some(gait) = found.filter(|_| is_ant) else {
        eprintln!("\nno gait was searched for this robot: cargo run -p host -- optimise");
        return Ok(None);
    };
    // A folder of its own: it has a truth and trials of its own, too.
    let folder = run.join(SEARCHED);
    std::fs::create_dir_all(&folder).map_err(FileError::on("create", &folder))?;
    let path = folder.join(run_folder::GAIT);
    gait.save(&path).map_err(|source| DemoError::Gait { source })?;
    if let Some(robot) = trained_on {
        robot.save(&folder.join(run_folder::ROBOT))?;
    }
    let robot = VirtualRobot::start(virtual_robot, &folder, args.seed)?;
    eprintln!("\nvirtual robot on {}", robot.port);
    let (gait, out) = (path.display().to_string(), folder.display().to_string());
    let truth = folder.join(run_folder::TRUTH).display().to_string();
    let duration = args.duration_s.to_string();
    let upload: UploadResult =
        steps.run("upload-gait", &["--gait", &gait, "--amp", "1", "--port", &robot.port])?;
    let trial: MeasureResult = steps.run(
        "measure",
        &["--port", &robot.port, "--duration", &duration, "--tracker", &truth, "--out", &out],
    )?;
    Ok(Some(Searched {
        cost_of_transport: trial.cost_of_transport,
        speed_m_s: trial.speed_m_s,
        mean_power_w: trial.mean_power_w,
        gait_sha256: upload.gait.gait_sha256,
        amplitude: trial.amplitude,
    }))
}

/// Runs the demo.
pub fn run(args: Args) -> Result<(), Failure> {
    demo(&args).map_err(DemoError::into_failure)
}

fn demo(args: &Args) -> Result<(), DemoError> {
    let start = Instant::now();
    let mut steps = Steps::new()?;
    let virtual_robot = args.virtual_robot.clone().unwrap_or_else(|| steps.beside("virtual-robot"));
    check(args, &virtual_robot)?;
    let run = run_folder::create(&format!("demo-seed{}", args.seed))?;
    let run_name = run.display().to_string();
    let seed = args.seed.to_string();
    let amplitude = args.amplitude.to_string();
    let duration = args.duration_s.to_string();

    let mut flags = vec!["--preset", &args.preset, "--seed", &seed, "--out", &run_name];
    let folder = args.robot.as_ref().map(|folder| folder.display().to_string());
    if let Some(folder) = &folder {
        flags.extend(["--robot", folder]);
    }
    let train: TrainResult = steps.run("train", &flags)?;
    steps.run::<IgnoredAny>("record", &["--run", &run_name])?;
    // Uploaded and walked in any case: a servo that lags is part of what is measured.
    steps.run::<IgnoredAny>("fit", &["--run", &run_name, "--lag"])?;

    let robot = VirtualRobot::start(&virtual_robot, &run, args.seed)?;
    eprintln!("\nvirtual robot on {}", robot.port);
    let gait = run.join(run_folder::GAIT).display().to_string();
    let upload: UploadResult =
        steps.run("upload-gait", &["--gait", &gait, "--amp", &amplitude, "--clip", "--port", &robot.port])?;
    let truth = run.join(run_folder::TRUTH).display().to_string();
    let trial: MeasureResult = steps.run(
        "measure",
        &["--port", &robot.port, "--duration", &duration, "--tracker", &truth, "--out", &run_name],
    )?;
    drop(robot);
    let searched = searched(&mut steps, args, &run, &virtual_robot)?;

    steps.wall_s.insert("total".to_owned(), rounded_s(start.elapsed().as_secs_f64()));
    let summary = Summary {
        seed: train.seed,
        reward_untrained: train.reward_untrained,
        reward_trained: train.reward_trained,
        train_env_steps: train.train_env_steps,
        gait_sha256: upload.gait.gait_sha256,
        gait_source: upload.gait.gait_source,
        clipped_share: upload.gait.clipped_share,
        cost_of_transport: trial.cost_of_transport,
        speed_m_s: trial.speed_m_s,
        mean_power_w: trial.mean_power_w,
        energy_j: trial.energy_j,
        distance_m: trial.distance_m,
        amplitude: trial.amplitude,
        frames_played: trial.frames_played,
        searched,
        run: run_name,
        wall_s: steps.wall_s,
    };
    let path = run.join(run_folder::SUMMARY);
    run_folder::write(&path, format!("{:#}\n", output::json(&summary)).as_bytes())?;
    run_folder::make_latest(&run)?;
    print_table(args, &summary);
    eprintln!("{}", path.display());
    if args.json {
        output::print_json(&summary);
    }
    Ok(())
}

fn print_table(args: &Args, summary: &Summary) {
    let figure = |value: Option<f64>| value.map_or("unknown".to_owned(), |value| format!("{value:.3}"));
    let line = |what: &str, cost: Option<f64>, speed: Option<f64>, power: Option<f64>, amplitude: f64| {
        let (cost, speed, power) = (figure(cost), figure(speed), figure(power));
        eprintln!("{what:21} {cost:>17} {speed:>11} {power:>8} {amplitude:11}");
    };
    eprintln!("\nTrials of {} s on the virtual robot:", args.duration_s);
    eprintln!("                      cost of transport   speed m/s  power W   amplitude");
    let Summary { cost_of_transport, speed_m_s, mean_power_w, .. } = *summary;
    line("learned just now", cost_of_transport, speed_m_s, mean_power_w, args.amplitude);
    if let Some(Searched { cost_of_transport, speed_m_s, mean_power_w, .. }) = summary.searched {
        line("searched (host/gaits)", cost_of_transport, speed_m_s, mean_power_w, 1.0);
    }
}
