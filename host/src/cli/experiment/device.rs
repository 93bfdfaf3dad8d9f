//! Trials through the firmware: on the virtual robot, or on a real one.
//!
//! Owns what a person at the robot is asked, and what of a step's JSON a trial
//! is judged by. Each trial is `upload-gait` and `measure`, as they would be
//! typed. A trial that the robot broke off is noted as such; a lost cable or a
//! full disk ends the command, which goes on there when it is called again.

use super::ExperimentError;
use crate::cli::Cause;
use crate::cli::steps::{StepError, Steps};
use crate::cli::virtual_robot::VirtualRobot;
use crate::experiment::materials::Materials;
use crate::experiment::trial::{Place, Raw, Trial};
use crate::robot::Robot;
use crate::run_folder::{self, FileError};
use serde_json::Value;
use std::io::{BufRead as _, IsTerminal as _};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

/// A robot that leans farther lies down.
const FALLEN_TILT_RAD: f64 = 1.0;

/// Where the robot is.
#[derive(Debug, Clone)]
pub enum Reach {
    /// A process of its own for each trial.
    Virtual {
        /// The program.
        program: PathBuf,
    },
    /// On a serial port.
    Port {
        /// Which.
        port: String,
        /// Positions, where somebody watches.
        tracker: Option<PathBuf>,
    },
}

/// What the person at the robot said.
enum Answer {
    Walk,
    Skip,
    Quit,
}

/// Walks trials, one after the other.
pub struct Device<'a> {
    pub reach: Reach,
    pub steps: Steps,
    pub folder: &'a Path,
    pub seed: u64,
    pub duration_s: f64,
    /// Legs that the robot has on, as far as was said.
    pub legs_on: Option<f64>,
    /// Set by Ctrl-C.
    pub stop: &'a AtomicBool,
}

impl Device<'_> {
    /// Refuses now what could not be answered after the first trial.
    pub fn check(&self) -> Result<(), ExperimentError> {
        match &self.reach {
            Reach::Virtual { program } if !program.is_file() => {
                Err(StepError::NoVirtualRobot { program: program.clone() }.into())
            }
            Reach::Port { tracker: None, .. } if !std::io::stdin().is_terminal() => {
                Err(ExperimentError::NoDistances)
            }
            _ => Ok(()),
        }
    }

    /// Walks one trial; `None` if the person at the robot left it out.
    pub fn walk(
        &mut self,
        place: Place,
        number: u32,
        materials: &Materials,
        left: usize,
    ) -> Result<Option<Trial>, ExperimentError> {
        let found = materials.gaits.iter().find(|material| material.note.method == place.method);
        let Some(material) = found else { return Ok(None) };
        let folder =
            self.folder.join("walks").join(crate::experiment::materials::folder_name(&materials.robot));
        std::fs::create_dir_all(&folder).map_err(FileError::on("create", &folder))?;
        materials.robot.save(&folder.join(run_folder::ROBOT))?;
        let gait = folder.join(format!("{}.bin", place.method.name()));
        run_folder::write(&gait, material.playable.encoded().bytes())?;

        let raw = match self.reach.clone() {
            Reach::Virtual { program } => {
                eprintln!("{}, trial {}; {left} to go", words(place), number + 1);
                let seed = self.seed.wrapping_add(u64::from(number));
                let robot = VirtualRobot::start(&program, &folder, seed)?;
                let truth = folder.join(run_folder::TRUTH);
                self.measured(place, &folder, &gait, &robot.port, Some(&truth), &materials.robot)?
            }
            Reach::Port { port, tracker } => {
                match self.ask(place, number, left)? {
                    Answer::Walk => {}
                    Answer::Skip => return Ok(None),
                    Answer::Quit => {
                        return Err(ExperimentError::Interrupted { folder: self.folder.to_owned() });
                    }
                }
                let raw =
                    self.measured(place, &folder, &gait, &port, tracker.as_deref(), &materials.robot)?;
                if tracker.is_none() { self.judged(raw)? } else { raw }
            }
        };
        Ok(Some(Trial::of(place, number, &raw, &material.note.gait_sha256)))
    }

    fn measured(
        &mut self,
        place: Place,
        folder: &Path,
        gait: &Path,
        port: &str,
        tracker: Option<&Path>,
        robot: &Robot,
    ) -> Result<Raw, ExperimentError> {
        let text = |path: &Path| path.display().to_string();
        let (gait, out, of_robot) = (text(gait), text(folder), text(&folder.join(run_folder::ROBOT)));
        let (amplitude, duration) = (place.amplification.to_string(), self.duration_s.to_string());
        self.steps.run(
            "upload-gait",
            &["--gait", &gait, "--amp", &amplitude, "--ram", "--robot", &of_robot, "--port", port],
        )?;
        let mut flags = vec!["--port", port, "--duration", &duration, "--robot", &of_robot, "--out", &out];
        let tracker = tracker.map(text);
        if let Some(tracker) = &tracker {
            flags.extend(["--tracker", tracker]);
        }
        let done = self.steps.attempt("measure", &flags)?;
        // Standing still and being stopped are results; all else ends the command.
        let stopped = match done.outcome {
            Ok(()) => false,
            Err(StepError::Failed { cause: Cause::Robot, .. }) => true,
            // Standing still is a result; a tracker's file that cannot be used is none.
            Err(StepError::Failed { cause: Cause::Input, .. })
                if done.json.as_ref().is_ok_and(|json| json["distance_m"].is_number()) =>
            {
                false
            }
            Err(StepError::Failed { cause: Cause::Interrupted, .. }) => {
                return Err(ExperimentError::Interrupted { folder: self.folder.to_owned() });
            }
            Err(error) => return Err(error.into()),
        };
        let json = done.json.map_err(|source| StepError::Json { step: "measure", source })?;
        Ok(Raw { stopped, ..raw(&json, robot) })
    }

    /// What nothing on the robot can see; a trial of which nothing more can be learned is not noted.
    fn judged(&self, raw: Raw) -> Result<Raw, ExperimentError> {
        if !std::io::stdin().is_terminal() || raw.stopped {
            return Ok(raw);
        }
        loop {
            eprint!("Enter if it walked well, f if it fell, b if it went backwards: ");
            match line()?.as_deref() {
                Some("") => return Ok(raw),
                None => return Err(ExperimentError::Interrupted { folder: self.folder.to_owned() }),
                Some("f") => return Ok(Raw { fell: true, ..raw }),
                Some("b") => {
                    let displacement_m = raw.displacement_m.map(|way| way.map(|m| -m));
                    return Ok(Raw { displacement_m, ..raw });
                }
                Some(other) => eprintln!("{other:?} is none of Enter, f and b"),
            }
        }
    }

    /// What comes next, and whether it may.
    fn ask(&mut self, place: Place, number: u32, left: usize) -> Result<Answer, ExperimentError> {
        if !std::io::stdin().is_terminal() {
            return Ok(Answer::Walk);
        }
        if self.legs_on != Some(place.leg) {
            eprintln!(
                "\nFrom here on: legs of {} L. Mount them, and check that the robot stands.",
                place.leg
            );
            self.legs_on = Some(place.leg);
        }
        eprintln!("\n{}, trial {}; {left} to go.", words(place), number + 1);
        loop {
            eprint!("Put the robot on its mark. Enter walks, s leaves this trial out, q ends for today: ");
            let answer = line()?;
            // Reading goes on after a Ctrl-C; the robot must not.
            match answer.as_deref() {
                _ if self.stop.load(Ordering::Relaxed) => return Ok(Answer::Quit),
                Some("") => return Ok(Answer::Walk),
                Some("s") => return Ok(Answer::Skip),
                Some("q") | None => return Ok(Answer::Quit),
                Some(other) => eprintln!("{other:?} is none of Enter, s and q"),
            }
        }
    }
}

