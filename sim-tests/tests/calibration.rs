//! The robot's own build: servos, PWM, shunt, supply.

use firmware::store::CALIBRATION_PLACES;
use protocol::calibration::{
    BoardCalibration, CALIBRATION_LEN, CalibrationError, JointCalibration, UNITY_GAIN_Q14,
};
use protocol::command::{CalibrationSource, Record};
use protocol::{Calibration, Command, Fault, JOINT_COUNT, Joint, Refusal, Reply, ResetCause, State};
use sim_tests::fixtures::{self, Gait, amplitude};
use sim_tests::sim_robot::SimRobot;
use sim_tests::sim_robot::ask::{WALK, rehearse_for, walk_for};

fn joints() -> [JointCalibration; JOINT_COUNT] {
    let authors = Calibration::authors();
    Joint::ALL.map(|joint| authors.joint(joint))
}

fn with_board(change: impl Fn(&mut BoardCalibration)) -> Calibration {
    let mut board = Calibration::authors().board();
    change(&mut board);
    Calibration::new(&joints(), &board)
}

/// Nothing of it is the authors': other outputs, half of them reversed, other scales.
fn another_build() -> ([JointCalibration; JOINT_COUNT], Calibration) {
    let joints = std::array::from_fn(|index| JointCalibration {
        channel: (5 * index as u8 + 3) % 8,
        reversed: index % 2 == 0,
        neutral_counts: 300 + 10 * index as u16,
        scale_q20: 5_000 + 700 * index as u16,
        min_counts: 280,
        max_counts: 390,
    });
    (joints, Calibration::new(&joints, &Calibration::authors().board()))
}

/// Stands at these angles while it walks.
fn still(centre_deg: [f64; JOINT_COUNT]) -> Gait {
    Gait::of("still", 1.0, centre_deg, |_, _| 0.0)
}

/// The pulses of a robot that walks this gait.
fn pulses_of(robot: &mut SimRobot, gait: &Gait) -> [Option<u16>; JOINT_COUNT] {
    robot.upload(gait, amplitude(1.0), false);
    robot.expect_done(WALK);
    robot.run_until(State::Walking);
    robot.run_frames(5);
    let pulses = *robot.pulses_over(3).last().unwrap();
    robot.expect_done(Command::Stop);
    robot.run_until(State::Idle);
    pulses
}

#[test]
fn a_new_robot_has_the_authors_and_says_that_it_is_none_of_its_own() {
    let mut robot = SimRobot::new();

    assert_eq!(robot.status().calibration, CalibrationSource::Default);
    assert_eq!(robot.calibration(), Ok(Calibration::authors()));
}

#[test]
fn every_number_of_a_joint_reaches_its_output() {
    let (joints, calibration) = another_build();
    let mut robot = SimRobot::new();
    robot.run_frames(2);
    robot.calibrate(&calibration);
    for centre_deg in [
        [0.0; JOINT_COUNT],
        [10.0, -10.0, 20.0, -20.0, 5.5, -5.5, 0.25, 33.0],
        [-50.0, 50.0, -50.0, 50.0, 50.0, -50.0, 50.0, -50.0],
    ] {
        let pulses = pulses_of(&mut robot, &still(centre_deg));

        for (joint, deg) in joints.iter().zip(centre_deg) {
            let sign = if joint.reversed { -1.0 } else { 1.0 };
            let free = f64::from(joint.neutral_counts) + sign * deg * f64::from(joint.scale_q20) / 4_096.0;
            let expected = free.clamp(280.0, 390.0);
            let counts = f64::from(pulses[usize::from(joint.channel)].unwrap());
            assert!((counts - expected).abs() <= 0.51, "{counts} counts on {joint:?}, {expected} expected");
        }
    }
}

#[test]
fn it_survives_resets_and_power_cycles_and_the_newest_of_many_is_found() {
    let mut robot = SimRobot::new();
    for autostart_s in [1, 2, 3, 4, 5] {
        robot.calibrate(&with_board(|board| board.autostart_s = autostart_s));
        assert_eq!(robot.status().calibration, CalibrationSource::Stored);
        robot = if autostart_s % 2 == 0 { robot.reset(ResetCause::External) } else { robot.power_cycle() };

        assert_eq!(robot.status().calibration, CalibrationSource::Stored);
        assert_eq!(robot.calibration().unwrap().board().autostart_s, autostart_s);
    }
}

#[test]
fn one_cut_off_while_it_was_saved_leaves_the_one_before() {
    for frames in [0, 1, 5, 10] {
        let mut robot = SimRobot::new();
        robot.calibrate(&with_board(|board| board.autostart_s = 1));
        let (_, other) = another_build();
        assert_eq!(robot.send_calibration(&other), Reply::Done);
        assert_eq!(robot.calibration(), Ok(other), "in use at once");
        robot.run_frames(frames);

        let mut robot = robot.power_cycle();

        assert_eq!(robot.calibration().unwrap().board().autostart_s, 1, "{frames} frames");
    }
}

