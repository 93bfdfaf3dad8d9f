//! The INA219, and the energy of a trial.
//!
//! Owns the sensor's configuration, the last good sample, and the integral.
//! Integer arithmetic only; the integral carries its remainder, so it is exact
//! over any number of frames. Refuses to count a frame without a sample: the
//! one before stands in, and the trial says how often.

use embedded_hal::i2c::I2c;
use ina219::SyncIna219;
use ina219::address::{Address, Pin};
use ina219::calibration::UnCalibrated;
use ina219::configuration::{
    BusVoltageRange, Configuration, MeasuredSignals, OperatingMode, Reset, Resolution, ShuntVoltageRange,
};
use protocol::FRAME_RATE_HZ;

/// Bus address 0x41, A0 high: both chips come out of the box at 0x40.
const ADDRESS: Address = Address::from_pins(Pin::Vcc, Pin::Gnd);
/// Bus voltage per count.
const MV_PER_COUNT: u16 = 4;
/// Current per count of 10 uV across 0.1 ohm.
const UA_PER_COUNT: i32 = 100;
/// The shunt register at the end of its /8 range: 320 mV.
const SHUNT_FULL_SCALE: u16 = 32_000;
const COUNTS_PER_MA: i16 = (1_000 / UA_PER_COUNT) as i16;
/// One product of counts is 4 mV * 100 uA for 1/60 s: 400 / 60 nJ, so this
/// many products make a microjoule.
const PRODUCTS_PER_UJ: i32 = FRAME_RATE_HZ as i32 * 1_000 / (MV_PER_COUNT as i32 * 100);

const _: () = assert!(PRODUCTS_PER_UJ == 150);

/// 8 samples averaged on both channels: 8.5 ms, half a frame. 16 would take
/// longer than a frame, and a single one would alias with the servos' PWM.
const CONFIGURATION: Configuration = Configuration {
    reset: Reset::Run,
    bus_voltage_range: BusVoltageRange::Fsr16v,
    shunt_voltage_range: ShuntVoltageRange::Fsr320mv,
    bus_resolution: Resolution::Avg8,
    shunt_resolution: Resolution::Avg8,
    operating_mode: OperatingMode::Continous(MeasuredSignals::ShutAndBusVoltage),
};

/// Why the sensor cannot be used.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SensorFault {
    /// No acknowledge, or a stuck bus.
    NoAnswer,
    /// It answers, but what was written does not read back.
    WrongConfiguration,
}

/// Why a frame has no sample of its own.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Missed {
    /// No acknowledge, or a stuck bus.
    NoAnswer,
    /// No conversion ended since the last reading.
    NotReady,
    /// The current is beyond the sensor's 3.2 A.
    Saturated,
}

/// One reading, in the sensor's counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Sample {
    bus_counts: u16,
    shunt_counts: i16,
}

impl Sample {
    /// No reading yet.
    pub const NONE: Self = Self { bus_counts: 0, shunt_counts: 0 };

    /// Supply voltage.
    #[must_use]
    pub const fn bus_mv(self) -> u16 {
        self.bus_counts * MV_PER_COUNT
    }

    /// Supply current.
    #[must_use]
    pub const fn current_ua(self) -> i32 {
        self.shunt_counts as i32 * UA_PER_COUNT
    }

    /// Whether the current is at `limit_ma` or more.
    #[must_use]
    pub const fn is_above_ma(self, limit_ma: u16) -> bool {
        // 10 counts a milliampere, and at most 3,150 of these: it fits.
        self.shunt_counts >= limit_ma as i16 * COUNTS_PER_MA
    }

    /// What leaves the battery, in products of a bus and a shunt count.
    ///
    /// The bus voltage is taken behind the shunt, whose own drop belongs to the
    /// battery's energy as well: 6 % at 3 A. A bus count is 400 shunt counts;
    /// 41/64 of 1/256 is 1/400 to a thousandth, without a division.
    const fn power_products(self) -> i32 {
        let shunt = self.shunt_counts as i32;
        // 4,000 * 32,000 + 32,000 * 32,000 / 400 is below 2^28.
        self.bus_counts as i32 * shunt + ((((shunt * shunt) >> 8) * 41) >> 6)
    }
}

