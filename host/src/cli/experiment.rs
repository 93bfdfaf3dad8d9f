//! `host experiment`: the paper's comparison, as one command.
//!
//! Owns the flags, the order - gaits, trials, figures, report - and what the
//! folder holds. The plan, the statistics and the claims are
//! [`crate::experiment`]'s; `prepare` makes gaits anew, `device` walks trials
//! through the firmware.

mod device;
mod outcome;
mod prepare;

use super::explain::{failure, failure_with_help, file_cause};
use super::reach::interruptible;
use super::steps::{StepError, Steps};
use super::{Cause, Failure};
use crate::experiment::ledger::{Identity, Ledger, LedgerError};
use crate::experiment::materials::{self, Materials, MaterialsError};
use crate::experiment::method::Method;
use crate::experiment::plan::Plan;
use crate::experiment::study::Venue;
use crate::experiment::summary::Planned;
use crate::experiment::twin_trials::{self, Authors};
use crate::experiment::{paper, trial::Trial};
use crate::robot::{Robot, RobotError};
use crate::run_folder::{self, FileError};
use crate::twin::TwinError;
use clap::ValueEnum;
use device::{Device, Reach};
use indicatif::{ProgressBar, ProgressStyle};
use protocol::Amplitude;
use sha2::{Digest as _, Sha256};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;
use thiserror::Error;

/// Trials of a condition in the twin, and where each takes 12 s of somebody's life.
const TRIALS_IN_TWIN: u32 = 10;
const TRIALS_ON_ROBOT: u32 = 3;
/// A study's gaits, in its folder.
const GAITS: &str = "gaits";

/// Where trials are walked.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum On {
    /// The direct simulation: minutes for all
    Twin,
    /// The real firmware in an emulator, in real time
    VirtualRobot,
}

/// The paper's whole comparison: methods, amplifications, legs; figures and a report.
///
/// Plays every method's gait at every amplification on both pairs of legs, and writes every
/// trial, the paper's Figures 3 to 8 and Table 2, and report.html. The gaits are those that
/// come with this program, unless --retrain makes them anew. Called again with the same
/// folder and flags, it goes on where it was interrupted.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Folder of the study [default: a new one in runs]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Legs, once for each pair: 1.0 is 23 cm [default: 1.0 and 0.6]
    #[arg(long = "leg", value_name = "SCALE", conflicts_with = "robot")]
    legs: Vec<f64>,
    /// Folder of another robot than the Ant; needs --retrain, or only --gait
    #[arg(long, value_name = "FOLDER")]
    robot: Option<PathBuf>,
    /// Methods, once for each [default: original, sinusoid, psto, ours, searched]
    #[arg(long = "method", value_name = "METHOD", value_enum)]
    methods: Vec<Method>,
    /// A gait of your own beside them: the file, on the first of the legs
    #[arg(long, value_name = "FILE")]
    gait: Option<PathBuf>,
    /// Amplifications, comma-separated; 1.875 is the stroke that each gait was found at
    /// [default: 1.0 to 2.4 by 0.2]
    #[arg(long = "amp", value_name = "X,X", value_delimiter = ',')]
    amplifications: Vec<f64>,
    /// Trials of each condition [default: 10 in the twin, 3 on a robot]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1000))]
    trials: Option<u32>,
    /// Length of a trial, in seconds
    #[arg(long = "duration", value_name = "S", default_value_t = paper::TRIAL_S)]
    duration_s: f64,
    /// Of starts and, with --retrain, of everything that is learned or searched
    #[arg(long, default_value_t = 0, value_parser = super::seed())]
    seed: u64,
    /// Where trials are walked
    #[arg(long, value_enum, default_value_t = On::Twin)]
    on: On,
    /// Walk them on a robot at this serial port, and ask for the distance of each
    #[arg(long, value_name = "PORT", conflicts_with = "on")]
    port: Option<String>,
    /// With --port: positions, as `measure` takes them, in place of a question
    #[arg(long, value_name = "FILE", requires = "port")]
    tracker: Option<PathBuf>,
    /// In the twin: every trial on a robot of its own, within what the fit, the floor and the
    /// servos leave open, as `optimise` draws them
    #[arg(long, conflicts_with = "port")]
    robots_differ: bool,
    /// The authors' tables, to play them in the twin as well
    #[arg(long, value_name = "CSV", conflicts_with = "port")]
    reference_tables: Option<PathBuf>,
    /// Train, fit and search every gait anew: hours
    #[arg(long)]
    retrain: bool,
    /// With --retrain: this share of the full effort for every method alike
    #[arg(long, value_name = "SHARE", default_value_t = 1.0, requires = "retrain")]
    effort: f64,
    /// The virtual robot's program; by default the one built beside this one
    #[arg(long, value_name = "FILE")]
    virtual_robot: Option<PathBuf>,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Error)]
