//! Speaks [`protocol`] with a robot over anything that reads and writes bytes.
//!
//! Holds the hello, sequence numbers, repeats of what was lost, and the sorting of
//! replies from telemetry and events that arrive between them. [`ports`] finds and
//! opens the port. Another protocol version is an error, and so is a robot that was
//! reset in mid-session. Does not depend on what the commands are for.
//!
//! Beyond 300 lines: one state machine, whose parts share its queues.

mod error;
pub mod ports;
mod timeouts;
pub mod words;

pub use error::LinkError;
pub use timeouts::Timeouts;

use protocol::command::Record;
use protocol::frame::{self, Decoder, MAX_FRAME_LEN, Request, STOP_BYTE};
use protocol::{Command, Event, HelloReply, Message, PROTOCOL_VERSION, Refusal, Reply, Status};
use std::collections::VecDeque;
use std::io::{ErrorKind, Read, Write};
use std::time::{Duration, Instant, SystemTime};

/// Telemetry or an event, which the robot sends unasked, and when it arrived.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Incoming {
    /// When its last byte had been read.
    pub at: SystemTime,
    /// Never a reply.
    pub message: Message,
}

/// About a minute of telemetry is kept until it is fetched.
const UNASKED_CAPACITY: usize = 4096;

/// Between two reads while another program takes the bytes.
const STOLEN_WAIT: Duration = Duration::from_millis(1);

/// A session with a robot.
#[derive(Debug)]
pub struct Link<P> {
    port: P,
    name: String,
    timeouts: Timeouts,
    decoder: Decoder,
    seq: u8,
    hello: Option<HelloReply>,
    started: bool,
    bytes_heard: u64,
    bad_frames: u64,
    /// Reads that found nothing although bytes had arrived: another program took them.
    stolen_reads: u64,
    replies: VecDeque<(u8, Reply)>,
    unasked: VecDeque<Incoming>,
}

impl<P: Read + Write> Link<P> {
    /// Takes over an open port, called `name` in errors, and waits for the robot's hello.
    ///
    /// Reads on `port` must time out after a few milliseconds; a timeout is not an error.
    ///
    /// # Errors
    /// [`LinkError::NoAnswer`], [`LinkError::ProtocolVersion`], or a broken port.
    pub fn connect(port: P, name: &str, timeouts: Timeouts) -> Result<Self, LinkError> {
        let mut link = Self {
            port,
            name: name.into(),
            timeouts,
            decoder: Decoder::new(),
            // A robot that was not reset may remember the last number of the
            // session before, which is unknown here.
            seq: SystemTime::UNIX_EPOCH.elapsed().map_or(0, |age| age.subsec_micros() as u8),
            hello: None,
            started: false,
            bytes_heard: 0,
            bad_frames: 0,
            stolen_reads: 0,
            replies: VecDeque::new(),
            unasked: VecDeque::new(),
        };
        let opened = Instant::now();
        link.listen_for_start(opened + timeouts.settle)?;
        let mut hello = link.greet(opened + timeouts.hello_for)?;
        if !link.started {
            // Who answered before any start was seen may yet be reset by the opening.
            link.listen_for_start(Instant::now() + timeouts.settle)?;
            if link.started {
                hello = link.greet(opened + timeouts.hello_for)?;
            }
        }
        link.hello = Some(hello);
        link.bad_frames = 0;
        link.unasked.clear();
        Ok(link)
    }

    /// The robot, as it introduced itself.
    #[must_use]
    pub const fn hello(&self) -> Option<&HelloReply> {
        self.hello.as_ref()
    }

    /// The port's name.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Frames of this session that arrived damaged.
    #[must_use]
    pub const fn bad_frames(&self) -> u64 {
        self.bad_frames
    }

