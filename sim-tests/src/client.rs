//! A host that lives in the same emulated time as the robot.
//!
//! Holds one end of the serial line: it frames commands, waits for their
//! answers, and keeps everything else that the robot says, with the cycle at
//! which its last byte arrived. Never repeats a command: on this line nothing gets
//! lost, so a lost answer is a finding. Does not depend on the wall clock.

use crate::nano::{CLOCK_HZ, NanoError};
use crate::virtual_robot::VirtualRobot;
use protocol::command::{Chunk, MAX_CHUNK_LEN};
use protocol::frame::{self, Decoder, FrameError, MAX_FRAME_LEN, Request};
use protocol::gait::{GaitError, MAX_ENCODED_LEN};
use protocol::{Amplitude, Command, GaitTable, Message, Reply, Telemetry};
use thiserror::Error;

/// Longest wait for an answer: a frame of the robot's is 16.7 ms.
const PATIENCE_CYCLES: u64 = CLOCK_HZ / 2;
/// Looks at the line this often.
const POLL_CYCLES: u64 = CLOCK_HZ / 10_000;

/// Why a command has no answer.
#[derive(Debug, Error)]
pub enum ClientError {
    /// The firmware ended.
    #[error(transparent)]
    Nano(#[from] NanoError),
    /// Nothing came back.
    #[error("no answer to {command:?} within {seconds} s")]
    Silence { command: Box<Command>, seconds: f64 },
    /// The robot sent something that is not a frame.
    #[error("the robot sent a broken frame: {0:?}")]
    Frame(FrameError),
    /// The gait cannot be sent at all.
    #[error("the gait does not encode: {0:?}")]
    Gait(GaitError),
    /// The robot said no to a step of an upload.
    #[error("the robot answered {0:?}")]
    Unexpected(Box<Reply>),
}

/// The host's end.
#[derive(Debug, Default)]
pub struct Client {
    seq: u8,
    decoder: Decoder,
    heard: Vec<(u64, Message)>,
}

impl Client {
    /// A host that has said nothing yet.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Sends a command and runs the robot until the answer is there.
    ///
    /// # Errors
    /// [`ClientError`] if there is none within half a second.
    pub fn ask(&mut self, robot: &mut VirtualRobot, command: Command) -> Result<Reply, ClientError> {
        Ok(self.ask_timed(robot, command)?.0)
    }

    /// As [`Self::ask`], with the cycle at which the answer was whole.
    ///
    /// # Errors
    /// As [`Self::ask`].
    pub fn ask_timed(
        &mut self,
        robot: &mut VirtualRobot,
        command: Command,
    ) -> Result<(Reply, u64), ClientError> {
        self.seq = self.seq.wrapping_add(1);
        let mut buffer = [0; MAX_FRAME_LEN];
        let bytes =
            frame::encode(&Request { seq: self.seq, command }, &mut buffer).map_err(ClientError::Frame)?;
        robot.nano_mut().send(bytes);
        let asked_at = self.heard.len();
        let deadline = robot.now() + PATIENCE_CYCLES;
        while robot.now() < deadline {
            robot.run_until(robot.now() + POLL_CYCLES)?;
            self.listen(robot)?;
            let answer = self.heard[asked_at..].iter().find_map(|(cycle, message)| match message {
                Message::Reply { seq, reply } if *seq == self.seq => Some((*reply, *cycle)),
                _ => None,
            });
            if let Some(answer) = answer {
                return Ok(answer);
            }
        }
        let seconds = PATIENCE_CYCLES as f64 / CLOCK_HZ as f64;
        Err(ClientError::Silence { command: Box::new(command), seconds })
    }

    /// Runs the robot and keeps what it says.
    ///
    /// # Errors
    /// [`ClientError`] if the firmware ended or a frame is broken.
    pub fn run_for(&mut self, robot: &mut VirtualRobot, duration_s: f64) -> Result<(), ClientError> {
        robot.run_for(duration_s)?;
        self.listen(robot)
    }

    /// As [`Self::run_for`], up to a cycle.
    ///
    /// # Errors
    /// As [`Self::run_for`].
    pub fn run_until(&mut self, robot: &mut VirtualRobot, cycle: u64) -> Result<(), ClientError> {
        robot.run_until(cycle)?;
        self.listen(robot)
    }

    /// Sends a whole gait and makes it active.
    ///
    /// # Errors
    /// [`ClientError::Unexpected`] if any step is refused.
    pub fn upload(
        &mut self,
        robot: &mut VirtualRobot,
        table: &GaitTable,
        amplitude: Amplitude,
        persist: bool,
    ) -> Result<(), ClientError> {
        let mut buffer = [0; MAX_ENCODED_LEN];
        let bytes = table.encode(&mut buffer).map_err(ClientError::Gait)?;
        self.expect_done(robot, Command::UploadBegin { len: bytes.len() as u16 })?;
        for (index, piece) in bytes.chunks(MAX_CHUNK_LEN).enumerate() {
            let offset = (index * MAX_CHUNK_LEN) as u16;
            self.expect_done(robot, Command::UploadChunk { offset, data: Chunk::of(piece) })?;
        }
        self.expect_done(robot, Command::UploadCommit { amplitude, persist })
    }

    /// Sends a command that is to be carried out.
    ///
    /// # Errors
    /// [`ClientError::Unexpected`] if the answer is not [`Reply::Done`].
    pub fn expect_done(&mut self, robot: &mut VirtualRobot, command: Command) -> Result<(), ClientError> {
        match self.ask(robot, command)? {
            Reply::Done => Ok(()),
            other => Err(ClientError::Unexpected(Box::new(other))),
        }
    }

    /// Everything heard so far, answers included, oldest first.
    #[must_use]
    pub fn heard(&self) -> &[(u64, Message)] {
        &self.heard
    }

    /// The telemetry among it.
    pub fn telemetry(&self) -> impl DoubleEndedIterator<Item = (u64, Telemetry)> + '_ {
        self.heard.iter().filter_map(|(cycle, message)| match message {
            Message::Telemetry(sample) => Some((*cycle, *sample)),
            _ => None,
        })
    }

    /// Forgets what was heard.
    pub fn forget(&mut self) {
        self.heard.clear();
    }

    fn listen(&mut self, robot: &mut VirtualRobot) -> Result<(), ClientError> {
        for (cycle, byte) in robot.nano_mut().receive() {
            if let Some(body) = self.decoder.push(byte) {
                let message = frame::parse(body.map_err(ClientError::Frame)?).map_err(ClientError::Frame)?;
                self.heard.push((cycle, message));
            }
        }
        Ok(())
    }
}
