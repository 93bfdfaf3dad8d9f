//! A memory whose power goes during a write, and a store on it.
//!
//! Holds what a byte may hold after that: the old bits, with any of them erased;
//! none; or the new ones, with any of the zeros still missing.

use firmware::hal::PersistentMemory;
use firmware::store::{Kind, Saved, Store};
use protocol::gait::MAX_ENCODED_LEN;
use protocol::{Amplitude, GAIT_SLOTS};

/// How far a write came.
#[derive(Debug, Clone, Copy)]
pub enum Torn {
    NotBegun,
    /// These bits are erased; the others are the old ones.
    Erasing(u8),
    Erased,
    /// All but these bits are written.
    Writing(u8),
}

impl Torn {
    pub const ALL: [Self; 8] = [
        Self::NotBegun,
        Self::Erasing(0xAA),
        Self::Erasing(0xA5),
        Self::Erasing(0x3C),
        Self::Erased,
        Self::Writing(0xAA),
        Self::Writing(0x55),
        Self::Writing(0x03),
    ];
}

/// Memory whose power goes during the write after so many.
#[derive(Clone)]
pub struct Memory {
    pub bytes: [u8; 1024],
    writes_left: usize,
    torn: Torn,
    pub is_off: bool,
    /// Writes that changed nothing but the cell's age.
    pub needless: usize,
}

impl Memory {
    pub fn erased() -> Self {
        Self::holding([0xFF; 1024])
    }

    pub fn holding(bytes: [u8; 1024]) -> Self {
        Self::cut_after(bytes, usize::MAX, Torn::NotBegun)
    }

    pub fn cut_after(bytes: [u8; 1024], writes_left: usize, torn: Torn) -> Self {
        Self { bytes, writes_left, torn, is_off: false, needless: 0 }
    }
}

impl PersistentMemory for Memory {
    fn is_busy(&self) -> bool {
        false
    }

    fn read(&mut self, at: u16) -> u8 {
        self.bytes[usize::from(at)]
    }

    fn write(&mut self, at: u16, byte: u8) {
        let place = &mut self.bytes[usize::from(at)];
        self.needless += usize::from(*place == byte);
        if self.writes_left > 0 {
            self.writes_left -= 1;
            *place = byte;
        } else if !std::mem::replace(&mut self.is_off, true) {
            *place = match self.torn {
                Torn::NotBegun => *place,
                Torn::Erasing(mask) => *place | mask,
                Torn::Erased => 0xFF,
                Torn::Writing(mask) => byte | mask,
            };
        }
    }
}

/// Runs the save until it is done; `None` if the power went before.
pub fn finish(store: &mut Store, memory: &mut Memory, payload: &[u8]) -> Option<Saved> {
    for _ in 0..2_000 {
        if memory.is_off {
            return None;
        }
        if let Some(saved) = store.step(memory, payload) {
            return Some(saved);
        }
    }
    panic!("a save of {} bytes without an end", payload.len());
}

/// Saves a gait where there is room.
pub fn save_gait(memory: &mut Memory, encoding: &[u8], amplitude: Amplitude) -> Option<Saved> {
    let mut store = Store::new();
    let slot = store.free_slot(memory).expect("a free slot");
    store.save_gait(slot, amplitude, encoding);
    finish(&mut store, memory, encoding)
}

/// Makes the gait in `slot` the first.
pub fn select(memory: &mut Memory, slot: u8) -> Option<Saved> {
    let mut store = Store::new();
    store.set_start(slot);
    finish(&mut store, memory, &[])
}

/// Saves a calibration or a trial.
pub fn save_record(memory: &mut Memory, kind: Kind, record: &[u8]) -> Option<Saved> {
    let mut store = Store::new();
    store.save_record(memory, kind, record);
    finish(&mut store, memory, record)
}

/// The gait in `slot`, whole.
pub fn gait_in(memory: &mut Memory, slot: u8) -> Option<(Vec<u8>, Amplitude)> {
    let mut buffer = [0; MAX_ENCODED_LEN];
    let (amplitude, len) = Store::new().load_gait(memory, slot, &mut buffer).ok()?;
    Some((buffer[..len].to_vec(), amplitude))
}

/// All whole gaits.
pub fn gaits(memory: &mut Memory) -> Vec<(Vec<u8>, Amplitude)> {
    (0..GAIT_SLOTS).filter_map(|slot| gait_in(memory, slot)).collect()
}

/// The gait that the robot starts with.
pub fn first_gait(memory: &mut Memory) -> Option<Vec<u8>> {
    let start = Store::new().start_slot(memory).unwrap_or(0);
    let slots = (0..GAIT_SLOTS).map(|next| (start + next) % GAIT_SLOTS);
    slots.into_iter().find_map(|slot| gait_in(memory, slot)).map(|(encoding, _)| encoding)
}
