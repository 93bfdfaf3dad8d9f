//! Uploads a gait: transfer, activate, verify, save.
//!
//! Holds the order of the commands and what each failure leaves on the robot: until
//! the commit it keeps the gait it had. Gaits and amplitudes beyond the robot's own
//! limits are an error before anything is sent. Does not depend on gait files.

pub mod upload_result;

use crate::device::link::{Link, LinkError};
use protocol::command::{ActiveGait, MAX_CHUNK_LEN, Record, Storage};
use protocol::{Amplitude, Chunk, Command};
use std::io::{Read, Write};
use std::time::{Duration, Instant};
use thiserror::Error;

/// EEPROM takes 3.4 ms a byte, so a table and its header about a second.
const SAVE_TIMEOUT: Duration = Duration::from_secs(10);

/// The steps of an upload, in their order.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stage {
    /// Pieces are being sent; the robot has its old gait.
    Transfer,
    /// The robot checks the table, and takes it whole or not at all.
    Commit,
    /// The new gait is active and is being compared.
    Verify,
    /// The new gait is active and is being written to EEPROM.
    Save,
}

impl Stage {
    /// What a failure at this stage leaves on the robot.
    #[must_use]
    pub const fn leaves(self) -> &'static str {
        match self {
            Self::Transfer => "the robot keeps the gait it had",
            Self::Commit => {
                "the robot has either the old gait or the new one, whole; repeat the upload to be sure"
            }
            Self::Verify | Self::Save => {
                "the new gait is active until the next reset, and may not be saved; repeat the upload"
            }
        }
    }
}

/// Why an upload failed.
#[derive(Debug, Error)]
// The messages say what each field is.
#[allow(missing_docs)]
pub enum UploadError {
    /// The robot has no room for it.
    #[error("the gait has {len} bytes; this robot takes at most {max}")]
    TooLong {
        len: usize,
        /// From the robot's hello.
        max: u16,
    },
    /// The robot does not play that amplitude.
    #[error("amplitude {asked} is outside this robot's {min} to {max}")]
    Amplitude {
        /// On the command line.
        asked: f64,
        /// From the robot's hello.
        min: f64,
        /// From the robot's hello.
        max: f64,
    },
    /// The link broke, or the robot refused.
    #[error("the upload failed: {}", .stage.leaves())]
    Link { stage: Stage, source: LinkError },
    /// The robot read back something else.
    #[error("the robot's gait differs from the uploaded one at byte {at}: {}", Stage::Verify.leaves())]
    Differs { at: usize },
    /// The EEPROM did not take it.
    #[error("the robot could not save the gait: its EEPROM did not read back what was written")]
    NotSaved,
    /// The EEPROM takes too long.
    #[error("the robot was still saving the gait after {} s", SAVE_TIMEOUT.as_secs())]
    SaveTimeout,
}

/// What the robot has after an upload.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Uploaded {
    /// The gait as the robot calls it.
    pub gait: ActiveGait,
    /// Where it lives.
    pub storage: Storage,
    /// From the first byte to the comparison.
    pub transfer: Duration,
    /// Until it was saved.
    pub total: Duration,
}

/// Uploads an encoded table; `progress` is told the stage and the bytes sent.
///
/// # Errors
/// [`UploadError`], which says what the robot is left with.
pub fn upload<P: Read + Write>(
    link: &mut Link<P>,
    table: &[u8],
    amplitude: Amplitude,
    persist: bool,
    mut progress: impl FnMut(Stage, usize),
) -> Result<Uploaded, UploadError> {
    let start = Instant::now();
    let chunk_len = check_limits(link, table, amplitude)?;
    let at = |stage| move |source| UploadError::Link { stage, source };

    progress(Stage::Transfer, 0);
    transfer(link, table, chunk_len, |sent| progress(Stage::Transfer, sent)).map_err(at(Stage::Transfer))?;
    progress(Stage::Commit, table.len());
    link.order(Command::UploadCommit { amplitude, persist }).map_err(|source| {
        // A refused commit has changed nothing.
        let stage = if source.is_from_robot() { Stage::Transfer } else { Stage::Commit };
        UploadError::Link { stage, source }
    })?;

    progress(Stage::Verify, table.len());
    let read_back = link.read(Record::Gait).map_err(at(Stage::Verify))?;
    if read_back != table {
        let pairs = read_back.iter().zip(table);
        return Err(UploadError::Differs { at: pairs.take_while(|(a, b)| a == b).count() });
    }
    let transfer = start.elapsed();
    if persist {
        progress(Stage::Save, table.len());
    }
    let (gait, storage) = wait_until_saved(link, persist)?;
    Ok(Uploaded { gait, storage, transfer, total: start.elapsed() })
}

/// Longest piece that both sides take.
fn check_limits<P: Read + Write>(
    link: &Link<P>,
    table: &[u8],
    amplitude: Amplitude,
) -> Result<usize, UploadError> {
    let Some(limits) = link.hello().map(|hello| hello.limits) else { return Ok(MAX_CHUNK_LEN) };
    if table.len() > usize::from(limits.max_gait_len) {
        return Err(UploadError::TooLong { len: table.len(), max: limits.max_gait_len });
    }
    if amplitude < limits.min_amplitude || amplitude > limits.max_amplitude {
        let (min, max) = (limits.min_amplitude.value(), limits.max_amplitude.value());
        return Err(UploadError::Amplitude { asked: amplitude.value(), min, max });
    }
    Ok(usize::from(limits.max_chunk_len).clamp(1, MAX_CHUNK_LEN))
}

/// Announces a gait or a calibration and sends its pieces in order; the robot
/// keeps what it has until a commit.
///
/// # Errors
/// As [`Link::request`].
pub fn transfer<P: Read + Write>(
    link: &mut Link<P>,
    bytes: &[u8],
    chunk_len: usize,
    mut progress: impl FnMut(usize),
) -> Result<(), LinkError> {
    link.order(Command::UploadBegin { len: bytes.len() as u16 })?;
    for (i, piece) in bytes.chunks(chunk_len).enumerate() {
        let offset = i * chunk_len;
        link.order(Command::UploadChunk { offset: offset as u16, data: Chunk::of(piece) })?;
        progress(offset + piece.len());
    }
    Ok(())
}

fn wait_until_saved<P: Read + Write>(
    link: &mut Link<P>,
    persist: bool,
) -> Result<(ActiveGait, Storage), UploadError> {
    let deadline = Instant::now() + SAVE_TIMEOUT;
    loop {
        let at_save = |source| UploadError::Link { stage: Stage::Save, source };
        let status = link.status().map_err(at_save)?;
        // It was read back a moment ago; without it the robot forgot everything.
        let gait = status.gait.ok_or(UploadError::Differs { at: 0 })?;
        match status.storage {
            Storage::Saved => return Ok((gait, status.storage)),
            Storage::RamOnly if !persist => return Ok((gait, status.storage)),
            Storage::Failed | Storage::RamOnly => return Err(UploadError::NotSaved),
            Storage::Saving if Instant::now() >= deadline => return Err(UploadError::SaveTimeout),
            Storage::Saving => std::thread::sleep(Duration::from_millis(50)),
        }
    }
}
