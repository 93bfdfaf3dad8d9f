//! Flags and files that the commands which search for a gait share.
//!
//! Holds the robot, the name and the folder of a new gait. A folder in which another
//! gait would be replaced is an error. Does not depend on how the gait is found.

use super::explain::{failure, file_cause};
use super::{Cause, Failure};
use crate::gait::gait_file::{GaitFile, JointSeries, Provenance, Source, short_name};
use crate::robot::{LegScale, Robot};
use crate::run_folder::{self, FileError};
use protocol::JOINT_COUNT;
use std::path::PathBuf;
use thiserror::Error;

/// Name of the robot that comes with the program.
const ANT: &str = "Ant";

/// The flags.
#[derive(Debug, clap::Args)]
pub struct NewGait {
    /// Shins: 1.0 is 23 cm, 0.6 is 13.8 cm
    #[arg(long, default_value = "1", value_name = "SCALE")]
    leg: LegScale,
    /// Folder of a robot other than the Ant
    #[arg(long, value_name = "FOLDER", conflicts_with = "leg")]
    robot: Option<PathBuf>,
    /// Random seed
    #[arg(long, default_value_t = 0, value_parser = super::seed())]
    pub seed: u64,
    /// What the robot will call the gait, up to 16 characters [default: from leg and seed]
    #[arg(long)]
    pub name: Option<String>,
    /// Folder for gait and report [default: a new one in runs; runs/latest stays the last
    /// trained run]
    #[arg(long, value_name = "FOLDER")]
    out: Option<PathBuf>,
}

#[derive(Debug, Error)]
enum NewGaitError {
    #[error("--name is {name:?}; a name is 1 to {} printable ASCII characters", protocol::Name::CAPACITY)]
    Name { name: String },
    #[error("{} exists already: name another folder with --out", .path.display())]
    Taken { path: PathBuf },
}

impl NewGait {
    /// Refuses now what would be refused after the search.
    pub fn check(&self) -> Result<(), Failure> {
        let usage = |error: NewGaitError| failure(Cause::Usage, error);
        if let Some(name) = self.name.as_ref().filter(|name| protocol::Name::new(name).is_none()) {
            return Err(usage(NewGaitError::Name { name: name.clone() }));
        }
        // A trained run, too, would no longer be what it says.
        let files = [run_folder::GAIT, run_folder::CONFIG, run_folder::ROBOT];
        let mut taken = self.out.iter().flat_map(|folder| files.map(|file| folder.join(file)));
        taken.find(|path| path.exists()).map_or(Ok(()), |path| Err(usage(NewGaitError::Taken { path })))
    }

    /// The robot that the gait is for.
    pub fn robot(&self) -> Result<Robot, Failure> {
        let robot = match &self.robot {
            Some(folder) => Robot::load(folder),
            None => Robot::ant(self.leg),
        };
        robot.map_err(|error| failure(Cause::Input, error))
    }

    /// Makes the folder, with the robot in it: one that cannot be written costs no search.
    pub fn folder(&self, command: &str, robot: &Robot) -> Result<PathBuf, Failure> {
        let folder = match &self.out {
            Some(folder) => {
                std::fs::create_dir_all(folder).map_err(FileError::on("create", folder)).map_err(machine)?;
                folder.clone()
            }
            None => run_folder::create(command).map_err(machine)?,
        };
        robot.save(&folder.join(run_folder::ROBOT)).map_err(|error| failure(Cause::Machine, error))?;
        Ok(folder)
    }

    /// The name that was given, else one made of `prefix`, leg and seed.
    pub fn name_or(&self, prefix: &str, robot: &Robot) -> String {
        let usual = || usual(prefix, robot, &format!("-seed{}", self.seed));
        self.name.clone().unwrap_or_else(usual)
    }

    /// The same without the seed, for several gaits of one search.
    pub fn names_or(&self, prefix: &str, robot: &Robot) -> String {
        let usual = || match robot.name.as_str() {
            ANT => usual(prefix, robot, ""),
            // Room for a speed behind it.
            name => short_name(&format!("{prefix}-"), &name.chars().take(7).collect::<String>(), ""),
        };
        self.name.clone().unwrap_or_else(usual)
    }

    /// The file; a name that is too long for the robot loses its end.
    pub fn file(
        &self,
        robot: &Robot,
        name: &str,
        source: Source,
        period_s: f64,
        unit_deg: f64,
        joints: [JointSeries; JOINT_COUNT],
    ) -> GaitFile {
        let arguments = std::env::args_os().skip(1).map(|a| a.to_string_lossy().into_owned());
        let command: Vec<String> = std::iter::once("host".to_owned()).chain(arguments).collect();
        let provenance = Provenance {
            seed: Some(self.seed),
            seam: Some("continuous".into()),
            leg_scale: Some(robot.geometry.leg_scale),
            command: Some(command.join(" ")),
            ..Provenance::of(source).with_robot(robot)
        };
        let name = name.chars().take(protocol::Name::CAPACITY).collect();
        GaitFile { name, period_s, unit_deg, provenance, joints }
    }
}

/// The Ant's legs tell its gaits apart, other robots their names.
fn usual(prefix: &str, robot: &Robot, after: &str) -> String {
    match robot.name.as_str() {
        ANT => format!("{prefix}-{}L{after}", robot.geometry.leg_scale.value()),
        name => short_name(&format!("{prefix}-"), name, after),
    }
}

/// A file that could not be written.
pub fn machine(error: FileError) -> Failure {
    failure(file_cause(&error), error)
}
