//! What a study's folder remembers, so that it can go on in the middle.
//!
//! Owns `plan.json` (what decides every trial), `trials.csv` (every trial so
//! far) and their agreement. Refuses to go on with another plan, trials of two
//! plans make no study, and with trials that this plan cannot have had.

mod identity;

pub use identity::{Identity, refuse_another};

use super::method::Method;
use super::trial::{Place, Trial, mark_reversed};
use crate::run_folder::{self, FileError};
use identity::{difference, plan_at};
use std::fs::{File, TryLockError};
use std::path::{Path, PathBuf};
use thiserror::Error;

/// What decides every trial.
pub const PLAN: &str = "plan.json";

/// Why a study's folder cannot be used.
#[derive(Debug, Error)]
pub enum LedgerError {
    /// The disk's reason.
    #[error(transparent)]
    File(#[from] FileError),
    /// Something else's plan.
    #[error("{path} is no plan of a study")]
    Plan {
        /// Which file.
        path: PathBuf,
        /// Where and why.
        source: serde_json::Error,
    },
    /// A plan that differs.
    #[error("{path} is the plan of another study: its {what} differ")]
    Other {
        /// Which file.
        path: PathBuf,
        /// In what.
        what: &'static str,
    },
    /// Trials of nobody knows what.
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
    /// Another program goes on with it.
    #[error("{path} is in use by another call of this command")]
    Busy {
        /// Its plan.
        path: PathBuf,
    },
    /// A table that was edited.
    #[error("{path} is no table of trials")]
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
        let path = folder.join(run_folder::TRIALS);
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
        let held = File::open(&plan).map_err(FileError::on("open", &plan))?;
        match held.try_lock() {
            Err(TryLockError::WouldBlock) => return Err(LedgerError::Busy { path: plan }),
            // Where the disk knows no locks, whoever calls twice is on their own.
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

fn read(path: &Path) -> Result<Vec<Trial>, LedgerError> {
    let on_csv = |source| LedgerError::Trials { path: path.to_owned(), source };
    let mut reader = csv::Reader::from_path(path).map_err(on_csv)?;
    reader.deserialize().collect::<Result<_, _>>().map_err(on_csv)
}

/// Refuses what an editor, or another study, left in the table.
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
        return Some(format!("{} {leg} L {amplification}x has a trial {number} already", method.name()));
    }
    let own = identity.gaits.iter().find(|(name, of, _)| name == method.name() && of == leg);
    let is_authors = matches!(method, Method::AuthorsOriginal | Method::AuthorsPsto);
    match own {
        Some((.., sha256)) if *sha256 == trial.gait_sha256 => {}
        None if is_authors && identity.reference.is_some() => {}
        _ => return Some(format!("no gait of this study is {} {leg} L with that SHA-256", method.name())),
    }
    let figures = [trial.dx_m, trial.dy_m, trial.distance_m, trial.speed_m_s, trial.power_w];
    let figures = figures.into_iter().chain([trial.cost_of_transport, trial.turned_deg]).flatten();
    let all = || figures.clone().chain([trial.duration_s]);
    if trial.mark.is_none() && !all().all(f64::is_finite) {
        return Some("a trial that counts has a number that is none".into());
    }
    let counts = trial.speed_m_s.is_some() && trial.cost_of_transport.is_some();
    if trial.mark.is_none() && !counts {
        return Some("a trial that counts has no speed or no cost of transport".into());
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiment::plan::Plan;
    use crate::experiment::study::Venue;
    use crate::experiment::trial::{Mark, Raw};

    const PLACE: Place = Place { method: Method::Psto, leg: 0.6, amplification: 1.4 };

    fn identity() -> Identity {
        let gaits = vec![("psto".to_owned(), 0.6, "abc".to_owned())];
        Identity { plan: Plan::paper(3, 0), venue: Venue::Twin, robots: Vec::new(), gaits, reference: None }
    }

    fn trial(number: u32, dx_m: f64) -> Trial {
        let raw = Raw {
            duration_s: 12.0,
            energy_j: 9.1,
            displacement_m: Some([dx_m, 0.1]),
            mass_kg: 0.85,
            ..Raw::default()
        };
        Trial::of(PLACE, number, &raw, "abc")
    }

    #[test]
    fn a_study_goes_on_where_it_was_left_with_the_same_numbers() {
        let folder = tempfile::tempdir().unwrap();
        let mut ledger = Ledger::open(folder.path(), &identity()).unwrap();
        ledger.add(vec![trial(0, 1.0 / 3.0), trial(2, 1.5)]).unwrap();
        drop(ledger);

        let mut again = Ledger::open(folder.path(), &identity()).unwrap();

        assert_eq!(again.missing(PLACE, 3), [1]);
        assert_eq!(again.missing(Place { leg: 1.0, ..PLACE }, 3), [0, 1, 2]);
        assert_eq!(again.trials, vec![trial(0, 1.0 / 3.0), trial(2, 1.5)]);
        again.add(vec![trial(1, -0.5)]).unwrap();
        let trials = again.close().unwrap();
        assert_eq!(trials[2].mark, Some(Mark::Reversed));
        assert_eq!(read(&folder.path().join(run_folder::TRIALS)).unwrap(), trials);
    }

    #[test]
    fn trials_that_the_plan_cannot_have_had_are_refused_with_their_line() {
        let folder = tempfile::tempdir().unwrap();
        let refusal = |trials: Vec<Trial>| {
            let mut ledger = Ledger::open(folder.path(), &identity()).unwrap();
            ledger.trials = trials;
            ledger.save().unwrap();
            drop(ledger);
            let error = Ledger::open(folder.path(), &identity()).unwrap_err().to_string();
            std::fs::remove_file(folder.path().join(run_folder::TRIALS)).unwrap();
            error
        };

        assert!(refusal(vec![trial(77, 1.0)]).ends_with("line 2: trial 77 of a plan of 3, counted from 0"));
        let twice = refusal(vec![trial(1, 1.0), trial(0, 1.0), trial(1, 1.2)]);
        assert!(twice.ends_with("line 4: psto 0.6 L 1.4x has a trial 1 already"), "{twice}");
        let of_another = Trial { gait_sha256: "abd".into(), ..trial(0, 1.0) };
        assert!(refusal(vec![of_another]).contains("no gait of this study is psto 0.6 L"));
        let no_number = Trial { cost_of_transport: Some(f64::NAN), ..trial(0, 1.0) };
        assert!(refusal(vec![no_number]).contains("a number that is none"));
        let no_speed = Trial { speed_m_s: None, ..trial(0, 1.0) };
        assert!(refusal(vec![no_speed]).contains("no speed"));
    }

    #[test]
    fn trials_without_their_plan_and_a_study_that_is_in_use_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let mut ledger = Ledger::open(folder.path(), &identity()).unwrap();
        ledger.add(vec![trial(0, 1.0)]).unwrap();

        assert!(matches!(Ledger::open(folder.path(), &identity()), Err(LedgerError::Busy { .. })));
        drop(ledger);
        std::fs::remove_file(folder.path().join(PLAN)).unwrap();
        assert!(matches!(Ledger::open(folder.path(), &identity()), Err(LedgerError::NoPlan { .. })));
    }

    #[test]
    fn another_plan_is_refused_by_what_differs() {
        let folder = tempfile::tempdir().unwrap();
        Ledger::open(folder.path(), &identity()).unwrap();
        let refusal = |identity: &Identity| match Ledger::open(folder.path(), identity) {
            Err(LedgerError::Other { what, .. }) => what,
            other => panic!("{other:?}"),
        };

        assert_eq!(refusal(&Identity { plan: Plan::paper(4, 0), ..identity() }), "numbers of trials");
        assert_eq!(refusal(&Identity { plan: Plan::paper(3, 1), ..identity() }), "seeds");
        assert_eq!(refusal(&Identity { venue: Venue::Robot, ..identity() }), "places of walking");
        assert_eq!(refusal(&Identity { gaits: Vec::new(), ..identity() }), "gaits");
        std::fs::write(folder.path().join(PLAN), "{").unwrap();
        assert!(matches!(Ledger::open(folder.path(), &identity()), Err(LedgerError::Plan { .. })));
    }
}
