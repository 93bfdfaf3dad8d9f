//! What the policy did that a run's own trajectory is of: `record.json` beside it.
//!
//! Owns the reading, and the proof that both are of one recording. Refuses a
//! description of another trajectory. Whatever is wrong with it is a warning:
//! a gait can be fitted without.

use crate::cli::recording::Chosen;
use crate::gait::fit::MOST_STRIDES;
use crate::run_folder::FileError;
use serde::Deserialize;
use std::path::PathBuf;
use thiserror::Error;

/// What `host record` leaves beside a trajectory; its own constant needs the learner built in.
const RECORD: &str = "record.json";
/// Times in the trajectory are rounded, and a flag's value may be.
const PERIOD_TOLERANCE: f64 = 0.01;

/// What of the description is of interest here.
#[derive(Debug, Deserialize)]
pub struct PolicyRecord {
    pub period_s: f64,
    pub speed_m_s: f64,
    pub power_w: f64,
    #[serde(default)]
    pub strides_averaged: u32,
    #[serde(default)]
    pub strides_left_out: u32,
    /// Of `record --window`.
    pub window_s: Option<f64>,
    strides_in_window: Option<f64>,
    /// Older releases did not write it.
    trajectory_sha256: Option<String>,
}

/// Why a description is not used.
#[derive(Debug, Error)]
pub enum BadRecord {
    #[error(transparent)]
    File(#[from] FileError),
    #[error("{path} is no record of a policy; `host record` writes it anew")]
    Parse { path: PathBuf, source: serde_json::Error },
    #[error("{path} is of another trajectory than the one beside it; `host record` writes both anew")]
    Other { path: PathBuf },
    #[error(
        "{path} is of a stride of {record_s:.3} s, the trajectory beside it lasts {recorded_s:.3} s; \
         `host record` writes both anew"
    )]
    OtherPeriod { path: PathBuf, record_s: f64, recorded_s: f64 },
}

impl PolicyRecord {
    /// The description of the trajectory, if all of it was taken and there is one.
    pub fn beside(chosen: &Chosen) -> Result<Option<Self>, BadRecord> {
        let path = chosen.path.with_file_name(RECORD);
        if !chosen.is_whole_stride || !path.exists() {
            return Ok(None);
        }
        let text = std::fs::read(&path).map_err(FileError::on("read", &path))?;
        let record: Self = serde_json::from_slice(&text)
            .map_err(|source| BadRecord::Parse { path: path.clone(), source })?;
        match &record.trajectory_sha256 {
            Some(sha256) if *sha256 != chosen.trajectory.sha256 => return Err(BadRecord::Other { path }),
            Some(_) => {}
            None => {
                let record_s = record.period_s;
                if let Some(recorded_s) = duration_s(chosen).filter(|&s| differ(s, record_s)) {
                    return Err(BadRecord::OtherPeriod { path, record_s, recorded_s });
                }
            }
        }
        Ok(Some(record))
    }

    /// Strides that share one curve, where they are more than it can follow.
    pub fn crowded_strides(&self) -> Option<f64> {
        self.strides_in_window.filter(|&strides| strides > MOST_STRIDES)
    }

    /// Whether the rows are taken to last as long as they did.
    pub fn lasts(&self, recorded_s: f64) -> bool {
        !differ(recorded_s, self.period_s)
    }
}

fn differ(a_s: f64, b_s: f64) -> bool {
    (a_s - b_s).abs() > PERIOD_TOLERANCE * b_s
}

/// By the file's own times, whatever the flags say.
fn duration_s(chosen: &Chosen) -> Option<f64> {
    let rows = chosen.trajectory.actions.len();
    chosen.trajectory.interval_s(0, rows).ok().flatten().map(|interval_s| interval_s * rows as f64)
}
