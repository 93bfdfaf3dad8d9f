use super::*;
use crate::robot::{LegScale, Robot};
use proptest::prelude::*;
use protocol::command::CalibrationSource;

fn authors() -> RobotCalibration {
    RobotCalibration::from_record(&Calibration::authors())
}

#[test]
fn the_authors_robot_reads_in_their_own_numbers() {
    let RobotCalibration { board, joints } = authors();

    assert_eq!((joints[0].neutral_us, joints[0].us_per_degree), (1346.4, 6.8003));
    assert_eq!((joints[7].channel, joints[7].min_us, joints[7].max_us), (7, 599.76, 2101.2));
    assert_eq!((board.pwm_hz, board.oscillator_mhz, board.shunt_ohm), (59.84, 25.0, 0.1));
}

#[test]
fn a_file_is_read_back_as_it_was_written() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("calibration.toml");
    let mut written = authors();
    written.joints[3].is_measured = true;
    written.joints[3].reversed = true;
    written.board.autostart_s = 30;

    written.save(&path).unwrap();

    assert_eq!(RobotCalibration::load(&path).unwrap(), written);
}

/// A board at 24.4 MHz runs 2.4 % slow: its counts are longer, and fewer make the same pulse.
#[test]
fn a_slow_oscillator_takes_fewer_counts_for_the_same_pulse() {
    let mut slow = authors();
    slow.board.oscillator_mhz = 24.4;

    let record = slow.record().unwrap();

    // 24.4 MHz / 4096 / 59.84 = 99.55: prescaler 99, 4.098 us a count.
    assert_eq!(record.board().prescale, 99);
    let joint = record.joint(Joint::Hip1);
    let pulse_us = f64::from(joint.neutral_counts) * count_us(&record.board());
    assert!((pulse_us - 1346.4).abs() < 2.05, "{pulse_us} us");
    // Neutral and turn are rounded apart: half a count each.
    assert!((f64::from(joint.counts(45 * 256)) * count_us(&record.board()) - 1652.4).abs() < 4.1);
}

#[test]
fn a_measured_rate_tells_the_oscillator() {
    assert_eq!(oscillator_mhz(59.838, 101), 25.0);
    assert_eq!(oscillator_mhz(58.4, 101), 24.399);
}

/// Digital servos take 300 Hz: 0.8 us a count, a tenth of a degree.
#[test]
fn fast_pwm_makes_fine_counts() {
    let mut fast = authors();
    fast.board.pwm_hz = 300.0;

    let record = fast.record().unwrap();

    assert_eq!(record.board().prescale, 19);
    assert!((count_us(&record.board()) - 0.8).abs() < 1e-9);
    assert_eq!(record.joint(Joint::Knee2).neutral_counts, 1683);
}

#[test]
fn every_bad_value_is_refused_by_name_with_its_limits() {
    let refused = |change: fn(&mut RobotCalibration)| {
        let mut calibration = authors();
        change(&mut calibration);
        calibration.record().unwrap_err().to_string()
    };

    assert_eq!(
        refused(|c| c.joints[2].channel = 9),
        "hip3: channel is 9; it must be within 0 to 7 (PCA9685 outputs)"
    );
    assert_eq!(refused(|c| c.joints[6].channel = 1), "hip2 and knee3 both have channel 1");
    assert_eq!(
        refused(|c| c.joints[4].neutral_us = 250.0),
        "knee1: neutral_us is 250; it must be within 300 to 3000 us"
    );
    assert_eq!(
        refused(|c| c.joints[4].min_us = 1400.0),
        "knee1: min_us is 1400; it must be within 300 to 1346.4 us (neutral_us)"
    );
    assert_eq!(
        refused(|c| c.joints[4].max_us = 1300.0),
        "knee1: max_us is 1300; it must be within 1346.4 to 3000 us"
    );
    assert_eq!(
        refused(|c| c.joints[0].us_per_degree = 0.0),
        "hip1: us_per_degree is 0; it must be within 1 to 30 us/degree"
    );
    assert_eq!(
        refused(|c| c.board.pwm_hz = 400.0),
        "board: pwm_hz is 400; it must be within 39.8 to 339.1 Hz"
    );
    assert_eq!(
        refused(|c| c.board.oscillator_mhz = 250.0),
        "board: oscillator_mhz is 250; it must be within 20 to 30 MHz"
    );
    assert_eq!(
        refused(|c| c.board.shunt_ohm = 0.01),
        "board: shunt_ohm is 0.01; it must be within 0.067 to 0.2 ohm"
    );
    assert_eq!(
        refused(|c| c.board.undervoltage_v = 5.0),
        "board: undervoltage_v is 5; it must be within 0 to 4.6 V (start_v)"
    );
    assert_eq!(
        refused(|c| c.board.overcurrent_a = 3.2),
        "board: overcurrent_a is 3.2; it must be within 0.001 to 3.15 A"
    );
    assert!(refused(|c| c.board.start_v = f64::NAN).contains("start_v is NaN"));
    // At 300 Hz the period itself is 3.3 ms, so nothing of a pulse is lost; at 339 Hz it is.
    assert!(
        refused(|c| {
            c.board.pwm_hz = 339.0;
            c.joints[0].max_us = 2960.0;
        })
        .contains("max_us is 2960; it must be within 1346.4 to 2948 us")
    );
}