/// Both places are whole when the power goes between the new mark and the old one's end.
#[test]
fn a_rotten_copy_gives_way_to_the_other_and_without_one_to_the_authors() {
    let mut robot = SimRobot::new();
    robot.calibrate(&with_board(|board| board.autostart_s = 1));
    robot.calibrate(&with_board(|board| board.autostart_s = 2));
    // The first copy was given up; here it was not yet.
    robot.board.memory_mut()[usize::from(CALIBRATION_PLACES[0])] = 0xA5;
    for (rotten, expected) in [(0, Some(2)), (1, None)] {
        robot.board.memory_mut()[usize::from(CALIBRATION_PLACES[rotten]) + 40] ^= 4;
        robot = robot.power_cycle();

        let found = robot.calibration().unwrap();

        assert_eq!(
            found,
            expected.map_or(Calibration::authors(), |s| with_board(|board| board.autostart_s = s))
        );
        let source = if expected.is_some() { CalibrationSource::Stored } else { CalibrationSource::Default };
        assert_eq!(robot.status().calibration, source);
    }
}

#[test]
fn a_worn_cell_leaves_it_in_use_and_says_that_it_is_not_saved() {
    let mut robot = SimRobot::new();
    robot.board.worn_cell = Some(CALIBRATION_PLACES[0] + 20);

    robot.calibrate(&with_board(|board| board.autostart_s = 9));

    assert_eq!(robot.status().calibration, CalibrationSource::NotSaved);
    assert_eq!(robot.calibration().unwrap().board().autostart_s, 9);
    assert_eq!(robot.power_cycle().status().calibration, CalibrationSource::Default);
}

#[test]
fn it_is_refused_while_servos_are_on_or_a_walk_is_rehearsed() {
    let mut robot = SimRobot::new();
    robot.upload(&fixtures::trot(), amplitude(1.0), false);
    let on = Reply::Refused(Refusal::ServosOn);
    robot.expect_done(Command::Nudge { channel: 0, counts: 330 });
    assert_eq!(robot.send_calibration(&Calibration::authors()), on);
    robot.expect_done(Command::Nudge { channel: 0, counts: 0 });
    for walk in [WALK, rehearse_for(500)] {
        robot.expect_done(walk);
        assert_eq!(robot.send_calibration(&Calibration::authors()), on);
        robot.run_until(State::Walking);
        assert_eq!(robot.ask(Command::CalibrationCommit), on);
        if walk == WALK {
            robot.expect_done(Command::Stop);
            robot.run_until(State::Holding);
            assert_eq!(robot.ask(Command::CalibrationCommit), on);
        }
        robot.expect_done(Command::Stop);
        robot.run_until(State::Idle);
    }

    robot.expect_done(Command::CalibrationCommit);
}

#[test]
fn it_waits_for_a_save_under_way() {
    let mut robot = SimRobot::new();
    robot.upload(&fixtures::trot(), amplitude(1.0), true);

    let busy = robot.send_calibration(&with_board(|board| board.autostart_s = 9));
    let meanwhile = robot.calibration();
    robot.run_frames(90);

    assert_eq!(busy, Reply::Refused(Refusal::StorageBusy));
    assert_eq!(meanwhile, Ok(Calibration::authors()));
    robot.expect_done(Command::CalibrationCommit);
    assert_eq!(robot.calibration().unwrap().board().autostart_s, 9);
}

#[test]
fn bytes_that_are_none_are_refused_with_what_is_wrong_and_the_old_one_stays() {
    let good = *with_board(|board| board.autostart_s = 9).bytes();
    let damaged = |at: usize, byte: u8| {
        let mut bytes = good.to_vec();
        bytes[at] = byte;
        bytes
    };
    for (bytes, error) in [
        (good[..CALIBRATION_LEN - 1].to_vec(), CalibrationError::Length),
        ([&good[..], &[0]].concat(), CalibrationError::Length),
        (damaged(0, 8), CalibrationError::Channel(0)),
        (damaged(9, 0), CalibrationError::Channel(1)),
        (damaged(9, 0x80), CalibrationError::Channel(1)),
        (damaged(2 * 9 + 6, 0xFF), CalibrationError::Pulse(2)),
        (damaged(7 * 9 + 8, 0xFF), CalibrationError::Pulse(7)),
        (damaged(8 * 9, 3), CalibrationError::Board),
    ] {
        let mut robot = SimRobot::new();
        robot.send_pieces(&bytes);

        let refused = robot.ask(Command::CalibrationCommit);
        robot.run_frames(40);

        assert_eq!(refused, Reply::Refused(Refusal::BadCalibration(error)));
        assert_eq!(robot.calibration(), Ok(Calibration::authors()));
        assert_eq!(robot.status().calibration, CalibrationSource::Default);
    }
    let mut robot = SimRobot::new();
    assert_eq!(robot.ask(Command::CalibrationCommit), Reply::Refused(Refusal::UploadIncomplete));
}

#[test]
fn a_gait_is_no_calibration_and_a_calibration_no_gait() {
    let mut robot = SimRobot::new();
    robot.send_pieces(Calibration::authors().bytes());
    let commit = Command::UploadCommit { amplitude: amplitude(1.0), persist: false };

    assert!(matches!(robot.ask(commit), Reply::Refused(Refusal::BadGait(_))));
    assert_eq!(robot.ask(Command::Read { record: Record::Gait, offset: 0 }), Reply::Refused(Refusal::NoGait));
    robot.expect_done(Command::CalibrationCommit);
}

