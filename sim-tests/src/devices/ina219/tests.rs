//! What the data sheet promises of the INA219.

use super::*;

/// A0 high.
const ADDRESS: u8 = 0x41;

fn write(chip: &mut Ina219, at_s: f64, register: u8, value: u16) {
    assert!(chip.select(ADDRESS, false, at_s));
    let [high, low] = value.to_be_bytes();
    for byte in [register, high, low] {
        chip.write(byte, at_s);
    }
    chip.stop(at_s);
}

fn read(chip: &mut Ina219, at_s: f64, register: u8) -> u16 {
    chip.select(ADDRESS, false, at_s);
    chip.write(register, at_s);
    chip.select(ADDRESS, true, at_s);
    let word = [chip.read(at_s), chip.read(at_s)];
    chip.stop(at_s);
    u16::from_be_bytes(word)
}

#[test]
fn configuration_after_power_on_after_reset_and_after_a_brown_out_is_the_data_sheets() {
    let mut chip = Ina219::new(ADDRESS);
    assert_eq!(read(&mut chip, 0.0, CONFIGURATION), 0x399F);

    write(&mut chip, 0.0, CONFIGURATION, 0x1DDF);
    assert_eq!(read(&mut chip, 0.0, CONFIGURATION), 0x1DDF);
    write(&mut chip, 0.0, CONFIGURATION, 0x5DDF);
    assert_eq!(read(&mut chip, 0.0, CONFIGURATION), 0x1DDF, "bit 14 is not there");
    write(&mut chip, 0.0, CONFIGURATION, 0x8000);
    assert_eq!(read(&mut chip, 0.0, CONFIGURATION), 0x399F);

    write(&mut chip, 0.0, CONFIGURATION, 0x1DDF);
    chip.brown_out(0.1);
    assert_eq!(read(&mut chip, 0.1, CONFIGURATION), 0x399F);
}

#[test]
fn registers_after_power_on_are_the_data_sheets_and_results_cannot_be_written() {
    let mut chip = Ina219::new(ADDRESS);
    for register in [SHUNT, BUS, POWER, CURRENT] {
        write(&mut chip, 0.0, register, 0x1234);
    }

    let registers = [SHUNT, BUS, POWER, CURRENT, CALIBRATION].map(|r| read(&mut chip, 0.0, r));

    assert_eq!(registers, [0; 5]);
}

#[test]
fn a_general_call_resets_it_like_the_reset_bit() {
    let mut chip = Ina219::new(ADDRESS);
    write(&mut chip, 0.0, CONFIGURATION, 0x1DDF);
    assert!(!chip.select(0, true, 0.0));

    assert!(chip.select(0, false, 0.0));
    assert!(!chip.write(0x07, 0.0));
    assert_eq!(chip.configuration(), 0x1DDF);
    assert!(chip.select(0, false, 0.0));
    assert!(chip.write(GENERAL_RESET, 0.0));

    assert_eq!(chip.configuration(), DEFAULT_CONFIGURATION);
}

#[test]
fn half_a_word_writes_nothing_and_the_pointer_stays_for_the_next_read() {
    let mut chip = Ina219::new(ADDRESS);
    write(&mut chip, 0.0, CALIBRATION, 0x1234);

    chip.select(ADDRESS, false, 0.0);
    chip.write(CALIBRATION, 0.0);
    chip.write(0xFF, 0.0);
    chip.stop(0.0);
    chip.select(ADDRESS, true, 0.0);

    assert_eq!([chip.read(0.0), chip.read(0.0)], [0x12, 0x34]);
}

/// Table 5, in microseconds, by the 4-bit setting; bit 2 means nothing below 8.
const CONVERSION_US: [f64; 16] = [
    84.0, 148.0, 276.0, 532.0, 84.0, 148.0, 276.0, 532.0, 532.0, 1060.0, 2130.0, 4260.0, 8510.0, 17_020.0,
    34_050.0, 68_100.0,
];

#[test]
fn each_setting_takes_its_conversion_time_on_either_input() {
    for (setting, us) in (0_u16..).zip(CONVERSION_US) {
        // The input under test continuously, then both, the other at 9 bits.
        for (mode, other_us) in [(5, 0.0), (6, 0.0), (7, 84.0)] {
            let mut chip = Ina219::new(ADDRESS);
            let settings = if mode == 6 { setting << 7 } else { setting << 3 };
            write(&mut chip, 0.0, CONFIGURATION, 0x3800 | settings | mode);

            let done_s = (us + other_us) * 1e-6;
            let early = read(&mut chip, done_s - 1e-6, BUS) & CONVERSION_READY;
            let done = read(&mut chip, done_s + 1e-6, BUS) & CONVERSION_READY;

            assert_eq!((early, done), (0, CONVERSION_READY), "setting {setting:#x}, mode {mode}");
        }
    }
}

