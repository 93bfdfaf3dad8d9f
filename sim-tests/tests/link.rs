//! Frames, numbers and repeats on a line that loses and garbles.

use proptest::prelude::*;
use protocol::frame::{self, MAX_FRAME_LEN, Request};
use protocol::{
    Chunk, Command, Event, JOINT_COUNT, PROTOCOL_VERSION, Refusal, Reply, ResetCause, State, WalkEnd,
};
use sim_tests::fixtures::{self, amplitude};
use sim_tests::sim_robot::SimRobot;

#[test]
fn a_repeated_command_is_answered_again_and_not_carried_out_twice() {
    let mut robot = SimRobot::new();
    robot.upload(&fixtures::trot(), amplitude(1.0), false);
    let walk = robot.framed(Command::Walk { amplitude: None, frames: None, detached: true, dry_run: false });

    robot.send(&walk);
    let first = robot.answer();
    robot.send(&walk);
    let second = robot.answer();

    // A second walk would have been refused.
    assert_eq!((first, second), (Reply::Done, Reply::Done));
}

#[test]
fn a_refusal_is_repeated_too() {
    let mut robot = SimRobot::new();
    let walk = robot.framed(Command::Walk { amplitude: None, frames: None, detached: true, dry_run: false });
    robot.send(&walk);
    let refused = robot.answer();

    robot.send(&walk);

    assert_eq!(refused, Reply::Refused(Refusal::NoGait));
    assert_eq!(robot.answer(), refused);
}

/// Numbers come round after 256 requests; a question in between proves that the
/// host has had its answer, so the same bytes are then a new request.
#[test]
fn a_command_whose_number_comes_round_again_is_carried_out() {
    let mut robot = SimRobot::new();
    robot.upload(&fixtures::trot(), amplitude(1.0), false);
    let walk = Command::Walk { amplitude: None, frames: Some(1), detached: true, dry_run: false };
    robot.expect_done(walk);
    robot.run_until(State::Idle);
    for _ in 0..255 {
        robot.ask(Command::Read { record: protocol::command::Record::Gait, offset: 0 });
    }

    robot.expect_done(walk);

    assert_eq!(robot.state(), State::Entering);
}

#[test]
fn another_protocol_version_is_refused_and_told_ours() {
    let mut robot = SimRobot::new();

    let stranger = robot.ask(Command::Hello { protocol_version: PROTOCOL_VERSION + 1 });
    let friend = robot.ask(Command::Hello { protocol_version: PROTOCOL_VERSION });

    assert_eq!(stranger, Reply::Refused(Refusal::ProtocolVersion { robot: PROTOCOL_VERSION }));
    assert!(matches!(friend, Reply::Hello(hello)
        if hello.reset_cause == ResetCause::PowerOn && hello.limits.max_gait_len == 264));
}

#[test]
fn half_a_frame_and_noise_cost_one_frame_and_are_counted() {
    let mut robot = SimRobot::new();
    let lost = robot.framed(Command::Stop);

    robot.send(&lost[..3]);
    robot.send(&[0x55; 300]);
    robot.send(&[0]);
    let status = robot.status();

    assert_eq!(status.bad_frames, 1);
}

#[test]
fn an_intact_frame_without_meaning_is_refused_by_its_number() {
    let mut robot = SimRobot::new();
    let mut body = vec![robot.framed(Command::Stop)[1], 0xEE];
    let crc = protocol::crc::crc16(&body);
    body.extend(crc.to_le_bytes());
    assert!(!body.contains(&0), "no byte for COBS to replace");
    let mut frame = vec![body.len() as u8 + 1];
    frame.extend(body);
    frame.push(0);

    robot.send(&frame);

    assert_eq!(robot.answer(), Reply::Refused(Refusal::Unknown));
}

const ATTACHED: Command = Command::Walk { amplitude: None, frames: None, detached: false, dry_run: false };
/// The protocol's second, and two frames on top.
const LINK_LOST_FRAMES: u64 = protocol::LINK_TIMEOUT_FRAMES as u64 + 2;

fn walking_attached() -> SimRobot {
    let mut robot = SimRobot::new();
    robot.upload(&fixtures::trot(), amplitude(0.5), false);
    robot.expect_done(ATTACHED);
    while robot.state() != State::Walking {
        robot.status();
    }
    robot
}

fn link_losses(robot: &SimRobot) -> usize {
    robot.events().filter(|event| *event == Event::WalkEnded(WalkEnd::LinkLost)).count()
}

#[test]
fn a_cable_pulled_in_mid_walk_stops_the_robot_within_a_second_and_leaves_it_limp() {
    let mut robot = walking_attached();
    robot.status();

    robot.run_frames(LINK_LOST_FRAMES);
    let stopped = robot.state();
    robot.run_until(State::Idle);

    assert_eq!(stopped, State::Holding, "where it is, without another step");
    robot.run_frames(2);
    assert!(!robot.board.chips.servo_driver.drives_any());
    assert_eq!(link_losses(&robot), 1);
    robot.expect_done(ATTACHED);
}

