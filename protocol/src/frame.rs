//! Frames on the wire: postcard, CRC-16, COBS, and a zero byte after each.
//!
//! `COBS(postcard(message) ++ crc16_le) ++ 0`. A receiver that lost a byte is
//! back in step at the next zero. A damaged frame is dropped, never repaired.
//!
//! COBS replaces two values here instead of one: 0, and [`STOP_BYTE`], which so
//! never occurs within a frame and stops the robot wherever it arrives. A code
//! byte is the distance to the next replaced byte, plus 0x80 if that one was a
//! stop byte; frames without one are plain COBS.

use crate::command::{Chunk, Command, MAX_CHUNK_LEN};
use crate::crc::{Crc16, crc16};
use crate::wire::{self, Sink, Writer};
use serde::{Deserialize, Serialize, de::DeserializeOwned};

/// Longest body in bytes, before CRC and COBS: a full chunk and its header.
pub const MAX_BODY_LEN: usize = MAX_CHUNK_LEN + 10;
/// Longest frame in bytes: body, CRC, one COBS code byte, and the delimiter.
pub const MAX_FRAME_LEN: usize = MAX_BODY_LEN + 2 + 1 + 1;

/// Stops a robot in the middle of whatever else is on the line: the walk ends
/// where it is, and the servos go limp a second later. It is no frame and has no
/// answer but the event.
pub const STOP_BYTE: u8 = 0xD2;
/// In a code byte: what it points to was a [`STOP_BYTE`].
const STOP_FLAG: u8 = 0x80;

// Code bytes must be neither of the two.
const _: () = assert!(MAX_FRAME_LEN < STOP_FLAG as usize && MAX_FRAME_LEN as u8 | STOP_FLAG < STOP_BYTE);

/// A command with its sequence number; `D` as in [`Command`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Request<D = Chunk> {
    /// Echoed in the reply; a repeat of the last number asks for the same answer.
    pub seq: u8,
    /// What is asked for.
    pub command: Command<D>,
}

/// Why a frame was dropped.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FrameError {
    /// Longer than [`MAX_FRAME_LEN`].
    TooLong,
    /// The COBS code bytes point outside the frame.
    Cobs,
    /// The checksum does not match.
    Crc,
    /// Intact, but no message of this protocol version.
    Meaning,
}

/// Writes `message` as one frame, delimiter included, into `buffer`.
///
/// # Errors
/// [`FrameError::TooLong`] if the frame does not fit the limit.
pub fn encode<'b, T: Serialize>(
    message: &T,
    buffer: &'b mut [u8; MAX_FRAME_LEN],
) -> Result<&'b [u8], FrameError> {
    let len = encode_into(message, |at, byte| {
        if let Some(place) = buffer.get_mut(usize::from(at)) {
            *place = byte;
        }
    })?;
    buffer.get(..usize::from(len)).ok_or(FrameError::TooLong)
}

/// Hands `place` the bytes of one frame, each with its distance from the first;
/// returns their number.
///
/// They come in order but for code bytes, which are known later than what they
/// stand before. An AVR needs no buffer so, beside the one that it sends from.
///
/// # Errors
/// [`FrameError::TooLong`] if the frame does not fit the limit: what was placed
/// is to be forgotten.
pub fn encode_into<T: Serialize>(message: &T, place: impl FnMut(u8, u8)) -> Result<u8, FrameError> {
    let mut writer = Writer(Encoder { place, crc: Crc16::new(), at: 1, code_at: 0 });
    message.serialize(&mut writer).map_err(|_| FrameError::Meaning)?;
    writer.0.finish()
}

struct Encoder<F> {
    place: F,
    crc: Crc16,
    /// Where the next byte goes.
    at: u8,
    /// Where the code byte for it goes.
    code_at: u8,
}

impl<F: FnMut(u8, u8)> Sink for Encoder<F> {
    fn put(&mut self, byte: u8) {
        let at = self.at;
        if usize::from(at) > MAX_BODY_LEN + 2 {
            return;
        }
        self.at = at + 1;
        self.crc.add(byte);
        if byte == 0 || byte == STOP_BYTE {
            // So short, COBS is a chain of distances between replaced bytes.
            let flag = if byte == 0 { 0 } else { STOP_FLAG };
            (self.place)(self.code_at, (at - self.code_at) | flag);
            self.code_at = at;
        } else {
            (self.place)(at, byte);
        }
    }
}

