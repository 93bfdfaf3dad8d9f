//! Which robot a command is about: the named one, the run's, else the Ant.
//!
//! Owns that order, and for gaits one step more: the Ant with the legs that the
//! gait was made for.

use super::explain::{failure, failure_with_help};
use super::{Cause, Failure};
use crate::robot::{Robot, RobotError};
use std::path::Path;

/// How far apart the legs of a gait and of a robot may be.
const LEG_TOLERANCE: f64 = 1e-6;

/// What the flags say of a robot.
#[derive(Debug, Clone, Copy)]
pub enum Named<'a> {
    /// Nothing.
    Nobody,
    /// `--robot`.
    Folder(&'a Path),
    /// `--leg`.
    Leg(f64),
}

impl<'a> Named<'a> {
    /// Of a command with `--robot` alone.
    pub fn folder(folder: Option<&'a Path>) -> Self {
        folder.map_or(Self::Nobody, Self::Folder)
    }
}

/// The robot of a folder that was named, else of a run, else the Ant.
pub fn of(named: Option<&Path>, run: &Path) -> Result<Robot, RobotError> {
    match named {
        Some(folder) => Robot::load(folder),
        None => Robot::of_run(run)?.map_or_else(|| Robot::ant(1.0), Ok),
    }
}

/// The robot of the run that a file lies in, else the Ant.
pub fn beside(named: Option<&Path>, file: &Path) -> Result<Robot, Failure> {
    of(named, folder_of(file)).map_err(|e| failure(Cause::Input, e))
}

/// The robot that the gait in `file` is for: the named one, its run's, else the
/// Ant with the gait's legs. Also says if the robot has other legs than the gait.
pub fn of_gait(named: Named, file: &Path, gait_leg: Option<f64>) -> Result<(Robot, Option<String>), Failure> {
    let unusable = |e: RobotError| failure(Cause::Input, e);
    let robot = match named {
        Named::Folder(folder) => Robot::load(folder).map_err(unusable)?,
        Named::Leg(leg) => Robot::ant(leg).map_err(unusable)?,
        Named::Nobody => match (Robot::of_run(folder_of(file)).map_err(unusable)?, gait_leg) {
            (Some(robot), _) => robot,
            (None, Some(leg)) => Robot::ant(leg).map_err(|e| {
                let help = "that is the leg_scale of the gait's file: name a robot with --robot FOLDER";
                failure_with_help(Cause::Input, e, help)
            })?,
            (None, None) => Robot::ant(1.0).map_err(unusable)?,
        },
    };
    let leg = robot.geometry.leg_scale;
    let warning = gait_leg.filter(|gait_leg| (gait_leg - leg).abs() > LEG_TOLERANCE).map(|gait_leg| {
        format!("the gait was made for legs of {gait_leg} L, {} has {leg} L: it walks otherwise", robot.name)
    });
    Ok((robot, warning))
}

fn folder_of(file: &Path) -> &Path {
    file.parent().unwrap_or(Path::new(""))
}