#[test]
fn a_file_with_a_joint_missing_or_twice_is_refused_with_its_name() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("calibration.toml");
    let text = authors().to_toml();
    let refused = |text: &str| {
        std::fs::write(&path, text).unwrap();
        RobotCalibration::load(&path).unwrap_err().to_string()
    };

    let cut = text.rfind("[[joint]]").unwrap();
    assert!(refused(&text[..cut]).contains("knee4 is missing; it needs hip1"));
    assert!(refused(&text.replace("\"knee4\"", "\"knee3\"")).contains("knee3 is there twice"));
    assert!(refused(&text.replace("\"knee4\"", "\"tail\"")).contains("\"tail\" is not a joint"));
    assert!(refused(&text.replace("version = 1", "version = 2")).contains("has version 2; this program"));
    assert!(refused("neutral = 3").contains("is not a calibration file"));
}

prop_compose! {
    /// Anything a robot may have stored.
    fn any_record()(
        scale in prop::array::uniform8(1_300..9_000_u16),
        neutral in prop::array::uniform8(250..450_u16),
        reach in 10..150_u16,
        turned in 0..8_usize,
        reversed in any::<u8>(),
        prescale in 90..=110_u8,
        oscillator_khz in 23_000..=27_000_u16,
        shunt_gain_q14 in UNITY_GAIN_Q14 / 2..=24_000_u16,
        start_mv in 3_000..=16_000_u16,
        overcurrent_ma in 1..=3_150_u16,
        autostart_s in any::<u8>(),
    ) -> Calibration {
        let joints = std::array::from_fn(|joint| JointCalibration {
            channel: ((joint + turned) % 8) as u8,
            reversed: reversed >> joint & 1 == 1,
            neutral_counts: neutral[joint],
            scale_q20: scale[joint],
            min_counts: neutral[joint] - reach,
            max_counts: neutral[joint] + reach,
        });
        let board = BoardCalibration {
            prescale, oscillator_khz, shunt_gain_q14, undervoltage_mv: start_mv / 2, start_mv,
            overcurrent_ma, autostart_s,
        };
        Calibration::new(&joints, &board)
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, rng_seed: proptest::test_runner::RngSeed::Fixed(5), failure_persistence: None, ..ProptestConfig::default() })]

    /// What is read from one robot and written to another is the same to the last bit.
    #[test]
    fn a_record_survives_the_file(record in any_record()) {
        let text = RobotCalibration::from_record(&record).to_toml();
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("calibration.toml");
        std::fs::write(&path, text).unwrap();
        prop_assert_eq!(RobotCalibration::load_checked(&path).unwrap().1, record);
    }
}

#[test]
fn a_pwm_in_step_with_the_frames_is_warned_of_and_the_way_out_is_none() {
    let mut board = RobotCalibration::from_record(&Calibration::authors()).board;
    assert_eq!(board.in_step(), None, "59.84 Hz");

    // 25.067 MHz / 4096 / 102 = 60.0 Hz.
    board.oscillator_mhz = 25.067;
    board.pwm_hz = 60.0;
    let warning = board.in_step().unwrap();
    board.pwm_hz = 58.0;
    let after = board.in_step();
    board.pwm_hz = 180.0;

    assert!(warning.contains("60.00 Hz") && warning.contains("pwm_hz to 58"), "{warning}");
    assert_eq!(after, None);
    assert_eq!(board.in_step().is_some(), (25.067e6_f64 / 4096.0 / 34.0 - 180.0).abs() < 0.1);
}

