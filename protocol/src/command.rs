//! Host to robot, and the robot's answers.
//!
//! Every command carries a sequence number in its frame and gets exactly one
//! [`Reply`] with the same number. A command sent again with the number of the
//! last one is answered again and not carried out twice, so a host that missed
//! an answer may simply repeat itself.

use crate::calibration::CalibrationError;
use crate::gait::{Amplitude, GaitError, Name, Speed};
use crate::telemetry::{Fault, ResetCause, State};
use serde::{Deserialize, Serialize};

/// Longest piece of a gait in one frame.
pub const MAX_CHUNK_LEN: usize = 64;

/// What the host asks for.
///
/// `D` is what holds a piece of a table; a robot that has the piece in its
/// receive buffer already takes a type that only says where.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Command<D = Chunk> {
    /// Who are you? Always the first command; encoding frozen.
    Hello {
        /// The host's [`crate::PROTOCOL_VERSION`].
        protocol_version: u8,
    },
    /// What are you doing?
    Status,
    /// A gait or a calibration of `len` bytes (CRC included) follows in chunks.
    UploadBegin {
        /// Length of the encoded table.
        len: u16,
    },
    /// A piece of the encoded table; no piece may leave a gap before it.
    UploadChunk {
        /// Where the piece starts.
        offset: u16,
        /// The piece.
        data: D,
    },
    /// All pieces are there: verify, make the gait active, or change nothing.
    UploadCommit {
        /// Amplitude that becomes the gait's default.
        amplitude: Amplitude,
        /// Also save both to EEPROM, while going on with whatever is going on.
        persist: bool,
    },
    /// All pieces of a [`crate::Calibration`] are there: verify, use and save it,
    /// or change nothing. Only while the servos are limp.
    CalibrationCommit,
    /// A piece of a record, for a host that wants to compare.
    Read {
        /// Which one.
        record: Record,
        /// Where the piece starts.
        offset: u16,
    },
    /// Enter the gait slowly, then walk.
    ///
    /// Attached, the robot depends on its host: it stops when it has heard no
    /// command for [`crate::LINK_TIMEOUT_FRAMES`]. Any command will do; repeats
    /// count, damaged frames do not.
    Walk {
        /// `None` walks with the stored amplitude.
        amplitude: Option<Amplitude>,
        /// Gait frames to walk before stopping by itself; `None` until [`Self::Stop`].
        frames: Option<u32>,
        /// Whether it walks on without a host.
        detached: bool,
        /// Whether everything happens but the pulses: a rehearsal with limp servos.
        dry_run: bool,
    },
    /// Stop walking: go to the gait's centre at bounded joint speed, hold for a
    /// moment, then let the servos go limp.
    Stop,
    /// Scale the gait from now on, without a jump.
    SetAmplitude(Amplitude),
    /// Play the gait faster, slower, or not at all from now on, without a jump.
    ///
    /// A new walk starts at speed 1.0.
    SetSpeed(Speed),
    /// Stream telemetry every this many frames; 0 is off.
    StreamTelemetry {
        /// 1 is every frame, 60 a second.
        every_frames: u8,
    },
    /// Leave the fault state, if its cause is gone.
    ClearFault,
    /// Play setpoints from the host: move slowly to the first, then take one a
    /// frame. A buffer that runs dry ends the walk.
    Stream,
    /// The next setpoints of a stream, answered by [`Reply::Buffered`], or
    /// refused whole with [`Refusal::StreamFull`].
    Setpoints {
        /// 1 to [`crate::STREAM_CAPACITY`] poses of 8 angles, each an i16 in
        /// 1/256 degree, little endian, in joint order.
        data: D,
    },
    /// What a place for gaits holds.
    StoredGait {
        /// 0 to [`crate::GAIT_SLOTS`] - 1.
        slot: u8,
    },
    /// Make a stored gait the active one, now and at every start.
    SelectGait {
        /// Its place.
        slot: u8,
    },
    /// Forget a stored gait; the active one stays active until the next start.
    EraseGait {
        /// Its place.
        slot: u8,
    },
    /// Send pulses to one output alone, all others limp: for calibrating.
    ///
    /// The output goes limp when no command has come for
    /// [`crate::LINK_TIMEOUT_FRAMES`].
    Nudge {
        /// PCA9685 output, 0 to 7.
        channel: u8,
        /// Pulse length in PWM counts; 0 ends it.
        counts: u16,
    },
}

/// What can be read from a robot in pieces.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Record {
    /// The active gait, as it was uploaded.
    Gait,
    /// The [`crate::Calibration`] in use.
    Calibration,
    /// The [`crate::TrialRecord`] of the last walk; empty if there is none.
    LastTrial,
}

/// Up to [`MAX_CHUNK_LEN`] bytes of a gait table.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct Chunk {
    len: u8,
    bytes: [u8; MAX_CHUNK_LEN],
}

impl Chunk {
    /// The first bytes of `bytes`, as many as fit.
    #[must_use]
    pub fn of(bytes: &[u8]) -> Self {
        let len = bytes.len().min(MAX_CHUNK_LEN);
        let mut chunk = Self { len: len as u8, bytes: [0; MAX_CHUNK_LEN] };
        chunk.bytes[..len].copy_from_slice(&bytes[..len]);
        chunk
    }

    /// The bytes.
    #[must_use]
    pub fn as_slice(&self) -> &[u8] {
        &self.bytes[..self.len as usize]
    }
}

impl core::fmt::Debug for Chunk {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        self.as_slice().fmt(f)
    }
}

impl Serialize for Chunk {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_bytes(self.as_slice())
    }
}

impl<'de> Deserialize<'de> for Chunk {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Visitor;
        impl serde::de::Visitor<'_> for Visitor {
            type Value = Chunk;

            fn expecting(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
                f.write_str("at most 64 bytes")
            }

            fn visit_bytes<E: serde::de::Error>(self, bytes: &[u8]) -> Result<Chunk, E> {
                if bytes.len() > MAX_CHUNK_LEN {
                    return Err(E::invalid_length(bytes.len(), &self));
                }
                Ok(Chunk::of(bytes))
            }
        }
        deserializer.deserialize_bytes(Visitor)
    }
}

/// The robot's answer to one command; `D` holds a piece of a table.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Reply<D = Chunk> {
    /// To [`Command::Hello`] of the same protocol version.
    Hello(HelloReply),
    /// Not done, and nothing changed. Second place: encoding frozen with it.
    Refused(Refusal),
    /// Done.
    Done,
    /// To [`Command::Status`].
    Status(Status),
    /// To [`Command::Read`]; empty past the end of the record.
    Piece(D),
    /// To [`Command::Setpoints`]: how many are buffered now.
    Buffered(u8),
    /// To [`Command::StoredGait`].
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

/// The gait that [`Command::Walk`] would play.
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
    /// A latched fault stands in the way.
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
    /// There is no such place, or nothing in it.
    NoSuchGait,
    /// What came is no calibration.
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
