//! Why a gait was refused, with the value and its limit.

use super::FILE_VERSION;
use crate::run_folder::FileError;
use protocol::gait::{
    COEFFICIENT_COUNT, GaitError, MAX_DEVIATION_DEG, MAX_LIMIT_DEG, MAX_PERIOD_US, MAX_ROWS, MIN_PERIOD_US,
};
use protocol::{JOINT_COUNT, Joint, Name};
use std::path::PathBuf;
use thiserror::Error;

/// Why a gait was refused.
#[derive(Debug, Error)]
// The messages say what each field is.
#[allow(missing_docs)]
pub enum GaitFileError {
    /// The file cannot be read or written.
    #[error(transparent)]
    File(#[from] FileError),
    /// The text is not a gait file.
    #[error("{path} is not a gait file")]
    Parse { path: PathBuf, source: Box<toml::de::Error> },
    /// The bytes are not a gait table.
    #[error("{path} is not a gait table, or is damaged ({len} bytes): {}", describe(*.reason))]
    Bytes { path: PathBuf, len: usize, reason: GaitError },
    /// The file can be read, but its values cannot be played.
    #[error("{path} cannot be used")]
    Unusable { path: PathBuf, source: UnusableGait },
}

/// Which value of a gait cannot be played.
#[derive(Debug, Clone, PartialEq, Error)]
// The messages say what each field is.
#[allow(missing_docs)]
pub enum UnusableGait {
    /// Another version of the format.
    #[error("its version is {found}; this program reads version {FILE_VERSION}")]
    Version { found: u32 },
    /// A name that the robot cannot store.
    #[error("its name is {name:?}; a name is 1 to {} printable ASCII characters", Name::CAPACITY)]
    Name { name: String },
    /// A number of the whole gait is out of its range.
    #[error("{field} is {value}; it must be within {min} to {max}")]
    Value { field: &'static str, value: f64, min: f64, max: f64 },
    /// Not eight joints.
    #[error("it has {found} joints; a robot has {JOINT_COUNT}: hip1 to hip4 and knee1 to knee4")]
    JointCount { found: usize },
    /// A name that is not a joint's.
    #[error("it names a joint {name:?}; joints are hip1 to hip4 and knee1 to knee4")]
    UnknownJoint { name: String },
    /// The same joint twice.
    #[error("it has {joint} twice")]
    RepeatedJoint { joint: &'static str },
    /// Not a degree-10 series.
    #[error("{joint} has {found} coefficients; a degree-10 curve has {COEFFICIENT_COUNT}")]
    CoefficientCount { joint: &'static str, found: usize },
    /// A number of one joint is out of its range.
    #[error("{joint}: {field} is {value}; it must be within {min} to {max} degrees")]
    JointValue { joint: &'static str, field: &'static str, value: f64, min: f64, max: f64 },
    /// The curve swings wider than any servo.
    #[error(
        "{joint}: the curve swings {deviation_deg:.1} degrees from its centre at amplitude 1.0; \
         a table holds at most {MAX_DEVIATION_DEG}"
    )]
    Deviation { joint: &'static str, deviation_deg: f64 },
}

/// A robot's verdict on a table, in words.
#[must_use]
pub fn describe(error: GaitError) -> String {
    match error {
        GaitError::Length => "it is too short or too long".into(),
        GaitError::Crc => "its checksum does not match".into(),
        GaitError::Name => "its name is empty or not printable ASCII".into(),
        GaitError::Period => format!(
            "its period is outside {} to {} s",
            f64::from(MIN_PERIOD_US) / 1e6,
            f64::from(MAX_PERIOD_US) / 1e6
        ),
        GaitError::JointLimits(index) => {
            let joint = Joint::ALL.get(usize::from(index)).map_or("a joint", |j| j.name());
            format!("{joint}'s limits are reversed, beyond {MAX_LIMIT_DEG} degrees, or exclude its centre")
        }
        GaitError::Kind => {
            "it is neither a polynomial nor a row of samples, or not the kind asked for".into()
        }
        GaitError::Rows => format!("it has fewer than 2 or more than {MAX_ROWS} rows, or a sample of -128"),
        GaitError::Step => "the step of its samples is 0".into(),
    }
}