fn line() -> Result<Option<String>, FileError> {
    let mut lines = std::io::stdin().lock().lines();
    let line = lines.next().transpose();
    line.map(|line| line.map(|line| line.trim().to_owned()))
        .map_err(FileError::on("read", Path::new("standard input")))
}

fn words(place: Place) -> String {
    format!("{} at {:.1}x, legs of {} L", place.method.label(), place.amplification, place.leg)
}

/// From the JSON of `measure`.
fn raw(json: &Value, robot: &Robot) -> Raw {
    let number = |field: &str| json[field].as_f64();
    let way = |axis: usize| json["displacement_m"][axis].as_f64();
    // Without a tracker only its length is known: along the floor's line.
    let displacement_m = match (way(0), way(1)) {
        (Some(dx_m), Some(dy_m)) => Some([dx_m, dy_m]),
        _ => number("distance_m").map(|distance_m| [distance_m, 0.0]),
    };
    Raw {
        duration_s: number("duration_s").unwrap_or(0.0),
        energy_j: number("energy_j").unwrap_or(f64::NAN),
        displacement_m,
        mass_kg: number("mass_kg").unwrap_or(robot.mass_kg()),
        fell: number("max_tilt_rad").is_some_and(|tilt_rad| tilt_rad > FALLEN_TILT_RAD),
        missed_samples: json["missed_samples"].as_u64().and_then(|n| u32::try_from(n).ok()).unwrap_or(0),
        ..Raw::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiment::method::Method;
    use crate::experiment::trial::Mark;
    use serde_json::json;

    #[test]
    fn a_trial_is_judged_by_what_measure_says() {
        let robot = Robot::ant(1.0).unwrap();
        let place = Place { method: Method::Psto, leg: 1.0, amplification: 2.0 };
        let well = json!({
            "duration_s": 12.0, "energy_j": 9.6, "distance_m": 1.5, "displacement_m": [0.9, 1.2],
            "mass_kg": 1.0, "missed_samples": 0, "max_tilt_rad": 0.2,
        });
        let trial = |json: &Value| Trial::of(place, 0, &raw(json, &robot), "");
        let with = |field: &str, value: Value| {
            let mut json = well.clone();
            json[field] = value;
            trial(&json).mark
        };

        assert_eq!(trial(&well).mark, None);
        assert_eq!(trial(&well).dy_m, Some(1.2));
        assert_eq!(with("max_tilt_rad", json!(1.4)), Some(Mark::Fell));
        assert_eq!(with("missed_samples", json!(2)), Some(Mark::MissedSamples));
        assert_eq!(trial(&json!({})).mark, Some(Mark::Stopped));
        let mut standing = well.clone();
        (standing["displacement_m"], standing["distance_m"]) = (Value::Null, json!(0.0));
        assert_eq!(trial(&standing).mark, Some(Mark::NoDistance));
    }
}
