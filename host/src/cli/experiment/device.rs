//! Trials through the firmware: on the virtual robot, or on a real one.
//!
//! Holds the steps of a trial, `upload-gait` and `measure`, and which of their
//! failures are results. A trial that the robot ended early is recorded as such
//! where nobody can be asked; a lost cable or a full disk ends the command, which
//! resumes there when it is called again. Does not depend on the plan's order.

use super::ExperimentError;
use super::person::{self, After, Before, Person};
use crate::cli::Cause;
use crate::cli::steps::{Done, StepError, Steps};
use crate::cli::virtual_robot::VirtualRobot;
use crate::device::tracker::{Epoch, Track};
use crate::device::trial::measure_result::MeasureResult;
use crate::device::upload::upload_result::UploadResult;
use crate::experiment::materials::{self, Materials};
use crate::experiment::plan::Plan;
use crate::experiment::trial::{Place, Raw, Trial};
use crate::run_folder::{self, FileError};
use serde::de::IgnoredAny;
use std::io::IsTerminal as _;
use std::path::{Path, PathBuf};

/// A robot that tilts further has fallen.
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
        /// Name of the port.
        port: String,
        /// File of positions; without it the person at the robot is asked.
        tracker: Option<PathBuf>,
    },
}

impl Reach {
    /// Checks now what would fail after the first trial.
    ///
    /// # Errors
    /// [`ExperimentError`] if there is no virtual robot, nobody to ask for distances, or a
    /// tracker's file that cannot tell `walks` trials apart.
    pub fn check(&self, walks: usize) -> Result<(), ExperimentError> {
        match self {
            Self::Virtual { program } if !program.is_file() => {
                Err(StepError::NoVirtualRobot { program: program.clone() }.into())
            }
            Self::Port { tracker: None, .. } if !std::io::stdin().is_terminal() => {
                Err(ExperimentError::NoDistances)
            }
            Self::Port { tracker: Some(path), .. } if path.exists() => match Track::check(path)? {
                Some(Epoch::TrialStart) if walks > 1 => {
                    Err(ExperimentError::RelativeTrack { path: path.clone(), walks })
                }
                _ => Ok(()),
            },
            _ => Ok(()),
        }
    }
}

/// What is walked, and on what.
struct Walk<'a> {
    place: Place,
    /// For the robot's description and what was measured.
    folder: &'a Path,
    gait: &'a Path,
}

/// Walks trials, one after the other.
pub struct Device<'a> {
    pub reach: &'a Reach,
    pub steps: Steps,
    pub folder: &'a Path,
    pub plan: &'a Plan,
    pub person: Person<'a>,
}

impl Device<'_> {
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
        let walk = Walk { place, folder: &folder, gait: &gait };

        let reach = self.reach;
        let raw = match reach {
            Reach::Virtual { program } => {
                eprintln!("{}", person::title(place, number, left));
                let seed = self.plan.seed.wrapping_add(u64::from(number));
                let robot = VirtualRobot::start(program, &folder, seed)?;
                Some(self.measured(&walk, &robot.port, Some(&folder.join(run_folder::TRUTH)))?)
            }
            Reach::Port { port, tracker } => {
                self.watched(&walk, port, tracker.as_deref(), |person| person.before(place, number, left))?
            }
        };
        let trial = raw.map(|raw| Trial::of(place, number, &raw, &material.note.gait_sha256));
        trial.iter().for_each(|trial| self.person.show(trial));
        Ok(trial)
    }

    /// Walks until the person at the robot, if anybody is there, accepts the trial.
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
                Before::Quit => return Err(self.quit()),
            }
            if was_stopped {
                // Whoever walks it again has seen why; a fault that remains refuses the walk.
                let cleared =
                    self.steps.attempt::<IgnoredAny>("status", &["--clear-fault", "--port", port])?.outcome;
                if let Err(StepError::Failed { cause: Cause::Interrupted, .. }) = cleared {
                    return Err(self.interrupted());
                }
            }
            let raw = match self.measured(walk, port, tracker) {
                // Refused before it began: the robot rests, and something has to be corrected.
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
                After::Quit => return Err(self.quit()),
            }
        }
    }

    fn measured(
        &mut self,
        walk: &Walk<'_>,
        port: &str,
        tracker: Option<&Path>,
    ) -> Result<Raw, ExperimentError> {
        // Ctrl-C may have come before anything was listening: nothing may walk after it.
        if self.person.has_stopped() {
            return Err(self.interrupted());
        }
        let text = |path: &Path| path.display().to_string();
        let (gait, out, robot) =
            (text(walk.gait), text(walk.folder), text(&walk.folder.join(run_folder::ROBOT)));
        let (amplitude, duration) = (walk.place.amplification.to_string(), self.plan.duration_s.to_string());
        let uploaded = self.steps.run::<UploadResult>(
            "upload-gait",
            &["--gait", &gait, "--amp", &amplitude, "--ram", "--robot", &robot, "--port", port],
        );
        uploaded.map_err(|error| self.ended(error))?;
        if self.person.has_stopped() {
            return Err(self.interrupted());
        }
        let mut flags = vec!["--port", port, "--duration", &duration, "--out", &out];
        let mass_kg = self.plan.mass_kg.map(|mass_kg| mass_kg.to_string());
        match &mass_kg {
            Some(mass_kg) => flags.extend(["--mass-kg", mass_kg]),
            None => flags.extend(["--robot", &robot]),
        }
        let tracker = tracker.map(text);
        if let Some(tracker) = &tracker {
            flags.extend(["--tracker", tracker]);
        }
        let Done { outcome, result } = self.steps.attempt::<MeasureResult>("measure", &flags)?;
        let is_known = result.as_ref().is_ok_and(|trial| trial.distance_m.is_some());
        // Standing still and being stopped are results; everything else ends the command.
        let stopped = match outcome {
            Ok(()) => false,
            Err(StepError::Failed { cause: Cause::Robot, .. }) if result.is_ok() => true,
            // Standing still is a result; a tracker's file that cannot be used is not.
            Err(StepError::Failed { cause: Cause::Input, .. }) if is_known => false,
            Err(error) => return Err(self.ended(error)),
        };
        let trial = result.map_err(|source| StepError::Json { step: "measure", source })?;
        Ok(Raw { stopped, ..raw(&trial) })
    }

    /// A step that Ctrl-C ended is not a failure.
    fn ended(&self, error: StepError) -> ExperimentError {
        match error {
            StepError::Failed { cause: Cause::Interrupted, .. } => self.interrupted(),
            error => error.into(),
        }
    }

    /// The person at the robot ended the session, or Ctrl-C did.
    fn quit(&self) -> ExperimentError {
        if self.person.has_stopped() {
            return self.interrupted();
        }
        ExperimentError::Quit { folder: self.folder.to_owned() }
    }

    fn interrupted(&self) -> ExperimentError {
        ExperimentError::Interrupted { folder: self.folder.to_owned() }
    }
}

