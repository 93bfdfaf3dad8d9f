//! A robot that exists only as bytes: it answers the protocol as the firmware
//! does, and fails on request. It advances one frame whenever it is listened
//! to and has nothing to say, so a trial takes no time.
//!
//! Here are its wires and its frames, beyond 300 lines because they share one
//! state with its troubles; what each command does is in [`obey`].
// Every test file uses another part of it.
#![allow(dead_code)]

#[cfg(target_os = "linux")]
pub mod bench;
mod obey;

use protocol::command::{ActiveGait, CalibrationSource, Storage, StoredGait};
use protocol::frame::{Decoder, MAX_FRAME_LEN, Request, STOP_BYTE, encode, parse};
use protocol::gait::Encoded;
use protocol::{
    Amplitude, Calibration, Command, Event, Fault, GAIT_SLOTS, JOINT_COUNT, LINK_TIMEOUT_FRAMES, Message,
    Reply, ResetCause, Speed, State, Telemetry, TrialRecord, WalkEnd,
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
    /// Somebody presses its button in this frame of the walk.
    pub button_at: Option<u32>,
    /// Misses its host after 60 frames of a walk without a command, as the
    /// firmware does; for robots that run in real time.
    pub depends_on_host: bool,
    /// Drops the telemetry of every n-th frame.
    pub drops_telemetry_every: Option<u32>,
    /// Nothing but a question mark in place of what was uploaded.
    pub misremembers: bool,
    /// Answers so many commands that touch its EEPROM with "busy" first.
    pub busy_for: u32,
    /// Has this little at rest.
    pub supply_mv: Option<u16>,
    /// Waits for setpoints that are late, for tests in real time on busy machines
    /// that are about something else.
    pub forgives_late_setpoints: bool,
    /// Setpoints run dry in this frame, whatever is in the buffer.
    pub runs_dry_at: Option<u32>,
}

/// Frames of the slow entry.
const ENTRY_FRAMES: u32 = 30;
/// Frames from the end of a walk until the servos are limp.
const HOLD_FRAMES: u32 = 60;
/// Energy of each gait frame: 0.9 W at 60 Hz.
pub const FRAME_ENERGY_UJ: u64 = 15_000;

/// Eight angles in 1/256 degree.
pub type Pose = [i16; JOINT_COUNT];

