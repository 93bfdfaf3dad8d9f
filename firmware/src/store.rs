//! Keeps one gait and its amplitude through power-off.
//!
//! Owns two slots of the persistent memory and writes them in turn, a byte
//! whenever the memory is ready, so saving never holds up a frame. A slot
//! counts only with its mark, which is cleared first and set last, after the
//! rest has been read back: whenever the power goes, the other slot is whole.
//! Refuses to save twice at once.
//!
//! Slot: mark, generation (2, little endian), amplitude (2), length (2), table
//! (256), CRC-16 of generation to table (2). Bytes that are right already are
//! not written again: each takes 3.4 ms and wears.

use protocol::Amplitude;
use protocol::gait::MAX_ENCODED_LEN;

use crate::hal::PersistentMemory;

const HEADER_LEN: u16 = 6;
const SLOT_LEN: u16 = 1 + HEADER_LEN + MAX_ENCODED_LEN as u16 + 2;
/// Where the slots start; what lies behind the second one is free.
pub const SLOTS: [u16; 2] = [0, 320];
const _: () = assert!(SLOT_LEN <= SLOTS[1]);

const WHOLE: u8 = 0xA5;
const VOID: u8 = 0x00;

/// What a finished save found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Saved {
    /// The slot reads back as written.
    Verified,
    /// It does not; the other slot is as it was.
    Failed,
}

/// A stored gait, its table left in the caller's buffer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Stored {
    /// Its default amplitude.
    pub amplitude: Amplitude,
    /// Bytes of the table.
    pub len: usize,
}

#[derive(Debug, Clone, Copy)]
struct Header {
    generation: u16,
    amplitude_units: u16,
    len: u16,
}

impl Header {
    const fn bytes(self) -> [u8; HEADER_LEN as usize] {
        let [g0, g1] = self.generation.to_le_bytes();
        let [a0, a1] = self.amplitude_units.to_le_bytes();
        let [l0, l1] = self.len.to_le_bytes();
        [g0, g1, a0, a1, l0, l1]
    }
}

#[derive(Debug, Clone, Copy)]
struct Save {
    header: Header,
    slot: u8,
    crc: u16,
    step: Step,
}

// From 1, so that no save is all zeros: a start value that takes no flash.
#[derive(Debug, Clone, Copy)]
#[repr(u8)]
enum Step {
    Void = 1,
    Body(u16),
    Verify,
    Mark,
    MarkWritten,
}

/// The two slots, and the save in progress.
#[derive(Debug)]
pub struct Store {
    generation: u16,
    next_slot: u8,
    save: Option<Save>,
}

impl Default for Store {
    fn default() -> Self {
        Self::new()
    }
}

impl Store {
    /// Knows nothing yet: call [`Self::load`] first.
    #[must_use]
    pub const fn new() -> Self {
        Self { generation: 0, next_slot: 0, save: None }
    }

    /// Whether a save is going on.
    #[must_use]
    pub const fn is_saving(&self) -> bool {
        self.save.is_some()
    }

    /// Reads the newest whole slot into `buffer`; `accept` judges the table.
    ///
    /// Falls back to the older slot where the newer one is refused.
    pub fn load(
        &mut self,
        memory: &mut impl PersistentMemory,
        buffer: &mut [u8; MAX_ENCODED_LEN],
        mut accept: impl FnMut(&[u8]) -> bool,
    ) -> Option<Stored> {
        let marked = [self.generation_in(memory, 0), self.generation_in(memory, 1)];
        let newer = match marked {
            // Generations wrap: the newer one is the one a short way ahead.
            [Some(first), Some(second)] => u8::from((second.wrapping_sub(first) as i16) > 0),
            [None, _] => 1,
            [_, None] => 0,
        };
        for slot in [newer, 1 - newer] {
            let Some(generation) = marked[usize::from(slot)] else { continue };
            if let Some(stored) = Self::read_slot(memory, slot, buffer)
                && accept(&buffer[..stored.len])
            {
                self.generation = generation;
                self.next_slot = 1 - slot;
                return Some(stored);
            }
        }
        None
    }

