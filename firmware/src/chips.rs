//! The chips on the two-wire bus: what the robot asks of each, and which ones it has.
//!
//! Holds a role for the servo driver and one for the power sensor, and the two
//! names that say which chip plays which role. Another part is one file in
//! `chips/` that implements its role, and one name here. Does not depend on the
//! board: a chip is reached through any [`I2c`].

mod ina219;
mod pca9685;

use embedded_hal::delay::DelayNs;
use embedded_hal::i2c::I2c;

/// The servo driver of this robot.
pub type ServoChip = pca9685::Pca9685;
/// The power sensor of this robot.
pub type SensorChip = ina219::Ina219;

/// What the servo driver is sent in every frame.
pub type ServoBurst = <ServoChip as ServoDriver>::Burst;

/// Why a chip cannot be used.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ChipFault {
    /// No acknowledge, or a stuck bus.
    NoAnswer,
    /// It answers, but what was written does not read back.
    WrongConfiguration,
}

/// The role of a servo driver: eight pulses from one write a frame.
///
/// Pulse widths are in counts of 1/4096 of the pulse period, which `prescale`
/// sets: `(prescale + 1) * 4096` cycles of a 25 MHz oscillator, as calibrations
/// have it. A chip with other units converts them here.
pub trait ServoDriver {
    /// 7-bit bus address.
    const ADDRESS: u8;
    /// An array of bytes: the one write that updates all eight outputs. The board
    /// sends it by interrupt at the start of every frame, so it has no other form.
    type Burst: Copy + AsRef<[u8]>;

    /// The burst that takes the pulses from all eight outputs.
    fn limp_burst() -> Self::Burst;

    /// Gives output `channel` a pulse of `counts`; the other outputs stay as they are.
    fn set_pulse(burst: &mut Self::Burst, channel: u8, counts: u16);

    /// Takes the pulses from every output, in any state of the chip.
    ///
    /// # Errors
    /// [`ChipFault::NoAnswer`] if the chip did not take it.
    fn switch_off(bus: &mut impl I2c) -> Result<(), ChipFault>;

    /// Configures the chip from whatever state it is in, outputs off, and checks it.
    ///
    /// # Errors
    /// What is wrong with the chip.
    fn configure(bus: &mut impl I2c, delay: &mut impl DelayNs, prescale: u8) -> Result<(), ChipFault>;

    /// Whether the chip still has its configuration, which a brown-out takes.
    ///
    /// # Errors
    /// What is wrong with the chip.
    fn check(bus: &mut impl I2c, prescale: u8) -> Result<(), ChipFault>;
}

/// Voltage per count, whatever the sensor's own unit.
pub const MV_PER_COUNT: u16 = 4;
/// Current per count, whatever the sensor's own unit.
pub const UA_PER_COUNT: i32 = 100;

/// The sensor's two registers as they were read.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Reading {
    /// [`PowerSensor::VOLTAGE_REGISTER`].
    pub voltage: u16,
    /// [`PowerSensor::CURRENT_REGISTER`].
    pub current: u16,
}

/// The role of a power sensor: voltage and current from two 16-bit registers.
///
/// The board reads both by interrupt, high byte first, nine times a frame.
pub trait PowerSensor {
    /// 7-bit bus address.
    const ADDRESS: u8;
    /// The register with the supply's voltage behind the shunt.
    const VOLTAGE_REGISTER: u8;
    /// The register with the current, or with the voltage across the shunt.
    const CURRENT_REGISTER: u8;
    /// From this many counts on, of either sign, the current is out of range.
    const FULL_SCALE: u16;
    /// What the shunt itself drops: counts of voltage per count of current, times 2^14.
    const SHUNT_DROP_Q14: i32;

    /// A reading as voltage in counts of [`MV_PER_COUNT`], at most 2^13, and current
    /// in counts of [`UA_PER_COUNT`].
    fn counts(reading: Reading) -> (u16, i16);

    /// Configures the sensor, and reads back that it took it.
    ///
    /// # Errors
    /// What is wrong with the sensor.
    fn configure(bus: &mut impl I2c) -> Result<(), ChipFault>;

    /// Whether the sensor still has its configuration, which a brown-out takes.
    ///
    /// # Errors
    /// What is wrong with the sensor.
    fn check(bus: &mut impl I2c) -> Result<(), ChipFault>;
}
