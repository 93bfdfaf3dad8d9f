//! The files of a study from which an interrupted one is resumed.
//!
//! Holds `plan.json` (what decides every trial), `study-trials.csv` (every trial
//! so far) and their agreement. A study is not resumed with another plan, nor
//! with trials that its plan cannot have had. Does not depend on how trials are
//! walked.

mod identity;

pub use identity::{Identity, refuse_another, sha256};

use super::method::Origin;
use super::trial::{Place, Trial, mark_reversed};
use crate::run_folder::{self, FileError};
use identity::{difference, plan_at};
use std::fs::{File, TryLockError};
use std::path::{Path, PathBuf};
use thiserror::Error;

/// What decides every trial.
pub const PLAN: &str = "plan.json";
/// Every trial so far. `trials.csv` is another table, of `host measure`.
pub const TRIALS: &str = "study-trials.csv";
/// What earlier versions called it.
const OLD_TRIALS: &str = "trials.csv";

/// Why a study's folder cannot be used.
#[derive(Debug, Error)]
pub enum LedgerError {
    /// The disk's reason.
    #[error(transparent)]
    File(#[from] FileError),
    /// A plan that cannot be read.
    #[error("{path} is not the plan of a study")]
    Plan {
        /// Which file.
        path: PathBuf,
        /// Where and why.
        source: serde_json::Error,
    },
    /// The plan of another study.
    #[error("{path} is the plan of another study: its {what} differ")]
    Other {
        /// Which file.
        path: PathBuf,
        /// What differs.
        what: &'static str,
    },
    /// Trials without their plan.
    #[error("{path} has trials, but their plan, {PLAN}, is gone")]
    NoPlan {
        /// Which file.
        path: PathBuf,
    },
    /// A trial that cannot be one of this study's.
    #[error("{path}, line {line}: {reason}")]
    Trial {
        /// Which file.
        path: PathBuf,
        /// Where, the heading being line 1.
        line: usize,
        /// Why not.
        reason: String,
    },
    /// Another program has it open.
    #[error("{path} is in use by another call of this command")]
    Busy {
        /// Its plan.
        path: PathBuf,
    },
    /// The table of an earlier version.
    #[error(
        "{path} has the trials of this study, under the name that an earlier version gave it; it is {TRIALS} now"
    )]
    OldName {
        /// Which file.
        path: PathBuf,
    },
    /// A table that cannot be read.
    #[error("{path} is not a table of a study's trials")]
    Trials {
        /// Which file.
        path: PathBuf,
        /// Where and why.
        source: csv::Error,
    },
}

/// The trials of a study, on disk after every change.
#[derive(Debug)]
pub struct Ledger {
    path: PathBuf,
    trials: Vec<Trial>,
    /// Locked as long as it is open: two calls would write over each other's trials.
    _plan: File,
}

impl Ledger {
    /// Opens a folder for a study, new or begun.
    ///
    /// # Errors
    /// [`LedgerError`] if it holds another study, or a file of it is damaged.
    pub fn open(folder: &Path, identity: &Identity) -> Result<Self, LedgerError> {
        let plan = folder.join(PLAN);
        let path = folder.join(TRIALS);
        match plan_at(&plan)? {
            Some(found) => {
                if let Some(what) = difference(&found, identity) {
                    return Err(LedgerError::Other { path: plan, what });
                }
            }
            None if path.exists() => return Err(LedgerError::NoPlan { path }),
            None => {
                let text = serde_json::to_string_pretty(identity)
                    .map_err(|source| LedgerError::Plan { path: plan.clone(), source })?;
                run_folder::write(&plan, format!("{text}\n").as_bytes())?;
            }
        }
        let old = folder.join(OLD_TRIALS);
        if !path.exists() && is_old_table(&old) {
            return Err(LedgerError::OldName { path: old });
        }
        let held = File::open(&plan).map_err(FileError::on("open", &plan))?;
        match held.try_lock() {
            Err(TryLockError::WouldBlock) => return Err(LedgerError::Busy { path: plan }),
            // File systems without locks cannot tell.
            Ok(()) | Err(TryLockError::Error(_)) => {}
        }
        let trials = if path.exists() { read(&path)? } else { Vec::new() };
        check(&path, &trials, identity)?;
        Ok(Self { path, trials, _plan: held })
    }

