//! `host robot export`: the simulated body for other simulators.

use crate::cli::explain::failure;
use crate::cli::{Cause, Failure};
use crate::robot::Robot;
use crate::robot::export::{Format, export};
use crate::robot::sketch::file_stem;
use crate::run_folder;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Write a robot's body as it is simulated, for other simulators.
///
/// Leg scale, neutral slope, masses and foot radius of robot.toml are applied; joints read 0 at
/// neutral and turn as far as the tighter of their range and the servo's end stop.
#[derive(Debug, clap::Args)]
#[command(group = clap::ArgGroup::new("format").required(true).args(["mjcf", "urdf"]))]
pub struct Args {
    /// The robot's folder, or the robot.toml in it
    folder: PathBuf,
    /// For MuJoCo, with the servos as actuators
    #[arg(long)]
    mjcf: bool,
    /// For ROS and others
    #[arg(long)]
    urdf: bool,
    /// Where to [default: NAME.xml or NAME.urdf here; `-` prints it]
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

#[derive(Debug, Error)]
enum ExportError {
    #[error("{} is the drawing of the robot itself: name another file with --out", .path.display())]
    OwnDrawing { path: PathBuf },
}

pub fn run(args: Args) -> Result<(), Failure> {
    let robot = Robot::load(&args.folder).map_err(|error| failure(Cause::Input, error))?;
    let format = if args.urdf { Format::Urdf } else { Format::Mjcf };
    let name = format!("{}.{}", file_stem(&robot.name), format.extension());
    let path = args.out.unwrap_or_else(|| PathBuf::from(&name));
    let file = path.file_name().map_or(name, |file| file.to_string_lossy().into_owned());
    let exported = export(&robot, format, &file);
    if path == Path::new("-") {
        println!("{}", exported.text.trim_end());
        return Ok(());
    }
    let folder = if args.folder.is_dir() {
        args.folder
    } else {
        args.folder.parent().unwrap_or(Path::new("")).to_owned()
    };
    let same = |a: &Path, b: &Path| matches!((a.canonicalize(), b.canonicalize()), (Ok(a), Ok(b)) if a == b);
    if same(&path, &folder.join(&robot.model.file)) {
        return Err(failure(Cause::Usage, ExportError::OwnDrawing { path }));
    }
    run_folder::write(&path, exported.text.as_bytes()).map_err(|error| failure(Cause::Machine, error))?;
    println!("{}: {} as it is simulated, {:.3} kg", path.display(), robot.name, robot.mass_kg());
    Ok(())
}
