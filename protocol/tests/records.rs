//! The records that a robot keeps: how it is built, and how its last walk went.

use proptest::prelude::*;
use protocol::calibration::{
    BoardCalibration, CALIBRATION_LEN, CalibrationError, JointCalibration, MAX_PRESCALE, MIN_PRESCALE,
    UNITY_GAIN_Q14,
};
use protocol::trial::TRIAL_LEN;
use protocol::{Amplitude, Calibration, Fault, JOINT_COUNT, Joint, TrialRecord, WalkEnd};

fn joints() -> [JointCalibration; JOINT_COUNT] {
    core::array::from_fn(|k| JointCalibration {
        channel: 7 - k as u8,
        reversed: k % 3 == 0,
        neutral_counts: 300 + 10 * k as u16,
        scale_q20: 6000 + 100 * k as u16,
        min_counts: 120 + k as u16,
        max_counts: 600 - k as u16,
    })
}

fn board() -> BoardCalibration {
    BoardCalibration {
        prescale: 121,
        oscillator_khz: 24_400,
        shunt_gain_q14: UNITY_GAIN_Q14 + 77,
        undervoltage_mv: 5_900,
        start_mv: 6_400,
        overcurrent_ma: 2_500,
        autostart_s: 30,
    }
}

fn judged(joints: &[JointCalibration; JOINT_COUNT], board: &BoardCalibration) -> Option<CalibrationError> {
    Calibration::from_bytes(Calibration::new(joints, board).bytes()).err()
}

#[test]
fn a_calibration_is_read_back_field_by_field() {
    let written = Calibration::new(&joints(), &board());

    let read = Calibration::from_bytes(written.bytes()).expect("a sound record");

    assert_eq!(Joint::ALL.map(|joint| read.joint(joint)), joints());
    assert_eq!(read.board(), board());
}

#[test]
fn a_calibration_keeps_its_bytes() {
    let record = Calibration::new(&joints(), &board());

    let hex = |bytes: &[u8]| bytes.iter().map(|b| format!("{b:02x}")).collect::<String>();

    assert_eq!(CALIBRATION_LEN, 84);
    assert_eq!(hex(&record.bytes()[..18]), "872c017017780058020636".to_owned() + "01d41779005702");
    assert_eq!(hex(&record.bytes()[72..]), "79505f4d400c170019c4091e");
}

/// What the authors' `ant16.ino` plays, and what the firmware did before it had calibrations.
#[test]
fn the_default_is_the_authors_330_counts_and_five_thirds_of_a_count_a_degree() {
    let calibration = Calibration::authors();

    assert_eq!(Calibration::from_bytes(calibration.bytes()), Ok(calibration));
    for joint in Joint::ALL {
        let joint_calibration = calibration.joint(joint);
        assert_eq!(joint_calibration.channel, joint.index() as u8);
        for angle_units in -90 * 256..=90 * 256_i16 {
            let exact = 330.0 + 5.0 / 3.0 * f64::from(angle_units) / 256.0;
            let counts = f64::from(joint_calibration.counts(angle_units));
            // Half a count, and 1/90 for the rounded scale.
            assert!((counts - exact).abs() <= 0.5 + 1.0 / 90.0, "{angle_units}: {counts}, not {exact}");
        }
    }
    let rate_hz = 25e6 / 4096.0 / f64::from(calibration.board().prescale + 1);
    assert!((rate_hz - 59.8).abs() < 0.05, "{rate_hz}");
}

#[test]
fn a_reversed_joint_turns_the_other_way_about_the_same_neutral() {
    let ahead = JointCalibration { reversed: false, ..joints()[0] };
    let reversed = JointCalibration { reversed: true, ..ahead };

    for angle_units in (-60 * 256..=60 * 256_i16).step_by(100) {
        let (a, b) = (i32::from(ahead.counts(angle_units)), i32::from(reversed.counts(angle_units)));
        assert_eq!(a - i32::from(ahead.neutral_counts), i32::from(ahead.neutral_counts) - b);
    }
}

#[test]
fn no_pulse_is_beyond_the_servos_own_range() {
    let joint = JointCalibration { scale_q20: u16::MAX, ..joints()[5] };

    assert_eq!(joint.counts(i16::MAX), joint.max_counts);
    assert_eq!(joint.counts(i16::MIN), joint.min_counts);
}

#[test]
fn every_joint_that_would_harm_is_refused_by_its_number() {
    let refused = |index: usize, change: fn(&mut JointCalibration)| {
        let mut joints = joints();
        change(&mut joints[index]);
        judged(&joints, &board())
    };

    assert_eq!(refused(0, |_| {}), None);
    assert_eq!(refused(3, |j| j.channel = 8), Some(CalibrationError::Channel(3)));
    assert_eq!(refused(3, |j| j.channel = 127), Some(CalibrationError::Channel(3)));
    // Joint 5 has output 2: the second to claim it is blamed.
    assert_eq!(refused(6, |j| j.channel = 2), Some(CalibrationError::Channel(6)));
    assert_eq!(refused(1, |j| j.min_counts = 0), Some(CalibrationError::Pulse(1)));
    assert_eq!(refused(7, |j| j.min_counts = j.neutral_counts + 1), Some(CalibrationError::Pulse(7)));
    assert_eq!(refused(0, |j| j.max_counts = j.neutral_counts - 1), Some(CalibrationError::Pulse(0)));
    assert_eq!(refused(2, |j| j.max_counts = 4096), Some(CalibrationError::Pulse(2)));
    assert_eq!(refused(2, |j| j.max_counts = 4095), None);
}