    /// Numbers of a condition's trials that are still to be walked.
    #[must_use]
    pub fn missing(&self, place: Place, trials: u32) -> Vec<u32> {
        let walked = |number: &u32| self.trials.iter().any(|t| t.place() == place && t.trial == *number);
        (0..trials).filter(|number| !walked(number)).collect()
    }

    /// Notes trials.
    ///
    /// # Errors
    /// [`LedgerError`], the table being as it was.
    pub fn add(&mut self, trials: Vec<Trial>) -> Result<(), LedgerError> {
        self.trials.extend(trials);
        self.save()
    }

    fn save(&self) -> Result<(), LedgerError> {
        let on_csv = |source| LedgerError::Trials { path: self.path.clone(), source };
        let mut writer = csv::Writer::from_writer(Vec::new());
        for trial in &self.trials {
            writer.serialize(trial).map_err(on_csv)?;
        }
        // Into memory: nothing to fail.
        let bytes = writer.into_inner().unwrap_or_default();
        Ok(run_folder::write(&self.path, &bytes)?)
    }

    /// All trials, those against their direction marked, in the table as well.
    ///
    /// # Errors
    /// [`LedgerError`] if the marks cannot be written.
    pub fn close(mut self) -> Result<Vec<Trial>, LedgerError> {
        mark_reversed(&mut self.trials);
        if !self.trials.is_empty() {
            self.save()?;
        }
        Ok(self.trials)
    }
}

/// Whether a file is a table of a study's trials, and not of `host measure`'s.
fn is_old_table(path: &Path) -> bool {
    std::fs::read_to_string(path).is_ok_and(|text| text.starts_with("method,leg,amplification,"))
}

fn read(path: &Path) -> Result<Vec<Trial>, LedgerError> {
    let on_csv = |source| LedgerError::Trials { path: path.to_owned(), source };
    let mut reader = csv::Reader::from_path(path).map_err(on_csv)?;
    reader.deserialize().collect::<Result<_, _>>().map_err(on_csv)
}

/// Refuses trials that an editor, or another study, left in the table.
fn check(path: &Path, trials: &[Trial], identity: &Identity) -> Result<(), LedgerError> {
    for (k, trial) in trials.iter().enumerate() {
        if let Some(reason) = foreign(trial, &trials[..k], identity) {
            return Err(LedgerError::Trial { path: path.to_owned(), line: k + 2, reason });
        }
    }
    Ok(())
}

/// Why a trial is not one of this study's.
fn foreign(trial: &Trial, before: &[Trial], identity: &Identity) -> Option<String> {
    let plan = &identity.plan;
    let Trial { method, leg, amplification, trial: number, .. } = trial;
    if *number >= plan.trials {
        return Some(format!("trial {number} of a plan of {}, counted from 0", plan.trials));
    }
    if before.iter().any(|other| other.place() == trial.place() && other.trial == *number) {
        return Some(format!("{} {leg} {amplification}x has a trial {number} already", method.name()));
    }
    let own = identity.gaits.iter().find(|(name, of, _)| name == method.name() && of == leg);
    let is_authors = matches!(method.spec().origin, Origin::AuthorsTables(_));
    match own {
        Some((.., sha256)) if *sha256 == trial.gait_sha256 => {}
        None if is_authors && identity.reference.is_some() => {}
        _ => return Some(format!("no gait of this study is {} {leg} with that SHA-256", method.name())),
    }
    let figures = [trial.dx_m, trial.dy_m, trial.distance_m, trial.speed_m_s, trial.power_w];
    let figures = figures.into_iter().chain([trial.cost_of_transport, trial.turned_deg]).flatten();
    let all = || figures.clone().chain([trial.duration_s]);
    if trial.mark.is_none() && !all().all(f64::is_finite) {
        return Some("a trial that counts has a number that is NaN or infinite".into());
    }
    let counts = trial.speed_m_s.is_some() && trial.cost_of_transport.is_some();
    if trial.mark.is_none() && !counts {
        return Some("a trial that counts has no speed or no cost of transport".into());
    }
    None
}

#[cfg(test)]
mod tests;
