//! What each command does.
//!
//! Owns the decisions: who may do what when, and what the refusal is. Changes
//! nothing before everything has been checked.

use protocol::command::{ActiveGait, MAX_CHUNK_LEN, Storage};
use protocol::gait::MAX_ENCODED_LEN;
use protocol::{
    Amplitude, FRAME_RATE_HZ, Fault, GaitTable, HelloReply, Limits, PROTOCOL_VERSION, Refusal, Reply, Status,
};

use super::App;
use crate::FIRMWARE_VERSION;
use crate::hal::Board;
use crate::link::{self, Command, Outcome, Piece};
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
    /// Answers a question, or carries out a command and returns its outcome.
    #[inline(never)]
    pub(super) fn obey(&mut self, board: &mut impl Board, seq: u8, command: &Command) -> Option<Outcome> {
        Some(match *command {
            Command::Hello { protocol_version: PROTOCOL_VERSION } => {
                self.say_hello(board, seq);
                return None;
            }
            Command::Status => {
                self.tell_status(board, seq);
                return None;
            }
            Command::ReadGait { offset } if self.active.is_some() => {
                self.read_gait(board, seq, offset);
                return None;
            }
            Command::Hello { .. } => Err(Refusal::ProtocolVersion { robot: PROTOCOL_VERSION }),
            Command::ReadGait { .. } => Err(Refusal::NoGait),
            Command::UploadBegin { len } => self.begin_upload(len),
            Command::UploadChunk { offset, data } => self.upload.take(offset, self.link.piece(data)),
            Command::UploadCommit { amplitude, persist } => self.commit_upload(amplitude, persist),
            Command::Walk { amplitude, frames, detached } => self.walk(board, amplitude, frames, detached),
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
        })
    }

    #[inline(never)]
    fn say_hello(&self, board: &mut impl Board, seq: u8) {
        let hello = HelloReply {
            protocol_version: PROTOCOL_VERSION,
            firmware_version: FIRMWARE_VERSION,
            limits: LIMITS,
            reset_cause: self.reset_cause,
        };
        link::answer(board.serial(), seq, Reply::Hello(hello));
    }

    #[inline(never)]
    fn tell_status(&self, board: &mut impl Board, seq: u8) {
        let status = Status {
            state: self.state(),
            gait: self.active,
            storage: self.storage,
            bus_mv: self.sample.bus_mv(),
            bad_frames: self.link.bad_frames(),
        };
        link::answer(board.serial(), seq, Reply::Status(status));
    }

    /// Streams the active gait through the part of it that one answer holds: a
    /// second buffer for all of it would take 256 bytes.
    #[inline(never)]
    fn read_gait(&self, board: &mut impl Board, seq: u8, offset: u16) {
        let mut window = Window { skip: offset, bytes: heapless::Vec::new() };
        self.gait.for_each_byte(|byte| window.take(byte));
        let crc32 = self.active.map_or(0, |active| active.crc32);
        for byte in crc32.to_le_bytes() {
            window.take(byte);
        }
        link::answer(board.serial(), seq, Reply::GaitChunk(Piece(&window.bytes)));
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
        detached: bool,
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
        self.require_supply()?;
        self.configure_chips(board).map_err(Refusal::ChipMissing)?;
        self.trial = Trial::NONE;
        // What is still on its way to the servos belongs to the walk before.
        for frame in [&mut self.live, &mut self.staged] {
            (frame.gait, frame.last) = (false, false);
        }
        self.detached = detached;
        self.player.walk(&self.gait, amplitude, frames);
        Ok(())
    }

    fn set_amplitude(&mut self, amplitude: Amplitude) -> Result<(), Refusal> {
        if !amplitude.is_valid() {
            return Err(Refusal::Amplitude);
        }
        let active = self.active.as_mut().ok_or(Refusal::NoGait)?;
        if active.amplitude != amplitude {
            active.amplitude = amplitude;
            self.storage = Storage::RamOnly;
        }
        self.player.set_amplitude(amplitude);
        Ok(())
    }

    fn clear_fault(&mut self, board: &mut impl Board) -> Result<(), Refusal> {
        if let Some(fault) = self.fault {
            if fault == Fault::Undervoltage {
                self.require_supply()?;
            }
            self.configure_chips(board).map_err(Refusal::ChipMissing)?;
            self.fault = None;
        }
        Ok(())
    }
}

/// The part of an encoding that one answer holds.
struct Window {
    skip: u16,
    bytes: heapless::Vec<u8, MAX_CHUNK_LEN>,
}

impl Window {
    // Called from a dozen places.
    #[inline(never)]
    fn take(&mut self, byte: u8) {
        if self.skip > 0 {
            self.skip -= 1;
        } else {
            // Full: the rest is for the next question.
            let _ = self.bytes.push(byte);
        }
    }
}