#[test]
fn a_cable_pulled_during_the_entry_stops_the_robot_too() {
    // 70 degrees at one degree a frame.
    let far = fixtures::Gait { centre_deg: [70.0; JOINT_COUNT], limit_deg: 90.0, ..fixtures::trot() };
    let mut robot = SimRobot::new();
    robot.upload(&far, amplitude(0.5), false);
    robot.expect_done(ATTACHED);

    robot.run_frames(LINK_LOST_FRAMES - 7);
    let before = robot.state();
    robot.run_frames(7);

    assert_eq!(before, State::Entering);
    assert_eq!(robot.state(), State::Holding);
    assert_eq!(link_losses(&robot), 1);
}

#[test]
fn a_heartbeat_every_quarter_of_a_second_keeps_the_robot_walking() {
    let mut robot = walking_attached();

    for _ in 0..80 {
        robot.run_frames(15);
        robot.status();
    }

    assert_eq!(robot.state(), State::Walking);
    assert_eq!(link_losses(&robot), 0);
}

#[test]
fn a_detached_walk_goes_on_to_its_frames_without_a_host() {
    let mut robot = SimRobot::new();
    robot.upload(&fixtures::trot(), amplitude(1.0), false);
    robot.expect_done(Command::StreamTelemetry { every_frames: 1 });
    robot.expect_done(Command::Walk { amplitude: None, frames: Some(300), detached: true, dry_run: false });

    robot.run_until(State::Idle);
    robot.run_frames(2);

    assert_eq!(robot.telemetry().last().unwrap().trial_frames, 300);
    assert!(robot.events().any(|event| event == Event::WalkEnded(WalkEnd::Finished)));
    assert_eq!(link_losses(&robot), 0);
}

/// Bytes that mean nothing are no host, however many.
#[test]
fn a_flood_of_garbage_is_no_sign_of_life() {
    let mut robot = walking_attached();
    let mut damaged = robot.framed(Command::Status);
    damaged[2] ^= 0x10;
    robot.status();

    for _ in 0..LINK_LOST_FRAMES {
        robot.send(&damaged);
        robot.send(&[0x55; 40]);
        robot.send(&[0]);
        robot.run_frames(1);
    }

    assert_eq!(robot.state(), State::Holding);
    assert!(robot.status().bad_frames > 50);
}

/// The next walk is not judged by the silence before it.
#[test]
fn silence_before_a_walk_does_not_count() {
    let mut robot = SimRobot::new();
    robot.upload(&fixtures::trot(), amplitude(0.5), false);
    robot.run_frames(300);

    robot.expect_done(ATTACHED);
    robot.run_frames(50);

    assert!(matches!(robot.state(), State::Entering | State::Walking), "{:?}", robot.state());
    assert_eq!(link_losses(&robot), 0);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, rng_seed: proptest::test_runner::RngSeed::Fixed(7), ..ProptestConfig::default() })]

    #[test]
    fn no_bytes_on_the_line_stop_the_robot_from_answering(
        noise in proptest::collection::vec(any::<u8>(), 0..600)
    ) {
        let mut robot = SimRobot::playing(&fixtures::trot(), amplitude(2.2));
        robot.send(&noise);
        robot.send(&[0]);
        robot.run_frames(5);

        let status = robot.status();

        let name = status.gait.unwrap().name;
        prop_assert_eq!(name.as_str(), "trot");
        prop_assert!(robot.board.longest_unfed_s() < 0.1);
    }
}

/// Intact frames of another language are no host either.
#[test]
fn a_flood_of_unknown_commands_is_no_sign_of_life() {
    let mut robot = walking_attached();
    let body = [7, 0xEE];
    let [low, high] = protocol::crc::crc16(&body).to_le_bytes();
    assert!(low != 0 && high != 0, "no byte for COBS to replace");
    robot.status();

    for _ in 0..LINK_LOST_FRAMES {
        robot.send(&[5, body[0], body[1], low, high, 0]);
        robot.run_frames(1);
    }

    assert_eq!(robot.state(), State::Holding);
    assert_eq!(link_losses(&robot), 1);
}

/// Two programs one after the other may pick the same number.
#[test]
fn another_command_of_the_same_number_is_no_repeat() {
    let mut robot = SimRobot::new();
    robot.upload(&fixtures::trot(), amplitude(1.0), false);
    let stop = robot.framed(Command::Stop);
    let command = Command::Walk { amplitude: None, frames: None, detached: true, dry_run: false };
    let mut buffer = [0; MAX_FRAME_LEN];
    let walk = frame::encode(&Request::<Chunk> { seq: stop[1], command }, &mut buffer).unwrap().to_vec();
    robot.send(&walk);
    assert_eq!(robot.answer(), Reply::Done);
    robot.run_frames(20);

    robot.send(&stop);

    assert_eq!(robot.answer(), Reply::Done);
    robot.run_frames(3);
    assert_eq!(robot.walk_ends(), [WalkEnd::Asked]);
}
