//! What the fake robot does with each command.

use super::{FakeRobot, Pose};
use protocol::calibration::MAX_COUNTS;
use protocol::command::{CalibrationSource, HelloReply, Limits, Record, Status, Storage, StoredGait};
use protocol::gait::{Encoded, MAX_ENCODED_LEN};
use protocol::{
    Amplitude, Calibration, Chunk, Command, GAIT_SLOTS, JOINT_COUNT, PROTOCOL_VERSION, Refusal, Reply,
    ResetCause, STREAM_CAPACITY, Speed, State, WalkEnd,
};
use std::collections::VecDeque;

type Outcome = Result<Reply, Refusal>;
const DONE: Outcome = Ok(Reply::Done);

impl FakeRobot {
    pub(super) fn obey(&mut self, command: Command) -> Reply {
        self.done.push(command);
        self.outcome(command).unwrap_or_else(Reply::Refused)
    }

    fn outcome(&mut self, command: Command) -> Outcome {
        match command {
            Command::Hello { protocol_version } => self.hello(protocol_version),
            Command::Status => Ok(self.status()),
            Command::UploadBegin { len } => {
                self.wait_for_eeprom()?;
                self.uploading.clear();
                self.upload_len = len.into();
                DONE
            }
            Command::UploadChunk { offset, data } => {
                let end = usize::from(offset) + data.as_slice().len();
                if usize::from(offset) > self.uploading.len() || end > self.upload_len {
                    return Err(Refusal::UploadRange);
                }
                self.uploading.truncate(offset.into());
                self.uploading.extend(data.as_slice());
                DONE
            }
            Command::UploadCommit { amplitude, persist } => self.commit_gait(amplitude, persist),
            Command::CalibrationCommit => self.commit_calibration(),
            Command::Read { .. } if self.troubles.misremembers => Ok(Reply::Piece(Chunk::of(b"?"))),
            Command::Read { record, offset } => self.read_record(record, offset),
            Command::Walk { amplitude, frames, detached, .. } => {
                let gait = self.active.ok_or(Refusal::NoGait);
                self.check_start()?;
                let gait = gait?;
                self.asked_frames = frames.unwrap_or(u32::MAX);
                self.amplitude = amplitude.unwrap_or(gait.amplitude);
                self.is_detached = detached;
                self.stream = None;
                self.start()
            }
            Command::Stop => {
                if matches!(self.state, State::Entering | State::Walking) {
                    self.end(WalkEnd::Asked);
                }
                DONE
            }
            Command::SetAmplitude(amplitude) => {
                self.amplitude = amplitude;
                DONE
            }
            Command::SetSpeed(speed) => {
                self.speed = speed;
                DONE
            }
            Command::StreamTelemetry { every_frames } => {
                self.telemetry_every = every_frames;
                DONE
            }
            Command::ClearFault => {
                if let State::Fault(_) = self.state {
                    self.state = State::Idle;
                }
                DONE
            }
            Command::Stream => {
                self.check_start()?;
                self.asked_frames = u32::MAX;
                self.is_detached = false;
                self.stream = Some(VecDeque::new());
                self.start()
            }
            Command::Setpoints { data } => self.take_setpoints(data.as_slice()),
            Command::StoredGait { slot } => {
                let place = self.stored.get(usize::from(slot)).ok_or(Refusal::NoSuchGait)?;
                Ok(Reply::Stored(place.as_ref().map(|(gait, _)| *gait)))
            }
            Command::SelectGait { slot } => self.select(slot),
            Command::EraseGait { slot } => {
                self.wait_for_eeprom()?;
                let place = self.stored.get_mut(usize::from(slot));
                place.and_then(Option::take).ok_or(Refusal::NoSuchGait)?;
                DONE
            }
            Command::Nudge { channel, counts } => {
                if channel > 7 || counts > MAX_COUNTS {
                    return Err(Refusal::Range);
                }
                if let State::Entering | State::Walking = self.state {
                    return Err(Refusal::ServosOn);
                }
                self.nudged = (counts > 0).then_some((channel, counts));
                self.nudges.extend(self.nudged);
                DONE
            }
        }
    }

    fn hello(&self, asked: u8) -> Outcome {
        let protocol_version = self.troubles.protocol_version.unwrap_or(PROTOCOL_VERSION);
        if asked != protocol_version {
            return Err(Refusal::ProtocolVersion { robot: protocol_version });
        }
        let limits = Limits {
            frame_rate_hz: 60,
            max_gait_len: MAX_ENCODED_LEN as u16,
            max_chunk_len: 64,
            min_amplitude: Amplitude::MIN,
            max_amplitude: Amplitude::MAX,
            gait_slots: GAIT_SLOTS,
            stream_capacity: STREAM_CAPACITY,
        };
        Ok(Reply::Hello(HelloReply {
            protocol_version,
            firmware_version: [0, 1, 0],
            limits,
            reset_cause: ResetCause::External,
        }))
    }

    fn status(&mut self) -> Reply {
        if self.storage == Storage::Saving {
            self.save_in = self.save_in.saturating_sub(1);
            if self.save_in == 0 {
                self.storage = if self.troubles.worn_out { Storage::Failed } else { Storage::Saved };
            }
        }
        Reply::Status(Status {
            state: self.state,
            gait: self.active,
            storage: self.storage,
            calibration: self.calibration_source,
            bus_mv: self.troubles.supply_mv.unwrap_or(5000),
            reset_cause: ResetCause::External,
            uptime_frames: self.uptime_frames,
            stack_left: 412,
            bad_frames: 2,
            dropped_bytes: 7,
            bus_errors: 1,
        })
    }

