//! Collects a gait table from pieces that may come in any order, or twice.
//!
//! Owns the one buffer that an encoded table passes through: uploads, saving
//! and loading take turns. Refuses pieces outside the announced length, and to
//! call a table whole while a byte of it is missing.

use protocol::Refusal;
use protocol::gait::MAX_ENCODED_LEN;

/// The buffer and what is known about it.
#[derive(Debug)]
pub struct Upload {
    bytes: [u8; MAX_ENCODED_LEN],
    arrived: [u8; MAX_ENCODED_LEN / 8],
    len: usize,
}

impl Default for Upload {
    fn default() -> Self {
        Self::new()
    }
}

impl Upload {
    /// Nothing announced.
    #[must_use]
    pub const fn new() -> Self {
        Self { bytes: [0; MAX_ENCODED_LEN], arrived: [0; MAX_ENCODED_LEN / 8], len: 0 }
    }

    /// Starts over, for a table of `len` bytes.
    ///
    /// # Errors
    /// [`Refusal::UploadRange`] if no table has this length.
    pub fn begin(&mut self, len: u16) -> Result<(), Refusal> {
        let len = usize::from(len);
        if len == 0 || len > MAX_ENCODED_LEN {
            return Err(Refusal::UploadRange);
        }
        self.len = len;
        self.arrived = [0; MAX_ENCODED_LEN / 8];
        Ok(())
    }

    /// Takes one piece.
    ///
    /// # Errors
    /// [`Refusal::UploadRange`] if it lies outside the announced table.
    pub fn take(&mut self, offset: u16, piece: &[u8]) -> Result<(), Refusal> {
        let start = usize::from(offset);
        // A chunk of at most 64 bytes after at most 65,535: no overflow even where usize has 16 bits.
        let end =
            start.checked_add(piece.len()).filter(|&end| end <= self.len).ok_or(Refusal::UploadRange)?;
        let place = self.bytes.get_mut(start..end).ok_or(Refusal::UploadRange)?;
        place.copy_from_slice(piece);
        for at in start..end {
            self.arrived[at / 8] |= 1 << (at % 8);
        }
        Ok(())
    }

    /// The table, once every byte of it is there.
    ///
    /// # Errors
    /// [`Refusal::UploadIncomplete`] before that.
    pub fn whole(&self) -> Result<&[u8], Refusal> {
        let is_whole = self.len > 0 && (0..self.len).all(|at| self.arrived[at / 8] & 1 << (at % 8) != 0);
        if is_whole { Ok(&self.bytes[..self.len]) } else { Err(Refusal::UploadIncomplete) }
    }

    /// Forgets the announcement, so that no later piece lands in this table.
    pub const fn close(&mut self) {
        self.len = 0;
    }

    /// The whole buffer, for who saves from it or loads into it.
    #[must_use]
    pub const fn buffer(&self) -> &[u8; MAX_ENCODED_LEN] {
        &self.bytes
    }

    /// The whole buffer, for who loads into it.
    pub const fn buffer_mut(&mut self) -> &mut [u8; MAX_ENCODED_LEN] {
        &mut self.bytes
    }
}