    /// Sends a command until its answer arrives, and again while the robot is
    /// busy with its EEPROM.
    ///
    /// # Errors
    /// [`LinkError::Refused`] if the robot refuses, [`LinkError::NoReply`] if it
    /// does not answer, [`LinkError::Reset`] if it restarted meanwhile, or a
    /// broken port.
    pub fn request(&mut self, command: Command) -> Result<Reply, LinkError> {
        let deadline = Instant::now() + self.timeouts.busy_for;
        loop {
            match self.request_once(command) {
                Err(LinkError::Refused { refusal: Refusal::StorageBusy, .. })
                    if Instant::now() < deadline =>
                {
                    std::thread::sleep(self.timeouts.busy_every);
                }
                outcome => return outcome,
            }
        }
    }

    fn request_once(&mut self, command: Command) -> Result<Reply, LinkError> {
        self.seq = self.seq.wrapping_add(1);
        let seq = self.seq;
        for _ in 0..self.timeouts.attempts {
            self.send(seq, command)?;
            let deadline = Instant::now() + self.timeouts.reply;
            while let Some((answered, reply)) = self.next_reply(deadline)? {
                match reply {
                    _ if answered != seq => {}
                    Reply::Refused(refusal) => {
                        return Err(LinkError::Refused { command: words::command(&command), refusal });
                    }
                    reply => return Ok(reply),
                }
            }
        }
        Err(LinkError::NoReply {
            port: self.name.clone(),
            command: words::command(&command),
            attempts: self.timeouts.attempts,
            other: self.other_reader(),
        })
    }

    /// Sends a command whose only good answer is [`Reply::Done`].
    ///
    /// # Errors
    /// As [`Self::request`].
    pub fn order(&mut self, command: Command) -> Result<(), LinkError> {
        match self.request(command)? {
            Reply::Done => Ok(()),
            _ => Err(LinkError::WrongReply { command: words::command(&command) }),
        }
    }

    /// Asks what the robot is doing.
    ///
    /// # Errors
    /// As [`Self::request`].
    pub fn status(&mut self) -> Result<Status, LinkError> {
        match self.request(Command::Status)? {
            Reply::Status(status) => Ok(status),
            _ => Err(LinkError::WrongReply { command: words::command(&Command::Status) }),
        }
    }

    /// Reads a record piece by piece; empty if the robot has none.
    ///
    /// # Errors
    /// As [`Self::request`].
    pub fn read(&mut self, record: Record) -> Result<Vec<u8>, LinkError> {
        let mut bytes = Vec::new();
        while bytes.len() < protocol::gait::MAX_ENCODED_LEN {
            let command = Command::Read { record, offset: bytes.len() as u16 };
            match self.request(command) {
                Ok(Reply::Piece(piece)) if piece.as_slice().is_empty() => break,
                Ok(Reply::Piece(piece)) => bytes.extend(piece.as_slice()),
                Ok(_) => return Err(LinkError::WrongReply { command: words::command(&command) }),
                Err(LinkError::Refused { refusal: Refusal::NoGait, .. }) => return Ok(Vec::new()),
                Err(error) => return Err(error),
            }
        }
        Ok(bytes)
    }

    /// Sends the byte that stops a robot, even in the middle of a frame.
    ///
    /// # Errors
    /// A broken port; the robot does not answer.
    pub fn send_stop_byte(&mut self) -> Result<(), LinkError> {
        self.port.write_all(&[STOP_BYTE]).map_err(|source| self.broken("write to", source))
    }

    /// The next telemetry or event, or `None` at the deadline.
    ///
    /// # Errors
    /// [`LinkError::Reset`] if the robot restarted, or a broken port.
    pub fn next_unasked(&mut self, deadline: Instant) -> Result<Option<Incoming>, LinkError> {
        loop {
            if let Some(incoming) = self.unasked.pop_front() {
                return Ok(Some(incoming));
            }
            if Instant::now() >= deadline {
                return Ok(None);
            }
            self.listen()?;
        }
    }

