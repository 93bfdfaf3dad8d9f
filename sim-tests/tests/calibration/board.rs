//! What the numbers of a calibration do.

use crate::{another_build, with_board};
use protocol::calibration::UNITY_GAIN_Q14;
use protocol::{Command, Fault, JOINT_COUNT, Refusal, Reply, State};
use sim_tests::fixtures::{self, Gait, amplitude};
use sim_tests::sim_robot::SimRobot;
use sim_tests::sim_robot::ask::{WALK, walk_for};

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
fn another_prescaler_is_in_the_chip_before_the_next_pulse() {
    let mut robot = SimRobot::new();
    robot.upload(&fixtures::trot(), amplitude(1.0), false);
    assert!((robot.board.chips.servo_driver.frequency_hz() - 59.84).abs() < 0.01);
    // 25 MHz / 4096 / 50 = 122 Hz.
    robot.calibrate(&with_board(|board| board.prescale = 49));

    robot.expect_done(WALK);
    robot.run_until(State::Walking);
    robot.run_frames(60);

    assert!((robot.board.chips.servo_driver.frequency_hz() - 122.07).abs() < 0.01);
    assert_eq!(robot.state(), State::Walking, "the check of the chips knows, too");
    assert!(
        robot.board.chips.servo_driver.misuses().is_empty(),
        "{:?}",
        robot.board.chips.servo_driver.misuses()
    );
    let robot = robot.power_cycle();
    assert!((robot.board.chips.servo_driver.frequency_hz() - 122.07).abs() < 0.01, "from the start");
}

/// Energy over a second at this true current through a shunt of so many ohms.
fn energy_through(shunt_ohm: f64, current_a: f64, gain: f64) -> (f64, i32) {
    let mut robot = SimRobot::new();
    robot.upload(&fixtures::trot(), amplitude(1.0), false);
    robot.calibrate(&with_board(|board| board.shunt_gain_q14 = (gain * f64::from(UNITY_GAIN_Q14)) as u16));
    robot.expect_done(Command::StreamTelemetry { every_frames: 1 });
    let now_s = robot.board.now_s();
    robot.board.chips.power_sensor.set_inputs(current_a * shunt_ohm, 4.992, now_s);
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
