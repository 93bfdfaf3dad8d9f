//! The virtual robot's program, for as long as a trial takes.
//!
//! Does not depend on what walks on it.

use super::steps::StepError;
use crate::run_folder;
use std::io::{BufRead as _, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};

/// The virtual robot's process: ended when dropped.
pub struct VirtualRobot {
    child: Child,
    pub port: String,
}

impl VirtualRobot {
    /// Starts it with the robot of a folder, which also gets the truth of its walk.
    pub fn start(program: &Path, run: &Path, seed: u64) -> Result<Self, StepError> {
        if !program.is_file() {
            return Err(StepError::NoVirtualRobot { program: program.to_owned() });
        }
        let mut child = Command::new(program)
            .args(["--seed", &seed.to_string(), "--robot"])
            .arg(run.join(run_folder::ROBOT))
            .arg("--truth")
            .arg(run.join(run_folder::TRUTH))
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .spawn()
            .map_err(|source| StepError::Start { program: program.to_owned(), source })?;
        let mut port = String::new();
        let offered = child
            .stdout
            .as_mut()
            .is_some_and(|out| BufReader::new(out).read_line(&mut port).is_ok_and(|bytes| bytes > 0));
        // From here on, dropping ends the process.
        let robot = Self { child, port: port.trim().to_owned() };
        if offered { Ok(robot) } else { Err(StepError::NoPort) }
    }
}

impl Drop for VirtualRobot {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
