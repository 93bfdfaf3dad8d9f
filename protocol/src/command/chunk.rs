//! Pieces of gait tables.
//!
//! On the wire a piece is as long as it is; in memory it has room for the longest.

use serde::{Deserialize, Serialize};

/// Longest piece of a gait in one frame.
pub const MAX_CHUNK_LEN: usize = 64;

/// Up to [`MAX_CHUNK_LEN`] bytes of a gait table.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct Chunk {
    len: u8,
    bytes: [u8; MAX_CHUNK_LEN],
}

impl Chunk {
    /// The first bytes of `bytes`, as many as fit.
    #[must_use]
    pub fn of(bytes: &[u8]) -> Self {
        let len = bytes.len().min(MAX_CHUNK_LEN);
        let mut chunk = Self { len: len as u8, bytes: [0; MAX_CHUNK_LEN] };
        chunk.bytes[..len].copy_from_slice(&bytes[..len]);
        chunk
    }

    /// The bytes.
    #[must_use]
    pub fn as_slice(&self) -> &[u8] {
        &self.bytes[..self.len as usize]
    }
}

impl core::fmt::Debug for Chunk {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        self.as_slice().fmt(f)
    }
}

impl Serialize for Chunk {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_bytes(self.as_slice())
    }
}

impl<'de> Deserialize<'de> for Chunk {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Visitor;
        impl serde::de::Visitor<'_> for Visitor {
            type Value = Chunk;

            fn expecting(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
                f.write_str("at most 64 bytes")
            }

            fn visit_bytes<E: serde::de::Error>(self, bytes: &[u8]) -> Result<Chunk, E> {
                if bytes.len() > MAX_CHUNK_LEN {
                    return Err(E::invalid_length(bytes.len(), &self));
                }
                Ok(Chunk::of(bytes))
            }
        }
        deserializer.deserialize_bytes(Visitor)
    }
}
