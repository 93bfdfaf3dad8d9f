//! Which column of a recording is which joint, and how its values are scaled.
//!
//! Holds the map's file format; the flags of `fit` override its entries one by one.
//! Does not depend on the recordings themselves.

use crate::run_folder::FileError;
use protocol::{JOINT_COUNT, Joint};
use serde::Deserialize;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// A map as written; what it leaves open, the flags or the defaults decide.
#[derive(Debug, Clone, PartialEq, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct JointMap {
    /// What each column holds, left to right: a joint, `time_s`, or `-`.
    pub columns: Option<Vec<String>>,
    /// Joints that turn the other way on the robot.
    pub negate: Option<Vec<String>>,
    /// Degrees per unit of action about the centre, at amplitude 1.0.
    pub unit_deg: Option<f64>,
    /// Degrees per unit of the mean action.
    pub centre_unit_deg: Option<f64>,
    /// Degrees between action 0 and neutral.
    pub centre_offset_deg: Option<f64>,
    /// What the columns hold at neutral, before any scale: one value, or one a joint.
    pub neutral: Option<Vec<f64>>,
    /// Joint limit, either way from neutral.
    pub limit_deg: Option<f64>,
}

/// Why a joint map was refused.
#[derive(Debug, Error)]
// The messages say what each field is.
#[allow(missing_docs)]
pub enum JointMapError {
    /// The file cannot be read.
    #[error(transparent)]
    File(#[from] FileError),
    /// The text is not a joint map.
    #[error("{path} is not a joint map")]
    Parse { path: PathBuf, source: Box<toml::de::Error> },
    /// A name that is not a joint's.
    #[error("{name:?} is not a joint; joints are hip1 to hip4 and knee1 to knee4, or ank1 to ank4")]
    UnknownJoint {
        /// The name.
        name: String,
    },
    /// Neither one value for all joints nor one for each.
    #[error(
        "there are {count} neutral values; give one for all joints, or {JOINT_COUNT}: hip1 to hip4, knee1 to knee4"
    )]
    Neutrals { count: usize },
    /// NaN or infinite.
    #[error("a neutral value of {value} is not a finite number")]
    Neutral { value: f64 },
}

impl JointMap {
    /// Reads a map.
    ///
    /// # Errors
    /// [`JointMapError`] naming the file and the line.
    pub fn load(path: &Path) -> Result<Self, JointMapError> {
        let bytes = std::fs::read(path).map_err(FileError::on("read", path))?;
        toml::from_slice(&bytes)
            .map_err(|source| JointMapError::Parse { path: path.to_owned(), source: Box::new(source) })
    }

    /// This map where it says something, `base` where it does not.
    #[must_use]
    pub fn or(self, base: Self) -> Self {
        Self {
            columns: self.columns.or(base.columns),
            negate: self.negate.or(base.negate),
            unit_deg: self.unit_deg.or(base.unit_deg),
            centre_unit_deg: self.centre_unit_deg.or(base.centre_unit_deg),
            centre_offset_deg: self.centre_offset_deg.or(base.centre_offset_deg),
            neutral: self.neutral.or(base.neutral),
            limit_deg: self.limit_deg.or(base.limit_deg),
        }
    }

    /// What each column holds at neutral, if that is not 0, in [`Joint::ALL`] order.
    ///
    /// # Errors
    /// [`JointMapError::Neutrals`], [`JointMapError::Neutral`].
    pub fn neutrals(&self) -> Result<Option<[f64; JOINT_COUNT]>, JointMapError> {
        let Some(values) = &self.neutral else { return Ok(None) };
        if let Some(&value) = values.iter().find(|value| !value.is_finite()) {
            return Err(JointMapError::Neutral { value });
        }
        match values.as_slice() {
            [all] => Ok(Some([*all; JOINT_COUNT])),
            values => {
                values.try_into().map(Some).map_err(|_| JointMapError::Neutrals { count: values.len() })
            }
        }
    }

    /// -1 for each negated joint, else 1, in [`Joint::ALL`] order.
    ///
    /// # Errors
    /// [`JointMapError::UnknownJoint`].
    pub fn signs(&self) -> Result<[f64; JOINT_COUNT], JointMapError> {
        let mut signs = [1.0; JOINT_COUNT];
        for name in self.negate.iter().flatten() {
            let joint = Joint::from_name(&name.trim().to_ascii_lowercase())
                .ok_or_else(|| JointMapError::UnknownJoint { name: name.clone() })?;
            signs[joint.index()] = -1.0;
        }
        Ok(signs)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_flag_says_stands_and_the_file_fills_the_rest() {
        let file: JointMap =
            toml::from_str("negate = [\"ank3\"]\nunit_deg = 30.0\nlimit_deg = 50.0").unwrap();
        let flags = JointMap { unit_deg: Some(24.0), ..Default::default() };

        let map = flags.or(file);

        assert_eq!((map.unit_deg, map.limit_deg), (Some(24.0), Some(50.0)));
        assert_eq!(map.signs().unwrap(), [1., 1., 1., 1., 1., 1., -1., 1.]);
    }

    #[test]
    fn a_name_that_is_no_joint_is_refused() {
        let map = JointMap { negate: Some(vec!["tail1".into()]), ..Default::default() };

        assert!(map.signs().unwrap_err().to_string().starts_with("\"tail1\" is not a joint"));
    }
}