/// The firmware's default is the Ant's: a robot that nobody calibrated walks the same.
#[test]
fn the_ants_description_gives_the_firmwares_own_calibration() {
    let ant = Robot::ant(LegScale::LONG).unwrap();

    assert_eq!(RobotCalibration::of_robot(&ant).record(), Ok(Calibration::authors()));
}

#[test]
fn a_description_gives_pulses_end_stops_outputs_and_directions() {
    let mut robot = Robot::ant(LegScale::LONG).unwrap();
    robot.servo.pulse_range_us = None;
    (robot.servo.neutral_pulse_us, robot.servo.pulse_us_per_deg) = (1500.0, 10.0);
    robot.servo.end_stop_deg = 60.0;
    robot.servo.channels = Some([7, 6, 5, 4, 3, 2, 1, 0]);
    robot.servo.reversed = Some([false, true, false, true, false, true, false, true]);

    let calibration = RobotCalibration::of_robot(&robot);

    let expected = JointSetup {
        channel: 6,
        reversed: true,
        neutral_us: 1500.0,
        us_per_degree: 10.0,
        min_us: 900.0,
        max_us: 2100.0,
        is_measured: true,
    };
    assert_eq!(calibration.joints[1], expected);
    assert!(calibration.record().is_ok());
}

/// Bounds of `robot.toml` are wider than what a servo driver sends.
#[test]
fn every_description_that_loads_has_a_calibration_that_a_robot_takes() {
    for (neutral, scale, stop, volts) in [
        (500.0, 1.0, 20.0, 1.0),
        (2500.0, 30.0, 180.0, 26.0),
        (500.0, 30.0, 180.0, 3.7),
        (1500.0, 16.0, 120.0, 4.5),
    ] {
        let mut robot = Robot::ant(LegScale::LONG).unwrap();
        robot.servo.pulse_range_us = None;
        (robot.servo.neutral_pulse_us, robot.servo.pulse_us_per_deg) = (neutral, scale);
        (robot.servo.end_stop_deg, robot.supply.nominal_v) = (stop, volts);
        robot.check().unwrap();

        RobotCalibration::of_robot(&robot).record().unwrap();
    }
}

#[test]
fn a_hand_calibrated_ant_agrees_though_its_horns_are_a_tooth_off() {
    let ant = Robot::ant(LegScale::LONG).unwrap();
    let mut by_hand = RobotCalibration::of_robot(&ant);
    for (joint, setup) in by_hand.joints.iter_mut().enumerate() {
        setup.neutral_us += 17.0 * setup.us_per_degree * if joint % 2 == 0 { 1.0 } else { -1.0 };
        setup.us_per_degree *= 1.05;
        setup.channel = 7 - setup.channel;
        setup.reversed = joint > 3;
    }
    let record = by_hand.record().unwrap();

    assert_eq!(differences(&record, CalibrationSource::Stored, &ant), []);
    assert!(!differences(&record, CalibrationSource::Default, &ant).is_empty());
}

#[test]
fn what_differs_is_named_once_for_all_joints_that_share_it() {
    let mut robot = Robot::ant(LegScale::LONG).unwrap();
    (robot.servo.neutral_pulse_us, robot.servo.pulse_us_per_deg) = (1500.0, 10.0);
    robot.servo.channels = Some([1, 0, 2, 3, 4, 5, 6, 7]);
    let of = |source| {
        let all = differences(&Calibration::authors(), source, &robot);
        all.iter().map(ToString::to_string).collect::<Vec<_>>()
    };

    let scale = "all joints: 6.80 us a degree, but 10.00 in the description";
    assert_eq!(
        of(CalibrationSource::Stored),
        ["hip1: on output 0, but 1 in the description", scale, "hip2: on output 1, but 0 in the description"]
    );
    assert!(of(CalibrationSource::Default).contains(
        &"all joints: neutral at 1346 us, but 1500 us in the description, 15 degrees apart".to_owned()
    ));
}
