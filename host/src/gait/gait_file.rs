//! The gait as a readable file, in degrees, with its provenance.
//!
//! Holds the TOML format, its checks, the angles in f64, and the conversion to the
//! table that the robot plays: whatever [`GaitFile::load`] returns can be converted.
//! [`mod@limits`] says how far a gait may be amplified. Of a robot it
//! holds the name and the hash. Does not depend on fits.
//!
//! `angle = centre_deg + amplitude * deviation(phase)`, the deviation being a
//! Chebyshev series in `x = 2 phase - 1`, in degrees at amplitude 1.0.

mod document;
mod error;
pub mod limits;
mod naming;
mod series;

use crate::robot::{LegScale, Robot};
pub use error::{GaitFileError, UnusableGait, describe};
pub use naming::short_name;
pub use series::{JointSeries, chebyshev};

use crate::run_folder::{self, FileError};
use protocol::gait::{COEFFICIENT_UNITS_PER_DEG, MAX_ENCODED_LEN, MAX_PERIOD_US, MIN_PERIOD_US};
use protocol::{Angle, GaitTable, JOINT_COUNT, Joint, JointCurve, Name};
use serde::{Deserialize, Serialize};
use sha2::{Digest as _, Sha256};
use std::path::Path;

/// Version of the file format that this program writes, and the only one it reads.
pub const FILE_VERSION: u32 = 1;

/// A gait with its history; angles in degrees, phases in strides.
#[derive(Debug, Clone, PartialEq)]
pub struct GaitFile {
    /// What the robot will call it: 1 to 16 printable ASCII characters.
    pub name: String,
    /// Duration of one stride.
    pub period_s: f64,
    /// Degrees a joint moves per unit of action at amplitude 1.0.
    pub unit_deg: f64,
    /// Where it came from.
    pub provenance: Provenance,
    /// In [`Joint::ALL`] order.
    pub joints: [JointSeries; JOINT_COUNT],
}

/// How a gait was made.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Source {
    /// Fitted to the trajectory of a policy that was trained here.
    Trained,
    /// Fitted to a trajectory from elsewhere.
    Fitted,
    /// Searched in simulation, without a policy.
    Searched,
    /// Waves tuned in simulation, amplitude, phase and offset of each.
    Sinusoid,
    /// Read back from the bytes of a table: the history is lost.
    Table,
}

impl Source {
    /// As in files: `trained`, `fitted`, `searched`, `sinusoid`, `table`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Trained => "trained",
            Self::Fitted => "fitted",
            Self::Searched => "searched",
            Self::Sinusoid => "sinusoid",
            Self::Table => "table",
        }
    }
}

/// A gait's history, as far as it is known.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Provenance {
    /// How the gait was made.
    pub source: Source,
    /// The trajectory that was fitted.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub file: Option<String>,
    /// SHA-256 of that file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub file_sha256: Option<String>,
    /// The data rows that were fitted, `first..end`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rows: Option<String>,
    /// How the ends of the stride were joined: `free` or `continuous`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub seam: Option<String>,
    /// How much slower than the trajectory it plays.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub time_stretch: Option<f64>,
    /// The run folder the trajectory lay in.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub run: Option<String>,
    /// The seed of that run.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub seed: Option<u64>,
    /// Name of the robot it was made for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub robot: Option<String>,
    /// SHA-256 of that robot's description and drawing.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub robot_sha256: Option<String>,
    /// Leg length of the robot it is meant for; 1.0 is 23 cm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub leg_scale: Option<LegScale>,
    /// Least and most amplitude at which it was found safe, on robots unlike each other.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub safe_amplitudes: Option<[f64; 2]>,
    /// The command that wrote it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub command: Option<String>,
}

impl Provenance {
    /// A history of which only the source is known.
    #[must_use]
    pub const fn of(source: Source) -> Self {
        Self {
            source,
            file: None,
            file_sha256: None,
            rows: None,
            seam: None,
            time_stretch: None,
            run: None,
            seed: None,
            robot: None,
            robot_sha256: None,
            leg_scale: None,
            safe_amplitudes: None,
            command: None,
        }
    }

    /// The same history with the robot that the gait is for.
    #[must_use]
    pub fn with_robot(self, robot: &Robot) -> Self {
        Self { robot: Some(robot.name.clone()), robot_sha256: Some(robot.sha256()), ..self }
    }
}

impl GaitFile {
    /// Reads a gait: the bytes of a table if `path` ends in `.bin`, else TOML.
    ///
    /// # Errors
    /// [`GaitFileError`] naming the file, the joint, the value and its limit.
    pub fn load(path: &Path) -> Result<Self, GaitFileError> {
        let bytes = std::fs::read(path).map_err(FileError::on("read", path))?;
        if path.extension().is_some_and(|e| e == "bin") {
            let table = GaitTable::decode(&bytes).map_err(|reason| GaitFileError::Bytes {
                path: path.to_owned(),
                len: bytes.len(),
                reason,
            })?;
            return Ok(Self::from_table(&table));
        }
        Self::parse(&bytes, path)
    }

