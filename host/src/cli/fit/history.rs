//! The provenance of a fitted gait, and the file that it is written to.
//!
//! Does not depend on the fit.

use super::Args;
use crate::cli::Failure;
use crate::cli::explain::{failure, file_cause};
use crate::cli::recording::Chosen;
use crate::gait::fit::Seam;
use crate::gait::gait_file::{Provenance, Source};
use crate::run_folder;
use std::path::{Path, PathBuf};

pub fn provenance(args: &Args, chosen: &Chosen, seam: Seam) -> Provenance {
    let path = &chosen.path;
    let trajectory = &chosen.trajectory;
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let trained = trajectory.is_own_stride && folder.join(run_folder::POLICY).is_file();
    let run = folder.canonicalize().ok().and_then(|f| Some(f.file_name()?.to_string_lossy().into_owned()));
    let seed = args.seed.or_else(|| trained.then(|| seed_of_run(folder)).flatten());
    // Not `args`: it panics on a path that is not UTF-8.
    let arguments = std::env::args_os().skip(1).map(|a| a.to_string_lossy().into_owned());
    let known = Provenance::of(if trained { Source::Trained } else { Source::Fitted });
    let known = match &chosen.robot {
        Some(robot) => known.with_robot(robot),
        None => known,
    };
    Provenance {
        file: Some(path.display().to_string()),
        file_sha256: Some(trajectory.sha256.clone()),
        rows: Some(format!("{}..{}", chosen.rows.start, chosen.rows.end)),
        seam: Some(seam.name().into()),
        time_stretch: Some(chosen.time_stretch),
        run: run.filter(|_| trained),
        seed,
        leg_scale: chosen.robot.as_ref().map(|robot| robot.geometry.leg_scale),
        command: Some(std::iter::once("host".to_owned()).chain(arguments).collect::<Vec<_>>().join(" ")),
        ..known
    }
}

/// The seed in a run's configuration.
fn seed_of_run(folder: &Path) -> Option<u64> {
    let text = std::fs::read_to_string(folder.join(run_folder::CONFIG)).ok()?;
    let table: toml::Table = text.parse().ok()?;
    table.get("seed")?.as_integer()?.try_into().ok()
}

/// Where a gait goes.
pub struct Destination {
    pub out: PathBuf,
    /// The folder that is the last run's once the gait is in it.
    pub latest: Option<PathBuf>,
}

pub fn destination(args: &Args, chosen: &Chosen) -> Result<Destination, Failure> {
    let machine = |e: run_folder::FileError| failure(file_cause(&e), e);
    if let Some(out) = &args.out {
        if let Some(folder) = out.parent() {
            std::fs::create_dir_all(folder)
                .map_err(run_folder::FileError::on("create", folder))
                .map_err(machine)?;
        }
        return Ok(Destination { out: out.clone(), latest: None });
    }
    if chosen.trajectory.is_own_stride {
        let out = chosen.path.with_file_name(run_folder::GAIT);
        return Ok(Destination { out, latest: None });
    }
    let folder = run_folder::create("fit").map_err(machine)?;
    Ok(Destination { out: folder.join(run_folder::GAIT), latest: Some(folder) })
}
