//! `host experiment`: the paper's comparison, as one command.
//!
//! Holds the flags and the order: gaits, trials, figures, report. `request`
//! checks the flags, `gaits` and `prepare` provide the gaits, `walks` and
//! `device` walk the trials, `outcome` writes the results. Does not depend on how
//! a study is planned and evaluated, which is [`crate::experiment`]'s.

mod device;
mod gaits;
mod outcome;
mod person;
mod prepare;
mod request;
mod walks;

use super::explain::{failure, failure_with_help, file_cause};
use super::reach::interruptible;
use super::steps::{StepError, Steps};
use super::{Cause, Failure};
use crate::device::tracker::TrackerError;
use crate::experiment::ledger::{self, Identity, Ledger, LedgerError};
use crate::experiment::materials::MaterialsError;
use crate::experiment::method::Method;
use crate::paper;
use crate::robot::LegScale;
use crate::robot::RobotError;
use crate::run_folder::{self, FileError};
use crate::twin::TwinError;
use clap::ValueEnum;
use device::Device;
use person::Person;
use request::Request;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;
use thiserror::Error;

/// Where trials are walked.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum On {
    /// The simulation, without firmware: less than a minute for the whole study
    Twin,
    /// The real firmware in an emulator, in real time
    VirtualRobot,
}

/// The paper's whole comparison: methods, amplifications, legs; figures and a report.
///
/// Plays every method's gait at every amplification on both pairs of legs, and writes every
/// trial, the paper's Figures 3 to 8 and Table 2, and report.html. The gaits are those that
/// come with this program, unless --retrain makes them anew. The same command with the same
/// folder resumes a study that was interrupted.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Folder of the study [default: a new one in runs]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Length of the legs, one value for each pair: 1.0 is 23 cm [default: 1.0 and 0.6]
    #[arg(long = "leg", value_name = "SCALE", conflicts_with = "robot", value_delimiter = ',')]
    legs: Vec<LegScale>,
    /// Folder of a robot other than the Ant; needs --retrain, or only --gait
    #[arg(long, value_name = "FOLDER")]
    robot: Option<PathBuf>,
    #[arg(long = "method", value_name = "METHOD", value_enum, value_delimiter = ',', help = methods_help())]
    methods: Vec<Method>,
    /// File of a gait of your own to compare with them, on the first pair of legs
    #[arg(long, value_name = "FILE")]
    gait: Option<PathBuf>,
    /// Amplifications, comma-separated; 1.875 is the stroke that each gait was found at
    /// [default: 1.0 to 2.4 by 0.2]
    #[arg(long = "amp", value_name = "X,X", value_delimiter = ',')]
    amplifications: Vec<f64>,
    /// Trials of each condition [default: 10 in simulation, 3 on a robot]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1000))]
    trials: Option<u32>,
    /// Length of a trial, in seconds
    #[arg(long = "duration", value_name = "S", default_value_t = paper::TRIAL_S, allow_negative_numbers = true)]
    duration_s: f64,
    /// Random seed of the starts and, with --retrain, of training and searches
    #[arg(long, default_value_t = 0, value_parser = super::seed())]
    seed: u64,
    /// Where trials are walked
    #[arg(long, value_enum, default_value_t = On::Twin)]
    on: On,
    /// Walk the trials on a robot at this serial port, and ask for the distance of each
    #[arg(long, value_name = "PORT", conflicts_with = "on")]
    port: Option<String>,
    /// With --port: file of positions, as for `measure`; the distances are read from it
    #[arg(long, value_name = "FILE", requires = "port")]
    tracker: Option<PathBuf>,
    /// With --port: mass of the robot with these legs, in kg [default: from its description]
    #[arg(long, value_name = "KG", requires = "port")]
    mass_kg: Option<f64>,
    /// In simulation: every trial on another robot, sampled within the uncertainty of fit, floor
    /// and servos, as in `optimise`
    #[arg(long, conflicts_with = "port")]
    robots_differ: bool,
    /// The authors' tables, to play them in simulation as well
    #[arg(long, value_name = "CSV", conflicts_with = "port")]
    reference_tables: Option<PathBuf>,
    /// Train, fit and search every gait anew, in the study's folder; takes hours
    #[arg(long)]
    retrain: bool,
    /// With --retrain: share of the full effort, the same for every method
    #[arg(long, value_name = "SHARE", default_value_t = 1.0, requires = "retrain")]
    effort: f64,
    /// Program of the virtual robot [default: the one built beside this program]
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
    #[error("--{flag} is for the simulation: the virtual robot is one robot, and it plays gait tables")]
    InTwinOnly { flag: &'static str },
    #[error("the distances are unknown, and nobody can be asked for them: standard input is not a terminal")]
    NoDistances,
    #[error(
        "the times in {} count from the first gait frame, so it cannot tell {walks} trials apart",
        .path.display()
    )]
    RelativeTrack { path: PathBuf, walks: usize },
    #[error(transparent)]
    Tracker(#[from] TrackerError),
    #[error("no condition can be walked: {reason}")]
    Nothing { reason: String },
    /// Not a failure: the person at the robot ended the session.
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
    #[error("the results cannot be written as JSON")]
    Json(#[source] serde_json::Error),
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
                failure_with_help(Cause::Usage, self, "run it in a terminal, or add --tracker FILE")
            }
            Self::RelativeTrack { .. } => {
                let help =
                    "write Unix times in its column time_s, for all trials in one file. Nothing has moved";
                failure_with_help(Cause::Input, self, help)
            }
            Self::Tracker(error) => {
                let help = format!("{}. Nothing has moved", error.help());
                failure_with_help(Cause::Input, error, help)
            }
            Self::Nothing { .. } => failure(Cause::Input, self),
            Self::Quit { .. } | Self::Interrupted { .. } => failure_with_help(
                Cause::Interrupted,
                self,
                "run the same command with the same --out to resume",
            ),
            Self::Materials(MaterialsError::NoneKnown { .. }) => {
                let help = "make them with --retrain, or name a gait with --gait FILE --method yours";
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
            Self::Ledger(LedgerError::OldName { .. }) => {
                let help = "rename the file to resume the study, or name another folder with --out";
                failure_with_help(Cause::Input, self, help)
            }
            Self::Ledger(LedgerError::NoPlan { .. } | LedgerError::Trial { .. }) => failure_with_help(
                Cause::Input,
                self,
                "undo the change that was made by hand, or name another folder with --out",
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
            Self::Figure(_) | Self::Prepare(_) | Self::Json(_) => failure(Cause::Machine, self),
        }
    }
}

