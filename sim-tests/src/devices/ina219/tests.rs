//! What the data sheet promises of the INA219.

use super::*;

fn write(chip: &mut Ina219, at_s: f64, register: u8, value: u16) {
    assert!(chip.select(INA219_ADDRESS, false, at_s));
    let [high, low] = value.to_be_bytes();
    for byte in [register, high, low] {
        chip.write(byte, at_s);
    }
    chip.stop(at_s);
}

fn read(chip: &mut Ina219, at_s: f64, register: u8) -> u16 {
    chip.select(INA219_ADDRESS, false, at_s);
    chip.write(register, at_s);
    chip.select(INA219_ADDRESS, true, at_s);
    let word = [chip.read(at_s), chip.read(at_s)];
    chip.stop(at_s);
    u16::from_be_bytes(word)
}

#[test]
fn configuration_after_power_on_after_reset_and_after_a_brown_out_is_the_data_sheets() {
    let mut chip = Ina219::new();
    assert_eq!(read(&mut chip, 0.0, CONFIGURATION), 0x399F);

    write(&mut chip, 0.0, CONFIGURATION, 0x1DDF);
    assert_eq!(read(&mut chip, 0.0, CONFIGURATION), 0x1DDF);
    write(&mut chip, 0.0, CONFIGURATION, 0x8000);
    assert_eq!(read(&mut chip, 0.0, CONFIGURATION), 0x399F);

    write(&mut chip, 0.0, CONFIGURATION, 0x1DDF);
    chip.brown_out(0.1);
    assert_eq!(read(&mut chip, 0.1, CONFIGURATION), 0x399F);
}

#[test]
fn voltages_are_rounded_to_their_lsbs() {
    let mut chip = Ina219::new();

    chip.set_inputs(0.012_346, 5.998_5, 0.0);

    // 12.346 mV is 1234.6 units of 10 uV; 5.9985 V is 1499.6 of 4 mV.
    assert_eq!(read(&mut chip, 0.01, SHUNT), 1235);
    assert_eq!(read(&mut chip, 0.01, BUS), 1500 << 3 | CONVERSION_READY);
}

#[test]
fn negative_shunt_voltages_are_twos_complement() {
    let mut chip = Ina219::new();

    chip.set_inputs(-0.001, 6.0, 0.0);

    assert_eq!(read(&mut chip, 0.01, SHUNT) as i16, -100);
}

#[test]
fn each_gain_saturates_at_its_own_range() {
    for (gain, full_scale) in [(0, 4000), (1, 8000), (2, 16_000), (3, 32_000)] {
        let mut chip = Ina219::new();
        write(&mut chip, 0.0, CONFIGURATION, 0x2000 | gain << 11 | 0x019F);

        chip.set_inputs(1.0, 40.0, 0.0);

        assert_eq!(read(&mut chip, 0.01, SHUNT), full_scale);
        assert_eq!(read(&mut chip, 0.01, BUS) >> 3, 8000);
    }
}

#[test]
fn a_conversion_is_the_mean_of_its_own_window_and_shunt_and_bus_take_turns() {
    let mut chip = Ina219::new();
    // 8 and 8 samples: shunt 0 to 4.26 ms, bus to 8.52 ms, shunt again.
    write(&mut chip, 0.0, CONFIGURATION, 0x3DDF);
    chip.set_inputs(0.010, 6.0, 0.0);
    chip.set_inputs(0.030, 6.0, 1.065e-3);
    chip.set_inputs(0.900, 5.0, 4.26e-3);

    // A quarter at 10 mV, the rest at 30; what came later is not in it.
    assert_eq!(read(&mut chip, 5e-3, SHUNT), 2500);
    assert_eq!(read(&mut chip, 5e-3, BUS), 0, "not before the bus is converted");
    assert_eq!(read(&mut chip, 8.53e-3, BUS), 1250 << 3 | CONVERSION_READY);
}

#[test]
fn ready_is_cleared_by_reading_power_and_by_a_new_mode() {
    let mut chip = Ina219::new();
    assert_eq!(read(&mut chip, 0.0, BUS) & CONVERSION_READY, 0);
    assert_ne!(read(&mut chip, 1.1e-3, BUS) & CONVERSION_READY, 0);
    assert_ne!(read(&mut chip, 1.1e-3, BUS) & CONVERSION_READY, 0, "reading the bus leaves it");

    read(&mut chip, 1.1e-3, POWER);
    assert_eq!(read(&mut chip, 1.1e-3, BUS) & CONVERSION_READY, 0);
    assert_ne!(read(&mut chip, 2.2e-3, BUS) & CONVERSION_READY, 0);
    write(&mut chip, 2.2e-3, CONFIGURATION, DEFAULT_CONFIGURATION);

    assert_eq!(read(&mut chip, 2.2e-3, BUS) & CONVERSION_READY, 0);
}

#[test]
fn a_triggered_conversion_runs_once() {
    let mut chip = Ina219::new();
    chip.set_inputs(0.010, 6.0, 0.0);
    write(&mut chip, 0.0, CONFIGURATION, 0x399B);
    assert_eq!(read(&mut chip, 0.01, SHUNT), 1000);

    chip.set_inputs(0.020, 6.0, 0.01);
    assert_eq!(read(&mut chip, 0.10, SHUNT), 1000);
    write(&mut chip, 0.10, CONFIGURATION, 0x399B);

    assert_eq!(read(&mut chip, 0.11, SHUNT), 2000);
}

#[test]
fn power_down_keeps_the_last_results() {
    let mut chip = Ina219::new();
    chip.set_inputs(0.010, 6.0, 0.0);
    assert_eq!(read(&mut chip, 0.01, SHUNT), 1000);

    write(&mut chip, 0.01, CONFIGURATION, 0x3998);
    chip.set_inputs(0.020, 6.0, 0.01);

    assert_eq!(read(&mut chip, 1.0, SHUNT), 1000);
}

#[test]
fn current_and_power_follow_the_calibration() {
    let mut chip = Ina219::new();
    assert_eq!(read(&mut chip, 0.01, CURRENT), 0, "zero until calibrated");
    // 100 uA a unit at 0.1 ohm: 0.04096 / (100 uA * 0.1 ohm) = 4096.
    write(&mut chip, 0.01, CALIBRATION, 4097);
    chip.set_inputs(0.050, 6.0, 0.01);

    // 0.5 A is 5000 units; power is in 20 units of current: 3 W / 2 mW.
    assert_eq!(read(&mut chip, 0.02, CALIBRATION), 4096);
    assert_eq!(read(&mut chip, 0.02, CURRENT), 5000);
    assert_eq!(read(&mut chip, 0.02, POWER), 1500);
}

#[test]
fn a_result_that_does_not_fit_raises_the_overflow_flag() {
    let mut chip = Ina219::new();
    write(&mut chip, 0.0, CALIBRATION, 0xFFFE);

    chip.set_inputs(0.3, 12.0, 0.0);

    assert_eq!(read(&mut chip, 0.01, BUS) & OVERFLOW, OVERFLOW);
}

#[test]
fn nine_bits_are_eight_times_coarser() {
    let mut chip = Ina219::new();
    write(&mut chip, 0.0, CONFIGURATION, 0x3807);

    chip.set_inputs(0.012_346, 5.998_5, 0.0);

    assert_eq!(read(&mut chip, 0.01, SHUNT), 1232);
    assert_eq!(read(&mut chip, 0.01, BUS) >> 3, 1496);
}
