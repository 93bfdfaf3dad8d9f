//! What other settings of the sensor would make of the same loads.
//!
//! Each scheme drives the model of the INA219 alone, without firmware: it reads
//! the chip on a schedule of its own and sums power times the time since the
//! reading before. A reading that falls into the servo burst waits for its end.

use crate::devices::{Device, INA219_ADDRESS, Ina219};
use crate::electric::{Supply, SupplyParameters};
use crate::virtual_robot::SHUNT_OHM;

use super::ripple::Ripple;

/// 16 V, 320 mV, both inputs continuously; resolutions are left to the schemes.
const BASE: u16 = 0x1807;
/// The robot's own supply.
const BENCH_SUPPLY: SupplyParameters =
    SupplyParameters { open_circuit_v: 5.0, resistance_ohm: 0.05, shunt_ohm: SHUNT_OHM };
/// A servo burst with its START and address.
const BURST_S: f64 = 0.9e-3;
const FRAME_S: f64 = 1.0 / 60.0;
const STEP_S: f64 = 32e-6;

/// Settings of the sensor and a schedule.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scheme {
    /// For the report.
    pub name: &'static str,
    /// The 4-bit setting of both converters (table 5 of the data sheet).
    setting: u16,
    /// Readings a frame.
    readings: u32,
    /// Adds the shunt's own loss, which lies before the bus input.
    adds_shunt: bool,
    /// Conversion times over the typical ones.
    pace: f64,
}

const fn scheme(name: &'static str, setting: u16, readings: u32, adds_shunt: bool) -> Scheme {
    Scheme { name, setting, readings, adds_shunt, pace: 1.0 }
}

/// What is compared.
pub const SCHEMES: [Scheme; 8] = [
    scheme("8 samples, once a frame", 0xB, 1, false),
    scheme("8 samples, once a frame, shunt's loss added", 0xB, 1, true),
    scheme("8 samples, twice a frame, shunt's loss added", 0xB, 2, true),
    scheme("2 samples, 8 times a frame, shunt's loss added", 0x9, 8, true),
    scheme("12 bits, 16 times a frame, shunt's loss added", 0x3, 16, true),
    scheme("11 bits, 16 times a frame, shunt's loss added", 0x2, 16, true),
    scheme("10 bits, 16 times a frame, shunt's loss added", 0x1, 16, true),
    scheme("9 bits, 16 times a frame, shunt's loss added", 0x0, 16, true),
];

/// How a scheme fared.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SchemeResult {
    /// Which.
    pub scheme: Scheme,
    /// The load on which it is farthest off.
    pub worst: Option<Ripple>,
    /// By how much, in per cent.
    pub worst_percent: f64,
}

impl Scheme {
    /// Its worst error over these loads.
    #[must_use]
    pub fn try_on(self, loads: &[Ripple], duration_s: f64) -> SchemeResult {
        let mut result = SchemeResult { scheme: self, worst: None, worst_percent: 0.0 };
        for ripple in loads {
            let percent = self.error_percent(ripple, duration_s);
            if percent.abs() > result.worst_percent.abs() || result.worst.is_none() {
                (result.worst, result.worst_percent) = (Some(*ripple), percent);
            }
        }
        result
    }

    fn error_percent(self, ripple: &Ripple, duration_s: f64) -> f64 {
        let Ok(mut supply) = Supply::new(BENCH_SUPPLY) else { return f64::NAN };
        let mut chip = Ina219::with_pace(self.pace);
        let configuration = BASE | self.setting << 7 | self.setting << 3;
        write(&mut chip, 0, configuration);

        // Settles first, over whole frames.
        let (begin_s, mut next_s, mut read_s) = (0.5, 0.0, 0.0);
        let (mut energy_j, mut true_j, mut true_at_begin_j) = (0.0, 0.0, None);
        let interval_s = FRAME_S / f64::from(self.readings);
        let mut slot = 0_u32;
        for step in 0.. {
            let now_s = f64::from(step) * STEP_S;
            if now_s >= begin_s + duration_s {
                break;
            }
            supply.draw(ripple.power_w(now_s), now_s);
            chip.set_inputs(supply.shunt_v(), supply.load_v(), now_s);
            if now_s < next_s {
                continue;
            }
            let (current_a, bus_v) = read(&mut chip, now_s);
            if let Some(begin_j) = true_at_begin_j {
                true_j = supply.battery_energy_j() - begin_j;
                let volts = bus_v + if self.adds_shunt { current_a * SHUNT_OHM } else { 0.0 };
                energy_j += volts * current_a * (now_s - read_s);
            } else if now_s >= begin_s {
                true_at_begin_j = Some(supply.battery_energy_j());
            }
            read_s = now_s;
            slot += 1;
            let wanted_s = f64::from(slot) * interval_s;
            let into_frame_s = wanted_s % FRAME_S;
            next_s = if into_frame_s < BURST_S { wanted_s - into_frame_s + BURST_S } else { wanted_s };
        }
        100.0 * (energy_j / true_j - 1.0)
    }
}

fn write(chip: &mut Ina219, register: u8, value: u16) {
    let [high, low] = value.to_be_bytes();
    chip.select(INA219_ADDRESS, false, 0.0);
    for byte in [register, high, low] {
        chip.write(byte, 0.0);
    }
    chip.stop(0.0);
}

/// Amperes and volts of the last conversions.
fn read(chip: &mut Ina219, now_s: f64) -> (f64, f64) {
    let mut word = |register: u8| {
        chip.select(INA219_ADDRESS, false, now_s);
        chip.write(register, now_s);
        chip.select(INA219_ADDRESS, true, now_s);
        let word = u16::from_be_bytes([chip.read(now_s), chip.read(now_s)]);
        chip.stop(now_s);
        word
    };
    let shunt_v = f64::from(word(1) as i16) * 10e-6;
    let bus_v = f64::from(word(2) >> 3) * 4e-3;
    (shunt_v / SHUNT_OHM, bus_v)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::energy::ripple::Shape;

    #[test]
    fn a_flat_load_is_measured_by_every_scheme_but_for_the_shunts_loss() {
        // 3 W at 6 V lose 0.8 % in the shunt.
        let flat = Ripple::new(3.0, Shape::Flat, 59.8);

        for scheme in SCHEMES {
            let percent = scheme.error_percent(&flat, 6.0);
            let lost = if scheme.adds_shunt { 0.0 } else { -0.85 };
            assert!((percent - lost).abs() < 0.2, "{}: {percent} %", scheme.name);
        }
    }

    #[test]
    fn a_schedule_in_step_with_the_pulses_sees_one_moment_of_them_for_ever() {
        // 1/60 s is what two conversions of 8 samples take at this pace.
        let in_step = Scheme { pace: FRAME_S / 2.0 / 8.52e-3, ..SCHEMES[0] };
        let pulses = Ripple::new(1.0, Shape::Pulse { duty: 0.1 }, 60.0);

        assert!(in_step.error_percent(&pulses, 6.0).abs() > 20.0);
    }
}
