//! What the data sheet promises of the PCA9685.

use super::*;

fn write(chip: &mut Pca9685, at_s: f64, bytes: &[u8]) {
    assert!(chip.select(PCA9685_ADDRESS, false, at_s));
    for &byte in bytes {
        assert!(chip.write(byte, at_s));
    }
    chip.stop(at_s);
}

fn read(chip: &mut Pca9685, register: u8, len: usize) -> Vec<u8> {
    assert!(chip.select(PCA9685_ADDRESS, false, 0.0));
    chip.write(register, 0.0);
    assert!(chip.select(PCA9685_ADDRESS, true, 0.0));
    let bytes = (0..len).map(|_| chip.read(0.0)).collect();
    chip.stop(0.0);
    bytes
}

/// Awake at 60 Hz with auto-increment.
fn awake() -> Pca9685 {
    let mut chip = Pca9685::new(NOMINAL_OSCILLATOR_HZ);
    write(&mut chip, 0.0, &[PRE_SCALE, 101]);
    write(&mut chip, 0.0, &[MODE1, AUTO_INCREMENT]);
    chip
}

#[test]
fn registers_after_power_on_are_the_data_sheets() {
    let mut chip = Pca9685::new(NOMINAL_OSCILLATOR_HZ);

    assert_eq!(read(&mut chip, MODE1, 1), [0x11]);
    assert_eq!(read(&mut chip, MODE2, 1), [0x04]);
    assert_eq!(read(&mut chip, ALLCALLADR, 1), [0xE0]);
    assert_eq!(read(&mut chip, 0x09, 1), [0x10]);
    assert_eq!(read(&mut chip, PRE_SCALE, 1), [0x1E]);
    assert_eq!(chip.counts(), [None; CHANNEL_COUNT]);
}

#[test]
fn without_auto_increment_every_byte_goes_to_the_same_register() {
    let mut chip = Pca9685::new(NOMINAL_OSCILLATOR_HZ);

    write(&mut chip, 0.0, &[LED0_ON_L, 1, 2, 3]);

    assert_eq!(chip.leds[0], Led { on: 3, off: FULL });
}

#[test]
fn auto_increment_wraps_from_the_last_channel_and_from_the_prescaler_to_mode1() {
    let mut chip = awake();

    assert_eq!(read(&mut chip, LED15_OFF_H, 3), [0x10, AUTO_INCREMENT, 0x04]);
    assert_eq!(read(&mut chip, PRE_SCALE, 2), [101, AUTO_INCREMENT]);
}

#[test]
fn the_prescaler_is_written_only_asleep_and_never_below_three() {
    let mut chip = awake();
    write(&mut chip, 0.0, &[PRE_SCALE, 50]);
    assert_eq!(read(&mut chip, PRE_SCALE, 1), [101]);

    write(&mut chip, 0.0, &[MODE1, SLEEP]);
    write(&mut chip, 0.0, &[PRE_SCALE, 0]);

    assert_eq!(read(&mut chip, PRE_SCALE, 1), [3]);
}

#[test]
fn prescaler_101_gives_59_8_hertz_and_the_oscillators_error_shows() {
    let fast = Pca9685 { prescale: 101, ..Pca9685::new(26.0e6) };

    assert!((awake().frequency_hz() - 59.838).abs() < 0.001);
    assert!((awake().count_us() - 4.08).abs() < 1e-9);
    assert!((fast.count_us() - 102.0 / 26.0).abs() < 1e-9);
}

#[test]
fn outputs_change_at_the_stop_and_servos_see_it_in_the_next_pwm_cycle() {
    let mut chip = awake();
    chip.select(PCA9685_ADDRESS, false, 0.020);
    for byte in [LED0_ON_L, 0, 0, 0x4A, 0x01] {
        chip.write(byte, 0.020);
    }
    assert_eq!(chip.counts()[0], None);
    chip.stop(0.021);

    // Cycles begin every 16.71 ms: at 16.71 and at 33.42.
    assert_eq!(chip.counts()[0], Some(330));
    assert_eq!(chip.pulses_us(0.030)[0], None);
    assert!((chip.pulses_us(0.034)[0].unwrap() - 1346.4).abs() < 1e-6);
    assert_eq!(chip.take_bursts().len(), 1);
}

#[test]
fn full_off_wins_over_full_on_and_both_are_no_pulse() {
    assert_eq!(width(Led { on: FULL, off: 100 }, false), None);
    assert_eq!(width(Led { on: FULL, off: FULL | 100 }, false), None);
    assert_eq!(width(Led { on: 4000, off: 100 }, false), Some(196));
    assert_eq!(width(Led { on: 0, off: 100 }, true), Some(3996));
}

#[test]
fn all_led_registers_write_every_channel_and_read_zero() {
    let mut chip = awake();

    write(&mut chip, 0.0, &[ALL_LED_ON_L, 0, 0, 0x10, 0x02]);

    assert_eq!(chip.counts(), [Some(0x210); CHANNEL_COUNT]);
    assert_eq!(read(&mut chip, ALL_LED_ON_L, 4), [0; 4]);
}

#[test]
fn sleep_stops_the_pulses_and_restart_brings_them_back() {
    let mut chip = awake();
    write(&mut chip, 0.0, &[LED0_ON_L, 0, 0, 0x4A, 0x01]);
    assert!(chip.pulses_us(0.1)[0].is_some());

    write(&mut chip, 0.1, &[MODE1, AUTO_INCREMENT | SLEEP]);
    assert_eq!(chip.pulses_us(0.2)[0], None);
    assert_eq!(read(&mut chip, MODE1, 1), [RESTART | AUTO_INCREMENT | SLEEP]);

    write(&mut chip, 0.2, &[MODE1, AUTO_INCREMENT]);
    assert_eq!(chip.pulses_us(0.3)[0], None);
    write(&mut chip, 0.3, &[MODE1, RESTART | AUTO_INCREMENT]);
    assert!(chip.pulses_us(0.4)[0].is_some());
    assert_eq!(read(&mut chip, MODE1, 1), [AUTO_INCREMENT]);
}

#[test]
fn sleeping_with_every_channel_off_leaves_nothing_to_restart() {
    let mut chip = awake();

    write(&mut chip, 0.1, &[MODE1, AUTO_INCREMENT | SLEEP]);

    assert_eq!(read(&mut chip, MODE1, 1), [AUTO_INCREMENT | SLEEP]);
}

#[test]
fn allcall_is_answered_until_it_is_switched_off_and_subaddresses_once_on() {
    let mut chip = Pca9685::new(NOMINAL_OSCILLATOR_HZ);
    assert!(chip.select(0x70, false, 0.0));
    assert!(!chip.select(0x70, true, 0.0));
    assert!(!chip.select(0x71, false, 0.0));

    write(&mut chip, 0.0, &[MODE1, SLEEP | 0x08]);

    assert!(!chip.select(0x70, false, 0.0));
    assert!(chip.select(0x71, false, 0.0));
}

#[test]
fn a_software_reset_by_general_call_restores_the_defaults() {
    let mut chip = awake();
    write(&mut chip, 0.0, &[ALL_LED_ON_L, 0, 0, 0x10, 0x02]);

    assert!(chip.select(0, false, 0.0));
    assert!(chip.write(SOFTWARE_RESET, 0.0));
    chip.stop(0.0);

    assert!(chip.is_asleep());
    assert_eq!(chip.counts(), [None; CHANNEL_COUNT]);
}
