//! Bytes to requests, messages to bytes.
//!
//! Holds the frame being received, and the outcome of the last request, so that
//! a repeated one is answered again and not carried out twice. A request waits until
//! its answer can be queued, and a message that finds no room is dropped whole. Does
//! not depend on what a request does.

use protocol::command::MAX_CHUNK_LEN;
use protocol::frame::{self, Decoder, MAX_FRAME_LEN, Request};
use protocol::{Event, Refusal, Reply, Telemetry};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::hal::SerialRing;

/// The answer that a repeated request gets again.
///
/// Only these follow from requests that change anything; questions are simply
/// asked again, so no answer with a body is ever kept.
pub type Outcome = Result<(), Refusal>;

/// A piece of a table that stands at the end of the frame heard last: copied
/// into the command, its 64 bytes would lie on the stack several times.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Tail(u8);

impl<'de> Deserialize<'de> for Tail {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let bytes = <&[u8]>::deserialize(deserializer)?;
        if bytes.len() > MAX_CHUNK_LEN {
            return Err(serde::de::Error::custom(""));
        }
        Ok(Self(bytes.len() as u8))
    }
}

/// A piece of a table to be sent.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Piece<'a>(pub &'a [u8]);

impl Serialize for Piece<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_bytes(self.0)
    }
}

/// What the host asks for, its bytes still in the receive buffer.
pub type Command = protocol::Command<Tail>;
/// What the robot says.
///
/// [`protocol::Message`] by reference: an answer of 50 bytes is written from
/// where it is, and not copied into its message first.
#[derive(Debug, Clone, Copy, Serialize)]
pub enum Message<'a> {
    /// The answer to request `seq`.
    Reply {
        /// The request's number.
        seq: u8,
        /// The answer.
        reply: &'a Reply<Piece<'a>>,
    },
    /// One sample of the stream.
    Telemetry(&'a Telemetry),
    /// Something happened without a request.
    Event(Event),
}

/// What a frame from the wire asks for.
#[derive(Debug)]
pub enum Incoming {
    /// Carry it out, and answer.
    Command(u8, Command),
    /// Answer it as the last time.
    Repeat(u8, Outcome),
    /// An intact frame without a command of this version.
    Unknown(u8),
}

/// One end of the wire.
#[derive(Debug)]
pub struct Link {
    decoder: Decoder,
    /// Number, checksum and outcome of the last request.
    last_seq: u8,
    last_crc: u16,
    last_outcome: Outcome,
    /// Whether there is an outcome: it changed something.
    remembers: bool,
    bad_frames: u16,
}

impl Default for Link {
    fn default() -> Self {
        Self::new()
    }
}

impl Link {
    /// Nothing heard yet.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            decoder: Decoder::new(),
            last_seq: 0,
            last_crc: 0,
            last_outcome: Ok(()),
            remembers: false,
            bad_frames: 0,
        }
    }

    /// Frames that failed their CRC or made no sense.
    #[must_use]
    pub const fn bad_frames(&self) -> u16 {
        self.bad_frames
    }

    /// Reads the port until a request is complete, or its ring is empty.
    pub fn listen(&mut self, serial: &mut impl SerialRing) -> Option<Incoming> {
        // The answer must find room: unread bytes wait in the ring meanwhile.
        while serial.is_worth_reading() && usize::from(serial.room()) >= MAX_FRAME_LEN {
            if !self.decoder.collect(serial.received()) {
                continue;
            }
            let heard = match self.decoder.finish() {
                None => continue,
                Some(Ok(&[seq, ..])) => Some(seq),
                Some(_) => None,
            };
            let Some(seq) = heard else {
                self.bad_frames = self.bad_frames.saturating_add(1);
                continue;
            };
            let crc = self.decoder.checksum();
            if self.remembers && self.last_seq == seq && self.last_crc == crc {
                return Some(Incoming::Repeat(seq, self.last_outcome));
            }
            // A host that asks something else has received that answer. Remembered, it
            // would swallow an equal request when the numbers have come round.
            self.remembers = false;
            (self.last_seq, self.last_crc) = (seq, crc);
            return Some(match frame::parse::<Request<Tail>>(self.decoder.body()) {
                Ok(request) => Incoming::Command(request.seq, request.command),
                Err(_) => {
                    self.bad_frames = self.bad_frames.saturating_add(1);
                    Incoming::Unknown(seq)
                }
            });
        }
        None
    }

    /// Notes the outcome of the request that [`Self::listen`] returned last.
    pub const fn remember(&mut self, outcome: Outcome) {
        self.last_outcome = outcome;
        self.remembers = true;
    }

    /// The piece that came with the request that [`Self::listen`] returned last.
    #[must_use]
    pub fn piece(&self, tail: Tail) -> &[u8] {
        let body = self.decoder.body();
        body.get(body.len().wrapping_sub(usize::from(tail.0))..).unwrap_or(&[])
    }
}

/// Queues `message` whole, or not at all.
pub fn send(serial: &mut impl SerialRing, message: &Message<'_>) -> bool {
    let room = serial.room();
    let len = frame::encode_into(message, |at, byte| {
        if at < room {
            serial.place(at, byte);
        }
    });
    let fits = len.ok().filter(|len| *len <= room);
    if let Some(len) = fits {
        serial.send(len);
    }
    fits.is_some()
}

/// Answers request `seq`.
pub fn answer(serial: &mut impl SerialRing, seq: u8, reply: &Reply<Piece<'_>>) -> bool {
    send(serial, &Message::Reply { seq, reply })
}