impl<F: FnMut(u8, u8)> Encoder<F> {
    fn finish(mut self) -> Result<u8, FrameError> {
        if usize::from(self.at) > MAX_BODY_LEN + 1 {
            return Err(FrameError::TooLong);
        }
        for byte in self.crc.value().to_le_bytes() {
            self.put(byte);
        }
        let end = self.at;
        (self.place)(self.code_at, end - self.code_at);
        (self.place)(end, 0);
        Ok(end + 1)
    }
}

/// Undoes COBS and checks the CRC of one frame, delimiter excluded, in place.
///
/// # Errors
/// Why the frame is to be dropped.
pub fn unframe(frame: &mut [u8]) -> Result<&[u8], FrameError> {
    if frame.len() >= MAX_FRAME_LEN {
        return Err(FrameError::TooLong);
    }
    let (mut code_at, mut replaced) = (0, 0);
    while let Some(place) = frame.get_mut(code_at) {
        let code = core::mem::replace(place, replaced);
        let distance = usize::from(code & !STOP_FLAG);
        code_at += distance;
        replaced = if code & STOP_FLAG == 0 { 0 } else { STOP_BYTE };
        if distance == 0 {
            return Err(FrameError::Cobs);
        }
    }
    // The last one points to the end, where nothing was replaced.
    if code_at != frame.len() || replaced != 0 {
        return Err(FrameError::Cobs);
    }
    let (body, crc) = frame.get(1..).and_then(|f| f.split_last_chunk::<2>()).ok_or(FrameError::Cobs)?;
    if crc16(body) != u16::from_le_bytes(*crc) {
        return Err(FrameError::Crc);
    }
    Ok(body)
}

/// Reads the message in a checked frame body.
///
/// # Errors
/// [`FrameError::Meaning`] if the bytes are not that message, or go on after it.
pub fn parse<T: DeserializeOwned>(body: &[u8]) -> Result<T, FrameError> {
    wire::from_bytes(body).map_err(|_| FrameError::Meaning)
}

/// Collects bytes into frames.
#[derive(Debug)]
pub struct Decoder {
    buffer: [u8; MAX_FRAME_LEN],
    /// Bytes of the frame under way; [`OVERLONG`] if it has more than any.
    len: u8,
    /// Of the body returned last.
    body_len: u8,
}

/// More bytes than the buffer has.
const OVERLONG: u8 = u8::MAX;

impl Default for Decoder {
    fn default() -> Self {
        Self::new()
    }
}

impl Decoder {
    /// An empty decoder.
    #[must_use]
    pub const fn new() -> Self {
        Self { buffer: [0; MAX_FRAME_LEN], len: 0, body_len: 0 }
    }

    /// Takes one byte; returns the body of the frame that it completes.
    ///
    /// Empty frames, two zeros in a row, are silence and return `None`.
    pub fn push(&mut self, byte: u8) -> Option<Result<&[u8], FrameError>> {
        if self.collect([byte]) { self.finish() } else { None }
    }

    /// The first half of [`Self::push`]: takes bytes up to the end of a frame;
    /// true if it was there, and [`Self::finish`] comes before the next byte.
    #[inline]
    pub fn collect(&mut self, bytes: impl IntoIterator<Item = u8>) -> bool {
        let mut len = self.len;
        let mut is_whole = false;
        for byte in bytes {
            if byte == 0 {
                is_whole = true;
                break;
            }
            match self.buffer.get_mut(usize::from(len)) {
                Some(place) => {
                    *place = byte;
                    len += 1;
                }
                None => len = OVERLONG,
            }
        }
        self.len = len;
        is_whole
    }

    /// The second half of [`Self::push`]: the body of the frame that has ended.
    pub fn finish(&mut self) -> Option<Result<&[u8], FrameError>> {
        let len = core::mem::take(&mut self.len);
        self.body_len = 0;
        if len == 0 {
            return None;
        }
        let Some(frame) = self.buffer.get_mut(..usize::from(len)) else {
            return Some(Err(FrameError::TooLong));
        };
        let body = unframe(frame);
        self.body_len = body.map_or(0, |body| body.len() as u8);
        Some(body)
    }

    /// The body that [`Self::push`] returned last; empty once the next frame has begun.
    #[must_use]
    pub fn body(&self) -> &[u8] {
        if self.len > 0 { &[] } else { self.buffer.get(1..=usize::from(self.body_len)).unwrap_or(&[]) }
    }

    /// The checksum of [`Self::body`], as it came with it; only together with that.
    #[must_use]
    pub fn checksum(&self) -> u16 {
        let end = self.buffer.get(usize::from(self.body_len) + 1..).and_then(|rest| rest.first_chunk::<2>());
        end.map_or(0, |crc| u16::from_le_bytes(*crc))
    }
}
