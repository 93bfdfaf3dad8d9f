//! Reads a robot's calibration, and sends another one.
//!
//! Holds the order of the commands: until the commit the robot keeps the calibration
//! it had, and what does not read back is an error. Does not depend on calibration files.

use crate::device::link::{Link, LinkError};
use crate::device::upload;
use protocol::calibration::CALIBRATION_LEN;
use protocol::command::{CalibrationSource, MAX_CHUNK_LEN, Record};
use protocol::{Calibration, Command};
use std::io::{Read, Write};
use thiserror::Error;

/// Why a calibration was not transferred.
#[derive(Debug, Error)]
// The messages say what each field is.
#[allow(missing_docs)]
pub enum TransferError {
    /// The link broke, or the robot refused.
    #[error(transparent)]
    Link(#[from] LinkError),
    /// The robot read back something else.
    #[error("the robot's calibration differs from the one that was sent, at byte {at} of {CALIBRATION_LEN}")]
    Differs { at: usize },
    /// The robot's bytes are not a calibration.
    #[error("the robot's own calibration is damaged: its {len} bytes are not a calibration")]
    Damaged { len: usize },
    /// It is in use, but lost at the next reset.
    #[error("the robot could not save the calibration: its EEPROM did not read back what was written")]
    NotSaved,
}

/// Reads the calibration in use.
///
/// # Errors
/// A [`LinkError`], or [`TransferError::Damaged`].
pub fn fetch<P: Read + Write>(link: &mut Link<P>) -> Result<Calibration, TransferError> {
    let bytes = link.read(Record::Calibration)?;
    Calibration::from_bytes(&bytes).map_err(|_| TransferError::Damaged { len: bytes.len() })
}

/// Sends a calibration, lets the robot use and save it, and compares.
///
/// # Errors
/// [`TransferError`]; refused with [`protocol::Refusal::ServosOn`] while the robot moves.
pub fn send<P: Read + Write>(link: &mut Link<P>, record: &Calibration) -> Result<(), TransferError> {
    upload::transfer(link, record.bytes(), MAX_CHUNK_LEN, |_| {})?;
    link.order(Command::CalibrationCommit)?;
    let read_back = link.read(Record::Calibration)?;
    if read_back != record.bytes() {
        let same = read_back.iter().zip(record.bytes()).take_while(|(a, b)| a == b);
        return Err(TransferError::Differs { at: same.count() });
    }
    // The robot answers this when its EEPROM is at rest: the save has then succeeded or failed.
    link.read(Record::LastTrial)?;
    match link.status()?.calibration {
        CalibrationSource::Stored => Ok(()),
        CalibrationSource::NotSaved | CalibrationSource::Default | CalibrationSource::Damaged => {
            Err(TransferError::NotSaved)
        }
    }
}
