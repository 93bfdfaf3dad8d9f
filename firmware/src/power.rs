//! The readings of a frame as one sample, and the energy of a trial.
//!
//! Holds what the readings of a frame add up to, and the integral. Integer
//! arithmetic only; the integral carries its remainder, so it is exact over any
//! number of frames. A frame without a sample counts with the one before, and the
//! trial says how often. Does not depend on the sensor beyond its role.

use protocol::FRAME_RATE_HZ;

use crate::chips::{MV_PER_COUNT, PowerSensor, Reading, SensorChip, UA_PER_COUNT};

/// How often a frame the board reads the sensor.
///
/// Servo current pulses with the PWM, which runs free of the frames, at 59.8 Hz
/// and a few per cent about it: readings at even distances then see every part of
/// it alike, and nine of them tell a current that is on for a tenth of the time
/// to 0.4 % within 12 s. Where PWM and frames happen to stand still, within
/// 0.05 Hz, nine points of the pulses are seen for ever, and energy may be a
/// quarter off; another prescaler moves them on.
pub const READINGS_PER_FRAME: u8 = 9;

const COUNTS_PER_MA: i32 = 1_000 / UA_PER_COUNT;
/// One product of counts is 4 mV * 100 uA for a reading's share of 1/60 s, 400 /
/// 60 / 9 nJ: this many products make a microjoule.
const PRODUCTS_PER_UJ: u32 = READINGS_PER_FRAME as u32 * FRAME_RATE_HZ * 1_000 / (MV_PER_COUNT as u32 * 100);

const _: () = assert!(PRODUCTS_PER_UJ == 1_350 && PRODUCTS_PER_UJ < 1 << 11);

// Nine squares of 16 bits, in units of 256, times the shunt's drop.
const _: () = assert!(SensorChip::SHUNT_DROP_Q14 as i64 * READINGS_PER_FRAME as i64 * (1 << 22) < 1 << 31);

/// Why a frame has no sample.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Missed {
    /// Not one reading: no acknowledge, or a stuck bus.
    NoAnswer,
    /// The current was beyond the sensor's range.
    Saturated,
}

/// The readings of one frame, in the sensor's counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Sample {
    bus_counts: u16,
    /// By its gain it may be beyond 16 bits.
    shunt_counts: i32,
    products: i32,
}

impl Sample {
    /// No reading yet.
    pub const NONE: Self = Self { bus_counts: 0, shunt_counts: 0, products: 0 };

    /// Supply voltage, the frame's mean.
    #[must_use]
    pub const fn bus_mv(self) -> u16 {
        self.bus_counts * MV_PER_COUNT
    }

    /// Supply current, the frame's mean.
    #[must_use]
    pub const fn current_ua(self) -> i32 {
        self.shunt_counts * UA_PER_COUNT
    }

    /// Whether the current is at `limit_ma` or more.
    #[must_use]
    pub const fn is_above_ma(self, limit_ma: u16) -> bool {
        self.shunt_counts >= limit_ma as i32 * COUNTS_PER_MA
    }
}

/// What the readings of a frame have come to so far.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Readings {
    count: u8,
    is_saturated: bool,
    /// The last one, in counts.
    bus: u16,
    shunt: i16,
    /// Sums over all of them.
    bus_sum: u16,
    shunt_sum: i32,
    products: i32,
    /// In 256 squared counts of the shunt.
    squares: i32,
}

impl Readings {
    /// None yet.
    pub const NONE: Self = Self {
        count: 0,
        is_saturated: false,
        bus: 0,
        shunt: 0,
        bus_sum: 0,
        shunt_sum: 0,
        products: 0,
        squares: 0,
    };

    /// Whether the frame has all of its readings; the next one is the next frame's.
    #[must_use]
    pub const fn is_complete(&self) -> bool {
        self.count == READINGS_PER_FRAME
    }

    /// Adds a reading.
    pub fn add(&mut self, reading: Reading) {
        (self.bus, self.shunt) = SensorChip::counts(reading);
        self.is_saturated |= self.shunt.unsigned_abs() >= SensorChip::FULL_SCALE;
        self.add_last();
    }

    fn add_last(&mut self) {
        let shunt = i32::from(self.shunt);
        self.count += 1;
        // Nine times 2^13, and nine times 4,000 in the range that is set.
        self.bus_sum = self.bus_sum.wrapping_add(self.bus);
        self.shunt_sum += shunt;
        // Nine times 4,000 * 32,000 is below 2^31.
        self.products = self.products.wrapping_add(i32::from(self.bus) * shunt);
        self.squares += (shunt * shunt) >> 8;
    }

    /// Closes the frame; the last reading is repeated for those that are missing.
    ///
    /// `shunt_gain_q14` corrects the shunt's counts: its resistor is 0.1 ohm to
    /// within a per cent, and the board's leads add to it.
    ///
    /// # Errors
    /// Why there is no sample.
    pub fn close(&mut self, shunt_gain_q14: u16) -> Result<Sample, Missed> {
        let is_missed = self.count == 0;
        while !is_missed && !self.is_complete() {
            self.add_last();
        }
        let all = core::mem::take(self);
        if is_missed {
            return Err(Missed::NoAnswer);
        }
        if all.is_saturated {
            return Err(Missed::Saturated);
        }
        // The bus voltage is taken behind the shunt, whose own drop belongs to the
        // battery's energy as well: 6 % at 3 A. Of the drop's 14 bits, 8 are in the
        // unit of the squares.
        let lost = (all.squares * SensorChip::SHUNT_DROP_Q14) >> 6;
        Ok(Sample {
            bus_counts: mean(i32::from(all.bus_sum)) as u16,
            shunt_counts: corrected(mean(all.shunt_sum), shunt_gain_q14),
            products: corrected(all.products + lost, shunt_gain_q14),
        })
    }
}

/// A ninth, to the nearest, of sums of nine counts of at most 32,000.
fn mean(sum: i32) -> i32 {
    const NINTH_Q16: i32 = (1 << 16) / READINGS_PER_FRAME as i32 + 1;
    (sum * NINTH_Q16 + (1 << 15)) >> 16
}

/// `value` times a gain in 2^-14, of which 2^14 leaves every value as it is.
#[inline(never)]
fn corrected(value: i32, gain_q14: u16) -> i32 {
    let gain = i32::from(gain_q14);
    (value >> 14) * gain + (((value & 0x3FFF) * gain) >> 14)
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
    /// Products not yet a microjoule, or owed.
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
        // A servo that brakes may feed the supply: what is below zero is a debt that
        // later frames pay, bounded so that no sum overflows.
        let products = (sample.products + self.remainder).max(-(1 << 29));
        if products < 0 {
            self.remainder = products;
        } else {
            let (energy_uj, remainder) = in_microjoules(products as u32);
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
    let mut step = PRODUCTS_PER_UJ << 20;
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