    fn check_start(&self) -> Result<(), Refusal> {
        match self.state {
            State::Fault(fault) => Err(Refusal::Faulted(fault)),
            State::Entering | State::Walking => Err(Refusal::AlreadyWalking),
            _ => match self.troubles.supply_mv {
                Some(bus_mv) if bus_mv < self.calibration.board().start_mv => {
                    Err(Refusal::SupplyTooLow { bus_mv })
                }
                _ => Ok(()),
            },
        }
    }

    fn start(&mut self) -> Outcome {
        self.state = State::Entering;
        self.speed = Speed::ONE;
        self.nudged = None;
        (self.entered, self.trial_frames) = (0, 0);
        self.played.clear();
        DONE
    }

    fn wait_for_eeprom(&mut self) -> Result<(), Refusal> {
        let busy = self.troubles.busy_for > 0;
        self.troubles.busy_for = self.troubles.busy_for.saturating_sub(1);
        if busy { Err(Refusal::StorageBusy) } else { Ok(()) }
    }

    fn uploaded(&mut self) -> Result<Vec<u8>, Refusal> {
        self.wait_for_eeprom()?;
        if self.uploading.len() < self.upload_len || self.upload_len == 0 {
            return Err(Refusal::UploadIncomplete);
        }
        self.upload_len = 0;
        Ok(std::mem::take(&mut self.uploading))
    }

    fn commit_gait(&mut self, amplitude: Amplitude, persist: bool) -> Outcome {
        let table = self.uploaded()?;
        Encoded::EMPTY.clone().replace(&table).map_err(Refusal::BadGait)?;
        let before = (self.table.clone(), self.active);
        self.activate(&table, amplitude);
        if persist && let Err(refusal) = self.store_active() {
            (self.table, self.active) = before;
            return Err(refusal);
        }
        self.storage = if persist { Storage::Saving } else { Storage::RamOnly };
        self.save_in = 2;
        DONE
    }

    /// A gait takes a free place; only then is the one of its name forgotten.
    pub(super) fn store_active(&mut self) -> Result<(), Refusal> {
        let Some(active) = self.active else { return Err(Refusal::NoGait) };
        let slot = self.stored.iter().position(Option::is_none).ok_or(Refusal::StorageFull)?;
        for place in &mut self.stored {
            place.take_if(|(gait, _)| gait.name == active.name);
        }
        for (gait, _) in self.stored.iter_mut().flatten() {
            gait.at_start = false;
        }
        let gait = StoredGait { name: active.name, amplitude: active.amplitude, at_start: true };
        self.stored[slot] = Some((gait, self.table.clone()));
        Ok(())
    }

    fn select(&mut self, slot: u8) -> Outcome {
        self.wait_for_eeprom()?;
        let place = self.stored.get(usize::from(slot)).and_then(Option::as_ref);
        let (gait, table) = place.cloned().ok_or(Refusal::NoSuchGait)?;
        self.activate(&table, gait.amplitude);
        for (place, (other, _)) in
            self.stored.iter_mut().enumerate().filter_map(|(i, p)| Some((i, p.as_mut()?)))
        {
            other.at_start = place == usize::from(slot);
        }
        self.storage = Storage::Saved;
        DONE
    }

    fn commit_calibration(&mut self) -> Outcome {
        if self.nudged.is_some() || !matches!(self.state, State::Idle) {
            return Err(Refusal::ServosOn);
        }
        let record = self.uploaded()?;
        self.calibration = Calibration::from_bytes(&record).map_err(Refusal::BadCalibration)?;
        self.calibration_source =
            if self.troubles.worn_out { CalibrationSource::NotSaved } else { CalibrationSource::Stored };
        DONE
    }

    fn read_record(&mut self, record: Record, offset: u16) -> Outcome {
        let bytes = match record {
            Record::Gait if self.active.is_none() => return Err(Refusal::NoGait),
            Record::Gait => self.table.clone(),
            Record::Calibration => self.calibration.bytes().to_vec(),
            Record::LastTrial => {
                self.wait_for_eeprom()?;
                self.last_trial.map(|trial| trial.bytes().to_vec()).unwrap_or_default()
            }
        };
        Ok(Reply::Piece(Chunk::of(bytes.get(usize::from(offset)..).unwrap_or(&[]))))
    }

    fn take_setpoints(&mut self, data: &[u8]) -> Outcome {
        let stream = self.stream.as_mut().ok_or(Refusal::NoStream)?;
        let (poses, rest) = data.as_chunks::<{ 2 * JOINT_COUNT }>();
        if poses.is_empty() || !rest.is_empty() || poses.len() > usize::from(STREAM_CAPACITY) {
            return Err(Refusal::NoStream);
        }
        if stream.len() + poses.len() > usize::from(STREAM_CAPACITY) {
            return Err(Refusal::StreamFull);
        }
        stream.extend(poses.iter().map(|pose| -> Pose {
            let (angles, _) = pose.as_chunks::<2>();
            std::array::from_fn(|joint| i16::from_le_bytes(angles[joint]))
        }));
        Ok(Reply::Buffered(stream.len() as u8))
    }
}
