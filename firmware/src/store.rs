//! What survives power-off: gaits, the calibration, the last trial.
//!
//! Holds the layout of the persistent memory and writes it a byte whenever the
//! memory is ready, so saving never holds up a frame. A place counts only with
//! its mark, which is cleared first and set last, after the rest has been read
//! back. A gait or calibration goes to a free place and the one it replaces is
//! given up last of all: whenever the power goes, one of them is whole. The one
//! trial is simply lost then. A gait is never written over. Does not depend on what
//! a gait or a calibration means, nor on which is active. Longer than most files:
//! the layout and what reads it change together.
//!
//! | from | place | bytes |
//! |---|---|---|
//! | 0, 271, 542 | gait | mark, amplitude (2), length (2), encoding (264), CRC-16 (2) |
//! | 813, 900 | calibration | mark, record (84), CRC-16 (2) |
//! | 987 | gait to start with | two of its bits, by the place's number; then the one before |
//! | 989 | last trial | mark, record (23), CRC-16 (2) |
//!
//! Bytes that are right already are not written again: each takes 3.4 ms and
//! wears.

mod save;

use protocol::calibration::CALIBRATION_LEN;
use protocol::command::StoredGait;
use protocol::gait::MAX_ENCODED_LEN;
use protocol::trial::TRIAL_LEN;
use protocol::{Amplitude, Calibration, GAIT_SLOTS, Name, Refusal};

use crate::hal::PersistentMemory;
use save::Job;

/// Amplitude and length, 2 bytes each.
const GAIT_HEAD_LEN: u16 = 4;
const CRC_LEN: u16 = 2;
/// Bytes of a place for gaits.
pub const GAIT_PLACE_LEN: u16 = 1 + GAIT_HEAD_LEN + MAX_ENCODED_LEN as u16 + CRC_LEN;
/// Where the places for calibrations start.
pub const CALIBRATION_PLACES: [u16; 2] =
    [GAIT_SLOTS as u16 * GAIT_PLACE_LEN, GAIT_SLOTS as u16 * GAIT_PLACE_LEN + CALIBRATION_PLACE_LEN];
const CALIBRATION_PLACE_LEN: u16 = 1 + CALIBRATION_LEN as u16 + CRC_LEN;
/// Where it stands which gait to start with; behind it, which it was before.
pub const START_PLACE: u16 = CALIBRATION_PLACES[1] + CALIBRATION_PLACE_LEN;
/// Where the trial starts.
pub const TRIAL_PLACE: u16 = START_PLACE + 2;
const _: () = assert!(TRIAL_PLACE + 1 + TRIAL_LEN as u16 + CRC_LEN <= 1024);
/// The name within an encoding.
const NAME: u16 = 1;

const WHOLE: u8 = 0xA5;
const VOID: u8 = 0x00;

/// What can be saved.
// From 1, so that no job is all zeros: a start value that takes no flash.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum Kind {
    /// The active gait.
    Gait = 1,
    /// Which gait to start with.
    Start,
    /// The calibration in use.
    Calibration,
    /// The trial that ended last.
    Trial,
}

/// How a save ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Saved {
    /// What was saved.
    pub kind: Kind,
    /// Whether it reads back as written; if not, what it was to replace is as it was.
    pub verified: bool,
}

/// The save in progress.
#[derive(Debug)]
pub struct Store {
    job: Option<Job>,
}

impl Default for Store {
    fn default() -> Self {
        Self::new()
    }
}

/// The code of `slot`: a byte whose writing was cut short has some of its zeros
/// missing, and is not the code of another slot.
const fn start_code(slot: u8) -> u8 {
    3 << (2 * slot)
}

const fn gait_place(slot: u8) -> u16 {
    slot as u16 * GAIT_PLACE_LEN
}

impl Store {
    /// Nothing to save.
    #[must_use]
    pub const fn new() -> Self {
        Self { job: None }
    }

    /// What is being saved.
    #[must_use]
    pub fn saving(&self) -> Option<Kind> {
        self.job.as_ref().map(|job| job.kind)
    }

    /// Whether the memory may be read and written by others.
    fn is_free(&self, memory: &impl PersistentMemory) -> Result<(), Refusal> {
        if self.job.is_some() || memory.is_busy() { Err(Refusal::StorageBusy) } else { Ok(()) }
    }

