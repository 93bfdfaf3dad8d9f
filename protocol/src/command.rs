//! Host to robot, and the robot's answers.
//!
//! Every command carries a sequence number in its frame and gets exactly one
//! [`Reply`] with the same number. A command sent again with the number of the
//! last one is answered again and not carried out twice, so a host that missed
//! an answer may simply repeat itself.

mod chunk;
mod reply;

pub use chunk::{Chunk, MAX_CHUNK_LEN};
pub use reply::{
    ActiveGait, CalibrationSource, HelloReply, Limits, Refusal, Reply, Status, Storage, StoredGait,
};

use crate::gait::{Amplitude, Speed};
use serde::{Deserialize, Serialize};

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
