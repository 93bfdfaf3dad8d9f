//! From a stop to limp servos, and what interrupts that way.

use crate::{ready, walking};
use protocol::{Command, LINK_TIMEOUT_FRAMES, State, WalkEnd};
use sim_tests::fixtures::{self, amplitude};
use sim_tests::sim_robot::SimRobot;
use sim_tests::sim_robot::ask::{ATTACHED_WALK, WALK, walk_for};
use sim_tests::sim_robot::pulses::{SLOW_STEP_COUNTS, error_from, largest_step, servos_off, servos_on};

/// One second, as the states promise it.
const HOLD_FRAMES: u64 = 60;

#[test]
fn a_stop_goes_to_the_gaits_centre_at_bounded_speed_holds_for_a_second_and_lets_go() {
    let gait = fixtures::medley();
    let mut robot = SimRobot::playing(&gait, amplitude(2.2));
    robot.run_frames(45);
    robot.take_pulses();

    robot.expect_done(Command::Stop);
    assert_eq!(robot.state(), State::Stopping);
    robot.run_frames(2);
    robot.take_pulses();
    let stopping = robot.frames_in(State::Stopping);
    let way = robot.take_pulses();
    let holding = robot.frames_in(State::Holding);
    let stand = robot.take_pulses();

    // 40 degrees at 60 a second at most.
    assert!((2..45).contains(&stopping), "{stopping} frames of stopping");
    assert!(way.iter().all(servos_on) && largest_step(&way) <= SLOW_STEP_COUNTS, "{}", largest_step(&way));
    assert!(holding.abs_diff(HOLD_FRAMES) <= 1, "{holding} frames of holding");
    assert!(error_from(&gait.centre_deg, stand.iter().rfind(|p| servos_on(p)).unwrap()) <= 0.6);
    assert_eq!(robot.state(), State::Idle);
    robot.run_frames(1);
    assert!(robot.pulses_over(3).iter().all(servos_off));
    assert_eq!(robot.walk_ends(), [WalkEnd::Asked]);
}

#[test]
fn a_stop_during_the_entry_goes_to_the_centre_too() {
    let gait = fixtures::medley();
    let mut robot = SimRobot::new();
    robot.upload(&gait, amplitude(3.0), false);
    robot.expect_done(WALK);
    robot.run_frames(8);
    robot.take_pulses();

    robot.expect_done(Command::Stop);
    let state = robot.state();
    robot.run_until(State::Idle);

    let on: Vec<_> = robot.take_pulses().into_iter().filter(servos_on).collect();
    assert_eq!(state, State::Stopping);
    assert!(largest_step(&on) <= SLOW_STEP_COUNTS);
    assert!(error_from(&gait.centre_deg, on.last().unwrap()) <= 0.6);
    assert_eq!(robot.walk_ends(), [WalkEnd::Asked]);
}

#[test]
fn a_stop_before_the_first_pulse_sends_none() {
    let mut robot = ready();
    let (walk, stop) = (robot.framed(WALK), robot.framed(Command::Stop));
    robot.run_frames(1);
    robot.take_pulses();

    // Both arrive within a frame.
    robot.send(&walk);
    robot.send(&stop);
    robot.run_frames(10);

    assert_eq!(robot.walk_ends(), [WalkEnd::Asked]);
    assert_eq!(robot.state(), State::Idle);
    assert!(robot.take_pulses().iter().all(servos_off));
}

#[test]
fn a_walk_after_a_stop_enters_from_where_it_stands() {
    for wait_frames in [3, 40] {
        let mut robot = SimRobot::playing(&fixtures::medley(), amplitude(2.2));
        robot.run_frames(45);
        robot.expect_done(Command::Stop);
        robot.run_frames(wait_frames);
        let state = robot.state();
        robot.take_pulses();

        robot.expect_done(WALK);
        robot.run_until(State::Walking);

        let pulses = robot.take_pulses();
        assert_eq!(state, if wait_frames == 3 { State::Stopping } else { State::Holding });
        assert!(pulses.iter().all(servos_on), "no moment limp");
        assert!(largest_step(&pulses) <= SLOW_STEP_COUNTS, "{}", largest_step(&pulses));
    }
}

#[test]
fn a_walk_asked_for_while_the_last_frames_are_counted_still_tells_how_the_one_before_ended() {
    let mut robot = walking();
    let (stop, walk) = (robot.framed(Command::Stop), robot.framed(WALK));

    robot.send(&stop);
    robot.send(&walk);
    robot.run_frames(5);

    assert_eq!(robot.walk_ends(), [WalkEnd::Asked]);
    assert!(matches!(robot.state(), State::Entering | State::Walking), "{:?}", robot.state());
}

#[test]
fn a_stop_while_idle_stopping_or_holding_changes_nothing() {
    let mut robot = ready();
    robot.expect_done(Command::Stop);
    assert_eq!(robot.state(), State::Idle);
    robot.expect_done(walk_for(5));
    robot.run_until(State::Stopping);
    robot.expect_done(Command::Stop);
    assert_eq!(robot.state(), State::Stopping);
    robot.run_until(State::Holding);
    robot.run_frames(30);
    robot.expect_done(Command::Stop);
    let left = robot.frames_in(State::Holding);

    assert!(left < 34, "{left} frames more: the hold began anew");
    assert_eq!(robot.walk_ends(), [WalkEnd::Finished]);
}

#[test]
fn the_light_and_the_output_enable_follow_the_way_to_limp() {
    let mut robot = walking();
    robot.expect_done(Command::Stop);
    robot.run_until(State::Holding);
    robot.run_frames(2);
    let mut lit = 0;
    for _ in 0..50 {
        robot.run_frames(1);
        assert!(robot.board.outputs_enabled());
        lit += u32::from(robot.board.is_lit());
    }
    robot.run_until(State::Idle);
    robot.run_frames(2);

    assert_eq!(lit, 50, "steady while it holds");
    assert!(!robot.board.outputs_enabled());
}

#[test]
fn a_detached_walk_without_frames_outlasts_its_host_and_an_attached_one_does_not() {
    let mut detached = ready();
    detached.expect_done(WALK);
    let mut attached = ready();
    attached.expect_done(ATTACHED_WALK);

    detached.run_frames(600);
    attached.run_frames(u64::from(LINK_TIMEOUT_FRAMES) + 2);
    let state = attached.state();
    attached.run_until(State::Idle);

    assert_eq!(detached.state(), State::Walking);
    assert!(detached.walk_ends().is_empty());
    assert_eq!(state, State::Holding);
    assert_eq!(attached.walk_ends(), [WalkEnd::LinkLost]);
}
