//! What the data sheet promises of the PCA9685.

use super::outputs::Led;
use super::*;

/// All address pins low.
const ADDRESS: u8 = 0x40;
const LED0: [u8; 5] = [LED0_ON_L, 0, 0, 0x4A, 0x01];
const CYCLE_S: f64 = 4096.0 * 102.0 / 25.0e6;

fn write(chip: &mut Pca9685, at_s: f64, bytes: &[u8]) {
    write_all(chip, at_s, bytes);
    chip.stop(at_s);
}

/// Without the STOP.
fn write_all(chip: &mut Pca9685, at_s: f64, bytes: &[u8]) {
    assert!(chip.select(ADDRESS, false, at_s));
    for &byte in bytes {
        assert!(chip.write(byte, at_s));
    }
}

fn read_at(chip: &mut Pca9685, at_s: f64, register: u8, len: usize) -> Vec<u8> {
    assert!(chip.select(ADDRESS, false, at_s));
    chip.write(register, at_s);
    assert!(chip.select(ADDRESS, true, at_s));
    let bytes = (0..len).map(|_| chip.read(at_s)).collect();
    chip.stop(at_s);
    bytes
}

fn read(chip: &mut Pca9685, register: u8, len: usize) -> Vec<u8> {
    read_at(chip, 0.0, register, len)
}

/// Awake at 60 Hz with auto-increment.
fn awake() -> Pca9685 {
    let mut chip = Pca9685::new(ADDRESS);
    write(&mut chip, 0.0, &[PRE_SCALE, 101]);
    write(&mut chip, 0.0, &[MODE1, AUTO_INCREMENT]);
    chip
}

/// Awake, and with a pulse on channel 0 in cycles that began at 10 ms.
fn pulsing() -> Pca9685 {
    let mut chip = awake();
    write(&mut chip, 0.010, &LED0);
    chip
}

/// Pulsing, and asleep since 100 ms; the cycle ended at 110.3 ms.
fn asleep() -> Pca9685 {
    let mut chip = pulsing();
    write(&mut chip, 0.100, &[MODE1, AUTO_INCREMENT | SLEEP]);
    chip
}

#[test]
fn registers_after_power_on_are_the_data_sheets() {
    let mut chip = Pca9685::new(ADDRESS);

    assert_eq!(read(&mut chip, MODE1, 1), [0x11]);
    assert_eq!(read(&mut chip, MODE2, 1), [0x04]);
    assert_eq!([2, 3, 4, 5].map(|register| read(&mut chip, register, 1)[0]), [0xE2, 0xE4, 0xE8, 0xE0]);
    for channel in 0..16 {
        let registers = [0, 1, 2, 3].map(|byte| read(&mut chip, LED0_ON_L + 4 * channel + byte, 1)[0]);
        assert_eq!(registers, [0, 0, 0, 0x10], "{channel}");
    }
    assert_eq!(read(&mut chip, PRE_SCALE, 1), [0x1E]);
    assert_eq!(chip.counts(), [None; CHANNEL_COUNT]);
}

#[test]
fn without_auto_increment_every_byte_goes_to_and_comes_from_the_same_register() {
    let mut chip = Pca9685::new(ADDRESS);

    write(&mut chip, 0.0, &[LED0_ON_L, 1, 2, 3]);

    assert_eq!(read(&mut chip, LED0_ON_L, 3), [3, 3, 3]);
    assert_eq!(read(&mut chip, LED0_ON_L + 1, 1), [0]);
}

#[test]
fn auto_increment_wraps_from_the_last_channel_and_from_the_prescaler_to_mode1() {
    let mut chip = awake();

    assert_eq!(read(&mut chip, LED15_OFF_H, 3), [0x10, AUTO_INCREMENT, 0x04]);
    assert_eq!(read(&mut chip, PRE_SCALE, 2), [101, AUTO_INCREMENT]);
}

#[test]
fn a_read_without_a_pointer_of_its_own_goes_on_where_the_last_one_pointed() {
    let mut chip = awake();
    assert!(chip.select(ADDRESS, false, 0.0) && chip.write(MODE2, 0.0));
    chip.stop(0.0);

    assert!(chip.select(ADDRESS, true, 0.0));

    assert_eq!([chip.read(0.0), chip.read(0.0)], [0x04, 0xE2]);
}

#[test]
fn reserved_registers_and_the_test_mode_are_not_acknowledged() {
    for register in [0x46, 0xF9, 0xFF] {
        let mut chip = awake();
        assert!(chip.select(ADDRESS, false, 0.0));

        assert!(!chip.write(register, 0.0), "{register:#x}");
        assert_eq!(chip.misuses(), [Misuse::Reserved(register)]);
    }
}

