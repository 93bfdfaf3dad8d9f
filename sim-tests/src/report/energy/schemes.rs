//! What other settings of the INA219 would measure of the same loads.
//!
//! Holds the settings and the schedule of each scheme. Does not depend on the
//! firmware: each scheme drives the model of the INA219 alone. A reading that falls
//! into the servo burst waits for its end. What makes the difference:
//! - How much of a PWM frame a reading covers. Eight samples of either input
//!   take 4.3 ms, so one reading a frame sees a quarter of the current.
//! - Whether PWM and readings beat: at 60.00 Hz of PWM they do not.
//! - Current and voltage move against each other within a PWM frame, so the
//!   product of two long means is not the mean of the products.
//! - The shunt's own loss lies before the bus input.

use crate::devices::ina219::Ina219;
use crate::devices::{Chip, Device, SHUNT_OHM};
use crate::electric::{Supply, SupplyParameters};

use super::ripple::Ripple;

/// 16 V, 320 mV, both inputs continuously; resolutions are left to the schemes.
const BASE: u16 = 0x1807;
/// The robot's own supply.
const BENCH_SUPPLY: SupplyParameters =
    SupplyParameters { open_circuit_v: 5.0, resistance_ohm: 0.1, shunt_ohm: SHUNT_OHM };
/// A servo burst with its START and address.
const BURST_S: f64 = 0.9e-3;
const FRAME_S: f64 = 1.0 / 60.0;
const STEP_S: f64 = 32e-6;
const CONVERSION_READY: u16 = 2;

/// When the chip is read, and how its readings are summed.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Reading {
    /// So often a frame, evenly; each reading stands for the time since the one before.
    Even(u32),
    /// So often between two bursts; conversions that were read already are left
    /// out, and each counts alike.
    EachOnce(u32),
    /// As [`Self::EachOnce`], but each frame's readings come a little later than
    /// those of the frame before, so that together they cover the whole frame.
    Staggered(u32),
}

/// Settings of the sensor and a schedule.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scheme {
    pub name: &'static str,
    /// The 4-bit settings of shunt and bus (table 5 of the data sheet).
    settings: (u16, u16),
    reading: Reading,
    /// Adds the shunt's own loss.
    adds_shunt: bool,
    /// Conversion times over the typical ones.
    pace: f64,
}

const fn scheme(name: &'static str, settings: (u16, u16), reading: Reading, adds_shunt: bool) -> Scheme {
    Scheme { name, settings, reading, adds_shunt, pace: 1.0 }
}

pub const SCHEMES: [Scheme; 9] = [
    scheme("8 samples, once a frame", (0xB, 0xB), Reading::Even(1), false),
    scheme("8 samples, once a frame, shunt's loss added", (0xB, 0xB), Reading::Even(1), true),
    scheme("8 samples, each conversion once, shunt's loss added", (0xB, 0xB), Reading::EachOnce(4), true),
    scheme("12 bits, 17 readings a frame, shunt's loss added", (0x3, 0x3), Reading::EachOnce(17), true),
    scheme("10 bits, 9 readings a frame, shunt's loss added", (0x1, 0x1), Reading::EachOnce(9), true),
    scheme("10 bits, 12 readings a frame, shunt's loss added", (0x1, 0x1), Reading::EachOnce(12), true),
    scheme("10 bits, 17 readings a frame, shunt's loss added", (0x1, 0x1), Reading::EachOnce(17), true),
    scheme(
        "10 bits, 9 readings a frame at shifting moments, shunt's loss added",
        (0x1, 0x1),
        Reading::Staggered(9),
        true,
    ),
    scheme(
        "10 bits, 12 readings a frame at shifting moments, shunt's loss added",
        (0x1, 0x1),
        Reading::Staggered(12),
        true,
    ),
];

/// How a scheme fared.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SchemeResult {
    pub scheme: Scheme,
    /// The load on which it is farthest off.
    pub worst: Option<Ripple>,
    /// By how much, in per cent.
    pub worst_percent: f64,
    /// The same without the loads whose PWM stands still against the frames.
    pub worst_beating_percent: f64,
}

/// One conversion of each input.
#[derive(Debug, Clone, Copy)]
struct Pair {
    current_a: f64,
    bus_v: f64,
    is_new: bool,
}

/// What has been summed since the reading that began it.
#[derive(Debug, Clone, Copy, Default)]
struct Sum {
    energy_j: f64,
    power_w: f64,
    count: f64,
    true_j: f64,
    elapsed_s: f64,
}

impl Scheme {
    /// Its worst error over these loads.
    #[must_use]
    pub fn try_on(self, loads: &[Ripple], duration_s: f64) -> SchemeResult {
        let mut result =
            SchemeResult { scheme: self, worst: None, worst_percent: 0.0, worst_beating_percent: 0.0 };
        for ripple in loads {
            let percent = self.error_percent(ripple, duration_s);
            if ripple.beats() && percent.abs() > result.worst_beating_percent.abs() {
                result.worst_beating_percent = percent;
            }
            if percent.abs() > result.worst_percent.abs() || result.worst.is_none() {
                (result.worst, result.worst_percent) = (Some(*ripple), percent);
            }
        }
        result
    }

