//! The chips on the robot's two-wire bus, and the bus with its faults.
//!
//! Holds the table of the chips, and addressing: which chip a START selects, and
//! that bytes reach only that one. Does not depend on the master; [`crate::nano`]
//! drives the bus from the emulated TWI unit. Time is emulated seconds, never the
//! wall clock.

pub mod ina219;
pub mod pca9685;

use ina219::Ina219;
use pca9685::Pca9685;

// The models behind the table's roles, for code that does not care which chip it is.
pub use ina219::Ina219 as PowerSensor;
pub use pca9685 as servo_driver;
pub use pca9685::Pca9685 as ServoDriver;

/// The shunt whose voltage is the power sensor's current.
pub const SHUNT_OHM: f64 = 0.1;

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

/// The table of the chips, as types: everything that exists once for each chip is
/// made from its row, so that a chip without a part of its row does not compile.
macro_rules! chips {
    ($($(#[$doc:meta])* $chip:ident, $field:ident: $model:ty = $name:literal at $address:literal, $new:expr;)+) => {
        /// A chip on the bus, by its role.
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        pub enum Chip {
            $($(#[$doc])* $chip,)+
        }

        impl Chip {
            /// Every chip, in the table's order.
            pub const ALL: [Self; [$($name),+].len()] = [$(Self::$chip),+];

            /// The part's name.
            #[must_use]
            pub const fn name(self) -> &'static str {
                match self {
                    $(Self::$chip => $name,)+
                }
            }

            /// Its 7-bit address on the robot.
            #[must_use]
            pub const fn address(self) -> u8 {
                match self {
                    $(Self::$chip => $address,)+
                }
            }
        }

        /// The bus with every chip of the table.
        #[derive(Debug)]
        pub struct Bus {
            $($(#[$doc])* pub $field: $model,)+
            selected: Vec<Chip>,
            silent: Vec<Chip>,
            stuck: bool,
            /// Clocks that a chip still waits for before it lets go of the data line.
            data_held_for: u8,
        }

        impl Bus {
            /// A healthy bus whose chips were just powered on.
            #[must_use]
            pub fn new() -> Self {
                Self {
                    $($field: ($new)($address),)+
                    selected: Vec::new(),
                    silent: Vec::new(),
                    stuck: false,
                    data_held_for: 0,
                }
            }

            /// Switches the chip's supply off and on again: registers and inputs are as new.
            pub fn power_cycle(&mut self, chip: Chip) {
                match chip {
                    $(Chip::$chip => self.$field = ($new)($address),)+
                }
            }

            fn device(&mut self, chip: Chip) -> &mut dyn Device {
                match chip {
                    $(Chip::$chip => &mut self.$field,)+
                }
            }
        }
    };
}

chips! {
    /// The servo driver; all address pins are low.
    ServoDriver, servo_driver: Pca9685 = "PCA9685" at 0x40, Pca9685::new;
    /// The power sensor; A0 is bridged, for 0x40 is taken.
    PowerSensor, power_sensor: Ina219 = "INA219" at 0x41, Ina219::new;
}

impl Bus {
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
        for chip in Chip::ALL {
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
        for chip in Chip::ALL {
            if !self.silent.contains(&chip) {
                self.device(chip).stop(now_s);
            }
        }
    }

    /// The master was reset in the middle of whatever it did: no STOP comes.
    pub fn abandon(&mut self) {
        self.selected.clear();
    }
}

impl Default for Bus {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use firmware::chips::{PowerSensor as _, SensorChip, ServoChip, ServoDriver as _};

    #[test]
    fn each_chip_answers_at_its_own_address_and_at_the_data_sheets_group_addresses() {
        let mut bus = Bus::new();

        let answers: Vec<u8> = (0..128).filter(|&address| bus.start(address, false, 0.0)).collect();

        // 0 is the general call and 0x70 the PCA9685's ALLCALL, on by default.
        assert_eq!(answers, [0, 0x40, 0x41, 0x70]);
    }

    #[test]
    fn a_chips_address_in_the_table_selects_that_chip_alone() {
        for chip in Chip::ALL {
            let mut bus = Bus::new();

            bus.start(chip.address(), false, 0.0);

            assert_eq!(bus.selected, [chip], "{} at {:#04x}", chip.name(), chip.address());
        }
    }

    /// Another chip in the firmware alone, or in the table alone, ends here.
    #[test]
    fn firmware_and_models_have_the_same_chips() {
        let of_firmware = |chip| match chip {
            Chip::ServoDriver => ServoChip::ADDRESS,
            Chip::PowerSensor => SensorChip::ADDRESS,
        };
        for chip in Chip::ALL {
            assert_eq!(chip.address(), of_firmware(chip), "address of the {} ({chip:?})", chip.name());
        }
    }

    #[test]
    fn an_unplugged_chip_is_silent_and_keeps_its_registers() {
        let address = Chip::PowerSensor.address();
        let mut bus = Bus::new();
        bus.start(address, false, 0.0);
        for byte in [0x05, 0x12, 0x34] {
            bus.write(byte, 0.0);
        }
        bus.stop(0.0);

        bus.unplug(Chip::PowerSensor);
        let silent = !bus.start(address, true, 0.0);
        bus.replug(Chip::PowerSensor);
        bus.start(address, true, 0.0);

        assert!(silent);
        assert_eq!([bus.read(0.0), bus.read(0.0)], [0x12, 0x34]);
    }
}