#[test]
fn the_prescaler_is_written_only_asleep_and_never_below_three() {
    let mut chip = awake();
    write(&mut chip, 0.0, &[PRE_SCALE, 50]);
    assert_eq!(read(&mut chip, PRE_SCALE, 1), [101]);
    assert_eq!(chip.misuses(), [Misuse::PrescaleWhileAwake]);

    write(&mut chip, 0.0, &[MODE1, SLEEP]);
    write(&mut chip, 0.0, &[PRE_SCALE, 0]);

    assert_eq!(read(&mut chip, PRE_SCALE, 1), [3]);
    assert_eq!(chip.misuses().len(), 1);
}

#[test]
fn prescaler_101_gives_59_8_hertz_and_the_oscillators_error_shows_in_every_pulse() {
    let [slow, fast] = OSCILLATOR_SPREAD_HZ.map(|oscillator_hz| {
        let mut chip = Pca9685 { prescale: 101, ..Pca9685::new(ADDRESS).with_oscillator(oscillator_hz) };
        write(&mut chip, 0.0, &[MODE1, AUTO_INCREMENT]);
        write(&mut chip, 0.01, &LED0);
        chip
    });

    assert!((awake().frequency_hz() - 59.838).abs() < 0.001);
    assert!((awake().count_us() - 4.08).abs() < 1e-9);
    for (mut chip, us) in [(slow, 330.0 * 102.0 / 24.0), (fast, 330.0 * 102.0 / 25.5)] {
        assert!((chip.pulses_us(0.02)[0].unwrap() - us).abs() < 1e-6);
    }
}

#[test]
fn outputs_change_at_the_stop_and_not_before() {
    let mut chip = awake();

    write_all(&mut chip, 0.020, &LED0);
    let (counts, bursts) = (chip.counts()[0], chip.take_bursts().len());
    chip.stop(0.021);

    assert_eq!((counts, bursts), (None, 0));
    assert_eq!(chip.counts()[0], Some(330));
    assert_eq!(chip.take_bursts().len(), 1);
}

#[test]
fn with_och_outputs_change_at_the_acknowledge_of_a_channels_fourth_register() {
    let mut chip = awake();
    write(&mut chip, 0.010, &[MODE2, CHANGE_ON_ACK | outputs::TOTEM_POLE]);

    write_all(&mut chip, 0.020, &LED0[..4]);
    let after_three = chip.counts()[0];
    chip.write(0x01, 0.020);

    assert_eq!((after_three, chip.counts()[0]), (None, Some(330)));
    // A single register alone changes nothing, not even at the STOP.
    assert_eq!(chip.take_bursts().len(), 1);
    write(&mut chip, 0.030, &[LED0_ON_L + 2, 0x00]);
    assert_eq!(chip.counts()[0], Some(330));
    assert_eq!(chip.take_bursts().len(), 0);
}

/// Section 7.3.3: with every output off the counters are disabled.
#[test]
fn the_first_channel_to_come_on_begins_a_pwm_cycle() {
    let mut chip = awake();

    write(&mut chip, 0.020, &LED0);

    assert!((chip.pulses_us(0.0201)[0].unwrap() - 1346.4).abs() < 1e-6);
}

#[test]
fn servos_see_a_new_width_in_the_next_pwm_cycle() {
    let mut chip = pulsing();

    write(&mut chip, 0.015, &[LED0_ON_L, 0, 0, 0x94, 0x02]);

    assert!((chip.pulses_us(0.010 + 0.99 * CYCLE_S)[0].unwrap() - 1346.4).abs() < 1e-6);
    assert!((chip.pulses_us(0.010 + 1.01 * CYCLE_S)[0].unwrap() - 2692.8).abs() < 1e-6);
}

#[test]
fn a_pulse_that_has_begun_is_the_last_one_after_full_off() {
    let mut chip = pulsing();
    let began_s = 0.010 + 5.0 * CYCLE_S;

    write(&mut chip, began_s + 0.5e-3, &[ALL_LED_OFF_H, 0x10]);

    assert!(!chip.drives_any());
    let ends_s = chip.last_pulse_ends_s(1.0).unwrap();
    assert!((ends_s - (began_s + 1346.4e-6)).abs() < 1e-9, "{ends_s}");
}

#[test]
fn full_off_wins_over_full_on_and_both_are_no_pulse() {
    let counts = |on, off| width(Led { on, off }, outputs::TOTEM_POLE);
    assert_eq!(counts(0x1000, 100), None);
    assert_eq!(counts(0x1000, 0x1000 | 100), None);
    assert_eq!(counts(0, 0x1000 | 100), None);
    assert_eq!(counts(4000, 100), Some(196));
    assert_eq!(width(Led { on: 0, off: 100 }, outputs::TOTEM_POLE | 0x10), Some(3996));
}