/// A trial of the study from one of `measure`.
fn raw(trial: &MeasureResult) -> Raw {
    Raw {
        duration_s: trial.duration_s,
        energy_j: trial.energy_j,
        // Without a tracker only its length is known: along the floor's line.
        displacement_m: trial.displacement_m.or(trial.distance_m.map(|distance_m| [distance_m, 0.0])),
        mass_kg: trial.mass_kg,
        fell: trial.max_tilt_rad.is_some_and(|tilt_rad| tilt_rad > FALLEN_TILT_RAD),
        fall_unseen: trial.max_tilt_rad.is_none(),
        missed_samples: trial.missed_samples.into(),
        ..Raw::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiment::method::Method;
    use crate::experiment::trial::Mark;
    use crate::robot::LegScale;

    #[test]
    fn a_trial_is_judged_by_what_measure_says() {
        let place = Place { method: Method::Psto, leg: LegScale::LONG, amplification: 2.0 };
        let well = MeasureResult {
            valid: true,
            reason: None,
            remark: None,
            gait_name: "psto".into(),
            gait_sha256: "ab".into(),
            gait_crc32: "00000001".into(),
            gait_source: None,
            amplitude: 2.0,
            frames_played: 720,
            duration_s: 12.0,
            energy_j: 9.6,
            true_energy_j: None,
            displacement_m: Some([0.9, 1.2]),
            max_tilt_rad: Some(0.2),
            mean_power_w: Some(0.8),
            distance_m: Some(1.5),
            distance_source: "tracker truth.jsonl".into(),
            speed_m_s: Some(0.125),
            mass_kg: 1.0,
            cost_of_transport: Some(0.653),
            clipped_frames: 0,
            missed_samples: 0,
            lost_telemetry_frames: 0,
            frame_rate_hz: Some(60.0),
            trials: "trials.csv".into(),
            telemetry: "telemetry-1.csv".into(),
        };
        let trial = |result: &MeasureResult| Trial::of(place, 0, &raw(result), "");
        let mark = |result: MeasureResult| trial(&result).mark;

        assert_eq!(trial(&well).mark, None);
        assert_eq!(trial(&well).dy_m, Some(1.2));
        assert_eq!(mark(MeasureResult { max_tilt_rad: Some(1.4), ..well.clone() }), Some(Mark::Fell));
        assert_eq!(mark(MeasureResult { missed_samples: 2, ..well.clone() }), Some(Mark::MissedSamples));
        assert_eq!(mark(MeasureResult { duration_s: 0.0, ..well.clone() }), Some(Mark::Stopped));
        let standing = MeasureResult { displacement_m: None, distance_m: Some(0.0), ..well };
        assert_eq!(mark(standing), Some(Mark::NoDistance));
    }
}
