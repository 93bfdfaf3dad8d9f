//! Which robot a command is about: the named one, the run's, else the Ant.
//!
//! Holds that order, and for gaits one step more: the Ant with the legs that the
//! gait was made for. Does not depend on any subcommand.

use super::explain::{failure, warn};
use super::{Cause, Failure};
use crate::robot::{LegScale, Robot, RobotError};
use std::path::Path;

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

/// The robot that the gait in `file` is for: the named one, its run's, else the
/// Ant with the gait's legs. Also says if the robot has other legs than the gait.
pub fn of_gait(
    named: RobotArg,
    file: &Path,
    gait_leg: Option<LegScale>,
) -> Result<(Robot, Option<String>), Failure> {
    let unusable = |e: RobotError| failure(Cause::Input, e);
    let robot = match named {
        RobotArg::Folder(folder) => Robot::load(folder).map_err(unusable)?,
        RobotArg::Leg(leg) => Robot::ant(leg).map_err(unusable)?,
        RobotArg::Default => match (Robot::of_run(folder_of(file)).map_err(unusable)?, gait_leg) {
            (Some(robot), _) => robot,
            (None, leg) => Robot::ant(leg.unwrap_or(LegScale::LONG)).map_err(unusable)?,
        },
    };
    let leg = robot.geometry.leg_scale;
    let warning = gait_leg.filter(|gait_leg| *gait_leg != leg).map(|gait_leg| {
        format!("the gait was made for legs of {gait_leg}, {} has {leg}: it walks differently", robot.name)
    });
    Ok((robot, warning))
}

fn folder_of(file: &Path) -> &Path {
    file.parent().unwrap_or(Path::new(""))
}