#[test]
fn an_open_drain_drives_no_servo() {
    let mut chip = pulsing();

    write(&mut chip, 0.02, &[MODE2, 0]);

    assert!(!chip.drives_any());
}

#[test]
fn the_same_count_for_on_and_off_is_noted() {
    let mut chip = awake();

    write(&mut chip, 0.02, &[LED0_ON_L, 7, 0, 7, 0]);

    assert_eq!(chip.counts()[0], None);
    assert_eq!(chip.misuses(), [Misuse::EqualOnAndOff]);
}

#[test]
fn registers_hold_12_bits_and_the_full_bit_and_no_more() {
    let mut chip = awake();

    write(&mut chip, 0.02, &[LED0_ON_L, 0xFF, 0xFF, 0xFF, 0xFF]);

    assert_eq!(read(&mut chip, LED0_ON_L, 4), [0xFF, 0x1F, 0xFF, 0x1F]);
}

#[test]
fn all_led_registers_write_every_channel_and_read_zero() {
    let mut chip = awake();

    write(&mut chip, 0.02, &[ALL_LED_ON_L, 0, 0, 0x10, 0x02]);

    assert_eq!(chip.counts(), [Some(0x210); CHANNEL_COUNT]);
    assert_eq!(read(&mut chip, ALL_LED_ON_L, 4), [0; 4]);
}

#[test]
fn sleep_ends_the_pulses_with_their_cycle_and_sets_restart_then() {
    let mut chip = pulsing();

    write(&mut chip, 0.100, &[MODE1, AUTO_INCREMENT | SLEEP]);

    // Cycle 5 runs from 93.6 to 110.3 ms.
    assert_eq!(read_at(&mut chip, 0.105, MODE1, 1), [AUTO_INCREMENT | SLEEP]);
    assert!(chip.pulses_us(0.105)[0].is_some());
    assert_eq!(read_at(&mut chip, 0.111, MODE1, 1), [RESTART | AUTO_INCREMENT | SLEEP]);
    assert_eq!(chip.pulses_us(0.111)[0], None);
}

#[test]
fn awake_again_there_are_no_pulses_until_restart_is_written() {
    let mut chip = asleep();

    write(&mut chip, 0.2, &[MODE1, AUTO_INCREMENT]);
    assert_eq!(chip.pulses_us(0.3)[0], None);
    assert_eq!(read_at(&mut chip, 0.3, MODE1, 1), [RESTART | AUTO_INCREMENT], "writing 0 leaves it");
    write(&mut chip, 0.3, &[MODE1, RESTART | AUTO_INCREMENT]);

    assert!(chip.pulses_us(0.4)[0].is_some());
    assert_eq!(read_at(&mut chip, 0.4, MODE1, 1), [AUTO_INCREMENT]);
    assert_eq!(chip.misuses(), []);
}

#[test]
fn restart_is_refused_asleep_while_waking_and_for_500_us_after() {
    let mut chip = asleep();

    write(&mut chip, 0.150, &[MODE1, RESTART | AUTO_INCREMENT | SLEEP]);
    write(&mut chip, 0.200, &[MODE1, RESTART | AUTO_INCREMENT]);
    write(&mut chip, 0.200_4, &[MODE1, RESTART | AUTO_INCREMENT]);

    assert_eq!(chip.pulses_us(0.3)[0], None);
    assert_eq!(read_at(&mut chip, 0.3, MODE1, 1), [RESTART | AUTO_INCREMENT]);
    assert_eq!(chip.misuses(), [Misuse::RestartTooEarly; 2]);
    write(&mut chip, 0.300, &[MODE1, RESTART | AUTO_INCREMENT]);
    assert!(chip.pulses_us(0.4)[0].is_some());
}

#[test]
fn writing_a_pulse_register_clears_restart_at_the_stop() {
    let mut chip = asleep();
    write(&mut chip, 0.2, &[MODE1, AUTO_INCREMENT]);

    write_all(&mut chip, 0.3, &[LED0_ON_L + 2, 0x4B]);
    assert_eq!(chip.pulses_us(0.3)[0], None);
    chip.stop(0.3);

    assert!(chip.pulses_us(0.3)[0].is_some());
    assert_eq!(read_at(&mut chip, 0.4, MODE1, 1), [AUTO_INCREMENT]);
}