#[test]
fn a_slow_chip_takes_a_tenth_longer() {
    let mut chip = Ina219::with_pace(ADDRESS, 1.1);
    write(&mut chip, 0.0, CONFIGURATION, 0x3800 | 0x80 | 0x08 | 7);

    assert_eq!(read(&mut chip, 325e-6, BUS) & CONVERSION_READY, 0);
    assert_ne!(read(&mut chip, 326e-6, BUS) & CONVERSION_READY, 0);
}

#[test]
fn voltages_are_rounded_to_their_lsbs() {
    let mut chip = Ina219::new(ADDRESS);

    chip.set_inputs(0.012_346, 5.998_5, 0.0);

    // 12.346 mV is 1234.6 units of 10 uV; 5.9985 V is 1499.6 of 4 mV.
    assert_eq!(read(&mut chip, 0.01, SHUNT), 1235);
    assert_eq!(read(&mut chip, 0.01, BUS), 1500 << 3 | CONVERSION_READY);
}

#[test]
fn negative_shunt_voltages_are_twos_complement() {
    let mut chip = Ina219::new(ADDRESS);

    chip.set_inputs(-0.001, 6.0, 0.0);

    assert_eq!(read(&mut chip, 0.01, SHUNT) as i16, -100);
}

#[test]
fn each_gain_saturates_at_its_own_range() {
    for (gain, full_scale) in [(0, 4000), (1, 8000), (2, 16_000), (3, 32_000)] {
        let mut chip = Ina219::new(ADDRESS);
        write(&mut chip, 0.0, CONFIGURATION, 0x2000 | gain << 11 | 0x019F);

        chip.set_inputs(1.0, 40.0, 0.0);

        assert_eq!(read(&mut chip, 0.01, SHUNT), full_scale);
        assert_eq!(read(&mut chip, 0.01, BUS) >> 3, 8000);
    }
}

#[test]
fn the_bus_register_holds_its_value_in_its_upper_13_bits_and_ends_at_16_or_32_v() {
    for (range, volts, counts) in
        [(0, 15.9, 3975), (0, 17.0, 4000), (0x2000, 17.0, 4250), (0x2000, 33.0, 8000)]
    {
        let mut chip = Ina219::new(ADDRESS);
        write(&mut chip, 0.0, CONFIGURATION, range | 0x199F);

        chip.set_inputs(0.0, volts, 0.0);

        assert_eq!(read(&mut chip, 0.01, BUS), counts << 3 | CONVERSION_READY, "{volts} V");
    }
}

/// What a schedule of many readings a frame stands on: 148 us of shunt, then
/// 148 us of bus, for ever.
#[test]
fn at_10_bits_results_are_means_of_148_us_and_change_at_the_ends_of_their_own_conversions() {
    let mut chip = Ina219::new(ADDRESS);
    write(&mut chip, 0.0, CONFIGURATION, 0x1800 | 0x80 | 0x08 | 7);
    let us = |us: f64| us * 1e-6;

    // On for 37 us of the first shunt conversion, and for all of the second.
    chip.set_inputs(0.040, 5.0, 0.0);
    chip.set_inputs(0.0, 6.0, us(37.0));
    assert_eq!(read(&mut chip, us(147.0), SHUNT), 0, "nothing yet");
    chip.set_inputs(0.3, 4.8, us(148.0));
    assert_eq!(read(&mut chip, us(149.0), SHUNT), 1000, "a quarter of 40 mV");
    assert_eq!(read(&mut chip, us(295.0), BUS), 0, "the bus comes after the shunt");
    chip.set_inputs(0.040, 6.4, us(296.0));
    assert_eq!(read(&mut chip, us(297.0), BUS), 1200 << 3 | CONVERSION_READY, "not what it was meanwhile");
    assert_eq!(read(&mut chip, us(443.0), SHUNT), 1000, "the last one stays until the next");
    chip.set_inputs(0.0, 4.0, us(444.0));
    assert_eq!(read(&mut chip, us(445.0), SHUNT), 4000);

    assert_eq!(read(&mut chip, us(593.0), BUS) >> 3, 1000);
}

#[test]
fn a_conversion_is_the_mean_of_its_own_window_and_shunt_and_bus_take_turns() {
    let mut chip = Ina219::new(ADDRESS);
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
    let mut chip = Ina219::new(ADDRESS);
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
    let mut chip = Ina219::new(ADDRESS);
    chip.set_inputs(0.010, 6.0, 0.0);
    write(&mut chip, 0.0, CONFIGURATION, 0x399B);
    assert_eq!(read(&mut chip, 0.01, SHUNT), 1000);

    chip.set_inputs(0.020, 6.0, 0.01);
    assert_eq!(read(&mut chip, 0.10, SHUNT), 1000);
    write(&mut chip, 0.10, CONFIGURATION, 0x399B);

    assert_eq!(read(&mut chip, 0.11, SHUNT), 2000);
}

