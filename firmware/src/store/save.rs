//! A save, a byte at a time.
//!
//! Holds the order: the place loses its mark, takes the bytes, is read back, and
//! gets its mark again; then the gait to start with is set, and what was replaced is
//! given up. Does not depend on what is saved.

use super::{
    CALIBRATION_PLACE_LEN, CALIBRATION_PLACES, CRC_LEN, GAIT_HEAD_LEN, Kind, NAME, START_PLACE, Saved, Store,
    TRIAL_PLACE, VOID, WHOLE, crc_of, gait_place, start_code, start_slot,
};
use crate::hal::PersistentMemory;
use protocol::{GAIT_SLOTS, Name};

#[derive(Debug, Clone, Copy)]
pub(super) struct Job {
    pub(super) kind: Kind,
    slot: u8,
    head: [u8; GAIT_HEAD_LEN as usize],
    len: u16,
    crc: u16,
    step: Step,
}

#[derive(Debug, Clone, Copy)]
enum Step {
    Void,
    Body(u16),
    Verify,
    Mark,
    Marked,
    KeepStart,
    Start,
    /// Gives up this place, if it holds what was replaced.
    Replaced(u8),
}

impl Store {
    #[inline(never)]
    pub(super) fn begin(&mut self, kind: Kind, slot: u8, head: [u8; GAIT_HEAD_LEN as usize], payload: &[u8]) {
        let mut job = Job { kind, slot, head, len: payload.len() as u16, crc: 0, step: Step::Void };
        job.crc = crc_of(&head[..usize::from(job.head_len())], payload);
        if kind == Kind::Start {
            job.step = Step::KeepStart;
        }
        self.job = Some(job);
    }

    /// Writes the next byte if the memory is ready; tells when the save ends.
    ///
    /// `payload` is what the save began with.
    pub fn step(&mut self, memory: &mut impl PersistentMemory, payload: &[u8]) -> Option<Saved> {
        let job = self.job.as_mut()?;
        if memory.is_busy() {
            return None;
        }
        let place = job.place();
        let mut ended = None;
        job.step = match job.step {
            Step::Void => {
                put(memory, place, VOID);
                Step::Body(0)
            }
            Step::Body(offset) => {
                put(memory, place + 1 + offset, job.byte(offset, payload));
                if offset + 1 < job.body_len() { Step::Body(offset + 1) } else { Step::Verify }
            }
            Step::Verify => {
                let reads_back =
                    (0..job.body_len()).all(|at| memory.read(place + 1 + at) == job.byte(at, payload));
                if !reads_back {
                    ended = Some(false);
                }
                Step::Mark
            }
            Step::Mark => {
                put(memory, place, WHOLE);
                Step::Marked
            }
            Step::Marked => {
                if memory.read(place) != WHOLE {
                    ended = Some(false);
                } else if job.kind == Kind::Trial {
                    ended = Some(true);
                }
                if job.kind == Kind::Gait { Step::KeepStart } else { Step::Replaced(0) }
            }
            Step::KeepStart => {
                // What the last power cut left of the first byte is not worth keeping.
                if let Some(slot) = start_slot(memory) {
                    put(memory, START_PLACE + 1, start_code(slot));
                }
                Step::Start
            }
            Step::Start => {
                put(memory, START_PLACE, start_code(job.slot));
                if job.kind == Kind::Start {
                    ended = Some(true);
                }
                Step::Replaced(0)
            }
            Step::Replaced(other) if other >= job.slots() => {
                ended = Some(true);
                job.step
            }
            Step::Replaced(other) => {
                let at = job.place_of(other);
                let is_replaced = other != job.slot && memory.read(at) == WHOLE && {
                    job.kind == Kind::Calibration || have_one_name(memory, at, place)
                };
                if is_replaced {
                    put(memory, at, VOID);
                }
                Step::Replaced(other + 1)
            }
        };
        let saved = ended.map(|verified| Saved { kind: job.kind, verified });
        if saved.is_some() {
            self.job = None;
        }
        saved
    }
}

impl Job {
    const fn head_len(&self) -> u16 {
        if matches!(self.kind, Kind::Gait) { GAIT_HEAD_LEN } else { 0 }
    }

    const fn slots(&self) -> u8 {
        if matches!(self.kind, Kind::Gait) { GAIT_SLOTS } else { CALIBRATION_PLACES.len() as u8 }
    }

    const fn place_of(&self, slot: u8) -> u16 {
        match self.kind {
            Kind::Gait | Kind::Start => gait_place(slot),
            Kind::Calibration => CALIBRATION_PLACES[0] + slot as u16 * CALIBRATION_PLACE_LEN,
            Kind::Trial => TRIAL_PLACE,
        }
    }

    const fn place(&self) -> u16 {
        self.place_of(self.slot)
    }

    const fn body_len(&self) -> u16 {
        self.head_len() + self.len + CRC_LEN
    }

    /// Byte `offset` of head, payload and CRC.
    fn byte(&self, offset: u16, payload: &[u8]) -> u8 {
        let [low, high] = self.crc.to_le_bytes();
        let head_len = self.head_len();
        if offset < head_len {
            self.head.get(usize::from(offset)).copied().unwrap_or(0)
        } else if offset < head_len + self.len {
            payload.get(usize::from(offset - head_len)).copied().unwrap_or(0)
        } else if offset == head_len + self.len {
            low
        } else {
            high
        }
    }
}

/// Writes a byte that is not there yet.
#[inline(never)]
fn put(memory: &mut impl PersistentMemory, at: u16, byte: u8) {
    if memory.read(at) != byte {
        memory.write(at, byte);
    }
}

/// Whether the gaits in two places have the same name.
fn have_one_name(memory: &mut impl PersistentMemory, one: u16, other: u16) -> bool {
    const FIRST: u16 = 1 + GAIT_HEAD_LEN + NAME;
    (FIRST..FIRST + Name::CAPACITY as u16).all(|at| memory.read(one + at) == memory.read(other + at))
}