#[test]
fn sleeping_with_every_channel_off_leaves_nothing_to_restart() {
    let mut chip = pulsing();
    write(&mut chip, 0.1, &[ALL_LED_OFF_H, 0x10]);

    write(&mut chip, 0.1, &[MODE1, AUTO_INCREMENT | SLEEP]);

    assert_eq!(read_at(&mut chip, 0.2, MODE1, 1), [AUTO_INCREMENT | SLEEP]);
}

#[test]
fn pulses_asked_for_while_the_oscillator_starts_are_noted() {
    let mut chip = Pca9685::new(ADDRESS);
    write(&mut chip, 0.1, &[MODE1, AUTO_INCREMENT]);

    write(&mut chip, 0.100_4, &LED0);
    assert_eq!(chip.misuses(), [Misuse::PulsesWhileStarting]);
    write(&mut chip, 0.100_6, &[LED0_ON_L + 2, 0x4B]);

    assert_eq!(chip.misuses().len(), 1);
}

#[test]
fn the_external_clock_is_chosen_asleep_only_and_for_good() {
    let mut chip = pulsing();
    write(&mut chip, 0.1, &[MODE1, EXTERNAL_CLOCK | AUTO_INCREMENT]);
    assert_eq!(read_at(&mut chip, 0.1, MODE1, 1), [AUTO_INCREMENT]);

    write(&mut chip, 0.1, &[MODE1, SLEEP | AUTO_INCREMENT]);
    write(&mut chip, 0.2, &[MODE1, EXTERNAL_CLOCK | SLEEP | AUTO_INCREMENT]);
    write(&mut chip, 0.2, &[MODE1, AUTO_INCREMENT]);

    assert_eq!(read_at(&mut chip, 0.3, MODE1, 1)[0] & EXTERNAL_CLOCK, EXTERNAL_CLOCK);
    assert_eq!(chip.misuses(), [Misuse::ExternalClock]);
    write(&mut chip, 0.3, &LED0);
    assert_eq!(chip.pulses_us(0.4)[0], None, "nothing is wired to that pin");
}

#[test]
fn allcall_is_answered_both_ways_until_it_is_switched_off_and_subaddresses_once_on() {
    let mut chip = Pca9685::new(ADDRESS);
    assert!(chip.select(0x70, false, 0.0) && chip.select(0x70, true, 0.0));
    assert!([0x71, 0x72, 0x74].iter().all(|&address| !chip.select(address, false, 0.0)));

    write(&mut chip, 0.0, &[MODE1, SLEEP | 0x0E]);
    assert!(!chip.select(0x70, false, 0.0));
    assert!([0x71, 0x72, 0x74].iter().all(|&address| chip.select(address, true, 0.0)));
    write(&mut chip, 0.0, &[SUBADR1, 0xA1]);

    assert!(!chip.select(0x71, false, 0.0));
    assert!(chip.select(0x50, false, 0.0));
    assert_eq!(read(&mut chip, SUBADR1, 1), [0xA0], "bit 0 is read-only");
}

#[test]
fn a_software_reset_takes_effect_at_its_stop_and_restores_the_defaults() {
    let mut chip = pulsing();

    assert!(chip.select(0, false, 0.1));
    assert!(chip.write(SOFTWARE_RESET, 0.1));
    assert!(!chip.is_asleep());
    chip.stop(0.1);

    assert!(chip.is_asleep());
    assert_eq!(read_at(&mut chip, 0.1, PRE_SCALE, 1), [0x1E]);
    assert_eq!(chip.counts(), [None; CHANNEL_COUNT]);
}

#[test]
fn a_software_reset_of_another_form_is_refused() {
    for bytes in [&[SOFTWARE_RESET, 0][..], &[0x07], &[]] {
        let mut chip = pulsing();
        assert!(!chip.select(0, true, 0.1));
        assert!(chip.select(0, false, 0.1));

        let answers: Vec<bool> = bytes.iter().map(|&byte| chip.write(byte, 0.1)).collect();
        chip.stop(0.1);

        assert!(answers.last().is_none_or(|last| !last), "{bytes:?}");
        assert!(chip.drives_any(), "{bytes:?}");
    }
}

#[test]
fn with_the_pin_oe_high_no_servo_gets_a_pulse_whatever_the_registers_say() {
    let mut chip = pulsing();

    chip.set_enabled(false, 0.0105);
    assert!(!chip.drives_any());
    assert_eq!(chip.pulses_us(0.02), [None; CHANNEL_COUNT]);
    assert!(chip.last_pulse_ends_s(0.02).unwrap() <= 0.0105, "cut off in its middle");
    assert_eq!(chip.counts()[0], Some(330), "registers stay");
    chip.set_enabled(true, 0.03);

    assert!(chip.drives_any());
    assert!(chip.pulses_us(0.05)[0].is_some());
}
