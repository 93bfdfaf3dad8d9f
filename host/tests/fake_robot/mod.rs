//! A robot that exists only as bytes: it answers the protocol as the firmware
//! does, and fails on request. It advances one frame whenever it is listened
//! to and has nothing to say, so a trial takes no time.
//!
//! Beyond 300 lines, because its answers and its troubles share one state.
// Every test file uses another part of it.
#![allow(dead_code)]

#[cfg(target_os = "linux")]
pub mod bench;

use protocol::command::{ActiveGait, HelloReply, Limits, Status, Storage};
use protocol::frame::{Decoder, MAX_FRAME_LEN, Request, encode, parse};
use protocol::{
    Amplitude, Chunk, Command, Event, Fault, GaitTable, LINK_TIMEOUT_FRAMES, Message, PROTOCOL_VERSION,
    Refusal, Reply, ResetCause, State, Telemetry,
};
use std::collections::VecDeque;
use std::io::{Error, ErrorKind, Read, Result, Write};

/// What goes wrong, and when.
#[derive(Debug, Default, Clone)]
pub struct Troubles {
    /// Says nothing at all.
    pub silent: bool,
    /// Sends this instead of anything sensible.
    pub babbles: Option<Vec<u8>>,
    /// Speaks this version.
    pub protocol_version: Option<u8>,
    /// Loses every n-th answer.
    pub loses_every: Option<u32>,
    /// Flips a bit in every n-th byte it sends.
    pub flips_every: Option<u32>,
    /// The cable is pulled after so many bytes to the robot.
    pub cut_after: Option<usize>,
    /// The EEPROM does not verify.
    pub worn_out: bool,
    /// Starts anew in this frame of the walk.
    pub resets_at: Option<u32>,
    /// Loses its sensor in this frame of the walk.
    pub faults_at: Option<u32>,
    /// Goes limp in this frame of the walk.
    pub ends_at: Option<u32>,
    /// Misses its host after 60 frames of a walk without a command, as the
    /// firmware does; for robots that run in real time.
    pub depends_on_host: bool,
    /// Drops the telemetry of every n-th frame.
    pub drops_telemetry_every: Option<u32>,
    /// Nothing but a question mark in place of the gait read back.
    pub misremembers: bool,
}

/// Frames of the slow entry.
const ENTRY_FRAMES: u32 = 30;
/// Energy of each gait frame: 0.9 W at 60 Hz.
pub const FRAME_ENERGY_UJ: u64 = 15_000;

#[derive(Debug)]
pub struct FakeRobot {
    pub troubles: Troubles,
    /// Encoded table of the active gait.
    pub table: Vec<u8>,
    pub active: Option<ActiveGait>,
    pub storage: Storage,
    /// Every command that was carried out, repeats not counted.
    pub done: Vec<Command>,
    pub state: State,
    uploading: Vec<u8>,
    received: Vec<bool>,
    decoder: Decoder,
    out: VecDeque<u8>,
    last: Option<(u8, Command, Reply)>,
    bytes_in: usize,
    bytes_out: u32,
    answers: u32,
    save_in: u32,
    telemetry_every: u8,
    uptime_frames: u32,
    asked_frames: u32,
    entered: u32,
    trial_frames: u32,
    silent_frames: u8,
}

impl FakeRobot {
    pub fn new(troubles: Troubles) -> Self {
        Self {
            troubles,
            table: Vec::new(),
            active: None,
            storage: Storage::RamOnly,
            done: Vec::new(),
            state: State::Idle,
            uploading: Vec::new(),
            received: Vec::new(),
            decoder: Decoder::new(),
            out: VecDeque::new(),
            last: None,
            bytes_in: 0,
            bytes_out: 0,
            answers: 0,
            save_in: 0,
            telemetry_every: 0,
            uptime_frames: 0,
            asked_frames: 0,
            entered: 0,
            trial_frames: 0,
            silent_frames: 0,
        }
    }

    /// With a gait, as if uploaded and saved before.
    pub fn with_gait(troubles: Troubles, table: &[u8], amplitude: f64) -> Self {
        let mut robot = Self::new(troubles);
        robot.activate(table, Amplitude::from_f64(amplitude).expect("in range"));
        robot.storage = Storage::Saved;
        robot
    }

    fn activate(&mut self, table: &[u8], amplitude: Amplitude) {
        let gait = GaitTable::decode(table).expect("a whole table");
        let crc32 = u32::from_le_bytes(*table.last_chunk().expect("a CRC"));
        self.active = Some(ActiveGait { name: gait.name, crc32, amplitude });
        self.table = table.to_vec();
    }

