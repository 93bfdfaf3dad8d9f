//! `host calibrate`: measures how a robot is built, servo by servo.
//!
//! Holds the flags, and the two ways without questions: a file to the robot, and the
//! robot's calibration to a file. Does not depend on the questions, which are in
//! [`wizard`].

mod board;
mod dialog;
mod joint;
mod pose;
mod servo;
mod wizard;

use super::explain::{failure, failure_with_help, file_cause};
use super::reach::{Port, unreachable_robot};
use super::{Cause, Failure};
use crate::calibration::{BadCalibration, CalibrationFileError, RobotCalibration};
use crate::device::calibration::{self as transfer, TransferError};
use crate::robot::{LegScale, Robot};
use protocol::Joint;
use protocol::command::CalibrationSource;
use std::path::{Path, PathBuf};

/// Calibrate the servos: outputs, neutrals, directions, limits.
///
/// Moves one servo at a time, by the arrow keys, with the robot held up: which
/// output it is on, where the joint's neutral is, which way it turns, how far
/// it may go. Each joint is saved in the file as soon as it is done; the same
/// command resumes where it was cancelled. Nothing on the robot changes before the
/// last question.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// File for the answers
    #[arg(long, value_name = "FILE", default_value = "calibration.toml")]
    out: PathBuf,
    /// Only this joint, though it was measured before; may be repeated
    #[arg(long = "joint", value_name = "NAME", value_parser = joint)]
    joints: Vec<Joint>,
    /// Angle at which a scale is measured, in degrees from neutral
    #[arg(long, value_name = "DEG", default_value_t = 45.0, value_parser = angle)]
    angle: f64,
    /// Folder of the robot: its drawing gives the poses that are asked for, its description the
    /// pulses to start with [default: the Ant, and the robot's own pulses]
    #[arg(long, value_name = "FOLDER")]
    robot: Option<PathBuf>,
    /// Send what this robot's description says of its servos, without questions
    #[arg(long, value_name = "FOLDER", conflicts_with_all = ["joints", "read", "write", "robot"])]
    from_robot: Option<PathBuf>,
    /// Send this file to the robot, without questions
    #[arg(long, value_name = "FILE", conflicts_with_all = ["joints", "read"])]
    write: Option<PathBuf>,
    /// Save the robot's calibration in this file, without questions
    #[arg(long, value_name = "FILE", conflicts_with = "joints")]
    read: Option<PathBuf>,
    #[command(flatten)]
    port: Port,
}

fn joint(name: &str) -> Result<Joint, String> {
    Joint::from_name(name).ok_or_else(|| "joints are hip1 to hip4 and knee1 to knee4".to_owned())
}

fn angle(text: &str) -> Result<f64, String> {
    let within = |angle: &f64| (5.0..=120.0).contains(angle);
    text.parse().ok().filter(within).ok_or_else(|| "it must be within 5 to 120 degrees".to_owned())
}

pub fn run(args: Args) -> Result<(), Failure> {
    if let Some(path) = &args.write {
        // A file that cannot be used is refused before a port is opened.
        let (calibration, record) = RobotCalibration::load_checked(path).map_err(unusable)?;
        if let Some(warning) = calibration.board.in_step() {
            eprintln!("warning: {warning}");
        }
        let mut link = args.port.connect()?;
        transfer::send(&mut link, &record).map_err(not_sent)?;
        println!("the robot on {} has saved the calibration in {}", link.name(), path.display());
        return Ok(());
    }
    if let Some(path) = &args.read {
        let mut link = args.port.connect()?;
        let record = transfer::fetch(&mut link).map_err(not_sent)?;
        RobotCalibration::from_record(&record).save(path).map_err(unusable)?;
        println!("the calibration of the robot on {} is in {}", link.name(), path.display());
        return Ok(());
    }
    if let Some(folder) = &args.from_robot {
        return describe(&args, folder);
    }
    wizard::run(&args)
}

/// The robot of a folder, else the Ant.
fn robot(folder: Option<&Path>) -> Result<Robot, Failure> {
    let robot = folder.map_or_else(|| Robot::ant(LegScale::LONG), Robot::load);
    robot.map_err(|error| failure(Cause::Input, error))
}

/// Sends what a description says; of a calibrated robot, the board keeps its own values.
fn describe(args: &Args, folder: &Path) -> Result<(), Failure> {
    let robot = robot(Some(folder))?;
    let mut calibration = RobotCalibration::of_robot(&robot);
    // What no robot takes is refused before a port is opened.
    calibration.record().map_err(bad_description)?;
    let mut link = args.port.connect()?;
    if link.status().map_err(unreachable_robot)?.calibration == CalibrationSource::Stored {
        let in_use = transfer::fetch(&mut link).map_err(not_sent)?;
        calibration.board = RobotCalibration::from_record(&in_use).board;
    }
    let record = calibration.record().map_err(bad_description)?;
    transfer::send(&mut link, &record).map_err(not_sent)?;
    println!(
        "the robot on {} has saved the calibration of {}: neutral {} us, {} us a degree",
        link.name(),
        robot.name,
        robot.servo.neutral_pulse_us,
        robot.servo.pulse_us_per_deg
    );
    Ok(())
}

fn bad_description(error: BadCalibration) -> Failure {
    failure_with_help(Cause::Input, error, "correct [servo] in robot.toml")
}

fn unusable(error: CalibrationFileError) -> Failure {
    let (cause, help) = match &error {
        CalibrationFileError::File(file) if file.action == "read" => (Cause::Input, READ_HELP),
        CalibrationFileError::File(file) => {
            (file_cause(file), "free some space, or name another file, in a folder that is there")
        }
        CalibrationFileError::Parse { .. } | CalibrationFileError::Joints { .. } => (Cause::Input, READ_HELP),
        CalibrationFileError::Version { .. } => (Cause::Input, "run the wizard again: host calibrate"),
        CalibrationFileError::Unusable { .. } => (Cause::Input, "correct the value in the file, and repeat"),
    };
    failure_with_help(cause, error, help)
}

const READ_HELP: &str =
    "write one from the robot's own: host calibrate --read FILE; or by the wizard: host calibrate";

fn bad(error: BadCalibration) -> Failure {
    let help = match &error {
        BadCalibration::Value { whose: "board", .. } => {
            "change it: run the wizard again and say y at the board's values".to_owned()
        }
        BadCalibration::Value { whose, .. } => format!("measure it again: host calibrate --joint {whose}"),
        BadCalibration::SharedChannel { joints, .. } => {
            format!("say which of them it is: host calibrate --joint {}", joints[1].name())
        }
    };
    failure_with_help(Cause::Input, error, help)
}

fn not_sent(error: TransferError) -> Failure {
    match error {
        TransferError::Link(error) => unreachable_robot(error),
        TransferError::NotSaved => failure_with_help(
            Cause::Robot,
            error,
            "it is in use until the next reset. Repeat the command; if it fails again, the EEPROM is worn out",
        ),
        TransferError::Differs { .. } => failure_with_help(Cause::Robot, error, "repeat the command"),
        TransferError::Damaged { .. } => failure(Cause::Robot, error),
    }
}
