//! Where a run keeps its artefacts, and how `runs/latest` finds it.
//!
//! Holds the file names. Does not depend on what is in the files. Every write goes
//! to a temporary file beside its target and is renamed: a full disk leaves the
//! old file, never half a new one.

use std::io::Write as _;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Where runs are kept, relative to the working directory.
pub const RUNS: &str = "runs";
/// The link to the run that commands use when none is named.
pub const LATEST: &str = "runs/latest";

/// The resolved training configuration.
pub const CONFIG: &str = "config.toml";
/// Folder of the robot that the run was made for.
pub const ROBOT: &str = "robot";
/// One row an evaluation: steps, rewards, losses, speed.
pub const LEARNING_CURVE: &str = "train.csv";
/// The best policy by evaluation reward.
pub const POLICY: &str = "policy.safetensors";
/// The average stride, in action units.
pub const TRAJECTORY: &str = "trajectory.csv";
/// The readable gait.
pub const GAIT: &str = "gait.toml";
/// The same gait as the robot takes it.
pub const GAIT_BYTES: &str = "gait.bin";
/// One row a measured trial.
pub const TRIALS: &str = "trials.csv";
/// The virtual robot's ground truth, JSON lines.
pub const TRUTH: &str = "truth.jsonl";
/// Result of a run.
pub const SUMMARY: &str = "summary.json";

/// What went wrong with a file or folder of a run.
#[derive(Debug, Error)]
#[error("cannot {action} {path}")]
pub struct FileError {
    /// `read`, `write`, `create`, `link`.
    pub action: &'static str,
    /// Which.
    pub path: PathBuf,
    /// Why.
    pub source: std::io::Error,
}

impl FileError {
    /// For `map_err` on the action on a path.
    pub fn on(action: &'static str, path: &Path) -> impl FnOnce(std::io::Error) -> Self {
        let path = path.to_owned();
        move |source| Self { action, path, source }
    }
}

/// Creates `runs/<local time>-<label>`, or with a number appended if taken.
///
/// # Errors
/// [`FileError`] if no folder can be made there.
pub fn create(label: &str) -> Result<PathBuf, FileError> {
    let stamp = jiff::Zoned::now().strftime("%Y%m%d-%H%M%S").to_string();
    let runs = Path::new(RUNS);
    std::fs::create_dir_all(runs).map_err(FileError::on("create", runs))?;
    for attempt in 1.. {
        let suffix = if attempt == 1 { String::new() } else { format!("-{attempt}") };
        let folder = runs.join(format!("{stamp}-{label}{suffix}"));
        match std::fs::create_dir(&folder) {
            Ok(()) => return Ok(folder),
            Err(error) if error.kind() == std::io::ErrorKind::AlreadyExists => {}
            Err(error) => return Err(FileError::on("create", &folder)(error)),
        }
    }
    unreachable!("the loop has no end of its own")
}

/// Points `runs/latest` at `folder`; a folder outside `runs` is linked by its absolute path.
///
/// # Errors
/// [`FileError`] if the link cannot be replaced.
pub fn make_latest(folder: &Path) -> Result<(), FileError> {
    let link = Path::new(LATEST);
    std::fs::create_dir_all(RUNS).map_err(FileError::on("create", Path::new(RUNS)))?;
    let target = folder.canonicalize().map_err(FileError::on("link", folder))?;
    let runs = Path::new(RUNS).canonicalize().map_err(FileError::on("link", link))?;
    let target = target.strip_prefix(&runs).map(Path::to_owned).unwrap_or(target);
    let fresh = Path::new(RUNS).join(format!(".latest-{}", std::process::id()));
    let _ = std::fs::remove_file(&fresh);
    std::os::unix::fs::symlink(&target, &fresh).map_err(FileError::on("link", &fresh))?;
    std::fs::rename(&fresh, link).map_err(FileError::on("link", link))
}

/// Writes a whole file or leaves the old one.
///
/// # Errors
/// [`FileError`] naming the file, with the old contents still in place.
pub fn write(path: &Path, contents: &[u8]) -> Result<(), FileError> {
    write_all(&[(path, contents)])
}

/// Writes files that belong together, or leaves all the old ones: none is
/// renamed before each is on the disk.
///
/// # Errors
/// [`FileError`] naming the file. The old contents are still in place, unless
/// the disk refuses a rename after it allowed another.
pub fn write_all(files: &[(&Path, &[u8])]) -> Result<(), FileError> {
    let mut staged = Vec::with_capacity(files.len());
    for &(path, contents) in files {
        // The one thing that a rename within a folder usually fails of.
        if path.is_dir() {
            return Err(FileError::on("write", path)(std::io::ErrorKind::IsADirectory.into()));
        }
        staged.push((path, stage(path, contents).map_err(FileError::on("write", path))?));
    }
    for (path, file) in staged {
        file.persist(path).map_err(|error| FileError::on("write", path)(error.error))?;
    }
    Ok(())
}

/// The contents in a temporary file beside `path`.
fn stage(path: &Path, contents: &[u8]) -> std::io::Result<tempfile::NamedTempFile> {
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut file = tempfile::NamedTempFile::new_in(folder)?;
    file.write_all(contents)?;
    file.as_file().sync_all()?;
    // Temporary files are private; what a run leaves is for everybody to read.
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt as _;
        file.as_file().set_permissions(std::fs::Permissions::from_mode(0o644))?;
    }
    Ok(file)
}
