//! The configuration of a run: seed, leg, device, learning and task.
//!
//! Holds the file's format and the limits of the task's numbers. It joins learner and
//! task, so that neither depends on the other. A file names only what differs from the
//! preset that it is `based_on`, by default `paper`; an unknown name is an error.

use super::preset::Preset;
use super::td3::config::{BadValue, Learning, Schedule, Td3Config};
use super::td3::device::Device;
use crate::robot::LegScale;
use crate::run_folder::{self, FileError};
use crate::sim::{AntEnvConfig, reward};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Why a configuration cannot be used.
#[derive(Debug, Error)]
pub enum ConfigError {
    /// The disk's reason.
    #[error(transparent)]
    File(#[from] FileError),
    /// Not TOML, an unknown name, or a value of a wrong type.
    #[error("{path} is not a valid training configuration")]
    Parse {
        /// The file.
        path: PathBuf,
        /// Line and reason.
        source: Box<toml::de::Error>,
    },
    /// A number is out of its range.
    #[error("{path} has a value out of range")]
    Value {
        /// The file.
        path: PathBuf,
        /// The number and its range.
        source: BadValue,
    },
    /// TOML cannot represent a number.
    #[error("cannot write {path}")]
    Unwritable {
        /// The file.
        path: PathBuf,
        /// The format's reason.
        source: Box<toml::ser::Error>,
    },
}

/// Everything that decides a run's result, except the robot.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct RunConfig {
    /// Random seed.
    pub seed: u64,
    /// Shins of the built-in Ant, as multiples of the paper's "1 L".
    pub leg_scale: LegScale,
    /// Device of the updates; results of different devices agree to rounding at first.
    pub device: Device,
    /// The algorithm.
    pub td3: Td3Config,
    /// Length of the run and its evaluations.
    pub schedule: Schedule,
    /// The task.
    pub env: AntEnvConfig,
}

/// A file alone, so that errors name its own lines, and the preset that it is based on.
#[derive(Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
struct File {
    based_on: Preset,
    #[serde(rename = "seed")]
    _seed: u64,
    #[serde(rename = "leg_scale")]
    _leg_scale: LegScale,
    #[serde(rename = "device")]
    _device: Device,
    #[serde(rename = "td3")]
    _td3: Td3Config,
    #[serde(rename = "schedule")]
    _schedule: Schedule,
    #[serde(rename = "env")]
    _env: AntEnvConfig,
}

impl RunConfig {
    /// A configuration that is part of the program.
    ///
    /// # Errors
    /// As [`Self::parse`]; tests parse all presets.
    pub fn preset(preset: Preset) -> Result<Self, ConfigError> {
        Self::parse(preset.text(), Path::new(preset.path()))
    }

    /// Parses a configuration and the preset it is based on; `path` is for errors.
    ///
    /// # Errors
    /// [`ConfigError`] if it is not a valid configuration or a number is out of range.
    pub fn parse(text: &str, path: &Path) -> Result<Self, ConfigError> {
        let parse = |source| ConfigError::Parse {
            path: path.to_owned(),
            source: Box::<toml::de::Error>::new(source),
        };
        let config: Self = whole(text).and_then(toml::Table::try_into).map_err(parse)?;
        config.check().map_err(|source| ConfigError::Value { path: path.to_owned(), source })?;
        Ok(config)
    }

    /// Reads a configuration file.
    ///
    /// # Errors
    /// [`ConfigError`] if it cannot be read, or as [`Self::parse`].
    pub fn load(path: &Path) -> Result<Self, ConfigError> {
        let text = std::fs::read_to_string(path).map_err(FileError::on("read", path))?;
        Self::parse(&text, path)
    }

    /// Writes every number, defaults included.
    ///
    /// # Errors
    /// [`ConfigError`] with the old file still in place.
    pub fn save(&self, path: &Path) -> Result<(), ConfigError> {
        let text = self
            .to_toml()
            .map_err(|source| ConfigError::Unwritable { path: path.to_owned(), source: Box::new(source) })?;
        Ok(run_folder::write(path, text.as_bytes())?)
    }