    /// Reads a readable file's text; `path` is for error messages.
    ///
    /// # Errors
    /// As [`Self::load`].
    pub fn parse(text: &[u8], path: &Path) -> Result<Self, GaitFileError> {
        let unusable = |source| GaitFileError::Unusable { path: path.to_owned(), source };
        let document = document::parse(text)
            .map_err(|source| GaitFileError::Parse { path: path.to_owned(), source: Box::new(source) })?;
        let gait = Self::from_document(document).map_err(unusable)?;
        gait.check().map_err(unusable)?;
        Ok(gait)
    }

    /// Writes the readable file, and the robot's bytes beside it as `.bin`.
    ///
    /// # Errors
    /// [`GaitFileError::File`] with both old files in place, or
    /// [`GaitFileError::Unusable`] if [`Self::check`] refuses the gait.
    pub fn save(&self, path: &Path) -> Result<(), GaitFileError> {
        let unusable = |source| GaitFileError::Unusable { path: path.to_owned(), source };
        let bytes = self.encoded().map_err(unusable)?;
        let toml = self.to_toml();
        run_folder::write_all(&[(&path.with_extension("bin"), &bytes), (path, toml.as_bytes())])?;
        Ok(())
    }

    /// The gait in a table, with no history.
    #[must_use]
    pub fn from_table(table: &GaitTable) -> Self {
        let joints = table.joints.map(|curve| JointSeries {
            centre_deg: curve.centre.deg(),
            min_deg: curve.min.deg(),
            max_deg: curve.max.deg(),
            coefficients_deg: curve
                .coefficients
                .map(|c| f64::from(c.0) / f64::from(COEFFICIENT_UNITS_PER_DEG)),
            residual_rms_deg: None,
            r2: None,
        });
        Self {
            name: table.name.as_str().into(),
            period_s: f64::from(table.period_us) / 1e6,
            unit_deg: table.unit_deg(),
            provenance: Provenance::of(Source::Table),
            joints,
        }
    }

    /// Checks that every value can be played.
    ///
    /// # Errors
    /// The first value that cannot, with its limit.
    pub fn check(&self) -> Result<(), UnusableGait> {
        self.table().map(|_| ())
    }

    /// The table that the robot plays: this gait, quantised.
    ///
    /// # Errors
    /// The first value that does not fit a table.
    pub fn table(&self) -> Result<GaitTable, UnusableGait> {
        let within = |field, value: f64, min: f64, max: f64| {
            if (min..=max).contains(&value) {
                Ok(value)
            } else {
                Err(UnusableGait::Value { field, value, min, max })
            }
        };
        let name = Name::new(&self.name).ok_or_else(|| UnusableGait::Name { name: self.name.clone() })?;
        let (min_s, max_s) = (f64::from(MIN_PERIOD_US) / 1e6, f64::from(MAX_PERIOD_US) / 1e6);
        let period_s = within("period_s", self.period_s, min_s, max_s)?;
        let unit_deg = within("unit_deg", self.unit_deg, 0.1, 127.0)?;
        let largest_seed = i64::MAX as f64;
        within("seed", self.provenance.seed.unwrap_or(0) as f64, 0.0, largest_seed.next_down())?;
        let mut joints = [JointCurve::default(); JOINT_COUNT];
        for joint in Joint::ALL {
            joints[joint.index()] = self.joints[joint.index()].quantise(joint.name())?;
        }
        Ok(GaitTable {
            name,
            // Down, for `GaitTable::phase_step`; a thousandth of a microsecond keeps whole ones whole.
            period_us: (period_s * 1e6 + 1e-3).floor() as u32,
            unit: Angle::from_deg(unit_deg),
            joints,
        })
    }

    /// The table's bytes, as in `gait.bin` and as the robot stores them.
    ///
    /// # Errors
    /// As [`Self::table`].
    pub fn encoded(&self) -> Result<Vec<u8>, UnusableGait> {
        let mut buffer = [0; MAX_ENCODED_LEN];
        // A table that passed is at most 256 bytes; `tests` has the longest.
        Ok(self.table()?.encode(&mut buffer).map(<[u8]>::to_vec).unwrap_or_default())
    }

    /// Angle asked of `joint` at `phase` in strides, unlimited, in degrees: the
    /// reference that quantised setpoints are held against.
    #[must_use]
    pub fn angle_deg(&self, joint: Joint, phase: f64, amplitude: f64) -> f64 {
        let series = &self.joints[joint.index()];
        series.centre_deg + amplitude * series.deviation_deg(phase.rem_euclid(1.0))
    }
}

/// What identifies a gait: SHA-256 of its encoded table, as `sha256sum gait.bin` prints it.
#[must_use]
pub fn gait_sha256(encoded: &[u8]) -> String {
    Sha256::digest(encoded).iter().map(|byte| format!("{byte:02x}")).collect()
}

#[cfg(test)]
mod tests;
