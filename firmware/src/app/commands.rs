//! What each command does.
//!
//! Owns the decisions: who may do what when, and what the refusal is. Changes
//! nothing before everything has been checked.

use postcard::ser_flavors::Flavor;
use protocol::command::{ActiveGait, MAX_CHUNK_LEN, Storage};
use protocol::gait::MAX_ENCODED_LEN;
use protocol::{
    Amplitude, Chunk, Command, FRAME_RATE_HZ, GaitTable, HelloReply, Limits, PROTOCOL_VERSION, Refusal,
    Reply, Status,
};

use super::App;
use crate::FIRMWARE_VERSION;
use crate::hal::Board;
use crate::player::Mode;
use crate::power::Trial;

const LIMITS: Limits = Limits {
    frame_rate_hz: FRAME_RATE_HZ as u8,
    max_gait_len: MAX_ENCODED_LEN as u16,
    max_chunk_len: MAX_CHUNK_LEN as u8,
    min_amplitude: Amplitude::MIN,
    max_amplitude: Amplitude::MAX,
};

impl App {
    /// Carries out one command, and answers it.
    pub(super) fn obey(&mut self, board: &mut impl Board, seq: u8, command: &Command) -> Reply {
        let outcome = match *command {
            Command::Hello { protocol_version } => return self.hello(protocol_version),
            Command::Status => return Reply::Status(self.status()),
            Command::ReadGait { offset } => return self.read_gait(offset),
            Command::UploadBegin { len } => self.begin_upload(len),
            Command::UploadChunk { offset, ref data } => self.upload.take(offset, data.as_slice()),
            Command::UploadCommit { amplitude, persist } => self.commit_upload(amplitude, persist),
            Command::Walk { amplitude, frames } => self.walk(board, amplitude, frames),
            Command::Stop => {
                self.player.stop();
                Ok(())
            }
            Command::SetAmplitude(amplitude) => self.set_amplitude(amplitude),
            Command::StreamTelemetry { every_frames } => {
                self.stream_every(every_frames);
                Ok(())
            }
            Command::ClearFault => self.clear_fault(board),
        };
        self.link.remember(seq, outcome);
        reply_of(outcome)
    }

    fn hello(&self, protocol_version: u8) -> Reply {
        if protocol_version != PROTOCOL_VERSION {
            return Reply::Refused(Refusal::ProtocolVersion { robot: PROTOCOL_VERSION });
        }
        Reply::Hello(HelloReply {
            protocol_version: PROTOCOL_VERSION,
            firmware_version: FIRMWARE_VERSION,
            limits: LIMITS,
            reset_cause: self.reset_cause,
        })
    }

    fn status(&self) -> Status {
        Status {
            state: self.state(),
            gait: self.active,
            storage: self.storage,
            bus_mv: self.sample.bus_mv(),
            bad_frames: self.link.bad_frames(),
        }
    }

    #[inline(never)]
    fn read_gait(&self, offset: u16) -> Reply {
        let Some(active) = self.active else { return Reply::Refused(Refusal::NoGait) };
        let window = Window { skip: offset, bytes: heapless::Vec::new() };
        let Ok(mut window) = postcard::serialize_with_flavor::<GaitTable, Window, Window>(&self.gait, window)
        else {
            return Reply::Refused(Refusal::NoGait);
        };
        for byte in active.crc32.to_le_bytes() {
            window.take(byte);
        }
        Reply::GaitChunk(Chunk::of(&window.bytes))
    }

    fn begin_upload(&mut self, len: u16) -> Result<(), Refusal> {
        // The table being saved lies in the same buffer.
        if self.store.is_saving() {
            return Err(Refusal::StorageBusy);
        }
        self.upload.begin(len)
    }

    #[inline(never)]
    fn commit_upload(&mut self, amplitude: Amplitude, persist: bool) -> Result<(), Refusal> {
        if !amplitude.is_valid() {
            return Err(Refusal::Amplitude);
        }
        let table = self.upload.whole()?;
        self.gait.decode_into(table).map_err(Refusal::BadGait)?;
        self.active = Some(ActiveGait { name: self.gait.name, crc32: GaitTable::crc32_of(table), amplitude });
        self.storage = Storage::RamOnly;
        // An upload can only have begun while no save was going on.
        if persist && self.store.begin(table, amplitude) {
            self.storage = Storage::Saving;
        }
        self.upload.close();
        self.player.replace(&self.gait, amplitude);
        Ok(())
    }

    #[inline(never)]
    fn walk(
        &mut self,
        board: &mut impl Board,
        amplitude: Option<Amplitude>,
        frames: Option<u32>,
    ) -> Result<(), Refusal> {
        if let Some(fault) = self.fault {
            return Err(Refusal::Faulted(fault));
        }
        if matches!(self.player.mode(), Mode::Entering | Mode::Walking) {
            return Err(Refusal::AlreadyWalking);
        }
        let active = self.active.ok_or(Refusal::NoGait)?;
        let amplitude = amplitude.unwrap_or(active.amplitude);
        if !amplitude.is_valid() {
            return Err(Refusal::Amplitude);
        }
        self.configure_chips(board).map_err(Refusal::ChipMissing)?;
        self.trial = Trial::NONE;
        // What is still on its way to the servos belongs to the walk before.
        for frame in [&mut self.live, &mut self.staged] {
            (frame.gait, frame.last) = (false, false);
        }
        self.player.walk(&self.gait, amplitude, frames);
        Ok(())
    }

    fn set_amplitude(&mut self, amplitude: Amplitude) -> Result<(), Refusal> {
        if !amplitude.is_valid() {
            return Err(Refusal::Amplitude);
        }
        let active = self.active.as_mut().ok_or(Refusal::NoGait)?;
        active.amplitude = amplitude;
        self.player.set_amplitude(amplitude);
        Ok(())
    }

    fn clear_fault(&mut self, board: &mut impl Board) -> Result<(), Refusal> {
        if self.fault.is_some() {
            self.configure_chips(board).map_err(Refusal::ChipMissing)?;
            self.fault = None;
        }
        Ok(())
    }
}

/// The answer to a command that changes something.
pub(super) const fn reply_of(outcome: Result<(), Refusal>) -> Reply {
    match outcome {
        Ok(()) => Reply::Done,
        Err(refusal) => Reply::Refused(refusal),
    }
}

/// The part of an encoding that one answer holds: streaming the active gait
/// through it needs no second buffer of 256 bytes.
struct Window {
    skip: u16,
    bytes: heapless::Vec<u8, MAX_CHUNK_LEN>,
}

impl Window {
    fn take(&mut self, byte: u8) {
        if self.skip > 0 {
            self.skip -= 1;
        } else {
            // Full: the rest is for the next question.
            let _ = self.bytes.push(byte);
        }
    }
}

impl Flavor for Window {
    type Output = Self;

    fn try_push(&mut self, byte: u8) -> postcard::Result<()> {
        self.take(byte);
        Ok(())
    }

    fn finalize(self) -> postcard::Result<Self> {
        Ok(self)
    }
}
