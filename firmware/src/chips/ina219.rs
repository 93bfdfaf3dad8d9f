//! The INA219 as power sensor, behind a shunt of 0.1 ohm.
//!
//! Holds the sensor's configuration and the units of its registers. Does not
//! depend on how often it is read, nor on what its readings are used for.

use embedded_hal::i2c::I2c;
use ina219::SyncIna219;
use ina219::address::{Address, Pin};
use ina219::calibration::UnCalibrated;
use ina219::configuration::{
    BusVoltageRange, Configuration, MeasuredSignals, OperatingMode, Reset, Resolution, ShuntVoltageRange,
};

use super::{ChipFault, PowerSensor, Reading};

/// Short conversions, one after the other: 10 bits take 0.15 ms for each input,
/// so that a reading's current and voltage belong together. Averaged over longer
/// times they do not: while current pulses, the voltage sags, and the product of
/// two means is not the mean of the products.
const CONFIGURATION: Configuration = Configuration {
    reset: Reset::Run,
    bus_voltage_range: BusVoltageRange::Fsr16v,
    shunt_voltage_range: ShuntVoltageRange::Fsr320mv,
    bus_resolution: Resolution::Res10Bit,
    shunt_resolution: Resolution::Res10Bit,
    operating_mode: OperatingMode::Continous(MeasuredSignals::ShutAndBusVoltage),
};

/// The chip with A0 high: both chips come out of the box at 0x40.
pub struct Ina219;

impl PowerSensor for Ina219 {
    const ADDRESS: u8 = 0x41;
    const VOLTAGE_REGISTER: u8 = 2;
    const CURRENT_REGISTER: u8 = 1;
    /// The shunt register at the end of its /8 range, 320 mV: 3.2 A.
    const FULL_SCALE: u16 = 32_000;
    /// 100 uA across 0.1 ohm are 1/400 of 4 mV, and 41/2^14 is that to a thousandth.
    const SHUNT_DROP_Q14: i32 = 41;

    fn counts(reading: Reading) -> (u16, i16) {
        // The voltage is in the upper 13 bits, flags below. The chip's units are the
        // role's: 4 mV, and 10 uV across 0.1 ohm.
        (reading.voltage >> 3, reading.current as i16)
    }

    fn configure(bus: &mut impl I2c) -> Result<(), ChipFault> {
        chip(bus).set_configuration(CONFIGURATION).map_err(|_| ChipFault::NoAnswer)?;
        Self::check(bus)
    }

    fn check(bus: &mut impl I2c) -> Result<(), ChipFault> {
        let configuration = chip(bus).configuration().map_err(|_| ChipFault::NoAnswer)?;
        if configuration == CONFIGURATION { Ok(()) } else { Err(ChipFault::WrongConfiguration) }
    }
}

fn chip<B: I2c>(bus: &mut B) -> SyncIna219<&mut B, UnCalibrated> {
    const PINS: Address = Address::from_pins(Pin::Vcc, Pin::Gnd);
    SyncIna219::new_unchecked(bus, PINS, UnCalibrated)
}