    /// Reads the gait in `slot` into `buffer`; returns its amplitude and length.
    ///
    /// # Errors
    /// [`Refusal::StorageBusy`] while something is being written,
    /// [`Refusal::NoSuchGait`] if none is there.
    pub fn load_gait(
        &self,
        memory: &mut impl PersistentMemory,
        slot: u8,
        buffer: &mut [u8; MAX_ENCODED_LEN],
    ) -> Result<(Amplitude, usize), Refusal> {
        self.is_free(memory)?;
        let (amplitude, len) = gait_head(memory, slot).ok_or(Refusal::NoSuchGait)?;
        let encoding = buffer.get_mut(..len).ok_or(Refusal::NoSuchGait)?;
        let at = gait_place(slot) + 1 + GAIT_HEAD_LEN;
        read_into(memory, at, encoding);
        let sum = crc_of(&head_of(amplitude, len as u16), encoding);
        let is_intact = crc_at(memory, at + len as u16) == sum;
        is_intact.then_some((amplitude, len)).ok_or(Refusal::NoSuchGait)
    }

    /// The slot of the gait to start with, or else the one before; it may be empty.
    pub fn start_slot(&self, memory: &mut impl PersistentMemory) -> Option<u8> {
        start_slot(memory)
    }

    /// What is in `slot`.
    ///
    /// # Errors
    /// [`Refusal::NoSuchGait`] if there is no such slot, [`Refusal::StorageBusy`]
    /// while something is being written.
    pub fn stored_gait(
        &self,
        memory: &mut impl PersistentMemory,
        slot: u8,
    ) -> Result<Option<StoredGait>, Refusal> {
        self.is_free(memory)?;
        if slot >= GAIT_SLOTS {
            return Err(Refusal::NoSuchGait);
        }
        let Some((amplitude, _)) = gait_head(memory, slot) else { return Ok(None) };
        let name = name_at(memory, slot);
        Ok(Some(StoredGait { name, amplitude, at_start: self.start_slot(memory) == Some(slot) }))
    }

    /// Makes the gait in `slot` the one to start with; only after [`Self::load_gait`].
    pub fn set_start(&mut self, slot: u8) {
        self.begin(Kind::Start, slot, [0; GAIT_HEAD_LEN as usize], &[]);
    }

    /// Gives up the gait in `slot`; returns its name.
    ///
    /// # Errors
    /// As [`Self::load_gait`].
    pub fn erase_gait(&self, memory: &mut impl PersistentMemory, slot: u8) -> Result<Name, Refusal> {
        self.is_free(memory)?;
        gait_head(memory, slot).ok_or(Refusal::NoSuchGait)?;
        let name = name_at(memory, slot);
        memory.write(gait_place(slot), VOID);
        Ok(name)
    }

    /// Reads the stored calibration, if there is a sound one; `buffer` is used up.
    pub fn load_calibration(
        &self,
        memory: &mut impl PersistentMemory,
        buffer: &mut [u8; MAX_ENCODED_LEN],
        calibration: &mut Calibration,
    ) -> bool {
        let Some(record) = buffer.get_mut(..CALIBRATION_LEN) else { return false };
        CALIBRATION_PLACES
            .into_iter()
            .any(|at| read_place(memory, at, record).is_some() && calibration.replace(record).is_ok())
    }

    /// Whether a calibration was stored, sound or not.
    pub fn has_calibration(&self, memory: &mut impl PersistentMemory) -> bool {
        CALIBRATION_PLACES.into_iter().any(|at| memory.read(at) == WHOLE)
    }

    /// Reads the last trial into `record`; says whether there is one.
    ///
    /// # Errors
    /// [`Refusal::StorageBusy`] while something is being written.
    pub fn load_trial(
        &self,
        memory: &mut impl PersistentMemory,
        record: &mut [u8; TRIAL_LEN],
    ) -> Result<bool, Refusal> {
        self.is_free(memory)?;
        Ok(read_place(memory, TRIAL_PLACE, record).is_some())
    }

