//! The board with programs of a few words, so that nothing here needs `avr-gcc`.

use super::*;

/// Sends `MCUSR`, then every byte that comes in.
///
/// in r16,MCUSR; clr; out MCUSR; sts UCSR0A,2; sts UBRR0L,16; sts UCSR0B,0x18;
/// sts UDR0,r16; wait for RXC0; lds r16,UDR0; wait for UDRE0; sts UDR0,r16.
const ECHO: [u16; 27] = [
    0xB704, 0xE010, 0xBF14, 0xE022, 0x9320, 0x00C0, 0xE120, 0x9320, 0x00C4, 0xE128, 0x9320, 0x00C1, 0x9300,
    0x00C6, 0x9120, 0x00C0, 0xFF27, 0xCFFC, 0x9100, 0x00C6, 0x9120, 0x00C0, 0xFF25, 0xCFFC, 0x9300, 0x00C6,
    0xCFF3,
];

/// One byte at UBRR0 = 16 and double speed: 10 bits of 136 cycles.
const NANO_BYTE_CYCLES: u64 = 1360;
const MILLISECOND: u64 = CLOCK_HZ / 1000;

fn board(program: &[u16]) -> Nano {
    Nano::new(&FirmwareImage::of_words(program), Bus::default()).unwrap()
}

fn bytes(received: &[(u64, u8)]) -> Vec<u8> {
    received.iter().map(|(_, byte)| *byte).collect()
}

#[test]
fn a_byte_takes_ten_bits_each_way() {
    let mut nano = board(&ECHO);
    nano.run_until(MILLISECOND).unwrap();
    nano.receive();

    let sent_at = nano.now();
    nano.send(b"x");
    nano.run_until(2 * MILLISECOND).unwrap();

    let received = nano.receive();
    let took = received[0].0 - sent_at;
    assert_eq!(bytes(&received), b"x");
    // 12,500 / 9 cycles in, 1360 out, and a few instructions between.
    assert!((1389 + NANO_BYTE_CYCLES..1389 + NANO_BYTE_CYCLES + 40).contains(&took), "{took} cycles");
}

#[test]
fn a_long_message_comes_back_whole_and_no_faster_than_the_line() {
    let mut nano = board(&ECHO);
    let message: Vec<u8> = (0..=255).collect();
    nano.run_until(MILLISECOND).unwrap();
    nano.receive();

    nano.send(&message);
    nano.run_until(MILLISECOND + 256 * 1388).unwrap();
    assert!(nano.receive().len() < 256);
    nano.run_until(MILLISECOND + 260 * 1400).unwrap();

    assert_eq!(nano.counters(), Counters::default());
    nano.receive();
    assert_eq!(nano.unsent(), 0);
}

#[test]
fn the_program_sees_why_it_was_reset_and_bytes_for_the_bootloader_are_lost() {
    let mut nano = board(&ECHO);
    nano.run_until(MILLISECOND).unwrap();
    assert_eq!(bytes(&nano.receive()), [MCUSR_POWER_ON]);

    nano.reset(10 * MILLISECOND);
    nano.send(b"lost");
    nano.run_until(11 * MILLISECOND).unwrap();
    assert!(nano.is_held());
    assert!(nano.receive().is_empty());
    nano.run_until(11 * MILLISECOND + START_UP_CYCLES + MILLISECOND).unwrap();

    assert_eq!(bytes(&nano.receive()), [MCUSR_EXTERNAL]);
    assert!(nano.now() >= 12 * MILLISECOND, "the clock goes on through a reset");
}

#[test]
fn eeprom_survives_reset_and_power_cycle_and_sram_only_the_reset() {
    // ldi r18,0x5A; sts 0x0100,r18; rjmp .
    let mut nano = board(&[0xE52A, 0x9320, 0x0100, 0xCFFF]);
    let mut contents = [0xFF; EEPROM_LEN];
    contents[1000] = 7;
    nano.set_eeprom(&contents);
    nano.run_until(MILLISECOND).unwrap();
    assert_eq!(nano.sram()[0], 0x5A);

    nano.reset(0);
    nano.run_until(nano.now() + START_UP_CYCLES + 1).unwrap();
    assert_eq!(nano.sram()[0], 0x5A);
    nano.power_cycle();
    nano.run_until(nano.now() + START_UP_CYCLES + 1).unwrap();

    // One cycle is not enough for the program to write it again.
    assert_eq!(nano.sram()[0], 0xA5);
    assert_eq!(nano.eeprom(), contents);
}