    /// Says hello until the robot answers.
    fn greet(&mut self, deadline: Instant) -> Result<HelloReply, LinkError> {
        let command = Command::Hello { protocol_version: PROTOCOL_VERSION };
        let first = self.seq.wrapping_add(1);
        let mut sent = 0_u8;
        while Instant::now() < deadline {
            self.seq = self.seq.wrapping_add(1);
            sent = sent.saturating_add(1);
            self.send(self.seq, command)?;
            let until = deadline.min(Instant::now() + self.timeouts.hello_every);
            while let Some((answered, reply)) = self.next_reply(until)? {
                match reply {
                    // An answer to any of these hellos will do.
                    _ if answered.wrapping_sub(first) >= sent => {}
                    Reply::Hello(hello) => return Ok(hello),
                    Reply::Refused(Refusal::ProtocolVersion { robot }) => {
                        return Err(LinkError::ProtocolVersion { port: self.name.clone(), robot });
                    }
                    _ => {}
                }
            }
        }
        Err(LinkError::NoAnswer {
            port: self.name.clone(),
            waited_s: self.timeouts.hello_for.as_secs_f64(),
            bytes_heard: self.bytes_heard,
            other: self.other_reader(),
        })
    }

    /// Who else reads this port: a name, or nothing but the fact.
    fn other_reader(&self) -> Option<String> {
        let seen = (self.stolen_reads > 0).then(|| "its name: your user may not see it".to_owned());
        ports::other_reader(&self.name).or(seen)
    }

    fn listen_for_start(&mut self, until: Instant) -> Result<(), LinkError> {
        while !self.started && Instant::now() < until {
            self.listen()?;
        }
        Ok(())
    }

    fn next_reply(&mut self, deadline: Instant) -> Result<Option<(u8, Reply)>, LinkError> {
        loop {
            if let Some(reply) = self.replies.pop_front() {
                return Ok(Some(reply));
            }
            if Instant::now() >= deadline {
                return Ok(None);
            }
            self.listen()?;
        }
    }

    fn send(&mut self, seq: u8, command: Command) -> Result<(), LinkError> {
        let mut buffer = [0; MAX_FRAME_LEN];
        // Every command fits a frame, as protocol's tests show.
        let Ok(bytes) = frame::encode(&Request { seq, command }, &mut buffer) else {
            return Err(LinkError::WrongReply { command: words::command(&command) });
        };
        self.port.write_all(bytes).map_err(|source| self.broken("write to", source))
    }

    /// Reads what has arrived, for at most the port's own timeout.
    fn listen(&mut self) -> Result<(), LinkError> {
        let mut bytes = [0; 256];
        let count = match self.port.read(&mut bytes) {
            Ok(0) => return Err(self.broken("read from", ErrorKind::UnexpectedEof.into())),
            Ok(count) => count,
            Err(error) => match error.kind() {
                ErrorKind::WouldBlock => {
                    self.stolen_reads += 1;
                    // Until the other program has taken them all, the port is always ready.
                    std::thread::sleep(STOLEN_WAIT);
                    return Ok(());
                }
                ErrorKind::TimedOut | ErrorKind::Interrupted => return Ok(()),
                _ => return Err(self.broken("read from", error)),
            },
        };
        self.bytes_heard += count as u64;
        let at = SystemTime::now();
        for &byte in &bytes[..count] {
            match self.decoder.push(byte).map(|body| body.and_then(frame::parse::<Message>)) {
                None => {}
                Some(Err(_)) => self.bad_frames += 1,
                Some(Ok(message)) => self.sort(at, message)?,
            }
        }
        Ok(())
    }

    fn sort(&mut self, at: SystemTime, message: Message) -> Result<(), LinkError> {
        match message {
            Message::Reply { seq, reply } => self.replies.push_back((seq, reply)),
            Message::Event(Event::Started(cause)) => {
                self.started = true;
                // What an earlier program answered is void.
                self.replies.clear();
                if self.hello.is_some() {
                    return Err(LinkError::Reset { port: self.name.clone(), cause });
                }
            }
            message => {
                if self.unasked.len() == UNASKED_CAPACITY {
                    self.unasked.pop_front();
                }
                self.unasked.push_back(Incoming { at, message });
            }
        }
        Ok(())
    }

    fn broken(&self, action: &'static str, source: std::io::Error) -> LinkError {
        LinkError::Broken { port: self.name.clone(), action, source }
    }
}
