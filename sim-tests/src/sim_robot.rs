//! The firmware's library on a simulated board: a bench that runs in milliseconds.
//!
//! Holds the main loop around [`App`], the host's end of the line, and what a
//! bench can do to a robot: break chips, cut the power, change the load. The
//! board itself is [`SimBoard`]. Does not depend on the processor: timing in cycles
//! is in [`crate::nano`].

pub mod ask;
mod board;
pub mod pulses;

pub use board::{SimBoard, SimBusError};

use crate::fixtures::Gait;
use board::NS_PER_S;
use firmware::{App, Boot};
use protocol::frame::{self, Decoder, MAX_FRAME_LEN, Request};
use protocol::gait::MAX_ENCODED_LEN;
use protocol::{
    Amplitude, Chunk, Command, Event, JOINT_COUNT, Message, Reply, ResetCause, State, Status, Telemetry,
};

/// One turn of the main loop.
const TURN_NS: u64 = 100_000;
/// Longest wait for anything, in turns: 20 s.
const PATIENCE_TURNS: u64 = 20 * NS_PER_S / TURN_NS;

/// Pulse widths of the eight joints in counts; `None` is no pulse.
pub type Pulses = [Option<u16>; JOINT_COUNT];

/// A robot on the bench, and its host.
pub struct SimRobot {
    app: App,
    /// The board, to measure and to break.
    pub board: SimBoard,
    decoder: Decoder,
    heard: Vec<Message>,
    seq: u8,
    pulses: Vec<Pulses>,
}

impl Default for SimRobot {
    fn default() -> Self {
        Self::new()
    }
}

impl SimRobot {
    /// Just powered on with an empty memory.
    #[must_use]
    pub fn new() -> Self {
        Self::started(SimBoard::new(), ResetCause::PowerOn)
    }

    /// Walking `gait`, its entry behind it.
    ///
    /// # Panics
    /// As [`Self::upload`] and [`Self::run_until`].
    #[must_use]
    pub fn playing(gait: &Gait, amplitude: Amplitude) -> Self {
        let mut robot = Self::new();
        robot.upload(gait, amplitude, false);
        robot.expect_done(Command::Walk { amplitude: None, frames: None, detached: true, dry_run: false });
        robot.run_until(State::Walking);
        robot
    }

    fn started(board: SimBoard, cause: ResetCause) -> Self {
        let servos_were_on = board.servos_noted_on();
        let mut robot = Self {
            app: App::new(),
            board,
            decoder: Decoder::new(),
            heard: Vec::new(),
            seq: 0,
            pulses: Vec::new(),
        };
        robot.app.boot(&mut robot.board, Boot { cause, servos_were_on });
        robot.run_turns(1);
        robot
    }

    /// Starts anew: chips and memory stay as they are, and so does time.
    #[must_use]
    pub fn reset(self, cause: ResetCause) -> Self {
        Self::started(self.board.after_reset(), cause)
    }

    /// Off and on again: what was being written to the memory is lost.
    #[must_use]
    pub fn power_cycle(self) -> Self {
        Self::started(self.board.after_power_cut(), ResetCause::PowerOn)
    }

    fn run_turns(&mut self, turns: u64) {
        for _ in 0..turns {
            self.turn();
        }
    }

    fn turn(&mut self) {
        self.app.poll(&mut self.board);
        self.board.advance(TURN_NS);
        for burst in self.board.chips.servo_driver.take_bursts() {
            let mut pulses = [None; JOINT_COUNT];
            pulses.copy_from_slice(&burst.counts[..JOINT_COUNT]);
            self.pulses.push(pulses);
        }
        for byte in self.board.take_outgoing() {
            if let Some(body) = self.decoder.push(byte) {
                let body = body.expect("the robot sends whole frames only");
                self.heard.push(frame::parse(body).expect("the robot sends messages only"));
            }
        }
    }

    /// Runs for so many frames.
    pub fn run_frames(&mut self, frames: u64) {
        let end = self.board.frames() + frames;
        while self.board.frames() < end {
            self.turn();
        }
    }

    /// Runs until the robot is in `state`.
    ///
    /// # Panics
    /// If that takes more than 20 s.
    pub fn run_until(&mut self, state: State) {
        for _ in 0..PATIENCE_TURNS {
            if self.app.state() == state {
                return;
            }
            self.turn();
        }
        panic!("still {:?} after 20 s, not {state:?}", self.app.state());
    }

    /// What the robot is doing.
    #[must_use]
    pub fn state(&self) -> State {
        self.app.state()
    }

