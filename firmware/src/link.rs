//! Bytes to requests, messages to bytes.
//!
//! Owns the frame being received, and the memory of the last request, so that
//! a repeated one is answered again and not carried out twice. Refuses to take
//! a request while its answer could not be queued, and to send half a message:
//! one that finds no room is dropped whole.

use protocol::frame::{self, Decoder, MAX_FRAME_LEN};
use protocol::{Command, Message, Refusal, Reply, crc::crc16, frame::Request};

use crate::hal::SerialRing;

/// The answer that a repeated request gets again.
///
/// Only these follow from requests that change anything; questions are simply
/// asked again, so no answer with a body is ever kept.
type Outcome = Result<(), Refusal>;

/// What a frame from the wire asks for.
#[derive(Debug)]
pub enum Heard {
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
    /// Number, checksum and outcome of the last request, if it changed something.
    last: Option<(u8, u16, Outcome)>,
    request_crc: u16,
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
        Self { decoder: Decoder::new(), last: None, request_crc: 0, bad_frames: 0 }
    }

    /// Frames that failed their CRC or made no sense.
    #[must_use]
    pub const fn bad_frames(&self) -> u16 {
        self.bad_frames
    }

    /// Reads the port until a request is complete, or its ring is empty.
    pub fn listen(&mut self, serial: &mut impl SerialRing) -> Option<Heard> {
        // The answer must find room: unread bytes wait in the ring meanwhile.
        while serial.room() >= MAX_FRAME_LEN {
            let byte = serial.read()?;
            let body = match self.decoder.push(byte) {
                None => continue,
                Some(Err(_)) => {
                    self.bad_frames = self.bad_frames.saturating_add(1);
                    continue;
                }
                Some(Ok(body)) => body,
            };
            let Some(&seq) = body.first() else {
                self.bad_frames = self.bad_frames.saturating_add(1);
                continue;
            };
            self.request_crc = crc16(body);
            if let Some((last_seq, last_crc, outcome)) = self.last
                && (last_seq, last_crc) == (seq, self.request_crc)
            {
                return Some(Heard::Repeat(seq, outcome));
            }
            // Whoever asks something else has had that answer. Kept, it would
            // swallow an equal request when the numbers have come round.
            self.last = None;
            return Some(match frame::parse::<Request>(body) {
                Ok(request) => Heard::Command(request.seq, request.command),
                Err(_) => {
                    self.bad_frames = self.bad_frames.saturating_add(1);
                    Heard::Unknown(seq)
                }
            });
        }
        None
    }

    /// Notes the outcome of the request that [`Self::listen`] returned last.
    pub const fn remember(&mut self, seq: u8, outcome: Outcome) {
        self.last = Some((seq, self.request_crc, outcome));
    }
}

/// Queues `message` whole, or not at all.
pub fn send(serial: &mut impl SerialRing, message: &Message) -> bool {
    let mut buffer = [0; MAX_FRAME_LEN];
    let Ok(frame) = frame::encode(message, &mut buffer) else { return false };
    let fits = serial.room() >= frame.len();
    if fits {
        for &byte in frame {
            serial.write(byte);
        }
    }
    fits
}

/// Answers request `seq`.
pub fn answer(serial: &mut impl SerialRing, seq: u8, reply: Reply) -> bool {
    send(serial, &Message::Reply { seq, reply })
}
