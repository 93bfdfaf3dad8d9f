//! What the robot answers.

use super::Chunk;
use crate::calibration::CalibrationError;
use crate::gait::{Amplitude, GaitError, Name};
use crate::telemetry::{Fault, ResetCause, State};
use serde::{Deserialize, Serialize};

/// The robot's answer to one command; `D` holds a piece of a table.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Reply<D = Chunk> {
    /// To [`Command::Hello`](super::Command::Hello) of the same protocol version.
    Hello(HelloReply),
    /// Not done, and nothing changed. Second place: encoding frozen with it.
    Refused(Refusal),
    /// Done.
    Done,
    /// To [`Command::Status`](super::Command::Status).
    Status(Status),
    /// To [`Command::Read`](super::Command::Read); empty past the end of the record.
    Piece(D),
    /// To [`Command::Setpoints`](super::Command::Setpoints): how many are buffered now.
    Buffered(u8),
    /// To [`Command::StoredGait`](super::Command::StoredGait).
    Stored(Option<StoredGait>),
}

/// A gait in the robot's EEPROM.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct StoredGait {
    /// Its name.
    pub name: Name,
    /// Its default amplitude.
    pub amplitude: Amplitude,
    /// Whether the robot starts with it.
    pub at_start: bool,
}

/// Who the robot is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct HelloReply {
    /// The robot's [`crate::PROTOCOL_VERSION`].
    pub protocol_version: u8,
    /// Major, minor, patch.
    pub firmware_version: [u8; 3],
    /// What it can take.
    pub limits: Limits,
    /// Why it last started.
    pub reset_cause: ResetCause,
}

/// What a robot can take.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Limits {
    /// Gait frames a second.
    pub frame_rate_hz: u8,
    /// Longest encoded gait table.
    pub max_gait_len: u16,
    /// Longest piece of it in one frame.
    pub max_chunk_len: u8,
    /// Smallest amplitude.
    pub min_amplitude: Amplitude,
    /// Largest amplitude.
    pub max_amplitude: Amplitude,
    /// Gaits that it stores.
    pub gait_slots: u8,
    /// Setpoints that it buffers.
    pub stream_capacity: u8,
}

/// What the robot is doing, and with what.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Status {
    /// What it is doing.
    pub state: State,
    /// The active gait, if there is one.
    pub gait: Option<ActiveGait>,
    /// Whether the active gait survives power-off.
    pub storage: Storage,
    /// Where its calibration comes from.
    pub calibration: CalibrationSource,
    /// Supply voltage at the last sample.
    pub bus_mv: u16,
    /// Why it last started.
    pub reset_cause: ResetCause,
    /// Frames since it did.
    pub uptime_frames: u32,
    /// Bytes of memory that the deepest stack has left untouched.
    pub stack_left: u16,
    /// Frames from the wire that failed their CRC or made no sense.
    pub bad_frames: u16,
    /// Bytes from the wire that found no room.
    pub dropped_bytes: u16,
    /// Transfers on the two-wire bus that failed.
    pub bus_errors: u16,
}

/// Where a robot's calibration comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum CalibrationSource {
    /// None is stored: [`crate::Calibration::authors`].
    Default,
    /// From EEPROM, or on its way there.
    Stored,
    /// It is in use, but the EEPROM did not take it.
    NotSaved,
    /// One is stored, but its bytes are not what was written: the robot is not
    /// built as the one in use says, and does not walk by it.
    Damaged,
}

/// The gait that [`Command::Walk`](super::Command::Walk) would play.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct ActiveGait {
    /// Its name.
    pub name: Name,
    /// The CRC-32 at the end of its encoding: its identity.
    pub crc32: u32,
    /// Its default amplitude.
    pub amplitude: Amplitude,
}

/// Where the active gait and its amplitude live.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Storage {
    /// In RAM only, be it the gait or an amplitude set since: gone at the next reset.
    RamOnly,
    /// Being written to EEPROM.
    Saving,
    /// In EEPROM, both as they are now.
    Saved,
    /// The write did not verify; the gait saved before, if any, is intact.
    Failed,
}

/// Why a command was refused.
// The tag starts at 1, in memory, not on the wire: no refusal is then the 0 of
// a robot that starts, and its start value costs it no flash.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[repr(u8)]
pub enum Refusal {
    /// Another protocol version; encoding frozen.
    ProtocolVersion {
        /// The robot's [`crate::PROTOCOL_VERSION`].
        robot: u8,
    } = 1,
    /// The frame was intact but holds no command of this version.
    Unknown,
    /// A length or an offset is beyond the announced table or leaves a gap, or a
    /// chunk came first.
    UploadRange,
    /// Pieces of the announced table are missing.
    UploadIncomplete,
    /// The table is damaged or its values are out of range.
    BadGait(GaitError),
    /// The amplitude is outside the limits in [`Limits`].
    Amplitude,
    /// There is no gait to walk.
    NoGait,
    /// A fault is latched.
    Faulted(Fault),
    /// Walking was asked for while walking: stop first.
    AlreadyWalking,
    /// The servo driver or the power sensor does not answer.
    ChipMissing(Fault),
    /// An earlier save is still going on.
    StorageBusy,
    /// Not even at rest does the supply have what a walk needs.
    SupplyTooLow {
        /// Voltage at the last sample.
        bus_mv: u16,
    },
    /// All places for gaits are taken: erase one first. A gait of the same name
    /// stays until the new one is whole, so it makes no room.
    StorageFull,
    /// The slot does not exist or is empty.
    NoSuchGait,
    /// The bytes are not a calibration.
    BadCalibration(CalibrationError),
    /// Not while the servos are on: stop first.
    ServosOn,
    /// The buffer has no room for these setpoints; send them again.
    StreamFull,
    /// Setpoints outside a stream, or not 1 to [`crate::STREAM_CAPACITY`] whole poses.
    NoStream,
    /// A speed, an output or a pulse is out of its range.
    Range,
    /// The stored calibration is damaged: send it again.
    CalibrationDamaged,
}