    /// What opening the port does to a Nano.
    pub fn reset(&mut self, cause: ResetCause) {
        let troubles = self.troubles.clone();
        let (table, active, storage) = (std::mem::take(&mut self.table), self.active, self.storage);
        let done = std::mem::take(&mut self.done);
        *self = Self { table, active, storage, done, ..Self::new(troubles) };
        self.say(&Message::Event(Event::Started(cause)));
    }

    fn say(&mut self, message: &Message) {
        if self.troubles.silent {
            return;
        }
        if let Some(babble) = &self.troubles.babbles {
            self.out.extend(babble);
            return;
        }
        let mut buffer = [0; MAX_FRAME_LEN];
        for &byte in encode(message, &mut buffer).expect("messages fit frames") {
            self.bytes_out += 1;
            let flip = self.troubles.flips_every.is_some_and(|n| self.bytes_out.is_multiple_of(n));
            self.out.push_back(if flip { byte ^ 0x04 } else { byte });
        }
    }

    fn hear(&mut self, request: Request) {
        let Request { seq, command } = request;
        self.silent_frames = 0;
        let reply = match self.last {
            Some((last_seq, last, reply)) if (last_seq, last) == (seq, command) => reply,
            _ => self.obey(command),
        };
        self.last = Some((seq, command, reply));
        self.answers += 1;
        if self.troubles.loses_every.is_some_and(|n| self.answers.is_multiple_of(n)) {
            return;
        }
        self.say(&Message::Reply { seq, reply });
    }

    fn obey(&mut self, command: Command) -> Reply {
        self.done.push(command);
        match command {
            Command::Hello { protocol_version } => self.hello(protocol_version),
            Command::Status => self.status(),
            Command::UploadBegin { len } => {
                self.uploading = vec![0; len.into()];
                self.received = vec![false; len.into()];
                Reply::Done
            }
            Command::UploadChunk { offset, data } => {
                let place = usize::from(offset)..usize::from(offset) + data.as_slice().len();
                match self.uploading.get_mut(place.clone()) {
                    None => Reply::Refused(Refusal::UploadRange),
                    Some(bytes) => {
                        bytes.copy_from_slice(data.as_slice());
                        self.received[place].fill(true);
                        Reply::Done
                    }
                }
            }
            Command::UploadCommit { amplitude, persist } => self.commit(amplitude, persist),
            Command::ReadGait { .. } if self.troubles.misremembers => Reply::GaitChunk(Chunk::of(b"?")),
            Command::ReadGait { .. } if self.active.is_none() => Reply::Refused(Refusal::NoGait),
            Command::ReadGait { offset } => {
                Reply::GaitChunk(Chunk::of(self.table.get(usize::from(offset)..).unwrap_or(&[])))
            }
            Command::Walk { frames, .. } => match self.state {
                State::Fault(fault) => Reply::Refused(Refusal::Faulted(fault)),
                State::Entering | State::Walking => Reply::Refused(Refusal::AlreadyWalking),
                _ if self.active.is_none() => Reply::Refused(Refusal::NoGait),
                _ => {
                    self.state = State::Entering;
                    self.asked_frames = frames.unwrap_or(u32::MAX);
                    (self.entered, self.trial_frames) = (0, 0);
                    Reply::Done
                }
            },
            Command::Stop => {
                self.state = State::Idle;
                Reply::Done
            }
            Command::StreamTelemetry { every_frames } => {
                self.telemetry_every = every_frames;
                Reply::Done
            }
            Command::SetAmplitude(_) => Reply::Done,
            Command::ClearFault => {
                self.state = State::Idle;
                Reply::Done
            }
        }
    }

    fn hello(&self, asked: u8) -> Reply {
        let protocol_version = self.troubles.protocol_version.unwrap_or(PROTOCOL_VERSION);
        if asked != protocol_version {
            return Reply::Refused(Refusal::ProtocolVersion { robot: protocol_version });
        }
        let limits = Limits {
            frame_rate_hz: 60,
            max_gait_len: 256,
            max_chunk_len: 64,
            min_amplitude: Amplitude::MIN,
            max_amplitude: Amplitude::MAX,
        };
        Reply::Hello(HelloReply {
            protocol_version,
            firmware_version: [0, 1, 0],
            limits,
            reset_cause: ResetCause::External,
        })
    }

