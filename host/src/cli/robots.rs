//! Which robot a command is about: the named one, the run's, else the Ant.
//!
//! Holds that order, and for gaits one step more: the Ant with the legs that the
//! gait was made for. Does not depend on any subcommand.

use super::explain::{failure, failure_with_help, warn};
use super::{Cause, Failure};
use crate::gait::gait_file::Provenance;
use crate::robot::{LegScale, Robot, RobotError};
use std::path::Path;
use thiserror::Error;

/// What the flags say of a robot.
#[derive(Debug, Clone, Copy)]
pub enum RobotArg<'a> {
    /// Nothing.
    Default,
    /// `--robot`.
    Folder(&'a Path),
    /// `--leg`.
    Leg(LegScale),
}

impl<'a> RobotArg<'a> {
    /// Of a command with `--robot` alone.
    pub fn folder(folder: Option<&'a Path>) -> Self {
        folder.map_or(Self::Default, Self::Folder)
    }
}

/// Prints what of a robot is probably not meant as it is written.
pub fn warn_of(robot: &Robot) {
    for warning in robot.warnings() {
        warn(&format!("{}: {warning}", robot.name));
    }
}

/// The robot of a folder that was named, else of a run, else the Ant.
pub fn of(named: Option<&Path>, run: &Path) -> Result<Robot, RobotError> {
    match named {
        Some(folder) => Robot::load(folder),
        None => Robot::of_run(run)?.map_or_else(|| Robot::ant(LegScale::LONG), Ok),
    }
}

/// The robot of the run that a file lies in, else the Ant.
pub fn beside(named: Option<&Path>, file: &Path) -> Result<Robot, Failure> {
    of(named, folder_of(file)).map_err(|e| failure(Cause::Input, e))
}

#[derive(Debug, Error)]
#[error("{path} is a gait of {made_for}, but the robot is {robot}")]
struct OtherRobot {
    path: String,
    made_for: String,
    robot: String,
}

/// Refuses a gait of a robot with another name; a gait that names none is for any.
pub fn check_gait(provenance: &Provenance, robot: &Robot, file: &Path) -> Result<(), Failure> {
    match &provenance.robot {
        Some(made_for) if *made_for != robot.name => {
            let path = file.display().to_string();
            let error = OtherRobot { path, made_for: made_for.clone(), robot: robot.name.clone() };
            let help =
                format!("name the folder of {made_for}, or of the robot that shall walk it: --robot FOLDER");
            Err(failure_with_help(Cause::Input, error, help))
        }
        _ => Ok(()),
    }
}

/// The robot that the gait in `file` is for: the named one, its run's, else the
/// Ant with the gait's legs. Also says if the gait was made for another robot or other legs.
///
/// # Errors
/// The robot cannot be read; or it was not named, it is not the gait's, and `anyway` does not
/// allow that.
pub fn of_gait(
    named: RobotArg,
    file: &Path,
    provenance: Option<&Provenance>,
    anyway: bool,
) -> Result<(Robot, Option<String>), Failure> {
    let unusable = |e: RobotError| failure(Cause::Input, e);
    let gait_leg = provenance.and_then(|provenance| provenance.leg_scale);
    let robot = match named {
        RobotArg::Folder(folder) => Robot::load(folder).map_err(unusable)?,
        RobotArg::Leg(leg) => Robot::ant(leg).map_err(unusable)?,
        RobotArg::Default => match (Robot::of_run(folder_of(file)).map_err(unusable)?, gait_leg) {
            (Some(robot), _) => robot,
            (None, leg) => Robot::ant(leg.unwrap_or(LegScale::LONG)).map_err(unusable)?,
        },
    };
    if let (Some(provenance), RobotArg::Default, false) = (provenance, named, anyway) {
        check_gait(provenance, &robot, file)?;
    }
    let other_robot = provenance.and_then(|provenance| other_robot(provenance, &robot));
    Ok((robot, other_robot))
}

/// In what the robot is not the gait's.
fn other_robot(provenance: &Provenance, robot: &Robot) -> Option<String> {
    if let Some(made_for) = provenance.robot.as_ref().filter(|made_for| **made_for != robot.name) {
        return Some(format!(
            "the gait was made for {made_for}, not for {}: it walks differently",
            robot.name
        ));
    }
    let leg = robot.geometry.leg_scale;
    if let Some(gait_leg) = provenance.leg_scale.filter(|gait_leg| *gait_leg != leg) {
        return Some(format!(
            "the gait was made for legs of {gait_leg}, {} has {leg}: it walks differently",
            robot.name
        ));
    }
    let hash = provenance.robot_sha256.as_ref().filter(|hash| **hash != robot.sha256())?;
    let known: String = hash.chars().take(8).collect();
    Some(format!(
        "the gait was made for another description of {} (SHA-256 {known}...): it may walk differently",
        robot.name
    ))
}

fn folder_of(file: &Path) -> &Path {
    file.parent().unwrap_or(Path::new(""))
}