    fn generation_in(&self, memory: &mut impl PersistentMemory, slot: u8) -> Option<u16> {
        let at = SLOTS[usize::from(slot)];
        (memory.read(at) == WHOLE).then(|| u16::from_le_bytes([memory.read(at + 1), memory.read(at + 2)]))
    }

    fn read_slot(
        memory: &mut impl PersistentMemory,
        slot: u8,
        buffer: &mut [u8; MAX_ENCODED_LEN],
    ) -> Option<Stored> {
        let at = SLOTS[usize::from(slot)] + 1;
        let mut header = [0; HEADER_LEN as usize];
        for (offset, byte) in (at..).zip(header.iter_mut()) {
            *byte = memory.read(offset);
        }
        let [_, _, a0, a1, l0, l1] = header;
        let amplitude = Amplitude::from_units(u16::from_le_bytes([a0, a1]))?;
        let len = usize::from(u16::from_le_bytes([l0, l1]));
        let table = buffer.get_mut(..len)?;
        let mut place = at + HEADER_LEN;
        for byte in table.iter_mut() {
            *byte = memory.read(place);
            place += 1;
        }
        let stored_crc = u16::from_le_bytes([memory.read(place), memory.read(place + 1)]);
        (crc_of(&header, table) == stored_crc).then_some(Stored { amplitude, len })
    }

    /// Starts saving `table`, which must stay as it is until the save ends.
    ///
    /// Returns `false`, and does nothing, while another save is going on.
    pub fn begin(&mut self, table: &[u8], amplitude: Amplitude) -> bool {
        if self.save.is_some() || table.len() > MAX_ENCODED_LEN {
            return false;
        }
        let header = Header {
            generation: self.generation.wrapping_add(1),
            amplitude_units: amplitude.units(),
            len: table.len() as u16,
        };
        let crc = crc_of(&header.bytes(), table);
        self.save = Some(Save { header, slot: self.next_slot, crc, step: Step::Void });
        true
    }

    /// Writes the next byte if the memory is ready; tells when the save ends.
    pub fn step(
        &mut self,
        memory: &mut impl PersistentMemory,
        buffer: &[u8; MAX_ENCODED_LEN],
    ) -> Option<Saved> {
        let save = self.save.as_mut()?;
        if memory.is_busy() {
            return None;
        }
        let start = SLOTS[usize::from(save.slot)];
        match save.step {
            Step::Void => {
                memory.write(start, VOID);
                save.step = Step::Body(0);
            }
            Step::Body(offset) => {
                let at = start + 1 + offset;
                let byte = save.byte(offset, buffer);
                if memory.read(at) != byte {
                    memory.write(at, byte);
                }
                save.step = if offset + 1 < save.body_len() { Step::Body(offset + 1) } else { Step::Verify };
            }
            Step::Verify => {
                let reads_back =
                    (0..save.body_len()).all(|o| memory.read(start + 1 + o) == save.byte(o, buffer));
                if !reads_back {
                    self.save = None;
                    return Some(Saved::Failed);
                }
                save.step = Step::Mark;
            }
            Step::Mark => {
                memory.write(start, WHOLE);
                save.step = Step::MarkWritten;
            }
            Step::MarkWritten => {
                let marked = memory.read(start) == WHOLE;
                if marked {
                    self.generation = save.header.generation;
                    self.next_slot = 1 - save.slot;
                }
                self.save = None;
                return Some(if marked { Saved::Verified } else { Saved::Failed });
            }
        }
        None
    }
}

impl Save {
    const fn body_len(&self) -> u16 {
        HEADER_LEN + self.header.len + 2
    }

    /// Byte `offset` of header, table and CRC.
    fn byte(&self, offset: u16, buffer: &[u8; MAX_ENCODED_LEN]) -> u8 {
        let table_end = HEADER_LEN + self.header.len;
        if offset < HEADER_LEN {
            self.header.bytes()[usize::from(offset)]
        } else if offset < table_end {
            buffer[usize::from(offset - HEADER_LEN)]
        } else {
            self.crc.to_le_bytes()[usize::from(offset - table_end)]
        }
    }
}

fn crc_of(header: &[u8], table: &[u8]) -> u16 {
    let mut crc = protocol::crc::Crc16::new();
    crc.update(header);
    crc.update(table);
    crc.value()
}
