//! The command line of `host experiment` as one checked value.
//!
//! Holds the ranges, the defaults and the combinations of flags that are
//! refused. [`Request::of`] is the only reader of [`Args`]: it takes every flag
//! once, so that whatever comes after depends on the request alone.

use super::device::Reach;
use super::{Args, ExperimentError, On};
use crate::cli::ranges::DURATION_RANGE_S;
use crate::cli::steps::Steps;
use crate::experiment::ledger::sha256;
use crate::experiment::method::{Method, Origin};
use crate::experiment::plan::Plan;
use crate::experiment::study::Venue;
use crate::experiment::twin_trials::Authors;
use crate::paper;
use crate::robot::Robot;
use crate::run_folder::FileError;
use protocol::Amplitude;
use std::path::{Path, PathBuf};

/// Trials of a condition in the simulation, and on a robot, where each takes 12 s.
const TRIALS_IN_TWIN: u32 = 10;
const TRIALS_ON_ROBOT: u32 = 3;
/// Shares of the full effort of `--retrain`.
const EFFORT_RANGE: (f64, f64) = (0.02, 10.0);
const MASS_RANGE_KG: (f64, f64) = (0.01, 1e3);

/// How `--retrain` makes gaits.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Retraining {
    /// Of training and searches.
    pub seed: u64,
    /// Share of the full effort, the same for every method.
    pub effort: f64,
}

/// The authors' tables, and the SHA-256 of their file.
#[derive(Debug)]
pub struct Reference {
    pub authors: Authors,
    pub sha256: String,
}

/// What a call asks for.
#[derive(Debug)]
pub struct Request {
    pub plan: Plan,
    /// One for each pair of legs.
    pub robots: Vec<Robot>,
    /// `None` in the simulation.
    pub reach: Option<Reach>,
    /// `None` for the gaits that come with the program.
    pub retraining: Option<Retraining>,
    /// A gait of the user's own, for the first of the robots.
    pub own_gait: Option<PathBuf>,
    pub reference: Option<Reference>,
    /// `None` for a new folder in `runs`.
    pub out: Option<PathBuf>,
    pub json: bool,
}

impl Request {
    /// Checks everything that can be checked before a folder is made or a trial is walked.
    ///
    /// # Errors
    /// [`ExperimentError`] naming the flag, its value and what is allowed.
    pub fn of(args: Args) -> Result<Self, ExperimentError> {
        let Args {
            out,
            legs,
            robot,
            methods,
            gait,
            amplifications,
            trials,
            duration_s,
            seed,
            on,
            port,
            tracker,
            mass_kg,
            robots_differ,
            reference_tables,
            retrain,
            effort,
            virtual_robot,
            json,
        } = args;
        let amplitudes = (Amplitude::MIN.value(), Amplitude::MAX.value());
        within("duration", DURATION_RANGE_S, [duration_s])?;
        within("effort", EFFORT_RANGE, [effort])?;
        within("amp", amplitudes, amplifications.iter().copied())?;
        within("mass-kg", MASS_RANGE_KG, mass_kg)?;
        distinct("amp", &amplifications)?;
        distinct("leg", &legs)?;
        distinct("method", &methods.iter().map(|method| method.name()).collect::<Vec<_>>())?;

        let in_twin = port.is_none() && on == On::Twin;
        let trials = trials.unwrap_or(if in_twin { TRIALS_IN_TWIN } else { TRIALS_ON_ROBOT });
        let mut plan = Plan { duration_s, robots_differ, mass_kg, ..Plan::paper(trials, seed) };
        if !amplifications.is_empty() {
            plan.amplifications = amplifications;
        }
        if !methods.is_empty() {
            plan.methods = methods;
        }
        if gait.is_some() && !plan.methods.contains(&Method::Yours) {
            plan.methods.push(Method::Yours);
        }
        if on == On::VirtualRobot {
            let given = [("robots-differ", robots_differ), ("reference-tables", reference_tables.is_some())];
            if let Some((flag, _)) = given.into_iter().find(|(_, given)| *given) {
                return Err(ExperimentError::InTwinOnly { flag });
            }
        }
        for method in &plan.methods {
            let flag = match method.spec().origin {
                Origin::AuthorsTables(_) => "reference-tables",
                Origin::CommandLine if gait.is_none() => "gait",
                Origin::CommandLine | Origin::Stride | Origin::GaitFile => continue,
            };
            return Err(ExperimentError::NotAMethod { method: method.name(), flag });
        }

        let robots = match robot {
            Some(folder) => vec![Robot::load(&folder)?],
            None => {
                let legs = if legs.is_empty() { paper::LEGS.to_vec() } else { legs };
                legs.into_iter().map(Robot::ant).collect::<Result<_, _>>()?
            }
        };
        let reference = reference_tables.as_deref().map(reference).transpose()?;
        let reach = match (port, on) {
            (Some(port), _) => Some(Reach::Port { port, tracker }),
            (None, On::VirtualRobot) => {
                let beside = Steps::new()?.beside("virtual-robot");
                Some(Reach::Virtual { program: virtual_robot.unwrap_or(beside) })
            }
            (None, On::Twin) => None,
        };
        if let Some(reach) = &reach {
            let walks = plan.methods.len() * plan.amplifications.len() * robots.len() * plan.trials as usize;
            reach.check(walks)?;
        }
        Ok(Self {
            plan,
            robots,
            reach,
            retraining: retrain.then_some(Retraining { seed, effort }),
            own_gait: gait,
            reference,
            out,
            json,
        })
    }

    /// Where trials are walked.
    pub fn venue(&self) -> Venue {
        match &self.reach {
            None => Venue::Twin,
            Some(Reach::Virtual { .. }) => Venue::VirtualRobot,
            Some(Reach::Port { .. }) => Venue::Robot,
        }
    }
}

fn within(
    flag: &'static str,
    (min, max): (f64, f64),
    values: impl IntoIterator<Item = f64>,
) -> Result<(), ExperimentError> {
    let outside = values.into_iter().find(|value| !(min..=max).contains(value));
    outside.map_or(Ok(()), |value| Err(ExperimentError::Flag { flag, value, min, max }))
}

fn distinct<T: PartialEq + ToString>(flag: &'static str, values: &[T]) -> Result<(), ExperimentError> {
    let again = values.iter().enumerate().find(|(k, value)| values[..*k].contains(value));
    again.map_or(Ok(()), |(_, value)| Err(ExperimentError::Twice { flag, value: value.to_string() }))
}

/// For the paper's long legs.
fn reference(path: &Path) -> Result<Reference, ExperimentError> {
    let robot = Robot::ant(paper::LEGS[0])?;
    let sample_s = robot.twin.as_ref().map_or(0.1, |twin| twin.sample_s);
    let authors = Authors::read(path, &robot, sample_s)?;
    let bytes = std::fs::read(path).map_err(FileError::on("read", path))?;
    Ok(Reference { authors, sha256: sha256(&bytes) })
}
