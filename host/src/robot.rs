//! What a robot is made of: a body, servos, ground and power.
//!
//! Holds the robot's folder: `robot.toml` and, beside it, the MJCF or URDF file
//! that draws the body. Does not depend on the simulation. NaN, numbers outside
//! their bounds ([`FIELDS`]) and bodies other than a torso on four legs of a hip
//! and a knee are refused.
//!
//! What a fit changes is in `robot.toml` and overrides the drawn body:
//! [`Limbs`] are the outcome, and what the simulation builds.
//!
//! The Ant's folder is `robots/ant`. Its numbers that no data sheet gives
//! (friction, servos, power) come from `host twin fit`, and its `[twin]`
//! section says from which.

mod assembly;
pub mod check;
mod document;
mod drawn;
mod error;
pub mod export;
mod fields;
mod inertia;
mod leg_scale;
mod limbs;
mod loaded;
mod mjcf;
mod plausible;
mod range;
mod raw;
mod sections;
pub mod servo_presets;
pub mod sketch;
mod solid;
pub mod statics;
mod symmetry;
mod urdf;
pub mod views;
mod warning;

pub use drawn::Drawn;
pub use error::{ModelError, RobotError};
pub use fields::{FIELDS, Field};
pub use inertia::{Inertia, Principal};
pub use leg_scale::{LEG_SCALE_RANGE, LegScale, LegScaleError};
pub use limbs::{Leg, Limbs, Link};
pub use range::BeyondRange;
pub use raw::Hinge;
pub use sections::{Geometry, Ground, Mass, Model, Power, PowerLine, Servo, Supply, TwinRecord};
pub use solid::{Shape, Solid};
pub use warning::RobotWarning;

use crate::run_folder::{self, FileError};
use serde::Serialize;
use sha2::{Digest as _, Sha256};
use std::path::Path;
use std::sync::Arc;

/// Name of the description in a robot's folder.
pub const DESCRIPTION: &str = "robot.toml";

/// The Ant, as the last fit left it.
const ANT: (&str, &str) = (include_str!("../robots/ant/robot.toml"), include_str!("../robots/ant/ant.xml"));

/// A robot with eight servos on four legs.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Robot {
    /// For people.
    pub name: String,
    /// Largest setpoint from neutral that the robot's tables may reach.
    pub joint_limit_deg: f64,
    /// Where the body is drawn, and its parts' names.
    pub model: Model,
    /// What of its lengths differs from the drawing.
    pub geometry: Geometry,
    /// What of its masses differs from the drawing.
    pub mass: Mass,
    /// The servos, all alike.
    pub servo: Servo,
    /// What the feet stand on.
    pub ground: Ground,
    /// From mechanical to electrical power.
    pub power: Power,
    /// What feeds it.
    pub supply: Supply,
    /// How it was fitted to measured trials, if it was.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub twin: Option<TwinRecord>,
    /// The body as drawn; its file is kept beside the description.
    #[serde(skip)]
    pub drawn: Arc<Drawn>,
}

impl Robot {
    /// The paper's Ant; its shins are 0.23 m times `leg_scale` long.
    ///
    /// # Errors
    /// None that a test has not met: the description comes with the program.
    ///
    /// # Source
    /// Lengths: the authors' model. Joint limit: their tables reach 51.6
    /// degrees. Pulses: 330 ticks of 4.08 us are neutral, 0.6 degree a tick.
    /// Friction, servo, power, mass and the shin's slope: the fit that the
    /// description's `[twin]` section names. How the mass is shared out, foot
    /// radius, torso height and the supply are our assumptions.
    pub fn ant(leg_scale: LegScale) -> Result<Self, RobotError> {
        let mut robot = document::read(ANT.0, Path::new("robots/ant/robot.toml"), |_| Ok(ANT.1.to_owned()))?;
        robot.geometry.leg_scale = leg_scale;
        robot.check()?;
        Ok(robot)
    }

    /// Reads and checks a robot's folder, named itself or by its `robot.toml`.
    ///
    /// # Errors
    /// [`RobotError`] naming the file, or the field, its value and its bounds.
    pub fn load(path: &Path) -> Result<Self, RobotError> {
        // Anything but a folder is taken for the description in one.
        let (folder, file) = if path.is_dir() || path.extension().is_none_or(|e| e != "toml") {
            (path.to_owned(), path.join(DESCRIPTION))
        } else {
            (path.parent().unwrap_or(Path::new("")).to_owned(), path.to_owned())
        };
        let text = std::fs::read_to_string(&file).map_err(FileError::on("read", &file))?;
        let robot = document::read(&text, &file, |name| {
            let path = folder.join(name);
            std::fs::read_to_string(&path).map_err(|e| FileError::on("read", &path)(e).into())
        })?;
        robot.check()?;
        Ok(robot)
    }

