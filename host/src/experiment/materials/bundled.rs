//! The gaits that come with the program, for both lengths of the Ant's legs.
//!
//! Holds the list of their files, which a new method's gait is added to. Does not
//! depend on what the files say.

use super::{MADE, MaterialsError};
use crate::robot::LegScale;
use crate::robot::Robot;
use crate::run_folder::{self, FileError};
use std::path::Path;

/// The files that come with the program, in a folder of `host/gaits`: names and texts.
macro_rules! bundled {
    ($leg:literal) => {
        bundled!($leg: "original.csv", "spread.csv", "psto.toml", "ours.toml", "sinusoid.toml", "searched.toml",
            "learning/seed-0/train.csv", "learning/seed-1/train.csv", "made.toml")
    };
    ($leg:literal: $($name:literal),*) => {
        &[$(($name, include_str!(concat!("../../../gaits/", $leg, "/", $name)))),*]
    };
}

const LONG: &[(&str, &str)] = bundled!("ant-1L");
const SHORT: &[(&str, &str)] = bundled!("ant-0.6L");

/// Writes the gaits that come with the program, unless the folder has gaits: a study's
/// own are never replaced. `made.toml` comes last, and so tells that all are there.
///
/// # Errors
/// [`MaterialsError::NoneKnown`] for other robots and legs; the disk's reasons.
pub fn unpack(robot: &Robot, folder: &Path) -> Result<(), MaterialsError> {
    let leg = robot.geometry.leg_scale;
    let is_ant = Robot::ant(leg).is_ok_and(|ant| ant == *robot);
    let files = match leg {
        leg if is_ant && leg == LegScale::LONG => LONG,
        leg if is_ant && leg == LegScale::SHORT => SHORT,
        _ => return Err(MaterialsError::NoneKnown { robot: robot.name.clone(), leg }),
    };
    if folder.join(MADE).exists() {
        return Ok(());
    }
    for (name, text) in files {
        let path = folder.join(name);
        if let Some(parent) = path.parent() {
            std::fs::create_dir_all(parent).map_err(FileError::on("create", parent))?;
        }
        run_folder::write(&path, text.as_bytes())?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiment::materials::{MadeFile, file_name};
    use crate::experiment::method::Method;

    #[test]
    fn every_bundled_method_comes_with_its_gait_and_the_command_that_made_it() {
        for (leg, files) in [("1 L", LONG), ("0.6 L", SHORT)] {
            let text = |file: &str| files.iter().find(|(name, _)| *name == file).map(|(_, text)| *text);
            let made: MadeFile = toml::from_str(text(MADE).expect("the commands")).expect("a table");
            for method in Method::bundled() {
                let file = file_name(method);
                assert!(text(&file).is_some(), "{}: add {file} of {leg} to `bundled!`", method.name());
                assert!(made.contains_key(method.name()), "{leg}: {MADE} says nothing of {}", method.name());
            }
        }
    }
}
