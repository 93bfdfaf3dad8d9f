//! Collects what comes in pieces, and holds the setpoints of a stream.
//!
//! Holds the one buffer that encoded gaits and calibrations pass through, from
//! the wire or from memory; a stream borrows it, so uploads and streams exclude
//! each other. A piece outside the announced length or beyond a gap is refused, and
//! a table is whole only with every byte. Does not depend on what the bytes mean.

use protocol::gait::MAX_ENCODED_LEN;
use protocol::{Angle, JOINT_COUNT, Refusal, STREAM_CAPACITY};

/// Bytes of one pose: an angle in two bytes for each joint.
const POSE_LEN: usize = 2 * JOINT_COUNT;

/// The buffer and what is known about it.
#[derive(Debug)]
pub struct Upload {
    bytes: [u8; MAX_ENCODED_LEN],
    /// Bytes announced.
    len: u16,
    /// Bytes there, from the start.
    arrived: u16,
    /// Place of the oldest setpoint.
    oldest: u8,
    /// Setpoints that wait.
    waiting: u8,
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
        Self { bytes: [0; MAX_ENCODED_LEN], len: 0, arrived: 0, oldest: 0, waiting: 0 }
    }

    /// Starts over, for a table of `len` bytes.
    ///
    /// # Errors
    /// [`Refusal::UploadRange`] if no table has this length.
    pub const fn begin(&mut self, len: u16) -> Result<(), Refusal> {
        if len == 0 || len > MAX_ENCODED_LEN as u16 {
            return Err(Refusal::UploadRange);
        }
        (self.len, self.arrived) = (len, 0);
        Ok(())
    }

    /// Takes one piece.
    ///
    /// # Errors
    /// [`Refusal::UploadRange`] if it lies outside the announced table, or not
    /// all is there that comes before it.
    pub fn take(&mut self, offset: u16, piece: &[u8]) -> Result<(), Refusal> {
        if offset > self.arrived || piece.len() > usize::from(self.len - offset) {
            return Err(Refusal::UploadRange);
        }
        let place = self.bytes.get_mut(usize::from(offset)..).and_then(|rest| rest.get_mut(..piece.len()));
        place.ok_or(Refusal::UploadRange)?.copy_from_slice(piece);
        self.arrived = self.arrived.max(offset + piece.len() as u16);
        Ok(())
    }

    /// The table, once every byte of it is there.
    ///
    /// # Errors
    /// [`Refusal::UploadIncomplete`] before that.
    pub fn whole(&self) -> Result<&[u8], Refusal> {
        let table = self.bytes.get(..usize::from(self.len)).filter(|table| !table.is_empty());
        table.filter(|_| self.arrived == self.len).ok_or(Refusal::UploadIncomplete)
    }

    /// Forgets the announcement, so that no later piece lands in this table.
    pub const fn close(&mut self) {
        (self.len, self.arrived) = (0, 0);
    }

    /// The whole buffer, for who loads into it.
    pub const fn buffer_mut(&mut self) -> &mut [u8; MAX_ENCODED_LEN] {
        &mut self.bytes
    }

    /// Empties the buffer for a stream.
    pub const fn begin_stream(&mut self) {
        self.close();
        (self.oldest, self.waiting) = (0, 0);
    }

    /// Setpoints that wait.
    #[must_use]
    pub const fn waiting(&self) -> u8 {
        self.waiting
    }

    /// Takes whole poses, all of them or none.
    ///
    /// # Errors
    /// [`Refusal::NoStream`] unless they are 1 to [`STREAM_CAPACITY`] poses,
    /// [`Refusal::StreamFull`] if there is no room for all of them.
    pub fn take_poses(&mut self, bytes: &[u8]) -> Result<(), Refusal> {
        let (poses, rest) = bytes.as_chunks::<POSE_LEN>();
        if poses.is_empty() || poses.len() > usize::from(STREAM_CAPACITY) || !rest.is_empty() {
            return Err(Refusal::NoStream);
        }
        if poses.len() > usize::from(STREAM_CAPACITY - self.waiting) {
            return Err(Refusal::StreamFull);
        }
        let (places, _) = self.bytes.as_chunks_mut::<POSE_LEN>();
        for pose in poses {
            if let Some(place) = places.get_mut(usize::from(wrapped(self.oldest + self.waiting))) {
                *place = *pose;
            }
            self.waiting += 1;
        }
        Ok(())
    }

    /// The setpoint of `joint` in the pose that is next.
    #[must_use]
    pub fn next_setpoint(&self, joint: usize) -> Angle {
        let (places, _) = self.bytes.as_chunks::<POSE_LEN>();
        let words = places.get(usize::from(self.oldest)).map(|place| place.as_chunks::<2>().0);
        let word = words.and_then(|words| words.get(joint)).copied().unwrap_or_default();
        Angle::from_units(i16::from_le_bytes(word))
    }

    /// Leaves the next pose behind.
    pub const fn drop_pose(&mut self) {
        if self.waiting > 0 {
            self.waiting -= 1;
            self.oldest = wrapped(self.oldest + 1);
        }
    }
}

/// A place in the ring, from at most one round beyond it.
const fn wrapped(place: u8) -> u8 {
    if place < STREAM_CAPACITY { place } else { place - STREAM_CAPACITY }
}
