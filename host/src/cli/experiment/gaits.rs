//! The gaits of a study, in its folder: those of the program, made anew, or the user's own.

use super::request::Request;
use super::{ExperimentError, prepare};
use crate::experiment::ledger::LedgerError;
use crate::experiment::materials::{self, Materials, MaterialsError};
use crate::experiment::method::Method;
use crate::gait::gait_file::GaitFile;
use crate::robot::Robot;
use crate::run_folder::FileError;
use std::path::Path;

/// Folders for gaits that came with the program, and for those that were made anew.
const BUNDLED: &str = "gaits";
const RETRAINED: &str = "retrained";

/// The gaits for every pair of legs; what the folder lacks is copied there or made.
///
/// # Errors
/// [`ExperimentError`] if a gait cannot be read or made, or the folder has another of its name.
pub fn gaits(request: &Request, folder: &Path) -> Result<Vec<Materials>, ExperimentError> {
    let plan = &request.plan;
    let of_robot = |(k, robot): (usize, &Robot)| {
        let parent = folder.join(if request.retraining.is_some() { RETRAINED } else { BUNDLED });
        let gaits = parent.join(materials::folder_name(robot));
        std::fs::create_dir_all(&gaits).map_err(FileError::on("create", &gaits))?;
        if let Some(retraining) = request.retraining {
            prepare::make(retraining, &plan.methods, robot, folder, &gaits)?;
        } else if plan.methods.iter().any(|&method| method != Method::Yours) {
            materials::unpack(robot, &gaits)?;
        }
        if let Some(path) = request.own_gait.as_ref().filter(|_| k == 0) {
            copy_own(path, &gaits)?;
        }
        let read = materials::read(&gaits, robot, &plan.methods)?;
        let own = read.gaits.iter().find(|material| material.note.method == Method::Yours);
        if let Some(remark) = own.and_then(|material| material.note.remark.as_ref()) {
            eprintln!("warning: the gait of --gait is {remark}");
        }
        Ok(read)
    };
    request.robots.iter().enumerate().map(of_robot).collect()
}

/// Copies the gait of `--gait` to a folder of gaits; one that is there must be the same.
fn copy_own(path: &Path, gaits: &Path) -> Result<(), ExperimentError> {
    let gait = GaitFile::load(path).map_err(MaterialsError::from)?;
    let own = gaits.join(materials::file_name(Method::Yours));
    let begun = own.exists().then(|| GaitFile::load(&own)).transpose().map_err(MaterialsError::from)?;
    match begun {
        None => Ok(gait.save(&own).map_err(MaterialsError::from)?),
        Some(begun) if begun.joints == gait.joints && begun.period_s == gait.period_s => Ok(()),
        Some(_) => Err(LedgerError::Other { path: own, what: "gait" }.into()),
    }
}
