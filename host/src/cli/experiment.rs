//! `host experiment`: the paper's comparison, as one command.
//!
//! Owns the flags, the order - gaits, trials, figures, report - and what the
//! folder holds. The plan, the statistics and the claims are
//! [`crate::experiment`]'s; `prepare` makes gaits anew, `device` walks trials
//! through the firmware.

mod device;
mod inputs;
mod outcome;
mod person;
mod prepare;
mod walks;

use super::explain::{failure, failure_with_help, file_cause};
use super::reach::interruptible;
use super::steps::{StepError, Steps};
use super::{Cause, Failure};
use crate::experiment::ledger::{self, Identity, Ledger, LedgerError};
use crate::experiment::materials::MaterialsError;
use crate::experiment::method::Method;
use crate::experiment::paper;
use crate::experiment::study::Venue;
use crate::robot::RobotError;
use crate::run_folder::{self, FileError};
use crate::twin::TwinError;
use clap::ValueEnum;
use device::{Device, Reach};
use person::Person;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;
use thiserror::Error;

/// Where trials are walked.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum On {
    /// The direct simulation: less than a minute for all
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
    #[arg(long = "leg", value_name = "SCALE", conflicts_with = "robot", value_delimiter = ',')]
    legs: Vec<f64>,
    /// Folder of another robot than the Ant; needs --retrain, or only --gait
    #[arg(long, value_name = "FOLDER")]
    robot: Option<PathBuf>,
    /// Methods, once for each [default: original, sinusoid, psto, ours, searched]
    #[arg(long = "method", value_name = "METHOD", value_enum, value_delimiter = ',')]
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
    #[arg(long = "duration", value_name = "S", default_value_t = paper::TRIAL_S, allow_negative_numbers = true)]
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
    /// With --port: what the robot weighs with the legs of this call [default: as its description says]
    #[arg(long, value_name = "KG", requires = "port")]
    mass_kg: Option<f64>,
    /// In the twin: every trial on a robot of its own, within what the fit, the floor and the
    /// servos leave open, as `optimise` draws them
    #[arg(long, conflicts_with = "port")]
    robots_differ: bool,
    /// The authors' tables, to play them in the twin as well
    #[arg(long, value_name = "CSV", conflicts_with = "port")]
    reference_tables: Option<PathBuf>,
    /// Train, fit and search every gait anew, in the study's folder: hours
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
    #[error("--{flag} is for the twin: on the virtual robot there is one robot, and it plays gait tables")]
    InTwinOnly { flag: &'static str },
    #[error("the distances are unknown, and nobody can be asked: standard input is no terminal")]
    NoDistances,
    #[error("no condition can be walked: {reason}")]
    Nothing { reason: String },
    /// No failure: what was asked for.
    #[error("the trials so far are in {}", .folder.display())]
    Quit { folder: PathBuf },
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
            Self::Flag { .. } | Self::Twice { .. } | Self::NotAMethod { .. } | Self::InTwinOnly { .. } => {
                failure(Cause::Usage, self)
            }
            Self::NoDistances => {
                failure_with_help(Cause::Usage, self, "call it in a terminal, or give --tracker FILE")
            }
            Self::Nothing { .. } => failure(Cause::Input, self),
            Self::Quit { .. } | Self::Interrupted { .. } => failure_with_help(
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
            Self::Ledger(LedgerError::Busy { .. }) => {
                failure_with_help(Cause::Usage, self, "wait for it, or name another folder with --out")
            }
            Self::Ledger(LedgerError::NoPlan { .. } | LedgerError::Trial { .. }) => failure_with_help(
                Cause::Input,
                self,
                "put right what was changed by hand, or name another folder with --out",
            ),
            Self::File(error) => failure(file_cause(&error), error),
            Self::Materials(_) | Self::Ledger(_) | Self::Reference(_) | Self::Robot(_) => {
                failure(Cause::Input, self)
            }
            Self::Prepare(prepare::PrepareError::Otherwise { .. }) => failure_with_help(
                Cause::Usage,
                self,
                "name another folder with --out, or the flags of that study",
            ),
            Self::Figure(_) | Self::Prepare(_) => failure(Cause::Machine, self),
        }
    }
}

pub fn run(args: Args) -> Result<(), Failure> {
    let stop = interruptible()?;
    match experiment(&args, &stop) {
        Err(ended @ ExperimentError::Quit { .. }) => {
            eprintln!("For today {ended}; the same command with the same --out goes on there.");
            Ok(())
        }
        outcome => outcome.map_err(ExperimentError::into_failure),
    }
}

fn experiment(args: &Args, stop: &AtomicBool) -> Result<(), ExperimentError> {
    let plan = inputs::plan(args)?;
    let robots = inputs::robots(args)?;
    let reference = match &args.reference_tables {
        Some(path) => Some(inputs::reference(path)?),
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
    let folder = match &args.out {
        Some(folder) => folder.clone(),
        None => run_folder::create("experiment")?,
    };
    std::fs::create_dir_all(&folder).map_err(FileError::on("create", &folder))?;
    let (seed, duration_s) = (args.seed, args.duration_s);
    let person = Person::at_standard_input(stop);
    let mass_kg = args.mass_kg;
    let device =
        reach.map(|reach| Device { reach, steps, folder: &folder, seed, duration_s, mass_kg, person });
    if let Some(device) = &device {
        device.check()?;
    }

    // Before hours of training, and before a gait is copied into a folder of something else.
    let robot_sha256s: Vec<String> =
        robots.iter().map(|robot| inputs::sha256(format!("{robot:?}").as_bytes())).collect();
    let reference_sha256 = reference.as_ref().map(|(_, sha256)| sha256.clone());
    ledger::refuse_another(&folder, &plan, venue, &robot_sha256s, reference_sha256.as_ref())?;
    let legs = inputs::gaits(args, &plan, &robots, &folder)?;
    if stop.load(Ordering::Relaxed) {
        return Err(ExperimentError::Interrupted { folder });
    }
    let prepare_wall_s = if args.retrain { prepare::wall_s(&legs) } else { 0.0 };

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
    let identity = Identity {
        plan: plan.clone(),
        venue,
        robots: robot_sha256s,
        gaits: gaits.collect(),
        reference: reference_sha256,
    };
    let mut ledger = Ledger::open(&folder, &identity)?;
    let walked = walks::Walks { plan: &plan, legs: &legs, authors, planned: &planned, stop };
    match device {
        None => walked.in_twin(&mut ledger, &folder)?,
        Some(mut device) => walked.on_device(&mut ledger, &mut device)?,
    }
    let trials = ledger.close()?;
    outcome::finish(args, &folder, outcome::Parts { identity, legs, planned, trials, prepare_wall_s, began })
}