    fn status(&mut self) -> Reply {
        if self.storage == Storage::Saving {
            self.save_in = self.save_in.saturating_sub(1);
            if self.save_in == 0 {
                self.storage = if self.troubles.worn_out { Storage::Failed } else { Storage::Saved };
            }
        }
        let (state, gait, storage) = (self.state, self.active, self.storage);
        Reply::Status(Status { state, gait, storage, bus_mv: 5000, bad_frames: 0 })
    }

    fn commit(&mut self, amplitude: Amplitude, persist: bool) -> Reply {
        if self.received.contains(&false) || self.received.is_empty() {
            return Reply::Refused(Refusal::UploadIncomplete);
        }
        let table = std::mem::take(&mut self.uploading);
        self.received.clear();
        if let Err(error) = GaitTable::decode(&table) {
            return Reply::Refused(Refusal::BadGait(error));
        }
        self.activate(&table, amplitude);
        self.storage = if persist { Storage::Saving } else { Storage::RamOnly };
        self.save_in = 2;
        Reply::Done
    }

    /// One sixtieth of a second.
    pub fn frame(&mut self) {
        self.uptime_frames += 1;
        self.silent_frames = self.silent_frames.saturating_add(1);
        let is_walking = matches!(self.state, State::Entering | State::Walking);
        if is_walking && self.troubles.depends_on_host && self.silent_frames >= LINK_TIMEOUT_FRAMES {
            self.state = State::Holding;
            self.say(&Message::Event(Event::LinkLost));
        }
        match self.state {
            State::Entering => {
                self.entered += 1;
                if self.entered == ENTRY_FRAMES {
                    self.state = State::Walking;
                }
            }
            State::Walking => self.walk(),
            _ => {}
        }
        let dropped =
            self.troubles.drops_telemetry_every.is_some_and(|n| self.uptime_frames.is_multiple_of(n));
        if self.telemetry_every > 0 && !dropped {
            self.say(&Message::Telemetry(Telemetry {
                uptime_frames: self.uptime_frames,
                state: self.state,
                trial_frames: self.trial_frames,
                trial_energy_uj: u64::from(self.trial_frames) * FRAME_ENERGY_UJ,
                clipped_frames: 0,
                phase: 0,
                bus_mv: 5000,
                current_ua: 180_000,
                missed_samples: 0,
            }));
        }
    }

    fn walk(&mut self) {
        self.trial_frames += 1;
        let now = Some(self.trial_frames);
        if now == self.troubles.resets_at {
            self.reset(ResetCause::BrownOut);
        } else if now == self.troubles.faults_at {
            self.state = State::Fault(Fault::SensorLost);
            self.say(&Message::Event(Event::Fault(Fault::SensorLost)));
        } else if now == self.troubles.ends_at {
            self.state = State::Idle;
        } else if self.trial_frames == self.asked_frames {
            self.state = State::Holding;
            self.say(&Message::Event(Event::WalkFinished));
        }
    }

    /// Gait frames of the last walk.
    pub fn trial_frames(&self) -> u32 {
        self.trial_frames
    }

    /// What it has said and nobody has fetched yet.
    pub fn take_said(&mut self) -> Vec<u8> {
        self.out.drain(..).collect()
    }

    fn is_cut(&self) -> bool {
        self.troubles.cut_after.is_some_and(|limit| self.bytes_in >= limit)
    }
}

impl Read for FakeRobot {
    fn read(&mut self, buffer: &mut [u8]) -> Result<usize> {
        if self.is_cut() {
            return Err(Error::from(ErrorKind::BrokenPipe));
        }
        if self.out.is_empty() {
            self.frame();
        }
        if self.out.is_empty() {
            return Err(Error::from(ErrorKind::TimedOut));
        }
        let count = self.out.len().min(buffer.len());
        for (place, byte) in buffer.iter_mut().zip(self.out.drain(..count)) {
            *place = byte;
        }
        Ok(count)
    }
}

impl Write for FakeRobot {
    fn write(&mut self, bytes: &[u8]) -> Result<usize> {
        for &byte in bytes {
            if self.is_cut() {
                return Err(Error::from(ErrorKind::BrokenPipe));
            }
            self.bytes_in += 1;
            let request = self.decoder.push(byte).map(|body| body.and_then(parse::<Request>));
            if let Some(Ok(request)) = request {
                self.hear(request);
            }
        }
        Ok(bytes.len())
    }

    fn flush(&mut self) -> Result<()> {
        Ok(())
    }
}
