//! Frames, numbers and repeats on a line that loses and garbles.

use proptest::prelude::*;
use protocol::{Command, PROTOCOL_VERSION, Refusal, Reply, ResetCause, State};
use sim_tests::fixtures::{self, amplitude};
use sim_tests::sim_robot::SimRobot;

#[test]
fn a_repeated_command_is_answered_again_and_not_carried_out_twice() {
    let mut robot = SimRobot::new();
    robot.upload(&fixtures::trot(), amplitude(1.0), false);
    let walk = robot.framed(Command::Walk { amplitude: None, frames: None });

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
    let walk = robot.framed(Command::Walk { amplitude: None, frames: None });
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
    let walk = Command::Walk { amplitude: None, frames: Some(1) };
    robot.expect_done(walk);
    robot.run_until(State::Idle);
    for _ in 0..255 {
        robot.ask(Command::ReadGait { offset: 0 });
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
        if hello.reset_cause == ResetCause::PowerOn && hello.limits.max_gait_len == 256));
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