    /// A slot that a gait may be saved to.
    ///
    /// # Errors
    /// [`Refusal::StorageBusy`] while something is being written,
    /// [`Refusal::StorageFull`] if every slot holds a gait.
    pub fn free_slot(&self, memory: &mut impl PersistentMemory) -> Result<u8, Refusal> {
        self.is_free(memory)?;
        (0..GAIT_SLOTS).find(|&slot| gait_head(memory, slot).is_none()).ok_or(Refusal::StorageFull)
    }

    /// Starts saving the gait of `encoding`, which must not change meanwhile.
    pub fn save_gait(&mut self, slot: u8, amplitude: Amplitude, encoding: &[u8]) {
        let len = encoding.len() as u16;
        self.begin(Kind::Gait, slot, head_of(amplitude, len), encoding);
    }

    /// Starts saving a calibration or a trial, which must stay as it is meanwhile.
    pub fn save_record(&mut self, memory: &mut impl PersistentMemory, kind: Kind, record: &[u8]) {
        // To the other place, or the first of two void ones.
        let slot = u8::from(kind == Kind::Calibration && memory.read(CALIBRATION_PLACES[0]) == WHOLE);
        self.begin(kind, slot, [0; GAIT_HEAD_LEN as usize], record);
    }

    /// Gives up saving the trial: another one begins.
    pub fn forget_trial(&mut self) {
        if self.saving() == Some(Kind::Trial) {
            self.job = None;
        }
    }
}

const fn head_of(amplitude: Amplitude, len: u16) -> [u8; GAIT_HEAD_LEN as usize] {
    let [a0, a1] = amplitude.units().to_le_bytes();
    let [l0, l1] = len.to_le_bytes();
    [a0, a1, l0, l1]
}

/// Amplitude and length of the gait in `slot`, if its place is marked whole.
#[inline(never)]
fn gait_head(memory: &mut impl PersistentMemory, slot: u8) -> Option<(Amplitude, usize)> {
    if slot >= GAIT_SLOTS || memory.read(gait_place(slot)) != WHOLE {
        return None;
    }
    let mut head = [0; GAIT_HEAD_LEN as usize];
    read_into(memory, gait_place(slot) + 1, &mut head);
    let [a0, a1, l0, l1] = head;
    let amplitude = Amplitude::from_units(u16::from_le_bytes([a0, a1]))?;
    Some((amplitude, usize::from(u16::from_le_bytes([l0, l1]))))
}

#[inline(never)]
fn start_slot(memory: &mut impl PersistentMemory) -> Option<u8> {
    let slot_in = |code: u8| match code {
        FIRST => Some(0),
        SECOND => Some(1),
        THIRD => Some(2),
        _ => None,
    };
    slot_in(memory.read(START_PLACE)).or_else(|| slot_in(memory.read(START_PLACE + 1)))
}

const FIRST: u8 = start_code(0);
const SECOND: u8 = start_code(1);
const THIRD: u8 = start_code(2);
const _: () = assert!(GAIT_SLOTS == 3);

#[inline(never)]
fn name_at(memory: &mut impl PersistentMemory, slot: u8) -> Name {
    let mut name = [0; Name::CAPACITY];
    read_into(memory, gait_place(slot) + 1 + GAIT_HEAD_LEN + NAME, &mut name);
    Name::from_bytes(name)
}

#[inline(never)]
fn read_into(memory: &mut impl PersistentMemory, at: u16, buffer: &mut [u8]) {
    for (at, byte) in (at..).zip(buffer) {
        *byte = memory.read(at);
    }
}

fn crc_at(memory: &mut impl PersistentMemory, at: u16) -> u16 {
    u16::from_le_bytes([memory.read(at), memory.read(at + 1)])
}

/// Reads a record whose place is marked whole and whose CRC is right.
fn read_place(memory: &mut impl PersistentMemory, at: u16, record: &mut [u8]) -> Option<()> {
    read_into(memory, at + 1, record);
    let is_whole =
        memory.read(at) == WHOLE && crc_at(memory, at + 1 + record.len() as u16) == crc_of(&[], record);
    is_whole.then_some(())
}

#[inline(never)]
fn crc_of(head: &[u8], payload: &[u8]) -> u16 {
    let mut crc = protocol::crc::Crc16::new();
    crc.update(head);
    crc.update(payload);
    crc.value()
}