#[test]
fn a_single_input_leaves_the_other_ones_result() {
    for (mode, shunt, bus) in [(1, 2000, 1500), (5, 2000, 1500), (2, 1000, 1250), (6, 1000, 1250)] {
        let mut chip = Ina219::new(ADDRESS);
        chip.set_inputs(0.010, 6.0, 0.0);
        read(&mut chip, 0.01, SHUNT);

        write(&mut chip, 0.01, CONFIGURATION, 0x3998 | mode);
        chip.set_inputs(0.020, 5.0, 0.01);

        assert_eq!(read(&mut chip, 0.1, SHUNT), shunt, "mode {mode}");
        assert_eq!(read(&mut chip, 0.1, BUS) >> 3, bus, "mode {mode}");
    }
}

#[test]
fn a_write_of_the_configuration_ends_the_conversion_under_way() {
    let mut chip = Ina219::new(ADDRESS);
    chip.set_inputs(0.010, 6.0, 0.0);
    write(&mut chip, 0.5e-3, CONFIGURATION, DEFAULT_CONFIGURATION);

    assert_eq!(read(&mut chip, 1.0e-3, SHUNT), 0);
    assert_eq!(read(&mut chip, 1.04e-3, SHUNT), 1000);
}

#[test]
fn out_of_power_down_the_first_conversion_begins_40_us_later() {
    for (before, us) in [(0x3998, 40.0), (0x399C, 0.0)] {
        let mut chip = Ina219::new(ADDRESS);
        write(&mut chip, 0.0, CONFIGURATION, before);
        chip.set_inputs(0.010, 6.0, 0.0);

        write(&mut chip, 0.01, CONFIGURATION, DEFAULT_CONFIGURATION);

        let done_s = 0.01 + (532.0 + us) * 1e-6;
        assert_eq!(read(&mut chip, done_s - 1e-6, SHUNT), 0, "{before:#x}");
        assert_eq!(read(&mut chip, done_s + 1e-6, SHUNT), 1000, "{before:#x}");
    }
}

#[test]
fn power_down_and_adc_off_leave_the_ready_flag() {
    for mode in [0x3998, 0x399C] {
        let mut chip = Ina219::new(ADDRESS);
        read(&mut chip, 1.1e-3, BUS);

        write(&mut chip, 1.1e-3, CONFIGURATION, mode);

        assert_ne!(read(&mut chip, 1.0, BUS) & CONVERSION_READY, 0, "{mode:#x}");
    }
}

#[test]
fn power_down_keeps_the_last_results() {
    let mut chip = Ina219::new(ADDRESS);
    chip.set_inputs(0.010, 6.0, 0.0);
    assert_eq!(read(&mut chip, 0.01, SHUNT), 1000);

    write(&mut chip, 0.01, CONFIGURATION, 0x3998);
    chip.set_inputs(0.020, 6.0, 0.01);

    assert_eq!(read(&mut chip, 1.0, SHUNT), 1000);
}

#[test]
fn current_and_power_follow_the_calibration() {
    let mut chip = Ina219::new(ADDRESS);
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
    let mut chip = Ina219::new(ADDRESS);
    write(&mut chip, 0.0, CALIBRATION, 0xFFFE);

    chip.set_inputs(0.3, 12.0, 0.0);

    assert_eq!(read(&mut chip, 0.01, BUS) & OVERFLOW, OVERFLOW);
    chip.set_inputs(0.001, 12.0, 0.01);
    assert_eq!(read(&mut chip, 0.02, BUS) & OVERFLOW, 0, "and the next one that fits clears it");
}

#[test]
fn each_bit_less_doubles_the_unit() {
    // 12.346 mV are 1234.6 units of 10 uV; 5.9985 V are 1499.6 of 4 mV.
    for (setting, shunt, bus) in [(0, 1232, 1496), (1, 1236, 1500), (2, 1234, 1500), (3, 1235, 1500)] {
        let mut chip = Ina219::new(ADDRESS);
        write(&mut chip, 0.0, CONFIGURATION, 0x3807 | setting << 7 | setting << 3);

        chip.set_inputs(0.012_346, 5.998_5, 0.0);

        assert_eq!(read(&mut chip, 0.01, SHUNT), shunt, "setting {setting}");
        assert_eq!(read(&mut chip, 0.01, BUS) >> 3, bus, "setting {setting}");
    }
}
