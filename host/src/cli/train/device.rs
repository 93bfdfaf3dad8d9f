//! The device of a run: from a flag, and in the run's `config.toml`.
//!
//! Holds the check before anything is written, and the change of device of a resumed
//! run, whose `config.toml` names the device that it last learned on. Does not depend
//! on libtorch.

use super::TrainCliError;
use crate::learn::run_config::RunConfig;
use crate::learn::td3::device::Device;
use crate::learn::td3::outcome::Event;
use crate::run_folder;
use indicatif::ProgressBar;
use std::path::Path;

/// Checks that the device is available.
pub fn check(device: Device) -> Result<(), TrainCliError> {
    device.check().map_err(|source| {
        let help = source.next_move();
        TrainCliError::Device { device, source, help }
    })
}

/// A run's configuration, with the device of the flag if there is one.
pub struct Configured {
    pub config: RunConfig,
    /// A change that `config.toml` does not have yet.
    pub change: Change,
}

/// The device in the run's `config.toml`, if it differs.
pub struct Change(Option<Device>);

impl Configured {
    pub fn load(folder: &Path, device: Option<Device>) -> Result<Self, TrainCliError> {
        let mut config = RunConfig::load(&folder.join(run_folder::CONFIG))?;
        let before = config.device;
        config.device = device.unwrap_or(before);
        check(config.device)?;
        Ok(Self { change: Change((config.device != before).then_some(before)), config })
    }
}

impl Change {
    /// The device that the run last learned on.
    pub fn learned_on(&self, config: &RunConfig) -> Device {
        self.0.unwrap_or(config.device)
    }

    /// Writes the change after the first round; a run that was already complete stays as it is.
    pub fn note(&mut self, event: &Event, config: &RunConfig, folder: &Path, bar: &ProgressBar) {
        if self.0.is_some() && matches!(event, Event::Round { .. }) {
            self.0 = None;
            if let Err(error) = config.save(&folder.join(run_folder::CONFIG)) {
                let device = config.device;
                super::say(bar, &format!("warning: {error}: use --device {device} again when you resume"));
            }
        }
    }
}
