//! EEPROM contents of a robot that was calibrated.
//!
//! Holds the memory that the firmware's own store writes to, so that the layout is the
//! firmware's. Does not depend on the emulator.

use crate::nano::EEPROM_LEN;
use firmware::hal::PersistentMemory;
use firmware::store::{Kind, Store};
use protocol::Calibration;
use protocol::gait::MAX_ENCODED_LEN;

/// A memory that is always ready.
struct Memory([u8; EEPROM_LEN]);

impl PersistentMemory for Memory {
    fn is_busy(&self) -> bool {
        false
    }

    fn read(&mut self, at: u16) -> u8 {
        self.0.get(usize::from(at)).copied().unwrap_or(0xFF)
    }

    fn write(&mut self, at: u16, byte: u8) {
        if let Some(place) = self.0.get_mut(usize::from(at)) {
            *place = byte;
        }
    }
}

/// The same contents with `record` as the stored calibration.
#[must_use]
pub fn with_calibration(contents: &[u8; EEPROM_LEN], record: &Calibration) -> [u8; EEPROM_LEN] {
    let (mut memory, mut store) = (Memory(*contents), Store::new());
    store.save_record(&mut memory, Kind::Calibration, record.bytes());
    // A step a byte: the store verifies what it wrote, then ends the save.
    while store.saving().is_some() {
        store.step(&mut memory, record.bytes());
    }
    memory.0
}

/// Whether the contents hold a calibration, sound or not.
#[must_use]
pub fn holds_calibration(contents: &[u8; EEPROM_LEN]) -> bool {
    Store::new().has_calibration(&mut Memory(*contents))
}

/// The calibration that the firmware loads from the contents, if there is a sound one.
#[must_use]
pub fn calibration_in(contents: &[u8; EEPROM_LEN]) -> Option<Calibration> {
    let mut calibration = Calibration::authors();
    let is_sound =
        Store::new().load_calibration(&mut Memory(*contents), &mut [0; MAX_ENCODED_LEN], &mut calibration);
    is_sound.then_some(calibration)
}

#[cfg(test)]
mod tests {
    use super::*;
    use host::calibration::RobotCalibration;
    use host::robot::Robot;
    use std::path::Path;

    #[test]
    fn the_firmware_loads_what_was_written() {
        let pony = Robot::load(Path::new("../host/robots/pony")).unwrap();
        let record = RobotCalibration::of_robot(&pony).record().unwrap();
        let fresh = [0xFF; EEPROM_LEN];

        let contents = with_calibration(&fresh, &record);

        assert!(!holds_calibration(&fresh) && holds_calibration(&contents));
        assert_eq!(calibration_in(&contents), Some(record));
    }
}
