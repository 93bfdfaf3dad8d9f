//! What each command does.
//!
//! Holds the decisions: which command is allowed when, and what the refusal is.
//! Changes nothing before everything has been checked. Does not depend on how a
//! command arrived.

use protocol::calibration::MAX_COUNTS;
use protocol::command::{ActiveGait, CalibrationSource, MAX_CHUNK_LEN, Record, Storage};
use protocol::gait::MAX_ENCODED_LEN;
use protocol::trial::TRIAL_LEN;
use protocol::{
    Amplitude, FRAME_RATE_HZ, Fault, GAIT_SLOTS, HelloReply, JOINT_COUNT, Limits, PROTOCOL_VERSION, Refusal,
    Reply, STREAM_CAPACITY, Speed, Status, WalkEnd,
};

use super::walks::Walk;
use super::{App, Nudge};
use crate::FIRMWARE_VERSION;
use crate::hal::{Board, PersistentMemory, SerialRing};
use crate::link::{self, Command, Outcome, Piece};
use crate::player::Mode;
use crate::store::Kind;

const LIMITS: Limits = Limits {
    frame_rate_hz: FRAME_RATE_HZ as u8,
    max_gait_len: MAX_ENCODED_LEN as u16,
    max_chunk_len: MAX_CHUNK_LEN as u8,
    min_amplitude: Amplitude::MIN,
    max_amplitude: Amplitude::MAX,
    gait_slots: GAIT_SLOTS,
    stream_capacity: STREAM_CAPACITY,
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
            Command::Read { record, offset } => match self.read(board, seq, record, offset) {
                Ok(()) => return None,
                Err(refusal) => Err(refusal),
            },
            Command::StoredGait { slot } => match self.store.stored_gait(board.memory(), slot) {
                Ok(stored) => {
                    link::answer(board.serial(), seq, &Reply::Stored(stored));
                    return None;
                }
                Err(refusal) => Err(refusal),
            },
            Command::Hello { .. } => Err(Refusal::ProtocolVersion { robot: PROTOCOL_VERSION }),
            Command::UploadBegin { len } => self.begin_upload(len),
            Command::UploadChunk { offset, data } => self.upload.take(offset, self.link.piece(data)),
            Command::UploadCommit { amplitude, persist } => self.commit_gait(board, amplitude, persist),
            Command::CalibrationCommit => self.commit_calibration(board),
            Command::Walk { amplitude, frames, detached, dry_run } => {
                self.walk(board, Walk { amplitude, frames, detached, dry_run })
            }
            Command::Stop => {
                self.stop(WalkEnd::Asked);
                Ok(())
            }
            Command::SetAmplitude(amplitude) => self.set_amplitude(amplitude),
            Command::SetSpeed(speed) => self.set_speed(speed),
            Command::StreamTelemetry { every_frames } => {
                self.stream_every(every_frames);
                Ok(())
            }
            Command::ClearFault => self.clear_fault(board),
            Command::Stream => self.stream(board),
            Command::Setpoints { data } if self.player.is_streaming() => {
                self.upload.take_poses(self.link.piece(data))
            }
            Command::Setpoints { .. } => Err(Refusal::NoStream),
            Command::SelectGait { slot } => self.select_gait(board, slot),
            Command::EraseGait { slot } => self.erase_gait(board, slot),
            Command::Nudge { channel, counts } => self.nudge(board, channel, counts),
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
        link::answer(board.serial(), seq, &Reply::Hello(hello));
    }

    #[inline(never)]
    fn tell_status(&self, board: &mut impl Board, seq: u8) {
        let gait = self.gait.bytes();
        let status = Status {
            state: self.state(),
            gait: (!gait.is_empty()).then(|| ActiveGait {
                name: self.gait.name(),
                crc32: self.gait.crc32(),
                amplitude: self.amplitude,
            }),
            storage: self.storage,
            calibration: self.calibration_source,
            bus_mv: self.sample.bus_mv(),
            reset_cause: self.reset_cause,
            uptime_frames: self.uptime_frames,
            stack_left: board.stack_left(),
            bad_frames: self.link.bad_frames(),
            dropped_bytes: board.serial().dropped(),
            bus_errors: board.bus_errors(),
        };
        link::answer(board.serial(), seq, &Reply::Status(status));
    }

    /// Answers with the piece of a record that starts at `offset`.
    ///
    /// # Errors
    /// [`Refusal::NoGait`] without a gait, [`Refusal::StorageBusy`] for a trial
    /// while something is being saved.
    #[inline(never)]
    fn read(&self, board: &mut impl Board, seq: u8, record: Record, offset: u16) -> Result<(), Refusal> {
        let mut trial = [0; TRIAL_LEN];
        let bytes: &[u8] = match record {
            Record::Gait if self.gait.bytes().is_empty() => return Err(Refusal::NoGait),
            Record::Gait => self.gait.bytes(),
            Record::Calibration => self.calibration.bytes(),
            Record::LastTrial => {
                if self.store.load_trial(board.memory(), &mut trial)? {
                    &trial
                } else {
                    &[]
                }
            }
        };
        let rest = bytes.get(usize::from(offset)..).unwrap_or(&[]);
        let piece = rest.get(..MAX_CHUNK_LEN).unwrap_or(rest);
        link::answer(board.serial(), seq, &Reply::Piece(Piece(piece)));
        Ok(())
    }

    const fn begin_upload(&mut self, len: u16) -> Result<(), Refusal> {
        // The stream's setpoints lie in the same buffer.
        if self.player.is_streaming() {
            return Err(Refusal::AlreadyWalking);
        }
        self.upload.begin(len)
    }

    #[inline(never)]
    fn commit_gait(
        &mut self,
        board: &mut impl Board,
        amplitude: Amplitude,
        persist: bool,
    ) -> Result<(), Refusal> {
        if !amplitude.is_valid() {
            return Err(Refusal::Amplitude);
        }
        let encoding = self.upload.whole()?;
        if self.store.saving() == Some(Kind::Gait) {
            return Err(Refusal::StorageBusy);
        }
        let slot = if persist { Some(self.store.free_slot(board.memory())?) } else { None };
        self.gait.replace(encoding).map_err(Refusal::BadGait)?;
        self.amplitude = amplitude;
        self.storage = Storage::RamOnly;
        if let Some(slot) = slot {
            self.store.save_gait(slot, amplitude, self.gait.bytes());
            self.storage = Storage::Saving;
        }
        self.upload.close();
        self.player.replace(&self.gait, amplitude);
        Ok(())
    }

    #[inline(never)]
    fn commit_calibration(&mut self, board: &mut impl Board) -> Result<(), Refusal> {
        self.require_limp()?;
        let record = self.upload.whole()?;
        if self.store.saving().is_some() || board.memory().is_busy() {
            return Err(Refusal::StorageBusy);
        }
        self.calibration.replace(record).map_err(Refusal::BadCalibration)?;
        self.upload.close();
        self.store.save_record(board.memory(), Kind::Calibration, self.calibration.bytes());
        self.calibration_source = CalibrationSource::Stored;
        Ok(())
    }

    fn select_gait(&mut self, board: &mut impl Board, slot: u8) -> Result<(), Refusal> {
        if self.player.is_streaming() {
            return Err(Refusal::AlreadyWalking);
        }
        self.load_gait(board, slot)?;
        self.store.set_start(slot);
        self.player.replace(&self.gait, self.amplitude);
        Ok(())
    }

    fn erase_gait(&mut self, board: &mut impl Board, slot: u8) -> Result<(), Refusal> {
        let name = self.store.erase_gait(board.memory(), slot)?;
        if name == self.gait.name() {
            self.storage = Storage::RamOnly;
        }
        Ok(())
    }

    const fn require_limp(&self) -> Result<(), Refusal> {
        if self.nudge.is_some() || !matches!(self.player.mode(), Mode::Limp) {
            return Err(Refusal::ServosOn);
        }
        Ok(())
    }

    fn nudge(&mut self, board: &mut impl Board, channel: u8, counts: u16) -> Result<(), Refusal> {
        if usize::from(channel) >= JOINT_COUNT || counts > MAX_COUNTS {
            return Err(Refusal::Range);
        }
        if counts == 0 {
            self.nudge = None;
            return Ok(());
        }
        if self.nudge.is_none() {
            if let Some(fault) = self.fault {
                return Err(Refusal::Faulted(fault));
            }
            self.require_limp()?;
            self.require_supply()?;
            self.configure_chips(board).map_err(Refusal::ChipMissing)?;
        }
        // It depends on its host.
        self.detached = false;
        self.nudge = Some(Nudge { channel, counts });
        Ok(())
    }

    fn set_amplitude(&mut self, amplitude: Amplitude) -> Result<(), Refusal> {
        if !amplitude.is_valid() {
            return Err(Refusal::Amplitude);
        }
        if self.gait.bytes().is_empty() {
            return Err(Refusal::NoGait);
        }
        if self.amplitude != amplitude {
            self.amplitude = amplitude;
            self.storage = Storage::RamOnly;
        }
        self.player.set_amplitude(amplitude);
        Ok(())
    }

    const fn set_speed(&mut self, speed: Speed) -> Result<(), Refusal> {
        if !speed.is_valid() {
            return Err(Refusal::Range);
        }
        self.player.set_speed(speed);
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