#[test]
fn another_prescaler_is_in_the_chip_before_the_next_pulse() {
    let mut robot = SimRobot::new();
    robot.upload(&fixtures::trot(), amplitude(1.0), false);
    assert!((robot.board.chips.pca9685.frequency_hz() - 59.84).abs() < 0.01);
    // 25 MHz / 4096 / 50 = 122 Hz.
    robot.calibrate(&with_board(|board| board.prescale = 49));

    robot.expect_done(WALK);
    robot.run_until(State::Walking);
    robot.run_frames(60);

    assert!((robot.board.chips.pca9685.frequency_hz() - 122.07).abs() < 0.01);
    assert_eq!(robot.state(), State::Walking, "the check of the chips knows, too");
    assert!(robot.board.chips.pca9685.misuses().is_empty(), "{:?}", robot.board.chips.pca9685.misuses());
    let robot = robot.power_cycle();
    assert!((robot.board.chips.pca9685.frequency_hz() - 122.07).abs() < 0.01, "from the start");
}

/// Energy over a second at this true current through a shunt of so many ohms.
fn energy_through(shunt_ohm: f64, current_a: f64, gain: f64) -> (f64, i32) {
    let mut robot = SimRobot::new();
    robot.upload(&fixtures::trot(), amplitude(1.0), false);
    robot.calibrate(&with_board(|board| board.shunt_gain_q14 = (gain * f64::from(UNITY_GAIN_Q14)) as u16));
    robot.expect_done(Command::StreamTelemetry { every_frames: 1 });
    let now_s = robot.board.now_s();
    robot.board.chips.ina219.set_inputs(current_a * shunt_ohm, 4.992, now_s);
    robot.run_frames(3);
    robot.expect_done(walk_for(60));
    robot.run_until(State::Holding);
    robot.run_frames(3);
    let sample = robot.telemetry().last().unwrap();
    (sample.trial_energy_uj as f64 * 1e-6, sample.current_ua)
}

#[test]
fn the_shunts_gain_makes_current_and_energy_true() {
    for (shunt_ohm, gain) in [(0.1, 1.0), (0.098, 1.0 / 0.98), (0.102, 1.0 / 1.02), (0.08, 1.25), (0.2, 0.5)]
    {
        let (energy_j, current_ua) = energy_through(shunt_ohm, 1.2, gain);

        // The battery's: the sensor sees 4.992 V behind the shunt.
        let expected_j = (4.992 + 1.2 * shunt_ohm) * 1.2;
        assert!(
            (energy_j / expected_j - 1.0).abs() < 2e-3,
            "{energy_j} J of {expected_j} at {shunt_ohm} ohm"
        );
        assert!(f64::from(current_ua.abs_diff(1_200_000)) < 2_000.0, "{current_ua} uA at {shunt_ohm} ohm");
    }
}

#[test]
fn the_supplys_thresholds_are_those_of_the_record() {
    let strict = with_board(|board| {
        (board.undervoltage_mv, board.start_mv, board.overcurrent_ma) = (6_000, 6_800, 1_000);
    });
    for (bus_v, current_a, fault) in
        [(6.1, 0.9, None), (5.9, 0.9, Some(Fault::Undervoltage)), (7.0, 1.0, Some(Fault::Overcurrent))]
    {
        let mut robot = SimRobot::new();
        robot.upload(&fixtures::trot(), amplitude(1.0), false);
        robot.calibrate(&strict);
        robot.board.set_supply(6.7, 0.0);
        robot.run_frames(3);
        let low = robot.ask(WALK);
        robot.board.set_supply(6.8, 0.0);
        robot.run_frames(3);
        robot.expect_done(WALK);
        robot.run_until(State::Walking);

        robot.board.set_supply(bus_v, current_a);
        robot.run_frames(30);

        assert!(matches!(low, Reply::Refused(Refusal::SupplyTooLow { bus_mv: 6_688..=6_704 })), "{low:?}");
        assert_eq!(robot.state(), fault.map_or(State::Walking, State::Fault), "{bus_v} V, {current_a} A");
    }
}

/// With a gain, 2.5 A in the sensor's counts are more than 16 bits hold.
#[test]
fn overcurrent_stops_the_robot_at_any_gain() {
    for gain in [1.0, 1.25, 1.5] {
        let mut robot = SimRobot::new();
        robot.upload(&fixtures::trot(), amplitude(1.0), false);
        robot.calibrate(&with_board(|board| {
            board.shunt_gain_q14 = (gain * f64::from(UNITY_GAIN_Q14)) as u16;
        }));
        robot.expect_done(WALK);
        robot.run_until(State::Walking);

        robot.board.set_supply(5.0, 3.1);
        robot.run_frames(10);

        assert_eq!(robot.state(), State::Fault(Fault::Overcurrent), "gain {gain}");
        assert!(robot.status().bus_mv > 4_900);
    }
}
