//! The files that a recording writes into the run folder.
//!
//! Holds `trajectory.csv` and, row by row, `trajectory-spread.csv`, `record.json` and the
//! picture. Does not depend on the simulation. The spread has its own file, because with
//! additional columns in `trajectory.csv` `fit` would not take it as one of our strides.

use super::{RecordError, Recording, figure};
use crate::gait::policy_record::{PolicyRecord, RECORD};
use crate::gait::stride::Sample;
use crate::run_folder;
use protocol::Joint;
use sha2::{Digest as _, Sha256};
use std::path::Path;

/// Standard deviation of each value of the trajectory.
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
        let record = PolicyRecord {
            summary: self.summary.clone(),
            trajectory_sha256: hex(&Sha256::digest(&trajectory)),
        };
        let files = [
            (run_folder::TRAJECTORY, trajectory),
            (SPREAD, self.to_csv(&self.deviations)),
            (FIGURE, svg),
            (RECORD, format!("{:#}\n", serde_json::json!(record))),
        ];
        for (name, contents) in files {
            run_folder::write(&run.join(name), contents.as_bytes())?;
        }
        Ok(())
    }

    /// CSV with a row a sample: time, then every joint in action units.
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
        self.summary.period_s / self.samples.len() as f64
    }
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}
