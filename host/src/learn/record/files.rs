//! What a recording leaves in the run's folder.
//!
//! Owns the files' names and shapes: `trajectory.csv` and beside it, row by row,
//! `trajectory-spread.csv`; `record.json`; and the picture. The spread has a
//! file of its own because other columns in `trajectory.csv` would make it a
//! recording of somebody else's, in which `fit` looks for a stride.

use super::{RecordError, Recording, figure};
use crate::gait::stride::Sample;
use crate::run_folder;
use protocol::Joint;
use sha2::{Digest as _, Sha256};
use std::path::Path;

/// What the recording came to, beside the trajectory.
pub const RECORD: &str = "record.json";
/// Standard deviation of every value of the trajectory.
pub const SPREAD: &str = "trajectory-spread.csv";
/// The paper's Figure 4.
pub const FIGURE: &str = "trajectory.svg";

impl Recording {
    /// Writes trajectory, spread, picture and description into the run's folder.
    ///
    /// # Errors
    /// [`RecordError::Plot`] before anything is written; [`RecordError::File`]
    /// with the old file still in place.
    pub fn save(&self, run: &Path) -> Result<(), RecordError> {
        let svg = figure::of(self).to_svg()?;
        let trajectory = self.to_csv(&self.samples);
        let mut description = serde_json::json!(self);
        // Which file it is of: `fit` compares with no other.
        description["trajectory_sha256"] = hex(&Sha256::digest(&trajectory)).into();
        let files = [
            (run_folder::TRAJECTORY, trajectory),
            (SPREAD, self.to_csv(&self.deviations)),
            (FIGURE, svg),
            (RECORD, format!("{description:#}\n")),
        ];
        for (name, contents) in files {
            run_folder::write(&run.join(name), contents.as_bytes())?;
        }
        Ok(())
    }

    /// One stride, a row a sample: time, then every joint in action units.
    pub(super) fn to_csv(&self, rows: &[Sample]) -> String {
        let mut csv = String::from("time_s");
        for joint in Joint::ALL {
            csv += ",";
            csv += joint.name();
        }
        csv += "\n";
        let interval_s = self.interval_s();
        for (row, sample) in rows.iter().enumerate() {
            csv += &format!("{:.6}", row as f64 * interval_s);
            for value in sample {
                csv += &format!(",{value:.6}");
            }
            csv += "\n";
        }
        csv
    }

    /// Time between samples.
    pub(super) fn interval_s(&self) -> f64 {
        self.period_s / self.samples.len() as f64
    }
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}
