//! What the buffer takes, and when.

use crate::{feed, run_of, streaming};
use protocol::command::Record;
use protocol::{Chunk, Command, JOINT_COUNT, Refusal, Reply, STREAM_CAPACITY, State};
use sim_tests::fixtures::{self, amplitude};
use sim_tests::sim_robot::ask::{WALK, setpoints};
use sim_tests::sim_robot::pulses::{error_from, servos_on};
use sim_tests::sim_robot::{Pulses, SimRobot, encoded};

#[test]
fn several_poses_fit_one_message_and_the_answer_tells_how_many_wait() {
    let mut robot = streaming();
    let far = [[40.0; JOINT_COUNT]; 2];

    // 40 frames of entry: nothing is taken out meanwhile.
    assert_eq!(robot.ask(setpoints(&far[..1])), Reply::Buffered(1));
    assert_eq!(robot.ask(setpoints(&far[..1])), Reply::Buffered(2));
    assert_eq!(robot.ask(setpoints(&far[..2])), Reply::Refused(Refusal::StreamFull), "whole or not at all");
    assert_eq!(robot.ask(setpoints(&far[..1])), Reply::Buffered(3));
    assert_eq!(robot.ask(setpoints(&far[..1])), Reply::Refused(Refusal::StreamFull));
    robot.run_until(State::Walking);
    robot.run_until(State::Holding);
    robot.run_frames(2);

    assert_eq!(robot.telemetry().last().unwrap().trial_frames, 3);
}

#[test]
fn a_repeat_of_a_lost_answer_pushes_nothing_twice() {
    let mut robot = streaming();
    let frame = robot.framed(setpoints(&[[40.0; JOINT_COUNT]; 2]));

    let answers = [0; 3].map(|_| {
        robot.send(&frame);
        robot.answer()
    });
    robot.run_until(State::Walking);
    robot.run_until(State::Holding);
    robot.run_frames(2);

    assert_eq!(answers, [Reply::Buffered(2); 3]);
    assert_eq!(robot.telemetry().last().unwrap().trial_frames, 2);
}

#[test]
fn a_host_that_comes_a_little_late_is_made_up_for_by_the_buffer() {
    let mut robot = streaming();
    feed(&mut robot, 0..30);
    for block in 0..10 {
        // Three poses at once, every three frames.
        let start = 30 + 3 * block;
        feed(&mut robot, start..start + 3);
        robot.run_frames(2);
    }
    robot.run_frames(1);

    assert_eq!(robot.state(), State::Walking);
    feed(&mut robot, 60..90);
    robot.run_frames(10);
    let on: Vec<Pulses> = robot.take_pulses().into_iter().filter(servos_on).collect();
    assert!(run_of(&on, 0..90));
}

#[test]
fn uploads_selections_nudges_and_walks_are_refused_meanwhile() {
    let mut robot = SimRobot::new();
    robot.keep(&fixtures::trot(), amplitude(1.0));
    let table = encoded(&fixtures::medley());
    robot.send_pieces(&table);
    robot.expect_done(Command::Stream);
    robot.ask(setpoints(&[[40.0; JOINT_COUNT]; STREAM_CAPACITY as usize]));
    let walking = Reply::Refused(Refusal::AlreadyWalking);

    assert_eq!(robot.ask(Command::UploadBegin { len: 84 }), walking);
    let piece = Command::UploadChunk { offset: 0, data: Chunk::of(&[0xFF; 64]) };
    assert_eq!(robot.ask(piece), Reply::Refused(Refusal::UploadRange));
    let commit = Command::UploadCommit { amplitude: amplitude(1.0), persist: false };
    assert_eq!(robot.ask(commit), Reply::Refused(Refusal::UploadIncomplete), "the buffer is the stream's");
    assert_eq!(robot.ask(Command::SelectGait { slot: 0 }), walking);
    assert_eq!(robot.ask(WALK), walking);
    assert_eq!(robot.ask(Command::Stream), walking);
    assert_eq!(robot.ask(Command::Nudge { channel: 0, counts: 330 }), Reply::Refused(Refusal::ServosOn));
    assert_eq!(robot.read_record(Record::Gait), encoded(&fixtures::trot()));
    robot.run_until(State::Walking);
    robot.run_frames(2);
    let reached = robot.pulses_over(2);

    assert!(
        error_from(&[40.0; JOINT_COUNT], reached.last().unwrap()) <= 0.6,
        "the poses are as they were sent"
    );
    robot.run_until(State::Idle);
    assert_eq!(robot.ask(commit), Reply::Refused(Refusal::UploadIncomplete));
    robot.upload(&fixtures::medley(), amplitude(1.0), false);
}

#[test]
fn setpoints_outside_a_stream_or_of_no_whole_pose_are_refused() {
    let none = Reply::Refused(Refusal::NoStream);
    let bytes = |len| Command::Setpoints { data: Chunk::of(&vec![0x11; len]) };
    let mut idle = SimRobot::new();
    assert_eq!(idle.ask(bytes(16)), none);
    let mut walking = SimRobot::playing(&fixtures::trot(), amplitude(1.0));
    assert_eq!(walking.ask(bytes(16)), none);

    let mut robot = streaming();
    robot.ask(setpoints(&[[60.0; JOINT_COUNT]]));
    for len in (0..=64).filter(|len| *len == 0 || len % 16 != 0) {
        assert_eq!(robot.ask(bytes(len)), none, "{len} bytes");
    }
    assert_eq!(robot.ask(setpoints(&[[60.0; JOINT_COUNT]])), Reply::Buffered(2));
}

#[test]
fn a_second_stream_starts_with_an_empty_buffer() {
    let mut robot = streaming();
    robot.ask(setpoints(&[[60.0; JOINT_COUNT]; 3]));
    robot.expect_done(Command::Stop);
    robot.run_until(State::Idle);
    robot.expect_done(Command::Stream);

    assert_eq!(robot.ask(setpoints(&[[1.0; JOINT_COUNT]])), Reply::Buffered(1));
}
