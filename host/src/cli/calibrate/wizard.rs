//! All questions in their order, and the file of answers.
//!
//! The file is written after each joint. At the end the robot gets the whole
//! calibration, or keeps the one it had. Does not depend on the questions about
//! a joint ([`joint`]) or the board ([`board`]).

use super::dialog::{Dialog, UserExit};
use super::joint::{self, Bench, Stopped};
use super::{Args, bad, board, not_sent, robot, unusable};
use crate::calibration::{JointSetup, RobotCalibration};
use crate::cli::explain::{failure, failure_with_help};
use crate::cli::reach::unreachable_robot;
use crate::cli::{Cause, Failure};
use crate::device::calibration::{self as transfer, TransferError};
use crate::device::link::words;
use crate::pwm::count_us;
use protocol::calibration::BoardCalibration;
use protocol::{Calibration, Joint, State};
use std::fmt;
use std::path::{Path, PathBuf};
use thiserror::Error;

#[derive(Debug, Error)]
enum WizardError {
    #[error("the robot is {}; it can be calibrated only while its servos are limp", words::state_in_full(*.state))]
    NotLimp { state: State },
    #[error("cancelled; {saved}")]
    Cancelled { saved: SavedCalibration },
    #[error("standard input ended in the middle of a question; {saved}")]
    InputEnded { saved: SavedCalibration },
}

/// Where the answers so far are saved.
#[derive(Debug)]
struct SavedCalibration {
    /// `None` before the first is written.
    file: Option<PathBuf>,
}

impl fmt::Display for SavedCalibration {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.file {
            Some(file) => write!(f, "what was measured is in {}", file.display()),
            None => f.write_str("nothing was measured yet"),
        }
    }
}

const INTRO: &str = "\
Calibrates the robot joint by joint. Hold it up or lay it on a block, so that
every leg moves freely, and switch the servos' supply on. One servo at a time gets
pulses, all others stay limp. Only the last question changes anything on the robot.";

pub fn run(args: &Args) -> Result<(), Failure> {
    let robot = robot(args.robot.as_deref())?;
    let mut link = args.port.connect()?;
    let state = link.status().map_err(unreachable_robot)?.state;
    if state != State::Idle {
        let help = match state {
            State::Fault(fault) => format!("{}, {}", words::fault_help(fault), words::CLEAR_FAULT),
            _ => "stop it, and wait two seconds: host stop".to_owned(),
        };
        return Err(failure_with_help(Cause::Robot, WizardError::NotLimp { state }, help));
    }
    // The wizard also replaces a damaged calibration.
    let in_use = match transfer::fetch(&mut link) {
        Ok(record) => record,
        Err(TransferError::Damaged { .. }) => Calibration::authors(),
        Err(error) => return Err(not_sent(error)),
    };
    let mut dialog = Dialog::open();
    dialog.say(INTRO);
    let mut calibration = if args.out.is_file() {
        dialog.say(&format!("Resuming: the answers so far are in {}", args.out.display()));
        RobotCalibration::load(&args.out).map_err(unusable)?
    } else {
        let mut start = RobotCalibration::from_record(&in_use);
        if args.robot.is_some() {
            let described = RobotCalibration::of_robot(&robot).joints;
            start.joints = described.map(|joint| JointSetup { is_measured: false, ..joint });
        }
        start
    };
    let cancelled = |exit| ended(exit, args);
    let save = |calibration: &RobotCalibration| calibration.save(&args.out).map_err(unusable);

    if args.joints.is_empty() {
        board::ask(&mut dialog, &mut link, &mut calibration.board, in_use.board())
            .map_err(|why| stopped(why, args))?;
        save(&calibration)?;
    }
    for joint in Joint::ALL {
        let setup = calibration.joints[joint.index()].clone();
        if !args.joints.is_empty() && !args.joints.contains(&joint) {
            continue;
        }
        if args.joints.is_empty() && setup.is_measured {
            dialog.say(&format!(
                "{} was measured before. To measure it again: host calibrate --joint {}",
                joint.name(),
                joint.name()
            ));
            continue;
        }
        // The PWM rate that the robot uses now, with the oscillator as measured.
        let board = BoardCalibration {
            oscillator_khz: (calibration.board.oscillator_mhz * 1e3).round() as u16,
            ..in_use.board()
        };
        let mut bench = Bench {
            link: &mut link,
            dialog: &mut dialog,
            count_us: count_us(&board),
            angle_deg: args.angle,
            robot: &robot,
            pictures: args.out.parent().unwrap_or(Path::new("")).to_owned(),
        };
        match joint::measure(&mut bench, joint, &setup) {
            Ok(Some(found)) => {
                calibration.joints[joint.index()] = found;
                save(&calibration)?;
            }
            Ok(None) => {}
            Err(why) => return Err(stopped(why, args)),
        }
    }

    let record = calibration.record().map_err(bad)?;
    let unmeasured: Vec<_> = Joint::ALL
        .into_iter()
        .filter(|joint| !calibration.joints[joint.index()].is_measured)
        .map(Joint::name)
        .collect();
    if !unmeasured.is_empty() {
        dialog.say(&format!("\nNot measured, and unchanged: {}", unmeasured.join(", ")));
    }
    let asks = dialog.agrees("\nSend the calibration to the robot, and let it save it?", true);
    if asks.map_err(cancelled)? {
        transfer::send(&mut link, &record).map_err(not_sent)?;
        println!("the robot has saved the calibration; it is also in {}", args.out.display());
    } else {
        let port = args.port.as_flag();
        println!("the robot keeps the calibration it had; the new one is in {}", args.out.display());
        println!("Send it later: cargo run -p host -- calibrate --write {}{port}", args.out.display());
    }
    Ok(())
}

fn stopped(why: Stopped, args: &Args) -> Failure {
    match why {
        Stopped::UserExit(exit) => ended(exit, args),
        Stopped::Link(error) => unreachable_robot(error),
    }
}

fn ended(exit: UserExit, args: &Args) -> Failure {
    let saved = SavedCalibration { file: args.out.is_file().then(|| args.out.clone()) };
    match exit {
        UserExit::Quit => failure_with_help(
            Cause::Interrupted,
            WizardError::Cancelled { saved },
            "run the same command to resume",
        ),
        UserExit::InputEnded => failure(Cause::Usage, WizardError::InputEnded { saved }),
    }
}