    /// Every number, as TOML.
    ///
    /// # Errors
    /// If TOML cannot represent a number.
    pub fn to_toml(&self) -> Result<String, toml::ser::Error> {
        toml::to_string(self)
    }

    /// Algorithm and schedule, without the task.
    pub fn learning(&self) -> Learning {
        Learning { td3: self.td3.clone(), schedule: self.schedule.clone() }
    }

    fn check(&self) -> Result<(), BadValue> {
        self.learning().check()?;
        let bad = |name: &str, value: f64, limit| {
            Err(BadValue { name: name.to_owned(), value: value.to_string(), limit })
        };
        // An evaluation needs episodes that end.
        if !(1..=1_000_000).contains(&self.env.episode_steps) {
            return bad("env.episode_steps", self.env.episode_steps.into(), "1 to 1,000,000");
        }
        let (env, start, random) = (&self.env, &self.env.start, &self.env.randomisation);
        let slew = env.slew_limit_rad_s.unwrap_or(1.0);
        let ranges = [
            ("env.slew_limit_rad_s", slew, 0.001..=1000.0, "0.001 to 1000"),
            ("env.setpoint_limit", env.setpoint_limit, 0.01..=1.0, "0.01 to 1"),
            ("env.max_tilt_rad", env.max_tilt_rad, 0.01..=3.2, "0.01 to 3.2"),
            ("env.start.yaw_rad", start.yaw_rad, 0.0..=3.2, "0 to 3.2"),
            ("env.start.height_m", start.height_m, 0.0..=1.0, "0 to 1"),
            ("env.start.joint_rad", start.joint_rad, 0.0..=0.95, "0 to 0.95, the end stops"),
            ("env.start.friction_share", start.friction_share, 0.0..=1.0, "0 to 1"),
            ("env.randomisation.twin_spread", random.twin_spread, 0.0..=5.0, "0 to 5 standard deviations"),
            ("env.randomisation.friction_share", random.friction_share, 0.0..=0.9, "0 to 0.9"),
            (
                "env.randomisation.mass_share",
                random.mass_share,
                0.0..=0.3,
                "0 to 0.3, what a torso can carry",
            ),
            ("env.randomisation.latency_s", random.latency_s, 0.0..=0.1, "0 to 0.1, in seconds"),
            ("env.randomisation.supply_share", random.supply_share, 0.0..=0.5, "0 to 0.5"),
        ];
        if let Some((name, value, _, limit)) = ranges.into_iter().find(|(_, v, range, _)| !range.contains(v))
        {
            return bad(name, value, limit);
        }
        let reward = &self.env.reward;
        let weights = reward::TERMS.iter().map(|term| (term.name, (term.weight)(reward)));
        let mut numbers = weights.chain([("alive_height_m", reward.alive_height_m)]);
        match numbers.find(|(_, number)| !(-1000.0..=1000.0).contains(number)) {
            Some((name, number)) => bad(&format!("env.reward.{name}"), number, "-1000 to 1000"),
            None => Ok(()),
        }
    }
}

/// Every number of a file, with those that it takes from its preset.
fn whole(text: &str) -> Result<toml::Table, toml::de::Error> {
    let File { based_on, .. } = toml::from_str(text)?;
    let mut named: toml::Table = toml::from_str(text)?;
    named.remove("based_on");
    // The paper's preset names everything and is based on none.
    let mut merged = match based_on {
        Preset::Paper => toml::from_str(Preset::Paper.text())?,
        preset => whole(preset.text())?,
    };
    lay_over(&mut merged, named);
    Ok(merged)
}

/// Replaces in `base` what `top` names, recursively.
fn lay_over(base: &mut toml::Table, top: toml::Table) {
    for (name, value) in top {
        match (base.get_mut(&name), value) {
            (Some(toml::Value::Table(below)), toml::Value::Table(above)) => lay_over(below, above),
            (_, value) => {
                base.insert(name, value);
            }
        }
    }
}

#[cfg(test)]
mod tests;
