//! The stored gait, with the power cut at every byte of a save.

use firmware::hal::PersistentMemory;
use firmware::store::{Saved, Store, Stored};
use protocol::command::Storage;
use protocol::gait::MAX_ENCODED_LEN;
use protocol::{Command, ResetCause};
use sim_tests::fixtures::{self, amplitude};
use sim_tests::sim_robot::{SimRobot, encoded};

/// What a byte holds whose write was cut short.
#[derive(Debug, Clone, Copy)]
enum Torn {
    NotBegun,
    Erased,
    /// Only some of the bits that were to become 0 have.
    Half,
}

/// Memory whose power goes during the write of this number.
#[derive(Clone)]
struct Memory {
    bytes: [u8; 1024],
    writes_left: usize,
    torn: Torn,
    is_off: bool,
}

impl Memory {
    fn holding(bytes: [u8; 1024], writes_left: usize, torn: Torn) -> Self {
        Self { bytes, writes_left, torn, is_off: false }
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
        if self.writes_left > 0 {
            self.writes_left -= 1;
            *place = byte;
        } else if !std::mem::replace(&mut self.is_off, true) {
            *place = match self.torn {
                Torn::NotBegun => *place,
                Torn::Erased => 0xFF,
                Torn::Half => byte | 0xAA,
            };
        }
    }
}

fn table_in(table: &[u8]) -> [u8; MAX_ENCODED_LEN] {
    let mut buffer = [0; MAX_ENCODED_LEN];
    buffer[..table.len()].copy_from_slice(table);
    buffer
}

/// Saves until it is done or the power is gone.
fn save(store: &mut Store, memory: &mut Memory, table: &[u8], value: f64) -> Option<Saved> {
    let buffer = table_in(table);
    assert!(store.begin(table, amplitude(value)));
    (0..2_000).find_map(|_| if memory.is_off { Some(None) } else { store.step(memory, &buffer).map(Some) })?
}

fn load(memory: &mut Memory) -> (Store, Option<(Stored, Vec<u8>)>) {
    let (mut store, mut buffer) = (Store::new(), [0; MAX_ENCODED_LEN]);
    let stored = store.load(memory, &mut buffer, |_| true);
    (store, stored.map(|stored| (stored, buffer[..stored.len].to_vec())))
}

#[test]
fn the_power_cut_at_every_byte_leaves_one_gait_whole_and_the_next_save_works() {
    let (old, new) = (encoded(&fixtures::trot()), encoded(&fixtures::medley()));
    for saves_before in 1..=3 {
        let mut memory = Memory::holding([0xFF; 1024], usize::MAX, Torn::Erased);
        let (mut store, nothing) = load(&mut memory);
        assert!(nothing.is_none());
        for number in 1..=saves_before {
            let value = 0.5 + 0.1 * f64::from(number);
            assert_eq!(save(&mut store, &mut memory, &old, value), Some(Saved::Verified));
        }
        let before = memory.bytes;
        let old_amplitude = amplitude(0.5 + 0.1 * f64::from(saves_before));

        for torn in [Torn::NotBegun, Torn::Erased, Torn::Half] {
            let mut was_new = 0;
            for writes in 0..=270 {
                let mut memory = Memory::holding(before, writes, torn);
                let (mut store, _) = load(&mut memory);
                save(&mut store, &mut memory, &new, 2.2);

                let mut memory = Memory::holding(memory.bytes, usize::MAX, torn);
                let (mut store, found) = load(&mut memory);
                let (stored, table) = found.expect("a gait after every cut");
                if table == new {
                    assert_eq!(stored.amplitude, amplitude(2.2));
                    was_new += 1;
                } else {
                    assert_eq!(
                        (&table, stored.amplitude),
                        (&old, old_amplitude),
                        "{writes} writes, {torn:?}"
                    );
                }
                assert_eq!(save(&mut store, &mut memory, &new, 3.0), Some(Saved::Verified));
                let (_, found) = load(&mut memory);
                assert_eq!(
                    found.map(|(stored, table)| (stored.amplitude, table)),
                    Some((amplitude(3.0), new.clone()))
                );
            }
            assert!((1..270).contains(&was_new), "{was_new} cuts came too late to matter");
        }
    }
}

/// What would be walked after a reset is what was saved, not what was set since.
#[test]
fn an_amplitude_set_after_the_save_is_told_to_be_in_ram_only() {
    let mut robot = SimRobot::new();
    robot.upload(&fixtures::trot(), amplitude(1.0), true);
    robot.run_frames(200);
    assert_eq!(robot.status().storage, Storage::Saved);

    robot.expect_done(Command::SetAmplitude(amplitude(1.0)));
    let unchanged = robot.status().storage;
    robot.expect_done(Command::SetAmplitude(amplitude(2.0)));
    let changed = robot.status().storage;
    let mut robot = robot.reset(ResetCause::External);

    assert_eq!((unchanged, changed), (Storage::Saved, Storage::RamOnly));
    let status = robot.status();
    assert_eq!((status.storage, status.gait.unwrap().amplitude), (Storage::Saved, amplitude(1.0)));
}

#[test]
fn an_amplitude_set_during_the_save_is_not_called_saved_by_its_end() {
    let mut robot = SimRobot::new();
    robot.upload(&fixtures::trot(), amplitude(1.0), true);
    robot.run_frames(2);
    assert_eq!(robot.status().storage, Storage::Saving);

    robot.expect_done(Command::SetAmplitude(amplitude(2.0)));
    robot.run_frames(200);

    assert_eq!(robot.status().storage, Storage::RamOnly);
    let mut robot = robot.power_cycle();
    assert_eq!(robot.status().gait.unwrap().amplitude, amplitude(1.0));
}
