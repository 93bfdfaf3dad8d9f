//! How long a gait takes into RAM, and into the EEPROM.
//!
//! An upload runs from the first byte of its first command to the last byte of
//! the status in which the robot names the gait's CRC-32 as its own. A save
//! runs from the same beginning to the status that calls it saved: the robot
//! has read it back by then. The host here answers within 0.1 ms; an adapter
//! that keeps bytes back adds its latency to each of an upload's steps. The EEPROM
//! is erased at first, so the first save of either slot writes every byte.

use super::rig::{Rig, RigError};
use crate::nano::seconds;
use protocol::GaitTable;
use protocol::command::Storage;
use protocol::gait::MAX_ENCODED_LEN;

/// Times of uploads and saves.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Transfers {
    /// Of each upload.
    pub upload_ms: Vec<f64>,
    /// Of each save, upload included.
    pub persist_ms: Vec<f64>,
}

impl Transfers {
    #[must_use]
    pub fn slowest_upload_ms(&self) -> Option<f64> {
        self.upload_ms.iter().copied().reduce(f64::max)
    }

    #[must_use]
    pub fn slowest_persist_ms(&self) -> Option<f64> {
        self.persist_ms.iter().copied().reduce(f64::max)
    }

    /// Sends the next gait, and waits until it is saved.
    ///
    /// # Errors
    /// [`RigError`] if it is refused, or not what was sent.
    pub fn upload_and_save(&mut self, rig: &mut Rig) -> Result<(), RigError> {
        let began = rig.robot.now();
        let table = rig.upload(true)?;
        let (mut status, mut at) = rig.status()?;
        if status.gait.map(|gait| gait.crc32) != crc32_of(&table) {
            return Err(RigError::Unseen("upload in the robot's status"));
        }
        self.upload_ms.push(seconds(at - began) * 1e3);
        while status.storage == Storage::Saving {
            rig.client.run_for(&mut rig.robot, 0.01)?;
            (status, at) = rig.status()?;
        }
        if status.storage != Storage::Saved {
            return Err(RigError::Unseen("save that verified"));
        }
        self.persist_ms.push(seconds(at - began) * 1e3);
        Ok(())
    }
}

fn crc32_of(table: &GaitTable) -> Option<u32> {
    let mut buffer = [0; MAX_ENCODED_LEN];
    table.encode(&mut buffer).ok().map(GaitTable::crc32_of)
}
