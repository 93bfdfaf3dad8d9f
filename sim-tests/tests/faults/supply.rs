//! Too little voltage, too much current.

use crate::{WALK, has_limp_servos, walking};
use firmware::limits;
use host::device::link::words;
use protocol::{Calibration, Command, Event, Fault, Refusal, Reply, State};
use sim_tests::devices::Chip;
use sim_tests::fixtures::{self, amplitude};
use sim_tests::sim_robot::SimRobot;

/// Samples in a row that the supply must be wrong for, and the frames that a
/// stop may take after them.
const DEBOUNCE_FRAMES: u64 = 5;
const STOP_FRAMES: u64 = 3;

/// Frames from a change of the supply to the last pulse.
fn frames_to_limp(robot: &mut SimRobot, bus_v: f64, current_a: f64) -> u64 {
    robot.board.set_supply(bus_v, current_a);
    let from = robot.board.frames();
    while !has_limp_servos(robot) {
        robot.run_frames(1);
        assert!(robot.board.frames() < from + 60, "it walks on at {bus_v} V and {current_a} A");
    }
    robot.board.frames() - from
}

#[test]
fn a_bad_supply_stops_the_robot_after_five_samples_and_it_stays_stopped() {
    for (bus_v, current_a, fault) in [
        (4.19, 1.0, Fault::Undervoltage),
        (0.0, 0.0, Fault::Undervoltage),
        (5.0, 3.0, Fault::Overcurrent),
        (5.0, 3.5, Fault::Overcurrent),
        (4.0, 3.1, Fault::Overcurrent),
    ] {
        let mut robot = walking();

        let frames = frames_to_limp(&mut robot, bus_v, current_a);
        robot.board.set_supply(5.0, 0.0);
        robot.run_frames(60);

        assert!(frames >= DEBOUNCE_FRAMES, "{bus_v} V, {current_a} A: {frames} frames");
        assert!(frames <= DEBOUNCE_FRAMES + STOP_FRAMES, "{bus_v} V, {current_a} A: {frames} frames");
        assert_eq!(robot.state(), State::Fault(fault), "{bus_v} V, {current_a} A");
        let told: Vec<Event> = robot.events().filter(|event| matches!(event, Event::Fault(_))).collect();
        assert_eq!(told, [Event::Fault(fault)]);
        assert_eq!(robot.ask(WALK), Reply::Refused(Refusal::Faulted(fault)));
        robot.expect_done(Command::ClearFault);
        robot.expect_done(WALK);
    }
}

#[test]
fn a_supply_just_within_its_limits_carries_a_walk() {
    let mut robot = walking();

    robot.board.set_supply(4.2, 2.99);
    robot.run_frames(300);

    assert_eq!(robot.state(), State::Walking);
}

#[test]
fn dips_and_peaks_shorter_than_the_debounce_do_not_stop_the_robot() {
    let mut robot = walking();

    for _ in 0..20 {
        for (bus_v, current_a) in [(4.0, 1.0), (5.0, 0.4), (5.0, 3.5), (5.0, 0.4)] {
            robot.board.set_supply(bus_v, current_a);
            robot.run_frames(DEBOUNCE_FRAMES - 1);
        }
    }

    assert_eq!(robot.state(), State::Walking);
}

#[test]
fn a_walk_on_a_low_supply_is_refused_with_its_voltage_and_nothing_moves() {
    for (bus_v, bus_mv) in [(4.592, 4_592), (3.296, 3_296), (0.0, 0)] {
        let mut robot = SimRobot::new();
        robot.upload(&fixtures::trot(), amplitude(1.0), false);
        robot.board.set_supply(bus_v, 0.0);
        robot.run_frames(3);

        let refused = robot.ask(WALK);

        assert_eq!(refused, Reply::Refused(Refusal::SupplyTooLow { bus_mv }));
        assert_eq!(robot.state(), State::Idle, "limp: no fault");
        assert!(has_limp_servos(&robot));
        robot.board.set_supply(4.6, 0.0);
        robot.run_frames(3);
        robot.expect_done(WALK);
    }
}

#[test]
fn an_undervoltage_is_not_cleared_while_the_supply_is_still_low() {
    let mut robot = walking();
    frames_to_limp(&mut robot, 4.1, 1.0);
    robot.board.set_supply(4.4, 0.0);
    robot.run_frames(3);

    let refused = robot.ask(Command::ClearFault);

    assert_eq!(refused, Reply::Refused(Refusal::SupplyTooLow { bus_mv: 4_400 }));
    assert_eq!(robot.state(), State::Fault(Fault::Undervoltage));
}

/// The host's texts are constants of their own: they must not drift.
#[test]
fn the_host_names_the_limits_that_the_robot_keeps() {
    let board = Calibration::authors().board();
    let volts = format!("{} V", f64::from(board.undervoltage_mv) / 1e3);
    let amperes = format!("{} A", f64::from(board.overcurrent_ma) / 1e3);

    assert!(words::fault(Fault::Undervoltage).contains(&volts), "{volts}");
    assert!(words::fault(Fault::Overcurrent).contains(&amperes), "{amperes}");
    assert_eq!(u64::from(limits::SUPPLY_FAULT_FRAMES), DEBOUNCE_FRAMES);
}

/// A sensor that answers every other time hides no low supply.
#[test]
fn missed_samples_do_not_start_the_debounce_anew() {
    let mut robot = walking();
    robot.board.set_supply(4.0, 1.0);
    let from = robot.board.frames();

    while robot.state() == State::Walking {
        robot.board.chips.unplug(Chip::PowerSensor);
        robot.run_frames(1);
        robot.board.chips.replug(Chip::PowerSensor);
        robot.run_frames(1);
        assert!(robot.board.frames() < from + 60, "it walks on at 4.0 V");
    }

    assert_eq!(robot.state(), State::Fault(Fault::Undervoltage));
}