#[derive(Debug)]
pub struct FakeRobot {
    pub troubles: Troubles,
    /// The active gait's bytes.
    pub table: Vec<u8>,
    pub active: Option<ActiveGait>,
    pub storage: Storage,
    /// Every command that was carried out, repeats not counted.
    pub done: Vec<Command>,
    pub state: State,
    /// Its EEPROM: gaits by place, calibration, the last walk.
    pub stored: [Option<(StoredGait, Vec<u8>)>; GAIT_SLOTS as usize],
    pub calibration: Calibration,
    pub calibration_source: CalibrationSource,
    pub last_trial: Option<TrialRecord>,
    /// Setpoints that it has played.
    pub played: Vec<Pose>,
    /// Output and counts that are being nudged.
    pub nudged: Option<(u8, u16)>,
    /// All nudges, the ends of them not counted.
    pub nudges: Vec<(u8, u16)>,
    pub amplitude: Amplitude,
    pub speed: Speed,
    pub stop_bytes: u32,
    is_detached: bool,
    stream: Option<VecDeque<Pose>>,
    uploading: Vec<u8>,
    upload_len: usize,
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
    held: u32,
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
            stored: Default::default(),
            calibration: Calibration::authors(),
            calibration_source: CalibrationSource::Default,
            last_trial: None,
            played: Vec::new(),
            nudged: None,
            nudges: Vec::new(),
            amplitude: Amplitude::ONE,
            speed: Speed::ONE,
            stop_bytes: 0,
            is_detached: false,
            stream: None,
            uploading: Vec::new(),
            upload_len: 0,
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
            held: 0,
            trial_frames: 0,
            silent_frames: 0,
        }
    }

    /// With a gait, as if uploaded and saved before.
    pub fn with_gait(troubles: Troubles, table: &[u8], amplitude: f64) -> Self {
        let mut robot = Self::new(troubles);
        let amplitude = Amplitude::from_f64(amplitude).expect("in range");
        robot.activate(table, amplitude);
        robot.store_active().expect("the first place is free");
        robot.storage = Storage::Saved;
        robot
    }

    fn activate(&mut self, table: &[u8], amplitude: Amplitude) {
        let mut gait = Encoded::EMPTY;
        gait.replace(table).expect("a whole table");
        self.active = Some(ActiveGait { name: gait.name(), crc32: gait.crc32(), amplitude });
        self.amplitude = amplitude;
        self.table = table.to_vec();
    }

    /// What opening the port does to a Nano.
    pub fn reset(&mut self, cause: ResetCause) {
        let fresh = Self::new(self.troubles.clone());
        let old = std::mem::replace(self, fresh);
        let (table, active, storage) = (old.table, old.active, old.storage);
        let (stored, calibration, last_trial) = (old.stored, old.calibration, old.last_trial);
        let calibration_source = old.calibration_source;
        let fresh = Self::new(old.troubles);
        *self = Self {
            table,
            active,
            storage,
            stored,
            calibration,
            calibration_source,
            last_trial,
            done: old.done,
            ..fresh
        };
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

    /// One sixtieth of a second.
    pub fn frame(&mut self) {
        self.uptime_frames += 1;
        self.silent_frames = self.silent_frames.saturating_add(1);
        if self.silent_frames >= LINK_TIMEOUT_FRAMES {
            self.nudged = None;
            let is_walking = matches!(self.state, State::Entering | State::Walking);
            if is_walking && self.troubles.depends_on_host && !self.is_detached {
                self.end(WalkEnd::LinkLost);
            }
        }
        match self.state {
            State::Entering => self.enter(),
            State::Walking => self.walk(),
            State::Holding if self.speed != Speed::PAUSED => {
                self.held += 1;
                if self.held >= HOLD_FRAMES {
                    self.state = State::Idle;
                }
            }
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

    fn enter(&mut self) {
        // A stream is entered towards its first setpoint, once that is there.
        if self.stream.as_ref().is_some_and(VecDeque::is_empty) {
            return;
        }
        self.entered += 1;
        if self.entered == ENTRY_FRAMES {
            self.state = State::Walking;
        }
    }

    fn walk(&mut self) {
        if self.speed == Speed::PAUSED {
            return;
        }
        if let Some(stream) = &mut self.stream {
            let is_dry = self.troubles.runs_dry_at.is_some_and(|frame| self.trial_frames >= frame);
            if stream.is_empty() && self.troubles.forgives_late_setpoints {
                return;
            }
            match stream.pop_front().filter(|_| !is_dry) {
                Some(pose) => self.played.push(pose),
                None => return self.end(WalkEnd::StreamDry),
            }
        }
        self.trial_frames += 1;
        let now = Some(self.trial_frames);
        if now == self.troubles.resets_at {
            self.reset(ResetCause::BrownOut);
        } else if now == self.troubles.faults_at {
            self.end(WalkEnd::Fault(Fault::SensorLost));
        } else if now == self.troubles.button_at {
            self.end(WalkEnd::Button);
        } else if now == self.troubles.ends_at {
            self.state = State::Idle;
        } else if self.trial_frames == self.asked_frames {
            self.end(WalkEnd::Finished);
        }
    }

    fn end(&mut self, end: WalkEnd) {
        self.last_trial = Some(TrialRecord {
            frames: self.trial_frames,
            energy_uj: u64::from(self.trial_frames) * FRAME_ENERGY_UJ,
            clipped_frames: 3,
            missed_samples: 1,
            gait_crc32: self.active.filter(|_| self.stream.is_none()).map_or(0, |gait| gait.crc32),
            amplitude: self.amplitude,
            end,
        });
        self.stream = None;
        self.held = 0;
        if let WalkEnd::Fault(fault) = end {
            self.state = State::Fault(fault);
            self.say(&Message::Event(Event::Fault(fault)));
        } else {
            self.state = State::Holding;
            self.say(&Message::Event(Event::WalkEnded(end)));
        }
    }

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
            if byte == STOP_BYTE {
                self.stop_bytes += 1;
                self.nudged = None;
                if matches!(self.state, State::Entering | State::Walking) {
                    self.end(WalkEnd::StopByte);
                }
                continue;
            }
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
