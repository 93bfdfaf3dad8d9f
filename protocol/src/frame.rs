//! Frames on the wire: postcard, CRC-16, COBS, and a zero byte after each.
//!
//! `COBS(postcard(message) ++ crc16_le) ++ 0`. A receiver that lost a byte is
//! back in step at the next zero. Refuses to guess: a frame is whole or gone.
//!
//! COBS replaces two values here instead of one: 0, and [`STOP_BYTE`], which so
//! never occurs within a frame and stops the robot wherever it arrives. A code
//! byte is the distance to the next replaced byte, plus 0x80 if that one was a
//! stop byte; frames without one are plain COBS.

use crate::command::{Chunk, Command, MAX_CHUNK_LEN};
use crate::crc::crc16;
use crate::wire::{self, Writer};
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
/// [`FrameError::TooLong`] if the frame does not fit `buffer` or the limit.
pub fn encode<'b, T: Serialize>(
    message: &T,
    buffer: &'b mut [u8; MAX_FRAME_LEN],
) -> Result<&'b [u8], FrameError> {
    // The body is built one byte in, where COBS wants its first code byte.
    let mut writer = Writer::new(&mut buffer[1..=MAX_BODY_LEN]);
    message.serialize(&mut writer).map_err(|_| FrameError::Meaning)?;
    let body_len = writer.finish().ok_or(FrameError::TooLong)?;
    let crc = crc16(&buffer[1..=body_len]).to_le_bytes();
    buffer[body_len + 1..body_len + 3].copy_from_slice(&crc);
    let end = body_len + 3;

    // So short, COBS in place is a chain of distances between replaced bytes.
    let mut code_at = 0;
    for i in 1..end {
        let flag = match buffer[i] {
            0 => 0,
            STOP_BYTE => STOP_FLAG,
            _ => continue,
        };
        buffer[code_at] = (i - code_at) as u8 | flag;
        code_at = i;
    }
    buffer[code_at] = (end - code_at) as u8;
    buffer[end] = 0;
    Ok(&buffer[..=end])
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
/// [`FrameError::Meaning`] if the bytes are no such message, or go on after it.
pub fn parse<T: DeserializeOwned>(body: &[u8]) -> Result<T, FrameError> {
    wire::from_bytes(body).map_err(|_| FrameError::Meaning)
}

/// Collects bytes into frames.
#[derive(Debug)]
pub struct Decoder {
    buffer: [u8; MAX_FRAME_LEN],
    len: usize,
    body_len: usize,
    overlong: bool,
}

impl Default for Decoder {
    fn default() -> Self {
        Self::new()
    }
}

impl Decoder {
    /// An empty decoder.
    #[must_use]
    pub const fn new() -> Self {
        Self { buffer: [0; MAX_FRAME_LEN], len: 0, body_len: 0, overlong: false }
    }

    /// Takes one byte; returns the body of the frame that it completes.
    ///
    /// Empty frames, two zeros in a row, are silence and return `None`.
    pub fn push(&mut self, byte: u8) -> Option<Result<&[u8], FrameError>> {
        if byte != 0 {
            match self.buffer.get_mut(self.len) {
                Some(place) => {
                    *place = byte;
                    self.len += 1;
                }
                None => self.overlong = true,
            }
            return None;
        }
        let len = core::mem::take(&mut self.len);
        if core::mem::take(&mut self.overlong) {
            return Some(Err(FrameError::TooLong));
        }
        self.body_len = 0;
        if len == 0 {
            return None;
        }
        let body = unframe(&mut self.buffer[..len]);
        self.body_len = body.map_or(0, <[u8]>::len);
        Some(body)
    }

    /// The body that [`Self::push`] returned last; empty once the next frame has begun.
    #[must_use]
    pub fn body(&self) -> &[u8] {
        if self.len > 0 { &[] } else { self.buffer.get(1..=self.body_len).unwrap_or(&[]) }
    }
}
