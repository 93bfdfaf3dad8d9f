//! The byte that stops a robot wherever it arrives.

use crate::{ready, walking};
use protocol::frame::STOP_BYTE;
use protocol::{Command, Event, State, WalkEnd};
use sim_tests::sim_robot::SimRobot;
use sim_tests::sim_robot::ask::{WALK, walk_for};
use sim_tests::sim_robot::pulses::{largest_step, servos_off, servos_on};

/// From the byte on the line to the last different pulses: the frame staged
/// already goes out, and the next one stands.
const LAST_MOVE_FRAMES: u64 = 3;

fn stop(robot: &mut SimRobot) {
    robot.send(&[STOP_BYTE]);
    robot.run_frames(LAST_MOVE_FRAMES);
    robot.take_pulses();
}

#[test]
fn it_freezes_a_walk_where_it_is_and_lets_go_a_second_later() {
    let mut robot = walking();

    stop(&mut robot);
    let state = robot.state();
    let held = robot.pulses_over(50);
    robot.run_until(State::Idle);

    assert_eq!(state, State::Holding);
    assert!(held.iter().all(servos_on) && largest_step(&held) == 0.0);
    assert_eq!(robot.walk_ends(), [WalkEnd::StopByte]);
    robot.run_frames(2);
    assert!(robot.pulses_over(3).iter().all(servos_off));
}

#[test]
fn it_works_in_the_middle_of_any_frame_and_the_frame_is_none_the_worse() {
    let len = {
        let mut robot = walking();
        robot.framed(Command::StreamTelemetry { every_frames: 2 }).len()
    };
    for at in 0..=len {
        let mut robot = walking();
        let mut bytes = robot.framed(Command::StreamTelemetry { every_frames: 2 });
        bytes.insert(at, STOP_BYTE);

        robot.send(&bytes);
        let reply = robot.answer();
        robot.run_frames(2);

        assert_eq!(reply, protocol::Reply::Done, "at {at}");
        assert_eq!(robot.state(), State::Holding, "at {at}");
        assert_eq!(robot.status().bad_frames, 0, "at {at}");
    }
}

#[test]
fn it_works_in_half_a_frame_that_never_ends() {
    let mut robot = walking();
    let half = robot.framed(Command::Stop);

    robot.send(&half[..half.len() / 2]);
    robot.run_frames(5);
    assert_eq!(robot.state(), State::Walking);
    robot.send(&[STOP_BYTE]);
    robot.run_frames(2);

    assert_eq!(robot.state(), State::Holding);
}

#[test]
fn it_works_behind_a_flood_that_fills_the_ring() {
    let mut robot = walking();

    robot.send(&[0x55; 500]);
    robot.send(&[STOP_BYTE]);
    robot.run_frames(5);

    assert_eq!(robot.state(), State::Holding);
}

#[test]
fn it_freezes_an_entry_and_the_way_to_a_stand() {
    let mut entering = ready();
    entering.expect_done(WALK);
    entering.run_frames(5);
    assert_eq!(entering.state(), State::Entering);
    let mut stopping = walking();
    stopping.expect_done(Command::Stop);
    stopping.run_frames(4);
    assert_eq!(stopping.state(), State::Stopping);

    for robot in [&mut entering, &mut stopping] {
        stop(robot);
        assert_eq!(robot.state(), State::Holding);
        let held = robot.pulses_over(40);
        assert!(held.iter().all(servos_on) && largest_step(&held) == 0.0);
        robot.run_until(State::Idle);
    }
    assert_eq!(entering.walk_ends(), [WalkEnd::StopByte]);
    assert_eq!(stopping.walk_ends(), [WalkEnd::Asked], "it had ended already");
}

#[test]
fn it_prolongs_no_hold_and_wakes_no_idle_robot() {
    let mut robot = ready();
    stop(&mut robot);
    assert_eq!(robot.state(), State::Idle);
    assert!(robot.pulses_over(5).iter().all(servos_off));
    robot.expect_done(walk_for(5));
    robot.run_until(State::Holding);
    robot.run_frames(30);

    robot.send(&[STOP_BYTE]);
    let left = robot.frames_in(State::Holding);

    assert!(left < 33, "{left} frames");
    assert_eq!(robot.walk_ends(), [WalkEnd::Finished]);
    let started = Event::Started(protocol::ResetCause::PowerOn);
    assert_eq!(robot.events().collect::<Vec<_>>(), [started, Event::WalkEnded(WalkEnd::Finished)]);
}

#[test]
fn it_ends_a_nudge_and_leaves_the_output_limp() {
    let mut robot = ready();
    robot.run_frames(2);
    robot.expect_done(Command::Nudge { channel: 3, counts: 330 });
    robot.run_frames(4);
    assert_eq!(robot.state(), State::Holding);

    stop(&mut robot);

    assert_eq!(robot.state(), State::Idle);
    assert!(robot.pulses_over(4).iter().all(servos_off));
}

#[test]
fn it_ends_a_pause() {
    let mut robot = walking();
    robot.expect_done(Command::SetSpeed(protocol::Speed::PAUSED));
    robot.run_frames(60);
    assert_eq!(robot.state(), State::Holding);
    robot.take_pulses();

    robot.send(&[STOP_BYTE]);
    robot.run_frames(70);

    assert_eq!(robot.state(), State::Idle);
    assert_eq!(robot.walk_ends(), [WalkEnd::StopByte]);
}

#[test]
fn it_never_switches_servos_on() {
    let mut robot = ready();
    robot.run_frames(2);
    robot.expect_done(Command::Stream);
    robot.run_frames(5);

    robot.send(&[STOP_BYTE]);
    robot.run_frames(10);

    assert!(robot.take_pulses().iter().all(servos_off));
    assert_eq!(robot.state(), State::Idle);
    assert_eq!(robot.walk_ends(), [WalkEnd::StopByte]);
}

/// What is on its way is a request of its own, and comes after the byte.
#[test]
fn a_walk_behind_it_is_obeyed() {
    let mut robot = walking();
    let walk = robot.framed(WALK);

    robot.send(&[STOP_BYTE]);
    robot.send(&walk);
    let reply = robot.answer();

    assert_eq!(reply, protocol::Reply::Done);
    robot.run_until(State::Walking);
    assert_eq!(robot.walk_ends(), [WalkEnd::StopByte]);
}

/// Whoever stops has the last word, over what the robot has not read yet too.
#[test]
fn a_walk_before_it_is_stopped_although_the_byte_is_seen_first() {
    let mut robot = ready();
    robot.run_frames(2);
    let mut bytes = robot.framed(Command::Status);
    bytes.extend(robot.framed(Command::Status));
    bytes.extend(robot.framed(WALK));
    bytes.push(STOP_BYTE);

    robot.send(&bytes);
    robot.run_frames(30);

    assert_eq!(robot.walk_ends(), [WalkEnd::StopByte], "it was obeyed, and ended");
    assert_eq!(robot.state(), State::Idle);
    assert!(robot.take_pulses().iter().all(servos_off));
}