/// A timer that the program sets makes simavr run on to it.
#[test]
fn a_run_ends_where_it_is_told_to_though_the_program_sets_a_timer_far_away() {
    // ldi r18,WDE; sts WDTCSR,r18; rjmp . : the watchdog bites at 256,000 cycles.
    let mut nano = board(&[0xE028, 0x9320, 0x0060, 0xCFFF]);

    nano.run_until(2).unwrap();
    nano.run_until(1_000).unwrap();

    assert!(nano.now() < 1_010, "{}", nano.now());
}

#[test]
fn a_watchdog_reset_is_counted_and_the_clock_goes_on() {
    // ldi r18,WDE; sts WDTCSR,r18; rjmp . : 16 ms to the bite.
    let mut nano = board(&[0xE028, 0x9320, 0x0060, 0xCFFF]);

    nano.run_until(20 * MILLISECOND).unwrap();

    assert_eq!(nano.counters().watchdog_resets, 1);
    assert!((20 * MILLISECOND..20 * MILLISECOND + 10).contains(&nano.now()));
}

/// Section 11.9.2: WDRF overrides WDE, and the reset left the shortest period.
#[test]
fn a_watchdog_that_has_bitten_bites_again_16_ms_after_each_start_until_it_is_turned_off() {
    // ldi r18,WDE; sts WDTCSR,r18; rjmp . : it is never turned off.
    let mut nano = board(&[0xE028, 0x9320, 0x0060, 0xCFFF]);
    nano.run_until(500 * MILLISECOND).unwrap();
    assert_eq!(nano.counters().watchdog_resets, 6);

    // in r16,MCUSR; sbrc r16,WDRF; rjmp . ; ldi r18,WDE; sts WDTCSR,r18; rjmp . :
    // after the first bite the program does not even touch the watchdog.
    let mut nano = board(&[0xB704, 0xFD03, 0xCFFF, 0xE028, 0x9320, 0x0060, 0xCFFF]);
    nano.run_until(500 * MILLISECOND).unwrap();
    assert_eq!(nano.counters().watchdog_resets, 6);
}

/// Section 11.5: the delay timer starts at the end of the watchdog's pulse.
#[test]
fn the_program_starts_66_ms_after_any_reset() {
    // sbi DDRD,4; ldi r18,WDE; sts WDTCSR,r18; rjmp . , and after the bite the
    // servo driver's OE is low again as soon as the program runs.
    let mut nano = board(&[0x9A54, 0xE028, 0x9320, 0x0060, 0xCFFF]);
    nano.wire_output_enable(OutputEnable::PulledUp);

    nano.run_until((16 + 66) * MILLISECOND).unwrap();
    let held = nano.is_held() && !nano.bus().servo_driver.is_enabled();
    nano.run_until((16 + 67) * MILLISECOND).unwrap();

    assert!(held && !nano.is_held() && nano.bus().servo_driver.is_enabled());
}

#[test]
fn a_program_that_can_never_wake_is_reported() {
    // sleep, with interrupts off.
    let mut nano = board(&[0x9588, 0xCFFF]);

    let error = nano.run_until(MILLISECOND).unwrap_err();

    assert!(matches!(error, NanoError::AsleepForEver { .. }), "{error}");
}

#[test]
fn invalid_instructions_and_jumps_out_of_the_program_are_crashes_and_no_panic() {
    // 0x0001 is reserved; `nop` alone runs off the end.
    for program in [[0x0001, 0xCFFF], [0x0000, 0x0000]] {
        let mut nano = board(&program);

        let error = nano.run_until(MILLISECOND).unwrap_err();

        assert!(matches!(error, NanoError::Crashed { .. }), "{error}");
    }
}

#[test]
fn a_receiver_at_the_wrong_speed_gets_nothing() {
    let mut slow = ECHO;
    slow[6] = 0xE220; // UBRR0 = 32
    let mut nano = board(&slow);
    nano.run_until(MILLISECOND).unwrap();

    nano.send(b"abc");
    nano.run_until(2 * MILLISECOND).unwrap();

    assert_eq!(nano.counters().framing_errors, 3);
}