fn methods_help() -> String {
    let names: Vec<&str> = Method::bundled().map(Method::name).collect();
    format!("Methods, once for each [default: {}]", names.join(", "))
}

pub fn run(args: Args) -> Result<(), Failure> {
    let stop = interruptible()?;
    match experiment(args, &stop) {
        Err(ended @ ExperimentError::Quit { .. }) => {
            eprintln!("Stopped: {ended}; run the same command with the same --out to resume.");
            Ok(())
        }
        outcome => outcome.map_err(ExperimentError::into_failure),
    }
}

fn experiment(args: Args, stop: &AtomicBool) -> Result<(), ExperimentError> {
    let request = Request::of(args)?;
    let (plan, venue) = (&request.plan, request.venue());
    let folder = match &request.out {
        Some(folder) => folder.clone(),
        None => run_folder::create("experiment")?,
    };
    std::fs::create_dir_all(&folder).map_err(FileError::on("create", &folder))?;

    // Before hours of training, and before a gait is copied into the folder of another study.
    let robot_sha256s: Vec<String> =
        request.robots.iter().map(|robot| ledger::sha256(format!("{robot:?}").as_bytes())).collect();
    let reference_sha256 = request.reference.as_ref().map(|reference| reference.sha256.clone());
    ledger::refuse_another(&folder, plan, venue, &robot_sha256s, reference_sha256.as_ref())?;
    let legs = gaits::gaits(&request, &folder)?;
    if stop.load(Ordering::Relaxed) {
        return Err(ExperimentError::Interrupted { folder });
    }
    let prepare_wall_s = if request.retraining.is_some() { prepare::wall_s(&legs) } else { 0.0 };

    let began = Instant::now();
    let authors = request.reference.as_ref().map(|reference| &reference.authors);
    let mut planned = plan.conditions(&legs);
    planned.extend(authors.iter().flat_map(|authors| authors.conditions(plan)));
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
    let walked = walks::Walks { plan, legs: &legs, authors, planned: &planned, stop };
    match &request.reach {
        None => walked.in_twin(&mut ledger, &folder)?,
        Some(reach) => {
            let person = Person::at_standard_input(stop);
            let mut device = Device { reach, steps: Steps::new()?, folder: &folder, plan, person };
            walked.on_device(&mut ledger, &mut device)?;
        }
    }
    let trials = ledger.close()?;
    let parts = outcome::Parts { identity, legs, planned, trials, prepare_wall_s, began };
    outcome::finish(&request, &folder, parts)
}
