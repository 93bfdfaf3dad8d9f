//! The start button, and a robot without a host.

use crate::walking;
use protocol::calibration::BoardCalibration;
use protocol::{Calibration, Command, Joint, ResetCause, State, WalkEnd};
use sim_tests::fixtures::{self, amplitude};
use sim_tests::sim_robot::SimRobot;
use sim_tests::sim_robot::ask::rehearse_for;
use sim_tests::sim_robot::pulses::{largest_step, servos_off};

/// Frames that a press must last: 50 ms.
const DEBOUNCE_FRAMES: u64 = 3;

fn with_autostart(autostart_s: u8) -> Calibration {
    let authors = Calibration::authors();
    let joints = Joint::ALL.map(|joint| authors.joint(joint));
    Calibration::new(&joints, &BoardCalibration { autostart_s, ..authors.board() })
}

/// Powered on with a stored gait and this autostart, its button not touched yet.
fn untethered(autostart_s: u8) -> SimRobot {
    let mut robot = SimRobot::new();
    robot.keep(&fixtures::trot(), amplitude(1.0));
    robot.calibrate(&with_autostart(autostart_s));
    let mut robot = robot.power_cycle();
    robot.run_frames(30);
    robot
}

fn press(robot: &mut SimRobot, frames: u64) {
    robot.board.is_button_down = true;
    robot.run_frames(frames);
    robot.board.is_button_down = false;
    robot.run_frames(DEBOUNCE_FRAMES + 1);
}

#[test]
fn a_robot_stays_limp_at_power_up_autostart_or_not() {
    for autostart_s in [0, 5, 255] {
        let mut robot = untethered(autostart_s);

        robot.run_frames(300);

        assert_eq!(robot.state(), State::Idle);
        assert!(robot.take_pulses().iter().all(servos_off));
    }
}

#[test]
fn without_autostart_the_button_starts_nothing() {
    let mut robot = untethered(0);

    press(&mut robot, 60);

    assert_eq!(robot.state(), State::Idle);
}

#[test]
fn a_press_starts_the_stored_gait_once_it_has_lasted_for_50_ms() {
    for frames in 1..6 {
        let mut robot = untethered(10);

        press(&mut robot, frames);

        let started = robot.state() == State::Entering || robot.state() == State::Walking;
        assert_eq!(started, frames >= DEBOUNCE_FRAMES, "{frames} frames of pressing");
    }
}

#[test]
fn bounces_start_nothing_and_stop_nothing() {
    for (mut robot, state) in [(untethered(10), State::Idle), (walking(), State::Walking)] {
        for frame in 0..200 {
            // Down for one or two frames, up for one.
            robot.board.is_button_down = frame % 5 < 2 || frame % 5 == 3;
            robot.run_frames(1);
        }
        assert_eq!(robot.state(), state);
    }
}

#[test]
fn the_walk_lasts_as_long_as_stored_without_a_host_and_leaves_its_trial() {
    let mut robot = untethered(3);
    robot.expect_done(Command::StreamTelemetry { every_frames: 1 });

    press(&mut robot, 10);
    robot.run_until(State::Walking);
    let walking = robot.frames_in(State::Walking);
    robot.run_until(State::Idle);
    robot.run_frames(60);

    assert!(walking.abs_diff(180) <= 1, "{walking} frames");
    assert_eq!(robot.walk_ends(), [WalkEnd::Finished]);
    let trial = robot.last_trial().unwrap();
    assert_eq!((trial.frames, trial.end, trial.amplitude), (180, WalkEnd::Finished, amplitude(1.0)));
}

#[test]
fn at_255_it_walks_until_it_is_pressed_again() {
    let mut robot = untethered(255);

    press(&mut robot, 10);
    robot.run_frames(255 * 60 + 600);
    let walking = robot.state();
    robot.take_pulses();
    robot.board.is_button_down = true;
    robot.run_frames(DEBOUNCE_FRAMES + 3);
    robot.take_pulses();
    let held = robot.pulses_over(40);

    assert_eq!(walking, State::Walking);
    assert_eq!(robot.state(), State::Holding);
    assert!(largest_step(&held) == 0.0);
    robot.run_until(State::Idle);
    robot.run_frames(120);
    assert_eq!(robot.state(), State::Idle, "a button held down is one press");
    assert_eq!(robot.walk_ends(), [WalkEnd::Button]);
}

#[test]
fn a_press_stops_whatever_moves_with_autostart_or_without() {
    let mut rehearsing = untethered(0);
    rehearsing.expect_done(rehearse_for(600));
    let mut nudging = untethered(10);
    nudging.expect_done(Command::Nudge { channel: 0, counts: 330 });
    let mut holding = walking();
    holding.expect_done(Command::Stop);
    holding.run_until(State::Holding);
    for robot in [&mut rehearsing, &mut nudging, &mut holding, &mut walking()] {
        press(robot, 5);
        assert!(matches!(robot.state(), State::Holding | State::Idle), "{:?}", robot.state());
        robot.run_until(State::Idle);
    }
    assert_eq!(rehearsing.walk_ends(), [WalkEnd::Button]);
    assert_eq!(holding.walk_ends(), [WalkEnd::Asked]);
}

/// A wire that touches ground, or a hand that has not let go: no press was seen.
#[test]
fn a_button_that_is_down_at_power_up_starts_nothing_until_it_was_let_go() {
    let mut robot = untethered(10);
    robot.board.is_button_down = true;
    let mut robot = robot.reset(ResetCause::PowerOn);
    robot.board.is_button_down = true;

    robot.run_frames(120);
    let held = robot.state();
    robot.board.is_button_down = false;
    robot.run_frames(10);
    press(&mut robot, 10);

    assert_eq!(held, State::Idle);
    assert_ne!(robot.state(), State::Idle);
}

#[test]
fn a_start_that_is_refused_leaves_the_robot_idle() {
    let mut without_gait = SimRobot::new();
    without_gait.calibrate(&with_autostart(10));
    let mut low = untethered(10);
    low.board.set_supply(4.0, 0.0);
    low.run_frames(3);
    for robot in [&mut without_gait, &mut low] {
        press(robot, 10);
        assert_eq!(robot.state(), State::Idle);
    }
}