    /// The robot that a run was made for; none where the run keeps none.
    ///
    /// # Errors
    /// As [`Self::load`].
    pub fn of_run(run: &Path) -> Result<Option<Self>, RobotError> {
        let folder = run.join(run_folder::ROBOT);
        if folder.is_dir() {
            return Self::load(&folder).map(Some);
        }
        // A file that lies in a robot's own folder.
        if run.join(DESCRIPTION).is_file() { Self::load(run).map(Some) } else { Ok(None) }
    }

    /// The robot that a run must have been made for.
    ///
    /// # Errors
    /// As [`Self::of_run`], and [`RobotError::File`] where there is none.
    pub fn of_trained_run(run: &Path) -> Result<Self, RobotError> {
        match Self::of_run(run)? {
            Some(robot) => Ok(robot),
            None => Self::load(&run.join(run_folder::ROBOT)),
        }
    }

    /// Writes the folder as [`Self::load`] reads it.
    ///
    /// # Errors
    /// [`FileError`] naming what cannot be written.
    pub fn save(&self, folder: &Path) -> Result<(), FileError> {
        std::fs::create_dir_all(folder).map_err(FileError::on("create", folder))?;
        // The description last: where it is, the folder is whole. One that is
        // of another body goes first.
        let (model, description) = (folder.join(&self.model.file), folder.join(DESCRIPTION));
        if std::fs::read(&model).ok().is_some_and(|text| text == self.drawn.text.as_bytes()) {
            return run_folder::write(&description, self.to_toml().as_bytes());
        }
        if description.exists() {
            std::fs::remove_file(&description).map_err(FileError::on("replace", &description))?;
        }
        run_folder::write(&model, self.drawn.text.as_bytes())?;
        run_folder::write(&description, self.to_toml().as_bytes())
    }

    /// The description.
    #[must_use]
    pub fn to_toml(&self) -> String {
        // Strings and finite numbers in tables: nothing that TOML cannot hold.
        toml::to_string_pretty(self).unwrap_or_default()
    }

    /// What is probably not meant as it is written: units, placeholders, a weight
    /// that the servos cannot carry. Empty for a robot that looks right.
    #[must_use]
    pub fn warnings(&self) -> Vec<RobotWarning> {
        let mut warnings = self.drawn.warnings.clone();
        warnings.extend(plausible::built(self));
        warnings
    }

    /// What identifies the robot: SHA-256 of its description and its drawing.
    #[must_use]
    pub fn sha256(&self) -> String {
        let text = self.to_toml() + &self.drawn.text;
        Sha256::digest(text).iter().map(|byte| format!("{byte:02x}")).collect()
    }

    /// Everything that it carries and is.
    #[must_use]
    pub fn mass_kg(&self) -> f64 {
        Limbs::of(self).mass_kg()
    }

    /// How far the shins slope below the horizontal with the knees at neutral, in
    /// degrees: the angle that a servo is set to when its horn is mounted.
    #[must_use]
    pub const fn neutral_shin_slope_deg(&self) -> f64 {
        self.geometry.shin_below_horizontal_deg
    }

    /// Checks every number against its bounds, and what they make of the body.
    ///
    /// # Errors
    /// [`RobotError`] for the first that does not fit.
    pub fn check(&self) -> Result<(), RobotError> {
        for field in FIELDS {
            let (value, (min, max)) = ((field.get)(self), field.bounds(self));
            // NaN is in no range.
            if !(min..=max).contains(&value) {
                return Err(RobotError::OutOfRange { field: field.name, value, min, max });
            }
        }
        self.servo.check_wiring()?;
        if let Some(value) = self.twin.as_ref().map(|twin| twin.sample_s)
            && !(0.02..=1.0).contains(&value)
        {
            return Err(RobotError::OutOfRange { field: "twin.sample_s", value, min: 0.02, max: 1.0 });
        }
        let spread = self.twin.iter().flat_map(|twin| &twin.spread);
        if let Some((name, &value)) = spread.into_iter().find(|(_, value)| !(0.0..=1000.0).contains(*value)) {
            return Err(RobotError::Spread { name: name.clone(), value });
        }
        limbs::check_neutral(self)
            .map_err(|source| RobotError::Model { path: (&self.model.file).into(), source: Box::new(source) })
    }
}

#[cfg(test)]
mod tests;
