//! Whether the connected robot is the one that a command is about.
//!
//! Holds the refusal and its words. Does not depend on the tolerances, which are in
//! [`crate::calibration::differences`].

use super::explain::failure_with_help;
use super::reach::{Port, unreachable_robot};
use super::{Cause, Failure};
use crate::calibration::differences;
use crate::device::link::ports::SerialLink;
use crate::robot::Robot;
use protocol::Calibration;
use protocol::command::Record;
use thiserror::Error;

#[derive(Debug, Error)]
#[error("the robot on {port} is not calibrated as {robot} is described:{differences}")]
struct OtherRobot {
    port: String,
    robot: String,
    differences: String,
}

/// Compares the robot's calibration with its description; returns in what they differ, on
/// one line, if the user goes on anyway.
pub fn check(
    link: &mut SerialLink,
    robot: &Robot,
    anyway: bool,
    port: &Port,
) -> Result<Option<String>, Failure> {
    let bytes = link.read(Record::Calibration).map_err(unreachable_robot)?;
    // The record is always sound: of a damaged one, the firmware uses and sends its default.
    let Ok(in_use) = Calibration::from_bytes(&bytes) else { return Ok(None) };
    let source = link.status().map_err(unreachable_robot)?.calibration;
    let all = differences(&in_use, source, robot);
    if all.is_empty() {
        return Ok(None);
    }
    if anyway {
        let all: Vec<_> = all.iter().map(ToString::to_string).collect();
        return Ok(Some(format!(
            "calibrated otherwise than {} is described: {}",
            robot.name,
            all.join("; ")
        )));
    }
    let error = OtherRobot {
        port: link.name().to_owned(),
        robot: robot.name.clone(),
        differences: all.iter().map(|difference| format!("\n  {difference}")).collect(),
    };
    let help = format!(
        "if it is {}: host calibrate --from-robot FOLDER{} writes the description's values, and host calibrate \
         --robot FOLDER measures them; if it is another robot, name it with --robot FOLDER; --anyway goes on",
        robot.name,
        port.as_flag()
    );
    Err(failure_with_help(Cause::Robot, error, help))
}
