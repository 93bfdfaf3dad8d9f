//! What a study is made of, from its flags: plan, robots, gaits, the authors' tables.

use super::{Args, ExperimentError, On, prepare};
use crate::cli::measure::DURATION_RANGE_S;
use crate::experiment::ledger::LedgerError;
use crate::experiment::materials::{self, Materials, MaterialsError};
use crate::experiment::method::Method;
use crate::experiment::paper;
use crate::experiment::plan::Plan;
use crate::experiment::twin_trials::Authors;
use crate::gait::gait_file::GaitFile;
use crate::robot::Robot;
use crate::run_folder::FileError;
use protocol::Amplitude;
use sha2::{Digest as _, Sha256};
use std::path::Path;

/// Trials of a condition in the twin, and where each takes 12 s of somebody's life.
const TRIALS_IN_TWIN: u32 = 10;
const TRIALS_ON_ROBOT: u32 = 3;
/// A study's gaits, in its folder: those that came with the program, and those made anew.
const GAITS: &str = "gaits";
const RETRAINED: &str = "retrained";

/// Refuses now what would be refused after the first trial.
pub fn plan(args: &Args) -> Result<Plan, ExperimentError> {
    let in_twin = args.port.is_none() && args.on == On::Twin;
    let trials = args.trials.unwrap_or(if in_twin { TRIALS_IN_TWIN } else { TRIALS_ON_ROBOT });
    let mut plan =
        Plan { robots_differ: args.robots_differ, mass_kg: args.mass_kg, ..Plan::paper(trials, args.seed) };
    let (least_s, most_s) = DURATION_RANGE_S;
    let (least, most) = (Amplitude::MIN.value(), Amplitude::MAX.value());
    let mut ranges =
        vec![("duration", args.duration_s, least_s, most_s), ("effort", args.effort, 0.02, 10.0)];
    ranges.extend(args.amplifications.iter().map(|&a| ("amp", a, least, most)));
    ranges.extend(args.mass_kg.map(|mass_kg| ("mass-kg", mass_kg, 0.01, 1e3)));
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
    if args.on == On::VirtualRobot {
        let given =
            [("robots-differ", args.robots_differ), ("reference-tables", args.reference_tables.is_some())];
        if let Some((flag, _)) = given.into_iter().find(|(_, given)| *given) {
            return Err(ExperimentError::InTwinOnly { flag });
        }
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

pub fn robots(args: &Args) -> Result<Vec<Robot>, ExperimentError> {
    if let Some(folder) = &args.robot {
        return Ok(vec![Robot::load(folder)?]);
    }
    let legs: &[f64] = if args.legs.is_empty() { &paper::LEGS } else { &args.legs };
    Ok(legs.iter().map(|&leg| Robot::ant(leg)).collect::<Result<_, _>>()?)
}

/// The authors' tables, for the paper's long legs, and their SHA-256.
pub fn reference(path: &Path) -> Result<(Authors, String), ExperimentError> {
    let robot = Robot::ant(paper::LEGS[0])?;
    let sample_s = robot.twin.as_ref().map_or(0.1, |twin| twin.sample_s);
    let authors = Authors::read(path, &robot, sample_s)?;
    let bytes = std::fs::read(path).map_err(FileError::on("read", path))?;
    Ok((authors, sha256(&bytes)))
}

/// As text.
pub fn sha256(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}

/// The gaits of every pair of legs, in the study's folder.
pub fn gaits(
    args: &Args,
    plan: &Plan,
    robots: &[Robot],
    folder: &Path,
) -> Result<Vec<Materials>, ExperimentError> {
    let mut legs = Vec::new();
    for (k, robot) in robots.iter().enumerate() {
        let gaits =
            folder.join(if args.retrain { RETRAINED } else { GAITS }).join(materials::folder_name(robot));
        std::fs::create_dir_all(&gaits).map_err(FileError::on("create", &gaits))?;
        if args.retrain {
            prepare::make(args, plan, robot, folder, &gaits)?;
        } else if plan.methods.iter().any(|&method| method != Method::Yours) {
            materials::unpack(robot, &gaits)?;
        }
        if let Some(path) = args.gait.as_ref().filter(|_| k == 0) {
            let gait = GaitFile::load(path).map_err(MaterialsError::from)?;
            let own = gaits.join(format!("{}.toml", Method::Yours.name()));
            let begun =
                own.exists().then(|| GaitFile::load(&own)).transpose().map_err(MaterialsError::from)?;
            match begun {
                None => gait.save(&own).map_err(MaterialsError::from)?,
                Some(begun) if begun.joints == gait.joints && begun.period_s == gait.period_s => {}
                Some(_) => return Err(LedgerError::Other { path: own, what: "gait" }.into()),
            }
        }
        let read = materials::read(&gaits, robot, &plan.methods)?;
        let own = read.gaits.iter().find(|material| material.note.method == Method::Yours);
        if let Some(remark) = own.and_then(|material| material.note.remark.as_ref()) {
            eprintln!("warning: the gait of --gait is {remark}");
        }
        legs.push(read);
    }
    Ok(legs)
}
