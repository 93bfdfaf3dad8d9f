//! Which robot a command is about: the named one, the run's, else the Ant.

use super::explain::failure;
use super::{Cause, Failure};
use crate::robot::{Robot, RobotError};
use std::path::Path;

/// The robot of a folder that was named, else of a run, else the Ant.
pub fn of(named: Option<&Path>, run: &Path) -> Result<Robot, RobotError> {
    match named {
        Some(folder) => Robot::load(folder),
        None => Robot::of_run(run)?.map_or_else(|| Robot::ant(1.0), Ok),
    }
}

/// The robot of the run that a file lies in, else the Ant.
pub fn beside(named: Option<&Path>, file: &Path) -> Result<Robot, Failure> {
    of(named, file.parent().unwrap_or(Path::new(""))).map_err(|e| failure(Cause::Input, e))
}
