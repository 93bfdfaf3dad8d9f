//! The whole chain against the virtual robot, each step a process of its own,
//! exactly as a person would type it.
//!
//! Owns the order of the steps and `summary.json`; every number in it comes
//! from a step's own `--json`.

use super::measure::DURATION_RANGE_S;
use super::steps::{StepError, Steps, rounded};
use super::virtual_robot::VirtualRobot;
use super::{Cause, Failure};
use crate::robot::Robot;
use crate::run_folder::{self, FileError};
use protocol::Amplitude;
use serde_json::{Map, Value, json};
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
    #[error("--{flag} is {value}; it must be within {min} to {max}")]
    Flag { flag: &'static str, value: f64, min: f64, max: f64 },
    #[error(transparent)]
    Step(#[from] StepError),
    #[error("step `{step}` reported no `{field}`")]
    Field { step: &'static str, field: &'static str },
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
            Self::Flag { .. } => (Cause::Usage, "nothing was trained yet"),
            Self::Field { .. } => {
                (Cause::Machine, "host and its steps are of different versions: rebuild both")
            }
            Self::File(_) | Self::Gait { .. } | Self::Robot(_) | Self::Step(_) => {
                (Cause::Machine, "is the disk full, or the folder read-only?")
            }
        };
        Failure::new(cause, miette::miette!(help = help, "{this}"))
    }
}

/// Refuses now what a later step would refuse after minutes of training.
fn check(args: &Args, virtual_robot: &Path) -> Result<(), DemoError> {
    let (least, most) = DURATION_RANGE_S;
    let ranges = [
        ("amp", args.amplitude, Amplitude::MIN.value(), Amplitude::MAX.value()),
        ("duration", args.duration_s, least, most),
    ];
    for (flag, value, min, max) in ranges {
        if !(min..=max).contains(&value) {
            return Err(DemoError::Flag { flag, value, min, max });
        }
    }
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
) -> Result<Option<Value>, DemoError> {
    let trained_on = Robot::of_run(run)?;
    let leg_scale = trained_on.as_ref().map_or(1.0, |robot| robot.geometry.leg_scale);
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
    let upload = steps.run("upload-gait", &["--gait", &gait, "--amp", "1", "--port", &robot.port])?;
    let mut trial = steps.run(
        "measure",
        &["--port", &robot.port, "--duration", &duration, "--tracker", &truth, "--out", &out],
    )?;
    trial["gait_sha256"] = upload["gait_sha256"].clone();
    Ok(Some(trial))
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
    let train = steps.run("train", &flags)?;
    steps.run("record", &["--run", &run_name])?;
    // Uploaded and walked in any case: a servo that lags is part of what is measured.
    steps.run("fit", &["--run", &run_name, "--lag"])?;

    let robot = VirtualRobot::start(&virtual_robot, &run, args.seed)?;
    eprintln!("\nvirtual robot on {}", robot.port);
    let gait = run.join(run_folder::GAIT).display().to_string();
    let upload =
        steps.run("upload-gait", &["--gait", &gait, "--amp", &amplitude, "--clip", "--port", &robot.port])?;
    let truth = run.join(run_folder::TRUTH).display().to_string();
    let trial = steps.run(
        "measure",
        &["--port", &robot.port, "--duration", &duration, "--tracker", &truth, "--out", &run_name],
    )?;
    drop(robot);
    let searched = searched(&mut steps, args, &run, &virtual_robot)?;

    let mut summary = Map::new();
    let mut take = |from: &Value, step: &'static str, fields: &[&'static str]| {
        for &field in fields {
            let value = from.get(field).ok_or(DemoError::Field { step, field })?;
            summary.insert(field.to_owned(), value.clone());
        }
        Ok::<(), DemoError>(())
    };
    let measured = [
        "cost_of_transport",
        "speed_m_s",
        "mean_power_w",
        "energy_j",
        "distance_m",
        "amplitude",
        "frames_played",
    ];
    take(&trial, "measure", &measured)?;
    take(&train, "train", &["seed", "reward_untrained", "reward_trained", "train_env_steps"])?;
    take(&upload, "upload-gait", &["gait_sha256", "gait_source", "clipped_share"])?;
    if let Some(trial) = &searched {
        let fields = ["cost_of_transport", "speed_m_s", "mean_power_w", "gait_sha256", "amplitude"];
        let of = |field: &&str| trial.get(*field).map(|value| ((*field).to_owned(), value.clone()));
        summary.insert("searched".to_owned(), Value::Object(fields.iter().filter_map(of).collect()));
    }
    steps.wall_s.insert("total".to_owned(), rounded(start.elapsed().as_secs_f64()));
    summary.insert("run".to_owned(), json!(run_name));
    summary.insert("wall_s".to_owned(), Value::Object(steps.wall_s));

    let summary = Value::Object(summary);
    let path = run.join(run_folder::SUMMARY);
    run_folder::write(&path, format!("{summary:#}\n").as_bytes())?;
    run_folder::make_latest(&run)?;
    let line = |what: &str, of: &Value, amplitude: f64| {
        let figure = |field: &str| of[field].as_f64().unwrap_or(f64::NAN);
        eprintln!(
            "{what:21} {:17.3} {:11.3} {:8.3} {amplitude:11}",
            figure("cost_of_transport"),
            figure("speed_m_s"),
            figure("mean_power_w"),
        );
    };
    eprintln!("\nTrials of {} s on the virtual robot:", args.duration_s);
    eprintln!("                      cost of transport   speed m/s  power W   amplitude");
    line("learned just now", &summary, args.amplitude);
    if let Some(trial) = &searched {
        line("searched (host/gaits)", trial, 1.0);
    }
    eprintln!("{}", path.display());
    if args.json {
        println!("{summary:#}");
    }
    Ok(())
}
