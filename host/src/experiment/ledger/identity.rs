//! What decides a study, and whether two studies are the same.
//!
//! Holds the parts of that identity. Does not depend on trials.

use super::{LedgerError, PLAN};
use crate::experiment::plan::Plan;
use crate::experiment::study::Venue;
use crate::robot::LegScale;
use crate::run_folder::FileError;
use serde::{Deserialize, Serialize};
use sha2::{Digest as _, Sha256};
use std::path::Path;

/// What decides a study: its plan, where it is walked, and by which gaits.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Identity {
    /// Methods, amplifications, trials.
    pub plan: Plan,
    /// Where.
    pub venue: Venue,
    /// SHA-256 of each robot's description.
    pub robots: Vec<String>,
    /// Method, legs and SHA-256 of each gait.
    pub gaits: Vec<(String, LegScale, String)>,
    /// SHA-256 of the authors' tables, where they take part.
    pub reference: Option<String>,
}

/// SHA-256 in hexadecimal digits.
#[must_use]
pub fn sha256(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}

/// Refuses a folder that holds another study, as far as can be told before there are gaits.
///
/// # Errors
/// [`LedgerError`] if it does, or its plan is damaged.
pub fn refuse_another(
    folder: &Path,
    plan: &Plan,
    venue: Venue,
    robots: &[String],
    reference: Option<&String>,
) -> Result<(), LedgerError> {
    let path = folder.join(PLAN);
    let Some(found) = plan_at(&path)? else { return Ok(()) };
    let asked = Identity {
        plan: plan.clone(),
        venue,
        robots: robots.to_vec(),
        gaits: found.gaits.clone(),
        reference: reference.cloned(),
    };
    difference(&found, &asked).map_or(Ok(()), |what| Err(LedgerError::Other { path, what }))
}

/// The plan in a folder, if there is one.
pub fn plan_at(path: &Path) -> Result<Option<Identity>, LedgerError> {
    match std::fs::read(path) {
        Ok(bytes) => serde_json::from_slice(&bytes)
            .map(Some)
            .map_err(|source| LedgerError::Plan { path: path.to_owned(), source }),
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(None),
        Err(error) => Err(FileError::on("read", path)(error).into()),
    }
}

/// In what they differ, if they do.
pub fn difference(found: &Identity, asked: &Identity) -> Option<&'static str> {
    let differs = [
        ("places of walking", found.venue != asked.venue),
        ("methods", found.plan.methods != asked.plan.methods),
        ("amplifications", found.plan.amplifications != asked.plan.amplifications),
        ("numbers of trials", found.plan.trials != asked.plan.trials),
        ("lengths of trials", found.plan.duration_s != asked.plan.duration_s),
        ("seeds", found.plan.seed != asked.plan.seed),
        ("perturbations", found.plan.robots_differ != asked.plan.robots_differ),
        ("masses", found.plan.mass_kg != asked.plan.mass_kg),
        ("robots", found.robots != asked.robots),
        ("gaits", found.gaits != asked.gaits),
        ("reference tables", found.reference != asked.reference),
    ];
    differs.into_iter().find(|(_, differs)| *differs).map(|(what, _)| what)
}
