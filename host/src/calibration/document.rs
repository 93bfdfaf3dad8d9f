//! The TOML of a calibration: what stands where.

use super::{BadCalibration, Board, JointSetup, RobotCalibration};
use crate::run_folder::{self, FileError};
use protocol::{JOINT_COUNT, Joint};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Version of the file format that this program writes, and the only one it reads.
const FILE_VERSION: u32 = 1;

const HEAD: &str = "\
# How one robot is built. Pulses in microseconds, angles in degrees from neutral:
# pulse = neutral_us +- us_per_degree * angle, held within min_us and max_us.
# `host calibrate --write FILE` sends it to the robot.
";

/// Why a calibration file was refused.
#[derive(Debug, Error)]
// The messages say what each field is.
#[allow(missing_docs)]
pub enum CalibrationFileError {
    /// The file cannot be read or written.
    #[error(transparent)]
    File(#[from] FileError),
    /// The text is not a calibration.
    #[error("{path} is not a calibration file")]
    Parse { path: PathBuf, source: Box<toml::de::Error> },
    /// Written for another version of this program.
    #[error("{path} has version {found}; this program reads version {FILE_VERSION}")]
    Version {
        path: PathBuf,
        /// What it says.
        found: u32,
    },
    /// Not each joint once.
    #[error("{path}: {problem}; it needs hip1 to hip4 and knee1 to knee4, each once")]
    Joints { path: PathBuf, problem: String },
    /// It can be read, but no robot accepts its values.
    #[error("{path} cannot be used")]
    Unusable { path: PathBuf, source: BadCalibration },
}

#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Document {
    version: u32,
    board: BoardEntry,
    joint: Vec<JointEntry>,
}

#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct BoardEntry {
    pwm_hz: f64,
    oscillator_mhz: f64,
    shunt_ohm: f64,
    undervoltage_v: f64,
    start_v: f64,
    overcurrent_a: f64,
    autostart_s: u8,
}

#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct JointEntry {
    name: String,
    channel: u8,
    reversed: bool,
    neutral_us: f64,
    us_per_degree: f64,
    min_us: f64,
    max_us: f64,
    /// May be left out in a file that is written by hand.
    #[serde(default)]
    measured: bool,
}

impl RobotCalibration {
    /// Reads a file; the values are checked by [`Self::record`].
    ///
    /// # Errors
    /// [`CalibrationFileError`] naming the file and the line or the joint.
    pub fn load(path: &Path) -> Result<Self, CalibrationFileError> {
        let bytes = std::fs::read(path).map_err(FileError::on("read", path))?;
        let document: Document = toml::from_slice(&bytes).map_err(|source| CalibrationFileError::Parse {
            path: path.to_owned(),
            source: Box::new(source),
        })?;
        if document.version != FILE_VERSION {
            return Err(CalibrationFileError::Version { path: path.to_owned(), found: document.version });
        }
        let wrong = |problem| CalibrationFileError::Joints { path: path.to_owned(), problem };
        let mut joints: [Option<JointSetup>; JOINT_COUNT] = Default::default();
        for entry in document.joint {
            let Some(joint) = Joint::from_name(&entry.name) else {
                return Err(wrong(format!("{:?} is not a joint", entry.name)));
            };
            if joints[joint.index()].replace(entry.into()).is_some() {
                return Err(wrong(format!("{} is there twice", joint.name())));
            }
        }
        if let Some(missing) = Joint::ALL.into_iter().find(|joint| joints[joint.index()].is_none()) {
            return Err(wrong(format!("{} is missing", missing.name())));
        }
        let BoardEntry {
            pwm_hz,
            oscillator_mhz,
            shunt_ohm,
            undervoltage_v,
            start_v,
            overcurrent_a,
            autostart_s,
        } = document.board;
        let board =
            Board { pwm_hz, oscillator_mhz, shunt_ohm, undervoltage_v, start_v, overcurrent_a, autostart_s };
        // None is missing.
        let default = || Self::from_record(&protocol::Calibration::authors()).joints[0].clone();
        Ok(Self { board, joints: joints.map(|joint| joint.unwrap_or_else(default)) })
    }

    /// Reads a file whose values a robot takes.
    ///
    /// # Errors
    /// As [`Self::load`], and [`CalibrationFileError::Unusable`].
    pub fn load_checked(path: &Path) -> Result<(Self, protocol::Calibration), CalibrationFileError> {
        let calibration = Self::load(path)?;
        let record = calibration
            .record()
            .map_err(|source| CalibrationFileError::Unusable { path: path.to_owned(), source })?;
        Ok((calibration, record))
    }

    /// Writes the file, or leaves the old one.
    ///
    /// # Errors
    /// [`CalibrationFileError::File`].
    pub fn save(&self, path: &Path) -> Result<(), CalibrationFileError> {
        Ok(run_folder::write(path, self.to_toml().as_bytes())?)
    }

    /// The file's text.
    #[must_use]
    pub fn to_toml(&self) -> String {
        let Board { pwm_hz, oscillator_mhz, shunt_ohm, undervoltage_v, start_v, overcurrent_a, autostart_s } =
            self.board;
        let board = BoardEntry {
            pwm_hz,
            oscillator_mhz,
            shunt_ohm,
            undervoltage_v,
            start_v,
            overcurrent_a,
            autostart_s,
        };
        let joint = Joint::ALL.into_iter().map(|joint| JointEntry::of(joint, &self.joints[joint.index()]));
        let document = Document { version: FILE_VERSION, board, joint: joint.collect() };
        // Numbers, booleans and names: nothing that TOML cannot hold.
        format!("{HEAD}{}", toml::to_string(&document).unwrap_or_default())
    }
}

impl JointEntry {
    fn of(joint: Joint, setup: &JointSetup) -> Self {
        let JointSetup { channel, reversed, neutral_us, us_per_degree, min_us, max_us, is_measured } = *setup;
        let name = joint.name().into();
        Self { name, channel, reversed, neutral_us, us_per_degree, min_us, max_us, measured: is_measured }
    }
}

impl From<JointEntry> for JointSetup {
    fn from(entry: JointEntry) -> Self {
        let JointEntry { channel, reversed, neutral_us, us_per_degree, min_us, max_us, measured, .. } = entry;
        Self { channel, reversed, neutral_us, us_per_degree, min_us, max_us, is_measured: measured }
    }
}
