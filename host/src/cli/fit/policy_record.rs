//! Reads `record.json` beside a run's own trajectory.
//!
//! Holds the check that both are of one recording. Does not depend on the learner.
//! Every error is only a warning to the user: a gait can be fitted without the record.

use crate::cli::recording::Chosen;
use crate::gait::policy_record::{PolicyRecord, RECORD, RecordSummary};
use crate::run_folder::FileError;
use std::path::PathBuf;
use thiserror::Error;

/// Why a description is not used.
#[derive(Debug, Error)]
pub enum BadRecord {
    #[error(transparent)]
    File(#[from] FileError),
    #[error("{path} is not a record of a policy; `host record` writes it again")]
    Parse { path: PathBuf, source: serde_json::Error },
    #[error("{path} is of another trajectory than the one beside it; `host record` writes both again")]
    Other { path: PathBuf },
}

/// The record of the trajectory, if there is one and all of the trajectory was taken.
pub fn beside(chosen: &Chosen) -> Result<Option<RecordSummary>, BadRecord> {
    let path = chosen.path.with_file_name(RECORD);
    if !chosen.is_whole_stride || !path.exists() {
        return Ok(None);
    }
    let text = std::fs::read(&path).map_err(FileError::on("read", &path))?;
    let record: PolicyRecord =
        serde_json::from_slice(&text).map_err(|source| BadRecord::Parse { path: path.clone(), source })?;
    if record.trajectory_sha256 != chosen.trajectory.sha256 {
        return Err(BadRecord::Other { path });
    }
    Ok(Some(record.summary))
}
