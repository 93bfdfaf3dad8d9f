//! What a run learns on: asked for by a flag, kept in the run's `config.toml`.
//!
//! Owns the check before anything is written, and the change of a resumed run:
//! its folder names the device that it last learned on.

use super::TrainCliError;
use crate::learn::td3::device::Device;
use crate::learn::td3::outcome::Event;
use crate::learn::td3::run_config::RunConfig;
use crate::run_folder;
use indicatif::ProgressBar;
use std::path::Path;

/// Whether the device is there.
pub fn check(device: Device) -> Result<(), TrainCliError> {
    device.check().map_err(|source| {
        let help = source.next_move();
        TrainCliError::Device { device, source, help }
    })
}

/// A run's configuration, on another device where one is asked for.
pub struct Configured {
    pub config: RunConfig,
    /// What is still to be written into the run's folder.
    pub change: Change,
}

/// The device that the run's folder names, where it is another.
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
    /// What the run last learned on.
    pub fn learned_on(&self, config: &RunConfig) -> Device {
        self.0.unwrap_or(config.device)
    }

    /// Writes it once the run has gone on; a run that was done already keeps what it had.
    pub fn note(&mut self, event: &Event, config: &RunConfig, folder: &Path, bar: &ProgressBar) {
        if self.0.is_some() && matches!(event, Event::Round { .. }) {
            self.0 = None;
            if let Err(error) = config.save(&folder.join(run_folder::CONFIG)) {
                let device = config.device;
                super::say(
                    bar,
                    &format!("warning: {error}: resume with --device {device} the next time too"),
                );
            }
        }
    }
}
