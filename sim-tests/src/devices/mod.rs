//! The chips on the robot's two-wire bus, and the bus with its faults.
//!
//! Owns addressing: which chip a START selects, and that bytes reach only that
//! one. Refuses to know the master; [`crate::nano`] drives it from the
//! emulated TWI unit. Time is emulated seconds, never the wall clock.

pub mod ina219;
pub mod pca9685;

pub use ina219::Ina219;
pub use pca9685::Pca9685;

/// The PCA9685's address on the robot.
pub const PCA9685_ADDRESS: u8 = 0x40;
/// The INA219's address on the robot: A0 bridged, for 0x40 is taken.
pub const INA219_ADDRESS: u8 = 0x41;

/// What a chip on the bus does with a transaction.
pub trait Device {
    /// A START with this 7-bit address; true acknowledges and selects the chip.
    fn select(&mut self, address: u8, read: bool, now_s: f64) -> bool;
    /// A byte from the master; true acknowledges.
    fn write(&mut self, byte: u8, now_s: f64) -> bool;
    /// A byte for the master.
    fn read(&mut self, now_s: f64) -> u8;
    /// A STOP on the bus; every chip sees it, selected or not.
    fn stop(&mut self, now_s: f64);
}

/// A chip that a bus can be told to break.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Chip {
    /// The servo driver.
    Pca9685,
    /// The power sensor.
    Ina219,
}

/// The bus with both chips.
#[derive(Debug)]
pub struct Bus {
    /// The servo driver.
    pub pca9685: Pca9685,
    /// The power sensor.
    pub ina219: Ina219,
    selected: Vec<Chip>,
    silent: Vec<Chip>,
    stuck: bool,
    /// Clocks that a chip still waits for before it lets go of the data line.
    data_held_for: u8,
}

impl Bus {
    /// A healthy bus.
    #[must_use]
    pub fn new(pca9685: Pca9685, ina219: Ina219) -> Self {
        let (selected, silent) = (Vec::new(), Vec::new());
        Self { pca9685, ina219, selected, silent, stuck: false, data_held_for: 0 }
    }

    /// From now on the chip acknowledges nothing, as with a broken wire.
    pub fn unplug(&mut self, chip: Chip) {
        self.silent.push(chip);
        self.selected.retain(|selected| *selected != chip);
    }

    /// The chip answers again; its registers are as they were.
    pub fn replug(&mut self, chip: Chip) {
        self.silent.retain(|silent| *silent != chip);
    }

    /// Holds the clock line low: no transfer ever ends.
    pub fn set_stuck(&mut self, stuck: bool) {
        self.stuck = stuck;
    }

    /// Holds the data line low, as a chip does that lost its master in the
    /// middle of a byte, until it has seen so many clocks.
    pub fn hold_data(&mut self, clocks: u8) {
        self.data_held_for = clocks;
    }

    /// Whether the data line is held low.
    #[must_use]
    pub fn is_data_held(&self) -> bool {
        self.data_held_for > 0
    }

    /// A clock by hand, outside any transfer.
    pub fn clock(&mut self) {
        self.data_held_for = self.data_held_for.saturating_sub(u8::from(!self.stuck));
    }

    /// Whether a line is held low, so that no transfer begins or ends.
    #[must_use]
    pub fn is_stuck(&self) -> bool {
        self.stuck || self.is_data_held()
    }

    /// A START, or repeated START, with an address; true if any chip answers.
    pub fn start(&mut self, address: u8, read: bool, now_s: f64) -> bool {
        self.selected.clear();
        for chip in [Chip::Pca9685, Chip::Ina219] {
            if !self.silent.contains(&chip) && self.device(chip).select(address, read, now_s) {
                self.selected.push(chip);
            }
        }
        !self.selected.is_empty()
    }

    /// A byte from the master; true if a selected chip acknowledges.
    pub fn write(&mut self, byte: u8, now_s: f64) -> bool {
        let mut acknowledged = false;
        for chip in self.selected.clone() {
            acknowledged |= self.device(chip).write(byte, now_s);
        }
        acknowledged
    }

    /// A byte for the master: open-drain lines, so silence is all ones.
    pub fn read(&mut self, now_s: f64) -> u8 {
        self.selected.clone().into_iter().fold(0xFF, |byte, chip| byte & self.device(chip).read(now_s))
    }

    /// A STOP.
    pub fn stop(&mut self, now_s: f64) {
        self.selected.clear();
        for chip in [Chip::Pca9685, Chip::Ina219] {
            if !self.silent.contains(&chip) {
                self.device(chip).stop(now_s);
            }
        }
    }

    /// The master was reset in the middle of whatever it did: no STOP comes.
    pub fn abandon(&mut self) {
        self.selected.clear();
    }

    fn device(&mut self, chip: Chip) -> &mut dyn Device {
        match chip {
            Chip::Pca9685 => &mut self.pca9685,
            Chip::Ina219 => &mut self.ina219,
        }
    }
}

impl Default for Bus {
    fn default() -> Self {
        Self::new(Pca9685::new(pca9685::NOMINAL_OSCILLATOR_HZ), Ina219::new())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_chip_answers_at_its_own_address_only() {
        let mut bus = Bus::default();

        let answers: Vec<u8> = (0..128).filter(|&address| bus.start(address, false, 0.0)).collect();

        // 0 is the general call and 0x70 the PCA9685's ALLCALL, on by default.
        assert_eq!(answers, [0, 0x40, 0x41, 0x70]);
    }

    #[test]
    fn an_unplugged_chip_is_silent_and_keeps_its_registers() {
        let mut bus = Bus::default();
        bus.start(INA219_ADDRESS, false, 0.0);
        for byte in [0x05, 0x12, 0x34] {
            bus.write(byte, 0.0);
        }
        bus.stop(0.0);

        bus.unplug(Chip::Ina219);
        let silent = !bus.start(INA219_ADDRESS, true, 0.0);
        bus.replug(Chip::Ina219);
        bus.start(INA219_ADDRESS, true, 0.0);

        assert!(silent);
        assert_eq!([bus.read(0.0), bus.read(0.0)], [0x12, 0x34]);
    }
}
