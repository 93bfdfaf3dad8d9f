//! How the servos follow a stream.

use crate::{feed, pose, run_of, streaming};
use protocol::frame::STOP_BYTE;
use protocol::{Chunk, Command, Fault, JOINT_COUNT, LINK_TIMEOUT_FRAMES, Refusal, Reply, State, WalkEnd};
use sim_tests::devices::Chip;
use sim_tests::fixtures::{self, amplitude};
use sim_tests::sim_robot::ask::{rehearse_for, setpoints, walk_for};
use sim_tests::sim_robot::pulses::{SLOW_STEP_COUNTS, error_from, largest_step, servos_off, servos_on, step};
use sim_tests::sim_robot::{Pulses, SimRobot};

/// A last setpoint that has arrived, and servos that stand: 0.1 s.
const DRY_FRAMES: u64 = 6;

#[test]
fn the_first_pose_is_entered_slowly_and_then_every_pose_gets_exactly_one_frame() {
    let mut robot = streaming();
    robot.take_pulses();

    feed(&mut robot, 0..200);
    let state = robot.state();
    robot.run_until(State::Holding);
    robot.run_frames(2);

    let on: Vec<Pulses> = robot.take_pulses().into_iter().filter(servos_on).collect();
    let arrival = on.iter().position(|p| error_from(&pose(0), p) <= 0.6).unwrap();
    assert_eq!(state, State::Walking);
    assert!(arrival > 10 && largest_step(&on[..=arrival]) <= SLOW_STEP_COUNTS);
    assert!(run_of(&on, 0..200), "a pose was left out or played twice");
    assert_eq!(robot.telemetry().last().unwrap().trial_frames, 200);
}

#[test]
fn a_stream_that_runs_dry_freezes_within_a_tenth_of_a_second_and_says_so() {
    for cut_after in [20, 33, 47] {
        let mut robot = streaming();
        feed(&mut robot, 0..cut_after);
        let from = robot.board.frames();
        robot.take_pulses();

        robot.run_frames(DRY_FRAMES);
        let state = robot.state();
        let last_moves = robot.take_pulses();
        let held = robot.pulses_over(40);
        robot.run_until(State::Idle);

        assert_eq!(state, State::Holding);
        assert!(largest_step(&held) == 0.0 && step(last_moves.last().unwrap(), &held[0]) == 0.0);
        assert!(error_from(&pose(cut_after - 1), &held[0]) <= 0.6, "it stands in the last pose");
        assert_eq!(robot.walk_ends(), [WalkEnd::StreamDry]);
        assert!(robot.board.frames() - from <= 60 + DRY_FRAMES + 1);
        robot.run_frames(2);
        assert!(robot.pulses_over(2).iter().all(servos_off));
    }
}

#[test]
fn a_stop_and_a_stop_byte_freeze_it_where_it_is() {
    for end in [WalkEnd::Asked, WalkEnd::StopByte] {
        let mut robot = streaming();
        feed(&mut robot, 0..60);
        if end == WalkEnd::Asked {
            robot.expect_done(Command::Stop);
        } else {
            robot.send(&[STOP_BYTE]);
        }
        robot.run_frames(3);
        robot.take_pulses();
        let held = robot.pulses_over(30);

        assert_eq!(robot.state(), State::Holding);
        assert!(held.iter().all(servos_on) && largest_step(&held) == 0.0);
        assert_eq!(robot.walk_ends(), [end]);
        assert_eq!(robot.ask(setpoints(&[pose(0)])), Reply::Refused(Refusal::NoStream));
    }
}

#[test]
fn it_waits_limp_for_its_first_pose_and_not_for_ever() {
    let mut robot = streaming();
    robot.take_pulses();

    robot.run_frames(30);
    let waiting = robot.state();
    robot.run_frames(u64::from(LINK_TIMEOUT_FRAMES));

    assert_eq!(waiting, State::Entering);
    assert_eq!(robot.state(), State::Idle);
    assert_eq!(robot.walk_ends(), [WalkEnd::LinkLost]);
    assert!(robot.take_pulses().iter().all(servos_off));
}