#[test]
fn every_number_of_the_board_has_its_range() {
    let refused = |change: fn(&mut BoardCalibration)| {
        let mut board = board();
        change(&mut board);
        judged(&joints(), &board)
    };
    let bad = Some(CalibrationError::Board);

    assert_eq!(refused(|b| b.prescale = MIN_PRESCALE), None);
    assert_eq!(refused(|b| b.prescale = MIN_PRESCALE - 1), bad);
    assert_eq!(refused(|b| b.prescale = MAX_PRESCALE), None);
    assert_eq!(refused(|b| b.prescale = MAX_PRESCALE + 1), bad);
    assert_eq!(refused(|b| b.oscillator_khz = 19_999), bad);
    assert_eq!(refused(|b| b.oscillator_khz = 30_001), bad);
    assert_eq!(refused(|b| b.shunt_gain_q14 = UNITY_GAIN_Q14 / 2 - 1), bad);
    assert_eq!(refused(|b| b.shunt_gain_q14 = UNITY_GAIN_Q14 / 2 * 3 + 1), bad);
    assert_eq!(refused(|b| b.start_mv = b.undervoltage_mv - 1), bad);
    assert_eq!(refused(|b| b.start_mv = 16_001), bad);
    assert_eq!(refused(|b| b.undervoltage_mv = 0), None);
    assert_eq!(refused(|b| b.overcurrent_ma = 0), bad);
    assert_eq!(refused(|b| b.overcurrent_ma = 3_151), bad);
    assert_eq!(refused(|b| b.autostart_s = 255), None);
}

#[test]
fn another_length_is_no_calibration() {
    let bytes = Calibration::authors();
    for len in 0..CALIBRATION_LEN {
        assert_eq!(Calibration::from_bytes(&bytes.bytes()[..len]), Err(CalibrationError::Length));
    }
    assert_eq!(Calibration::from_bytes(&[1; CALIBRATION_LEN + 1]), Err(CalibrationError::Length));
    // Erased and empty memory.
    assert!(Calibration::from_bytes(&[0xFF; CALIBRATION_LEN]).is_err());
    assert!(Calibration::from_bytes(Calibration::NONE.bytes()).is_err());
}

fn ends() -> Vec<WalkEnd> {
    let plain = [
        WalkEnd::Finished,
        WalkEnd::Asked,
        WalkEnd::LinkLost,
        WalkEnd::StopByte,
        WalkEnd::Button,
        WalkEnd::StreamDry,
    ];
    plain.into_iter().chain(Fault::ALL.map(WalkEnd::Fault)).collect()
}

fn trial(end: WalkEnd) -> TrialRecord {
    TrialRecord {
        frames: 0x0102_0304,
        energy_uj: 0xA0B0_C0D0_E0F0,
        clipped_frames: 0x1112_1314,
        missed_samples: 0x2122,
        gait_crc32: 0xDEAD_BEEF,
        amplitude: Amplitude::from_f64(2.2).expect("in range"),
        end,
    }
}

#[test]
fn a_trial_is_read_back_whatever_its_end() {
    for end in ends() {
        assert_eq!(TrialRecord::from_bytes(&trial(end).bytes()), Some(trial(end)), "{end:?}");
    }
}

#[test]
fn a_trial_keeps_its_bytes() {
    let hex = |end: WalkEnd| trial(end).bytes().iter().map(|b| format!("{b:02x}")).collect::<String>();

    assert_eq!(hex(WalkEnd::Button), "04030201f0e0d0c0b0a0141312112221efbeadde664604");
    let codes: Vec<u8> = ends().into_iter().map(|end| trial(end).bytes()[TRIAL_LEN - 1]).collect();
    assert_eq!(codes, [0, 1, 2, 3, 4, 5, 17, 18, 19, 20, 21]);
}

#[test]
fn bytes_that_are_no_trial_are_refused() {
    let good = trial(WalkEnd::Finished).bytes();
    for len in 0..TRIAL_LEN {
        assert_eq!(TrialRecord::from_bytes(&good[..len]), None);
    }
    for end in (6..=16).chain(22..=255) {
        let mut bytes = good;
        bytes[TRIAL_LEN - 1] = end;
        assert_eq!(TrialRecord::from_bytes(&bytes), None, "end {end}");
    }
    assert_eq!(TrialRecord::from_bytes(&[0xFF; TRIAL_LEN]), None);
    assert_eq!(TrialRecord::from_bytes(&[0; TRIAL_LEN]), None);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, rng_seed: proptest::test_runner::RngSeed::Fixed(4), failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn any_record_is_judged_without_a_panic_and_keeps_its_servos_in_range(
        bytes in prop::collection::vec(any::<u8>(), CALIBRATION_LEN),
        angle_units in any::<i16>(),
    ) {
        if let Ok(calibration) = Calibration::from_bytes(&bytes) {
            for joint in Joint::ALL {
                let joint = calibration.joint(joint);
                prop_assert!((joint.min_counts..=joint.max_counts).contains(&joint.counts(angle_units)));
            }
        }
    }

    #[test]
    fn any_angle_and_scale_are_rounded_to_the_nearest_count(
        angle_units in any::<i16>(),
        scale_q20 in any::<u16>(),
        reversed in any::<bool>(),
    ) {
        let joint = JointCalibration {
            channel: 0, reversed, neutral_counts: 2000, scale_q20, min_counts: 1, max_counts: 4095,
        };
        let turn = f64::from(angle_units) * f64::from(scale_q20) / f64::from(1 << 20);
        let exact = (2000.0 + if reversed { -turn } else { turn }).clamp(1.0, 4095.0);
        prop_assert!((f64::from(joint.counts(angle_units)) - exact).abs() <= 0.5 + 1e-9);
    }
}