    /// Puts bytes on the line.
    pub fn send(&mut self, bytes: &[u8]) {
        self.board.receive(bytes);
    }

    /// One framed command with the next sequence number.
    ///
    /// # Panics
    /// If the command does not fit a frame, which none does.
    #[must_use]
    pub fn framed(&mut self, command: Command) -> Vec<u8> {
        self.seq = self.seq.wrapping_add(1);
        let mut buffer = [0; MAX_FRAME_LEN];
        frame::encode(&Request { seq: self.seq, command }, &mut buffer).expect("a command fits").to_vec()
    }

    /// Sends a command; returns the answer.
    ///
    /// # Panics
    /// If there is none within 20 s.
    pub fn ask(&mut self, command: Command) -> Reply {
        let frame = self.framed(command);
        self.send(&frame);
        self.answer()
    }

    /// Waits for the answer to the last number.
    ///
    /// # Panics
    /// If there is none within 20 s.
    pub fn answer(&mut self) -> Reply {
        let asked_at = self.heard.len();
        for _ in 0..PATIENCE_TURNS {
            self.turn();
            let mut new = self.heard[asked_at..].iter();
            let answer = new.find_map(|message| match message {
                Message::Reply { seq, reply } if *seq == self.seq => Some(*reply),
                _ => None,
            });
            if let Some(answer) = answer {
                return answer;
            }
        }
        panic!("no answer within 20 s");
    }

    /// Sends a command that is to be carried out.
    ///
    /// # Panics
    /// If it is not.
    pub fn expect_done(&mut self, command: Command) {
        assert_eq!(self.ask(command), Reply::Done, "to {command:?}");
    }

    /// What [`Command::Status`] tells.
    ///
    /// # Panics
    /// If it tells nothing.
    pub fn status(&mut self) -> Status {
        match self.ask(Command::Status) {
            Reply::Status(status) => status,
            other => panic!("a status was asked for, not {other:?}"),
        }
    }

    /// Announces a table of these bytes and sends them all.
    pub fn send_pieces(&mut self, bytes: &[u8]) {
        self.expect_done(Command::UploadBegin { len: bytes.len() as u16 });
        for (index, piece) in bytes.chunks(protocol::command::MAX_CHUNK_LEN).enumerate() {
            let offset = (index * protocol::command::MAX_CHUNK_LEN) as u16;
            self.expect_done(Command::UploadChunk { offset, data: Chunk::of(piece) });
        }
    }

    /// Uploads a gait and makes it active.
    ///
    /// # Panics
    /// If the robot refuses it.
    pub fn upload(&mut self, gait: &Gait, amplitude: Amplitude, persist: bool) {
        self.upload_encoded(&encoded(gait), amplitude, persist);
    }

    /// As [`Self::upload`], for a gait in bytes.
    ///
    /// # Panics
    /// If the robot refuses it.
    pub fn upload_encoded(&mut self, encoding: &[u8], amplitude: Amplitude, persist: bool) {
        self.send_pieces(encoding);
        self.expect_done(Command::UploadCommit { amplitude, persist });
    }

    /// Pulses of the next `frames` frames.
    pub fn pulses_over(&mut self, frames: u64) -> Vec<Pulses> {
        self.pulses.clear();
        self.run_frames(frames);
        std::mem::take(&mut self.pulses)
    }

    /// Pulses since the last question, one entry for each write to the outputs.
    pub fn take_pulses(&mut self) -> Vec<Pulses> {
        std::mem::take(&mut self.pulses)
    }

    pub fn events(&self) -> impl Iterator<Item = Event> + '_ {
        self.heard.iter().filter_map(|message| match message {
            Message::Event(event) => Some(*event),
            _ => None,
        })
    }

    pub fn telemetry(&self) -> impl DoubleEndedIterator<Item = Telemetry> + '_ {
        self.heard.iter().filter_map(|message| match message {
            Message::Telemetry(sample) => Some(*sample),
            _ => None,
        })
    }

    #[must_use]
    pub fn answers(&self) -> usize {
        self.heard.iter().filter(|message| matches!(message, Message::Reply { .. })).count()
    }
}

/// A gait's table as bytes.
///
/// # Panics
/// If the fixture is not a valid gait.
#[must_use]
pub fn encoded(gait: &Gait) -> Vec<u8> {
    let mut buffer = [0; MAX_ENCODED_LEN];
    gait.table().encode(&mut buffer).expect("a valid gait").to_vec()
}