#[test]
fn from_a_stand_it_waits_standing() {
    let mut robot = SimRobot::playing(&fixtures::medley(), amplitude(1.0));
    robot.expect_done(Command::Stop);
    robot.run_until(State::Holding);
    robot.run_frames(2);
    robot.take_pulses();

    robot.expect_done(Command::Stream);
    robot.run_frames(20);
    feed(&mut robot, 0..20);

    let pulses = robot.take_pulses();
    assert!(pulses.iter().all(servos_on), "no moment limp");
    assert!(largest_step(&pulses[..15]) == 0.0);
}

/// A stream does not depend on how the walk before it was asked for.
#[test]
fn after_a_detached_rehearsal_it_moves_and_depends_on_its_host() {
    let mut robot = SimRobot::new();
    robot.upload(&fixtures::trot(), amplitude(1.0), false);
    robot.expect_done(rehearse_for(5));
    robot.run_until(State::Idle);
    robot.take_pulses();

    robot.expect_done(Command::Stream);
    robot.ask(setpoints(&[[90.0; JOINT_COUNT]]));
    robot.run_frames(u64::from(LINK_TIMEOUT_FRAMES) + 2);

    assert!(robot.take_pulses().iter().any(servos_on));
    assert_eq!(robot.walk_ends(), [WalkEnd::Finished, WalkEnd::LinkLost]);
}

#[test]
fn a_host_that_dies_during_the_entry_is_noticed() {
    let mut robot = streaming();
    robot.ask(setpoints(&[[90.0; JOINT_COUNT]]));

    robot.run_frames(u64::from(LINK_TIMEOUT_FRAMES) + 2);

    assert_eq!(robot.state(), State::Holding);
    assert_eq!(robot.walk_ends(), [WalkEnd::LinkLost]);
}

/// 147 and 515 counts are what the authors' servos are sent at most.
#[test]
fn angles_beyond_the_servos_are_held_at_their_shortest_and_longest_pulse() {
    for (units, expected) in [(i16::MAX, 515), (i16::MIN, 147)] {
        let mut robot = streaming();
        let bytes: Vec<u8> = (0..JOINT_COUNT).flat_map(|_| units.to_le_bytes()).collect();
        robot.ask(Command::Setpoints { data: Chunk::of(&bytes) });
        while robot.state() == State::Entering {
            robot.status();
        }
        robot.run_frames(3);

        assert_eq!(robot.pulses_over(2).last(), Some(&[Some(expected); JOINT_COUNT]));
        assert_eq!(robot.telemetry().last().unwrap().clipped_frames, 1, "and it is told");
    }
}

#[test]
fn faults_stop_it_as_they_stop_a_walk() {
    let mut robot = streaming();
    feed(&mut robot, 0..40);
    robot.board.chips.unplug(Chip::PowerSensor);
    let mut index = 40;
    while !matches!(robot.state(), State::Fault(_)) {
        robot.ask(setpoints(&[pose(index)]));
        index += 1;
        assert!(index < 200, "it goes on without its sensor");
    }

    assert_eq!(robot.state(), State::Fault(Fault::SensorLost));
    assert!(!robot.board.chips.servo_driver.drives_any());
    assert_eq!(robot.ask(Command::Stream), Reply::Refused(Refusal::Faulted(Fault::SensorLost)));
    assert_eq!(robot.ask(setpoints(&[pose(0)])), Reply::Refused(Refusal::NoStream));
}

#[test]
fn it_needs_no_gait() {
    let mut robot = SimRobot::new();
    robot.run_frames(2);
    robot.expect_done(Command::Stream);

    feed(&mut robot, 0..40);

    assert_eq!(robot.state(), State::Walking);
}

#[test]
fn it_depends_on_its_host_though_the_walk_before_did_not() {
    let mut robot = streaming();
    robot.expect_done(Command::Stop);
    robot.expect_done(walk_for(10));
    robot.run_until(State::Holding);
    robot.run_frames(3);
    robot.expect_done(Command::Stream);

    robot.run_frames(u64::from(LINK_TIMEOUT_FRAMES) + 2);

    assert_ne!(robot.state(), State::Entering);
    assert_eq!(robot.walk_ends().last(), Some(&WalkEnd::LinkLost));
}