enum ExperimentError {
    #[error("--{flag} is {value}; it must be within {min} to {max}")]
    Flag { flag: &'static str, value: f64, min: f64, max: f64 },
    #[error("--{flag} names {value} twice")]
    Twice { flag: &'static str, value: String },
    #[error("the method {method} has no gait: it comes from --{flag}")]
    NotAMethod { method: &'static str, flag: &'static str },
    #[error("the distances are unknown, and nobody can be asked: standard input is no terminal")]
    NoDistances,
    #[error("no condition can be walked: {reason}")]
    Nothing { reason: String },
    #[error("interrupted; the trials so far are in {}", .folder.display())]
    Interrupted { folder: PathBuf },
    #[error(transparent)]
    Step(#[from] StepError),
    #[error(transparent)]
    Materials(#[from] MaterialsError),
    #[error(transparent)]
    Ledger(#[from] LedgerError),
    #[error(transparent)]
    Reference(#[from] TwinError),
    #[error(transparent)]
    Robot(#[from] RobotError),
    #[error(transparent)]
    File(#[from] FileError),
    #[error("a figure could not be written")]
    Figure(#[from] crate::experiment::figures::WriteError),
    #[error(transparent)]
    Prepare(#[from] prepare::PrepareError),
}

impl ExperimentError {
    fn into_failure(self) -> Failure {
        match self {
            Self::Step(error) => error.into_failure(),
            Self::Flag { .. } | Self::Twice { .. } | Self::NotAMethod { .. } => failure(Cause::Usage, self),
            Self::NoDistances => {
                failure_with_help(Cause::Usage, self, "call it in a terminal, or give --tracker FILE")
            }
            Self::Nothing { .. } => failure(Cause::Input, self),
            Self::Interrupted { .. } => failure_with_help(
                Cause::Interrupted,
                self,
                "the same command with the same --out goes on there",
            ),
            Self::Materials(MaterialsError::NoneKnown { .. }) => {
                let help = "make them with --retrain, or name one with --gait FILE and --method yours";
                failure_with_help(Cause::Input, self, help)
            }
            Self::Ledger(LedgerError::Other { .. }) => failure_with_help(
                Cause::Usage,
                self,
                "name another folder with --out, or the flags of that study",
            ),
            Self::File(error) => failure(file_cause(&error), error),
            Self::Materials(_) | Self::Ledger(_) | Self::Reference(_) | Self::Robot(_) => {
                failure(Cause::Input, self)
            }
            Self::Figure(_) | Self::Prepare(_) => failure(Cause::Machine, self),
        }
    }
}

pub fn run(args: Args) -> Result<(), Failure> {
    experiment(&args).map_err(ExperimentError::into_failure)
}

fn experiment(args: &Args) -> Result<(), ExperimentError> {
    let plan = plan(args)?;
    let robots = robots(args)?;
    let reference = match &args.reference_tables {
        Some(path) => Some(reference(path)?),
        None => None,
    };
    let steps = Steps::new()?;
    let reach = match (&args.port, args.on) {
        (Some(port), _) => Some(Reach::Port { port: port.clone(), tracker: args.tracker.clone() }),
        (None, On::VirtualRobot) => {
            let beside = || steps.beside("virtual-robot");
            Some(Reach::Virtual { program: args.virtual_robot.clone().unwrap_or_else(beside) })
        }
        (None, On::Twin) => None,
    };
    let venue = match &reach {
        None => Venue::Twin,
        Some(Reach::Virtual { .. }) => Venue::VirtualRobot,
        Some(Reach::Port { .. }) => Venue::Robot,
    };
    let stop = interruptible().map_err(|_| ExperimentError::Interrupted { folder: PathBuf::new() });
    let stop = stop?;
    let folder = match &args.out {
        Some(folder) => folder.clone(),
        None => run_folder::create("experiment")?,
    };
    std::fs::create_dir_all(&folder).map_err(FileError::on("create", &folder))?;
    let (seed, duration_s) = (args.seed, args.duration_s);
    let device = reach.map(|reach| Device { reach, steps, folder: &folder, seed, duration_s, legs_on: None });
    if let Some(device) = &device {
        device.check()?;
    }

    let prepared = Instant::now();
    let legs = gaits(args, &plan, &robots, &folder)?;
    let prepare_wall_s = if args.retrain { prepared.elapsed().as_secs_f64() } else { 0.0 };

    let began = Instant::now();
    let authors = reference.as_ref().map(|(authors, _)| authors);
    let mut planned = plan.conditions(&legs);
    planned.extend(authors.iter().flat_map(|authors| authors.conditions(&plan)));
    if planned.iter().all(|planned| planned.not_run.is_some()) {
        let reason = planned.first().and_then(|planned| planned.not_run.clone());
        return Err(ExperimentError::Nothing {
            reason: reason.unwrap_or_else(|| "none was asked for".into()),
        });
    }
    let gaits = legs.iter().flat_map(|materials| {
        let leg = materials.robot.geometry.leg_scale;
        materials
            .gaits
            .iter()
            .map(move |g| (g.note.method.name().to_owned(), leg, g.note.gait_sha256.clone()))
    });
    let reference_sha256 = reference.as_ref().map(|(_, sha256)| sha256.clone());
    let identity =
        Identity { plan: plan.clone(), venue, gaits: gaits.collect(), reference: reference_sha256 };
    let mut ledger = Ledger::open(&folder, &identity)?;
    let walked = Walks { plan: &plan, legs: &legs, authors, planned: &planned, stop: &stop };
    match device {
        None => walked.in_twin(&mut ledger, &folder)?,
        Some(mut device) => walked.on_device(&mut ledger, &mut device)?,
    }
    let trials = ledger.close()?;
    outcome::finish(args, &folder, outcome::Parts { identity, legs, planned, trials, prepare_wall_s, began })
}

/// The trials of all conditions, those done before left out.
struct Walks<'a> {
    plan: &'a Plan,
    legs: &'a [Materials],
    authors: Option<&'a Authors>,
    planned: &'a [Planned],
    stop: &'a AtomicBool,
}

impl Walks<'_> {
    fn runnable(&self) -> impl Iterator<Item = &Planned> {
        self.planned.iter().filter(|planned| planned.not_run.is_none())
    }

    fn left(&self, ledger: &Ledger) -> usize {
        self.runnable().map(|planned| ledger.missing(planned.place, self.plan.trials).len()).sum()
    }

    fn in_twin(&self, ledger: &mut Ledger, folder: &Path) -> Result<(), ExperimentError> {
        let style =
            ProgressStyle::with_template("{bar:30} {pos}/{len} trials, {msg}, {elapsed} gone, {eta} to go");
        let bar = ProgressBar::new(self.left(ledger) as u64)
            .with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
        for Planned { place, .. } in self.runnable() {
            let numbers = ledger.missing(*place, self.plan.trials);
            if numbers.is_empty() {
                continue;
            }
            bar.set_message(format!("{} {} L", place.method.label(), place.leg));
            let trials = twin_trials::walk(self.plan, self.legs, self.authors, *place, &numbers);
            bar.inc(trials.len() as u64);
            ledger.add(trials)?;
            if self.stop.load(Ordering::Relaxed) {
                bar.finish_and_clear();
                return Err(ExperimentError::Interrupted { folder: folder.to_owned() });
            }
        }
        bar.finish_and_clear();
        Ok(())
    }

    fn on_device(&self, ledger: &mut Ledger, device: &mut Device<'_>) -> Result<(), ExperimentError> {
        for Planned { place, .. } in self.runnable() {
            let same_legs = |materials: &&Materials| materials.robot.geometry.leg_scale == place.leg;
            let Some(materials) = self.legs.iter().find(same_legs) else { continue };
            for number in ledger.missing(*place, self.plan.trials) {
                let left = self.left(ledger);
                let trial: Option<Trial> = device.walk(*place, number, materials, left)?;
                ledger.add(trial.into_iter().collect())?;
                if self.stop.load(Ordering::Relaxed) {
                    return Err(ExperimentError::Interrupted { folder: device.folder.to_owned() });
                }
            }
        }
        Ok(())
    }
}

/// Refuses now what would be refused after the first trial.
fn plan(args: &Args) -> Result<Plan, ExperimentError> {
    let in_twin = args.port.is_none() && args.on == On::Twin;
    let trials = args.trials.unwrap_or(if in_twin { TRIALS_IN_TWIN } else { TRIALS_ON_ROBOT });
    let mut plan = Plan { robots_differ: args.robots_differ, ..Plan::paper(trials, args.seed) };
    let (least_s, most_s) = super::measure::DURATION_RANGE_S;
    let (least, most) = (Amplitude::MIN.value(), Amplitude::MAX.value());
    let mut ranges =
        vec![("duration", args.duration_s, least_s, most_s), ("effort", args.effort, 0.001, 10.0)];
    ranges.extend(args.amplifications.iter().map(|&a| ("amp", a, least, most)));
    ranges.extend(args.legs.iter().map(|&leg| ("leg", leg, 0.1, 3.0)));
    for (flag, value, min, max) in ranges {
        if !(min..=max).contains(&value) {
            return Err(ExperimentError::Flag { flag, value, min, max });
        }
    }
    twice("amp", &args.amplifications)?;
    twice("leg", &args.legs)?;
    let named: Vec<&str> = args.methods.iter().map(|method| method.name()).collect();
    twice("method", &named)?;
    plan.duration_s = args.duration_s;
    if !args.amplifications.is_empty() {
        plan.amplifications.clone_from(&args.amplifications);
    }
    if !args.methods.is_empty() {
        plan.methods.clone_from(&args.methods);
    }
    if args.gait.is_some() && !plan.methods.contains(&Method::Yours) {
        plan.methods.push(Method::Yours);
    }
    for method in &plan.methods {
        let flag = match method {
            Method::AuthorsOriginal | Method::AuthorsPsto => "reference-tables",
            Method::Yours if args.gait.is_none() => "gait",
            _ => continue,
        };
        return Err(ExperimentError::NotAMethod { method: method.name(), flag });
    }
    Ok(plan)
}

fn twice<T: PartialEq + ToString>(flag: &'static str, values: &[T]) -> Result<(), ExperimentError> {
    let again = values.iter().enumerate().find(|(k, value)| values[..*k].contains(value));
    again.map_or(Ok(()), |(_, value)| Err(ExperimentError::Twice { flag, value: value.to_string() }))
}

fn robots(args: &Args) -> Result<Vec<Robot>, ExperimentError> {
    if let Some(folder) = &args.robot {
        return Ok(vec![Robot::load(folder)?]);
    }
    let legs: &[f64] = if args.legs.is_empty() { &paper::LEGS } else { &args.legs };
    Ok(legs.iter().map(|&leg| Robot::ant(leg)).collect::<Result<_, _>>()?)
}

/// The authors' tables, for the paper's long legs, and their SHA-256.
fn reference(path: &Path) -> Result<(Authors, String), ExperimentError> {
    let robot = Robot::ant(paper::LEGS[0])?;
    let sample_s = robot.twin.as_ref().map_or(0.1, |twin| twin.sample_s);
    let authors = Authors::read(path, &robot, sample_s)?;
    let bytes = std::fs::read(path).map_err(FileError::on("read", path))?;
    let sha256 = Sha256::digest(&bytes).iter().map(|byte| format!("{byte:02x}")).collect();
    Ok((authors, sha256))
}

/// The gaits of every pair of legs, in the study's folder.
fn gaits(
    args: &Args,
    plan: &Plan,
    robots: &[Robot],
    folder: &Path,
) -> Result<Vec<Materials>, ExperimentError> {
    let mut legs = Vec::new();
    for (k, robot) in robots.iter().enumerate() {
        let gaits = folder.join(GAITS).join(materials::folder_name(robot));
        std::fs::create_dir_all(&gaits).map_err(FileError::on("create", &gaits))?;
        if args.retrain {
            prepare::make(args, plan, robot, folder, &gaits)?;
        } else if plan.methods.iter().any(|&method| method != Method::Yours) {
            materials::unpack(robot, &gaits)?;
        }
        if let Some(path) = args.gait.as_ref().filter(|_| k == 0) {
            let bytes = std::fs::read(path).map_err(FileError::on("read", path))?;
            run_folder::write(&gaits.join(format!("{}.toml", Method::Yours.name())), &bytes)?;
        }
        legs.push(materials::read(&gaits, robot, &plan.methods)?);
    }
    Ok(legs)
}
