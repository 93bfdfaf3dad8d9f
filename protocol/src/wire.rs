//! Messages to postcard bytes and back, in as little flash as an AVR has for it.
//!
//! Holds the part of postcard's format that our messages use: variants below 128
//! in one byte, varints of 16 and 32 bits, zigzag, options, byte strings, tuples
//! and structs. The `postcard` crate writes and reads the same bytes, as
//! `tests/wire.rs` holds for every message, and does so wherever flash is plenty;
//! through it the firmware's image is 2 KB longer, for looking at every field's
//! outcome and for variant numbers of 32 bits. Types of other shapes are refused.

mod read;
mod write;

pub use read::from_bytes;
pub(crate) use write::{Sink, Writer};

/// The bytes are not a message of this protocol.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct WireError;

impl core::fmt::Display for WireError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str("not a message of this protocol")
    }
}

impl core::error::Error for WireError {}

impl serde::ser::Error for WireError {
    fn custom<T: core::fmt::Display>(_: T) -> Self {
        Self
    }
}

impl serde::de::Error for WireError {
    fn custom<T: core::fmt::Display>(_: T) -> Self {
        Self
    }
}