#[test]
fn a_program_that_does_not_read_loses_what_the_chip_would_lose() {
    // As ECHO, but stops in an endless loop after enabling the receiver.
    let mut deaf = ECHO;
    deaf[14] = 0xCFFF;
    let mut nano = board(&deaf);
    nano.run_until(MILLISECOND).unwrap();

    nano.send(b"abcde");
    nano.run_until(2 * MILLISECOND).unwrap();

    assert_eq!(nano.counters().receiver_overruns, 2);
}

/// sbi DDRD,4; 200 nops; sbi PORTD,4; 200 nops; cbi DDRD,4; rjmp .
fn drives_d4() -> Vec<u16> {
    [&[0x9A54][..], &[0; 200], &[0x9A5C], &[0; 200], &[0x9854, 0xCFFF]].concat()
}

#[test]
fn output_enable_follows_d4_and_its_resistor() {
    for (wiring, levels) in [
        (OutputEnable::Unwired, [true; 5]),
        // At power-on, driven low, driven high, let go, in reset.
        (OutputEnable::PulledDown, [true, true, false, true, true]),
        (OutputEnable::PulledUp, [false, true, false, false, false]),
    ] {
        let mut nano = board(&drives_d4());
        nano.wire_output_enable(wiring);
        let mut enabled = vec![nano.bus().servo_driver.is_enabled()];
        for cycle in [100, 300, 500] {
            nano.run_until(cycle).unwrap();
            enabled.push(nano.bus().servo_driver.is_enabled());
        }
        nano.reset(1_000);
        enabled.push(nano.bus().servo_driver.is_enabled());

        assert_eq!(enabled, levels, "{wiring:?}");
        nano.run_until(500 + 1_000 + START_UP_CYCLES + 100).unwrap();
        assert!(nano.bus().servo_driver.is_enabled(), "{wiring:?}: driven low again");
    }
}

#[test]
fn a_watchdog_reset_lets_go_of_d4() {
    // sbi DDRD,4; ldi r18,WDE; sts WDTCSR,r18; rjmp . , and after the bite only
    // in r16,MCUSR; sbrc r16,WDRF; rjmp . before it.
    let program = [0xB704, 0xFD03, 0xCFFF, 0x9A54, 0xE028, 0x9320, 0x0060, 0xCFFF];
    let mut nano = board(&program);
    nano.wire_output_enable(OutputEnable::PulledUp);

    nano.run_until(15 * MILLISECOND).unwrap();
    let before = nano.bus().servo_driver.is_enabled();
    nano.run_until(17 * MILLISECOND).unwrap();

    assert!(before && !nano.bus().servo_driver.is_enabled());
}

#[test]
fn the_button_pulls_d2_down_against_its_pull_up_and_without_one_the_pin_floats() {
    // sbi PORTD,2, or a nop; in r16,PIND; sts 0x0100,r16; rjmp to the in.
    for (first, is_pressed, level) in [(0x9A5A, false, 4), (0x9A5A, true, 0), (0x0000, false, 0)] {
        let mut nano = board(&[first, 0xB109, 0x9300, 0x0100, 0xCFFC]);
        nano.press_button(is_pressed);

        nano.run_until(100).unwrap();

        assert_eq!(nano.sram()[0] & 4, level, "{first:#x}, {is_pressed}");
    }
}

#[test]
fn a_button_let_go_and_pressed_again_is_seen_each_time() {
    let mut nano = board(&[0x9A5A, 0xB109, 0x9300, 0x0100, 0xCFFC]);

    let levels = [false, true, false, true].map(|is_pressed| {
        nano.press_button(is_pressed);
        nano.run_until(nano.now() + 100).unwrap();
        nano.sram()[0] & 4
    });

    assert_eq!(levels, [4, 0, 4, 0]);
}

#[test]
fn equal_inputs_at_equal_cycles_give_equal_runs() {
    let run = || {
        let mut nano = board(&ECHO);
        let mut log = Vec::new();
        for slice in 1..200 {
            nano.run_until(slice * 1234).unwrap();
            nano.send(&[slice as u8]);
            log.push((nano.now(), nano.receive()));
        }
        log
    };

    assert_eq!(run(), run());
}