    fn error_percent(self, ripple: &Ripple, duration_s: f64) -> f64 {
        /// Filters and schedule settle first.
        const BEGIN_S: f64 = 30.0 * FRAME_S;
        let Ok(mut supply) = Supply::new(BENCH_SUPPLY) else { return f64::NAN };
        let mut chip = Ina219::with_pace(Chip::PowerSensor.address(), self.pace);
        write(&mut chip, 0, BASE | self.settings.1 << 7 | self.settings.0 << 3);

        let mut began: Option<(f64, f64)> = None;
        let mut sum = Sum::default();
        let (mut read_s, mut slot) = (0.0, 0_u32);
        for step in 0_u32.. {
            let now_s = f64::from(step) * STEP_S;
            if now_s > BEGIN_S + duration_s {
                break;
            }
            supply.draw(ripple.power_w(now_s), now_s);
            chip.set_inputs(supply.shunt_v(), supply.load_v(), now_s);
            if now_s < self.slot_s(slot) {
                continue;
            }
            slot += 1;
            let pair = read(&mut chip, now_s);
            if let Some((begin_s, begin_j)) = began {
                let power_w = self.power_w(pair);
                sum.energy_j += power_w * (now_s - read_s);
                if pair.is_new {
                    sum.power_w += power_w;
                    sum.count += 1.0;
                }
                sum.true_j = supply.battery_energy_j() - begin_j;
                sum.elapsed_s = now_s - begin_s;
            } else if now_s >= BEGIN_S {
                began = Some((now_s, supply.battery_energy_j()));
            }
            read_s = now_s;
        }
        let energy_j = match self.reading {
            Reading::Even(_) => sum.energy_j,
            Reading::EachOnce(_) | Reading::Staggered(_) => sum.power_w / sum.count * sum.elapsed_s,
        };
        100.0 * (energy_j / sum.true_j - 1.0)
    }

    /// Power at the battery's terminals by this reading.
    fn power_w(self, pair: Pair) -> f64 {
        let lost_v = if self.adds_shunt { pair.current_a * SHUNT_OHM } else { 0.0 };
        (pair.bus_v + lost_v) * pair.current_a
    }

    fn slot_s(self, slot: u32) -> f64 {
        match self.reading {
            Reading::Even(readings) => {
                let wanted_s = f64::from(slot) * FRAME_S / f64::from(readings);
                let into_frame_s = wanted_s % FRAME_S;
                if into_frame_s < BURST_S { wanted_s - into_frame_s + BURST_S } else { wanted_s }
            }
            Reading::EachOnce(readings) => {
                // The last one ends before the next burst begins.
                let spacing_s = (FRAME_S - BURST_S - 0.3e-3) / f64::from(readings - 1);
                f64::from(slot / readings) * FRAME_S + BURST_S + f64::from(slot % readings) * spacing_s
            }
            Reading::Staggered(readings) => {
                // Five eighths of a spacing on in each frame: all eighths in turn.
                let spacing_s = (FRAME_S - BURST_S - 0.3e-3) / f64::from(readings);
                let (frame, index) = (slot / readings, slot % readings);
                let shift = f64::from(frame * 5 % 8) / 8.0;
                f64::from(frame) * FRAME_S + BURST_S + (f64::from(index) + shift) * spacing_s
            }
        }
    }
}

fn write(chip: &mut Ina219, register: u8, value: u16) {
    let [high, low] = value.to_be_bytes();
    chip.select(Chip::PowerSensor.address(), false, 0.0);
    for byte in [register, high, low] {
        chip.write(byte, 0.0);
    }
    chip.stop(0.0);
}

/// The last conversions; reading the power register clears their mark.
fn read(chip: &mut Ina219, now_s: f64) -> Pair {
    let mut word = |register: u8| {
        chip.select(Chip::PowerSensor.address(), false, now_s);
        chip.write(register, now_s);
        chip.select(Chip::PowerSensor.address(), true, now_s);
        let word = u16::from_be_bytes([chip.read(now_s), chip.read(now_s)]);
        chip.stop(now_s);
        word
    };
    let (bus, shunt, _) = (word(2), word(1), word(3));
    Pair {
        current_a: f64::from(shunt as i16) * 10e-6 / SHUNT_OHM,
        bus_v: f64::from(bus >> 3) * 4e-3,
        is_new: bus & CONVERSION_READY != 0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::energy::ripple::Shape;

    #[test]
    fn a_flat_load_is_measured_by_every_scheme_but_for_the_shunts_loss() {
        // 3 W at 5 V lose 1.2 % in the shunt, and a little more with the gait's swing.
        let flat = Ripple::new(3.0, Shape::Flat, 59.8);

        for scheme in SCHEMES {
            let percent = scheme.error_percent(&flat, 6.0);
            let lost = if scheme.adds_shunt { 0.0 } else { -1.28 };
            assert!((percent - lost).abs() < 0.2, "{}: {percent} %", scheme.name);
        }
    }

    #[test]
    fn a_schedule_in_step_with_the_pulses_sees_one_moment_of_them_for_ever() {
        // At this pace a frame is two rounds of both inputs.
        let in_step = Scheme { pace: FRAME_S / 2.0 / 8.52e-3, ..SCHEMES[0] };
        let pulses = Ripple::new(1.0, Shape::Pulse { duty: 0.1 }, 60.0);

        assert!(in_step.error_percent(&pulses, 6.0).abs() > 20.0);
    }
}
