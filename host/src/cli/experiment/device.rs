//! Trials through the firmware: on the virtual robot, or on a real one.
//!
//! Owns what of a step's JSON a trial is judged by. Each trial is `upload-gait`
//! and `measure`, as they would be typed. A trial that the robot broke off is
//! noted as such where nobody can be asked; a lost cable or a full disk ends the
//! command, which goes on there when it is called again.

use super::ExperimentError;
use super::person::{self, After, Before, Person};
use crate::cli::Cause;
use crate::cli::steps::{StepError, Steps};
use crate::cli::virtual_robot::VirtualRobot;
use crate::experiment::materials::{self, Materials};
use crate::experiment::trial::{Place, Raw, Trial};
use crate::robot::Robot;
use crate::run_folder::{self, FileError};
use serde_json::Value;
use std::io::IsTerminal as _;
use std::path::{Path, PathBuf};

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

/// What is walked, and on what.
struct Walk<'a> {
    place: Place,
    /// For the robot's description and what was measured.
    folder: &'a Path,
    gait: &'a Path,
    robot: &'a Robot,
}

/// Walks trials, one after the other.
pub struct Device<'a> {
    pub reach: Reach,
    pub steps: Steps,
    pub folder: &'a Path,
    pub seed: u64,
    pub duration_s: f64,
    /// As weighed.
    pub mass_kg: Option<f64>,
    pub person: Person<'a>,
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
        let robot = &materials.robot;
        let folder = self.folder.join("walks").join(materials::folder_name(robot));
        std::fs::create_dir_all(&folder).map_err(FileError::on("create", &folder))?;
        robot.save(&folder.join(run_folder::ROBOT))?;
        let gait = folder.join(format!("{}.bin", place.method.name()));
        run_folder::write(&gait, material.playable.encoded().bytes())?;
        let walk = Walk { place, folder: &folder, gait: &gait, robot };

        let raw = match self.reach.clone() {
            Reach::Virtual { program } => {
                eprintln!("{}", person::title(place, number, left));
                let seed = self.seed.wrapping_add(u64::from(number));
                let robot = VirtualRobot::start(&program, &folder, seed)?;
                Some(self.measured(&walk, &robot.port, Some(&folder.join(run_folder::TRUTH)))?)
            }
            Reach::Port { port, tracker } => {
                self.watched(&walk, &port, tracker.as_deref(), |person| person.before(place, number, left))?
            }
        };
        let trial = raw.map(|raw| Trial::of(place, number, &raw, &material.note.gait_sha256));
        trial.iter().for_each(|trial| self.person.told(trial));
        Ok(trial)
    }

    /// Walks until the person at the robot, if anybody is there, is content.
    fn watched(
        &mut self,
        walk: &Walk<'_>,
        port: &str,
        tracker: Option<&Path>,
        before: impl Fn(&mut Person<'_>) -> Result<Before, FileError>,
    ) -> Result<Option<Raw>, ExperimentError> {
        let mut was_stopped = false;
        loop {
            match before(&mut self.person)? {
                Before::Walk => {}
                Before::Skip => return Ok(None),
                Before::Quit => return Err(self.ended_today()),
            }
            if was_stopped {
                // Whoever walks it again has seen why; what still stands, the walk is refused for.
                let cleared = self.steps.attempt("status", &["--clear-fault", "--port", port])?.outcome;
                if let Err(StepError::Failed { cause: Cause::Interrupted, .. }) = cleared {
                    return Err(self.interrupted());
                }
            }
            let raw = match self.measured(walk, port, tracker) {
                // Refused before it began: at rest, with something to be put right.
                Err(ExperimentError::Step(StepError::Failed { cause: Cause::Robot, .. }))
                    if self.person.is_there() =>
                {
                    Raw { stopped: true, ..Raw::default() }
                }
                raw => raw?,
            };
            was_stopped = raw.stopped;
            match self.person.after(raw, tracker.is_none())? {
                After::Note(raw) => return Ok(Some(raw)),
                After::Again => {}
                After::Skip => return Ok(None),
                After::Quit => return Err(self.ended_today()),
            }
        }
    }

    fn measured(
        &mut self,
        walk: &Walk<'_>,
        port: &str,
        tracker: Option<&Path>,
    ) -> Result<Raw, ExperimentError> {
        // Ctrl-C may have come while nobody listened: nothing may walk after it.
        if self.person.has_stopped() {
            return Err(self.interrupted());
        }
        let text = |path: &Path| path.display().to_string();
        let (gait, out, robot) =
            (text(walk.gait), text(walk.folder), text(&walk.folder.join(run_folder::ROBOT)));
        let (amplitude, duration) = (walk.place.amplification.to_string(), self.duration_s.to_string());
        let uploaded = self.steps.run(
            "upload-gait",
            &["--gait", &gait, "--amp", &amplitude, "--ram", "--robot", &robot, "--port", port],
        );
        uploaded.map_err(|error| self.ended(error))?;
        if self.person.has_stopped() {
            return Err(self.interrupted());
        }
        let mut flags = vec!["--port", port, "--duration", &duration, "--out", &out];
        let mass_kg = self.mass_kg.map(|mass_kg| mass_kg.to_string());
        match &mass_kg {
            Some(mass_kg) => flags.extend(["--mass-kg", mass_kg]),
            None => flags.extend(["--robot", &robot]),
        }
        let tracker = tracker.map(text);
        if let Some(tracker) = &tracker {
            flags.extend(["--tracker", tracker]);
        }
        let done = self.steps.attempt("measure", &flags)?;
        let is_known = done.json.as_ref().is_ok_and(|json| json["distance_m"].is_number());
        // Standing still and being stopped are results; all else ends the command.
        let stopped = match done.outcome {
            Ok(()) => false,
            Err(StepError::Failed { cause: Cause::Robot, .. }) if done.json.is_ok() => true,
            // Standing still is a result; a tracker's file that cannot be used is none.
            Err(StepError::Failed { cause: Cause::Input, .. }) if is_known => false,
            Err(error) => return Err(self.ended(error)),
        };
        let json = done.json.map_err(|source| StepError::Json { step: "measure", source })?;
        Ok(Raw { stopped, ..raw(&json, walk.robot) })
    }

    /// A step that Ctrl-C ended is no failure.
    fn ended(&self, error: StepError) -> ExperimentError {
        match error {
            StepError::Failed { cause: Cause::Interrupted, .. } => self.interrupted(),
            error => error.into(),
        }
    }

    /// By the person's word, or by Ctrl-C.
    fn ended_today(&self) -> ExperimentError {
        if self.person.has_stopped() {
            return self.interrupted();
        }
        ExperimentError::Quit { folder: self.folder.to_owned() }
    }

    fn interrupted(&self) -> ExperimentError {
        ExperimentError::Interrupted { folder: self.folder.to_owned() }
    }
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
        fall_unseen: number("max_tilt_rad").is_none(),
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