fn chip<B: I2c>(bus: &mut B) -> SyncIna219<&mut B, UnCalibrated> {
    SyncIna219::new_unchecked(bus, ADDRESS, UnCalibrated)
}

/// Configures the sensor, and reads back that it took it.
///
/// # Errors
/// What is wrong with the sensor.
pub fn configure(bus: &mut impl I2c) -> Result<(), SensorFault> {
    chip(bus).set_configuration(CONFIGURATION).map_err(|_| SensorFault::NoAnswer)?;
    check(bus)
}

/// Whether the sensor still has its configuration, which a brown-out takes.
///
/// # Errors
/// What is wrong with the sensor.
pub fn check(bus: &mut impl I2c) -> Result<(), SensorFault> {
    let configuration = chip(bus).configuration().map_err(|_| SensorFault::NoAnswer)?;
    if configuration == CONFIGURATION { Ok(()) } else { Err(SensorFault::WrongConfiguration) }
}

/// The reading that ended last.
///
/// # Errors
/// Why there is none.
pub fn sample(bus: &mut impl I2c) -> Result<Sample, Missed> {
    let reading = match chip(bus).next_measurement() {
        Ok(Some(reading)) => reading,
        Ok(None) => return Err(Missed::NotReady),
        Err(ina219::errors::MeasurementError::I2cError(_)) => return Err(Missed::NoAnswer),
        // Beyond the ranges: nothing else is left, the chip does no sums here.
        Err(_) => return Err(Missed::Saturated),
    };
    let shunt_counts = reading.shunt_voltage.shunt_voltage_10uv();
    if shunt_counts.unsigned_abs() >= SHUNT_FULL_SCALE {
        return Err(Missed::Saturated);
    }
    Ok(Sample { bus_counts: reading.bus_voltage.voltage_4mv(), shunt_counts })
}

/// The figures of one trial.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Trial {
    /// Gait frames played.
    pub frames: u32,
    /// Gait frames in which a joint was held at its limit.
    pub clipped_frames: u32,
    /// Energy over those frames.
    pub energy_uj: u64,
    /// Frames whose sample was missed.
    pub missed_samples: u16,
    /// Products not yet a microjoule, of either sign.
    remainder: i32,
}

impl Trial {
    /// Nothing played yet.
    pub const NONE: Self =
        Self { frames: 0, clipped_frames: 0, energy_uj: 0, missed_samples: 0, remainder: 0 };

    /// Counts one gait frame with its sample.
    pub fn add(&mut self, sample: Sample, clipped: bool, missed: bool) {
        // Two years of frames: these may wrap, for the saturating kind takes 200 bytes more.
        self.frames = self.frames.wrapping_add(1);
        self.clipped_frames = self.clipped_frames.wrapping_add(u32::from(clipped));
        self.missed_samples = self.missed_samples.saturating_add(u16::from(missed));
        let products = sample.power_products() + self.remainder;
        let (energy_uj, remainder) = in_microjoules(products.unsigned_abs());
        // A servo that brakes may feed the supply; below zero there is nothing to give back.
        if products < 0 {
            self.energy_uj = self.energy_uj.saturating_sub(u64::from(energy_uj));
            self.remainder = -remainder;
        } else {
            self.energy_uj = self.energy_uj.wrapping_add(u64::from(energy_uj));
            self.remainder = remainder;
        }
    }
}

/// Quotient and remainder of `products / PRODUCTS_PER_UJ`.
///
/// Long division by hand: the quotient has 20 bits, and the general routine
/// costs an AVR 1.1 KB of flash and four times the cycles.
fn in_microjoules(products: u32) -> (u32, i32) {
    let (mut quotient, mut remainder) = (0, products);
    let mut step = (PRODUCTS_PER_UJ as u32) << 20;
    for _ in 0..=20 {
        quotient <<= 1;
        if remainder >= step {
            remainder -= step;
            quotient |= 1;
        }
        step >>= 1;
    }
    (quotient, remainder as i32)
}
