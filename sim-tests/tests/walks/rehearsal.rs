//! The dry run: everything but the pulses.

use crate::ready;
use protocol::frame::STOP_BYTE;
use protocol::{Calibration, Command, Joint, Refusal, Reply, State, WalkEnd};
use sim_tests::devices::Chip;
use sim_tests::fixtures::{self, Gait, amplitude};
use sim_tests::sim_robot::SimRobot;
use sim_tests::sim_robot::ask::{WALK, rehearse_for, walk_for};
use sim_tests::sim_robot::pulses::{servos_off, servos_on};

/// The states that a walk goes through, each once.
fn states_of(robot: &mut SimRobot, walk: Command) -> Vec<State> {
    robot.expect_done(walk);
    let mut states = vec![robot.state()];
    while robot.state() != State::Idle {
        robot.run_frames(1);
        if states.last() != Some(&robot.state()) {
            states.push(robot.state());
        }
    }
    robot.run_frames(2);
    states
}

#[test]
fn it_goes_through_all_states_of_a_walk_counts_its_frames_and_moves_nothing() {
    let mut robot = ready();
    robot.expect_done(Command::StreamTelemetry { every_frames: 1 });
    robot.take_pulses();

    let states = states_of(&mut robot, rehearse_for(72));
    let sample = robot.telemetry().last().unwrap();

    assert_eq!(states, [State::Entering, State::Walking, State::Stopping, State::Holding, State::Idle]);
    assert!(robot.take_pulses().iter().all(servos_off));
    assert!(!robot.board.outputs_enabled());
    assert_eq!(sample.trial_frames, 72);
    assert_eq!(robot.walk_ends(), [WalkEnd::Finished]);
}

#[test]
fn it_counts_the_frames_that_a_walk_would_clip() {
    let gait = Gait { limit_deg: 20.0, ..fixtures::trot() };
    let clipped = [rehearse_for(144), walk_for(144)].map(|walk| {
        let mut robot = SimRobot::new();
        robot.upload(&gait, amplitude(2.2), false);
        robot.expect_done(Command::StreamTelemetry { every_frames: 1 });
        states_of(&mut robot, walk);
        robot.telemetry().last().unwrap().clipped_frames
    });

    assert!(clipped[0] > 50, "{clipped:?}");
    assert_eq!(clipped[0], clipped[1]);
}

/// The servos' own limits are the robot's, and no gait knows them.
#[test]
fn it_counts_the_frames_in_which_a_servo_would_be_held_at_its_own_limit() {
    let authors = Calibration::authors();
    let mut joints = Joint::ALL.map(|joint| authors.joint(joint));
    // 15 of the trot's 24 degrees, at one knee.
    joints[6].max_counts = 330 + 25;
    let narrow = Calibration::new(&joints, &authors.board());
    let clipped = [(authors, rehearse_for(144)), (narrow, rehearse_for(144)), (narrow, walk_for(144))].map(
        |(calibration, walk)| {
            let mut robot = ready();
            robot.calibrate(&calibration);
            robot.expect_done(Command::StreamTelemetry { every_frames: 1 });
            states_of(&mut robot, walk);
            robot.telemetry().last().unwrap().clipped_frames
        },
    );

    assert_eq!(clipped[0], 0);
    assert!(clipped[1] > 30 && clipped[1] < 144, "{clipped:?}");
    assert_eq!(clipped[1], clipped[2]);
}

#[test]
fn it_is_stopped_by_a_stop_a_stop_byte_and_a_lost_link() {
    let attached = Command::Walk { amplitude: None, frames: None, detached: false, dry_run: true };
    for end in [WalkEnd::Asked, WalkEnd::StopByte, WalkEnd::LinkLost] {
        let mut robot = ready();
        robot.take_pulses();
        robot.expect_done(attached);
        match end {
            WalkEnd::Asked => robot.expect_done(Command::Stop),
            WalkEnd::StopByte => robot.send(&[STOP_BYTE]),
            _ => robot.run_frames(62),
        }
        robot.run_frames(2);
        robot.run_until(State::Idle);

        assert_eq!(robot.walk_ends(), [end]);
        assert!(robot.take_pulses().iter().all(servos_off), "{end:?}");
    }
}

#[test]
fn a_walk_during_it_is_refused_and_a_walk_after_it_moves() {
    let mut robot = ready();
    robot.expect_done(rehearse_for(30));
    assert_eq!(robot.ask(WALK), Reply::Refused(Refusal::AlreadyWalking));
    robot.run_until(State::Idle);
    robot.take_pulses();

    robot.expect_done(WALK);
    robot.run_until(State::Walking);

    assert!(robot.take_pulses().iter().any(servos_on));
}

/// A robot that stands is not to fall for a rehearsal.
#[test]
fn a_stream_right_after_it_powers_nothing_before_its_first_setpoint() {
    let mut robot = ready();
    robot.expect_done(rehearse_for(5));
    robot.run_until(State::Holding);
    robot.take_pulses();

    robot.expect_done(Command::Stream);
    robot.run_frames(20);

    assert!(robot.take_pulses().iter().all(servos_off));
}

#[test]
fn a_chip_lost_during_it_is_no_fault_for_nothing_moves() {
    let mut robot = ready();
    robot.expect_done(rehearse_for(200));
    robot.run_until(State::Walking);

    robot.board.chips.unplug(Chip::ServoDriver);
    robot.board.set_supply(3.0, 0.0);
    robot.run_frames(60);

    assert_eq!(robot.state(), State::Walking);
}

/// It moves nothing, so it lets nothing fall either.
#[test]
fn one_asked_of_a_standing_robot_is_refused_until_it_is_limp() {
    let mut robot = ready();
    robot.expect_done(walk_for(10));
    robot.run_until(State::Holding);

    assert_eq!(robot.ask(rehearse_for(10)), Reply::Refused(Refusal::ServosOn));
    robot.run_until(State::Idle);
    robot.run_frames(2);
    robot.expect_done(rehearse_for(10));
}
