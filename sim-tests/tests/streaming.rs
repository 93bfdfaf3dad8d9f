//! Setpoints from the host, a pose a frame.

use protocol::command::Record;
use protocol::frame::STOP_BYTE;
use protocol::{
    Chunk, Command, Fault, JOINT_COUNT, LINK_TIMEOUT_FRAMES, Refusal, Reply, STREAM_CAPACITY, State, WalkEnd,
};
use sim_tests::devices::Chip;
use sim_tests::fixtures::{self, amplitude};
use sim_tests::sim_robot::ask::{WALK, setpoints};
use sim_tests::sim_robot::pulses::{SLOW_STEP_COUNTS, error_from, largest_step, servos_off, servos_on, step};
use sim_tests::sim_robot::{Pulses, SimRobot, encoded};

/// A last setpoint that has arrived, and servos that stand: 0.1 s.
const DRY_FRAMES: u64 = 6;

/// Poses that all differ, by more than a count from one to the next.
fn pose(index: usize) -> [f64; JOINT_COUNT] {
    std::array::from_fn(|joint| 1.25 * (index % 17) as f64 - 2.0 * joint as f64 + 0.5 * (index / 17) as f64)
}

fn streaming() -> SimRobot {
    let mut robot = SimRobot::new();
    robot.upload(&fixtures::trot(), amplitude(1.0), false);
    robot.expect_done(Command::StreamTelemetry { every_frames: 1 });
    robot.expect_done(Command::Stream);
    robot
}

/// Sends these poses one by one, as fast as the buffer takes them.
fn feed(robot: &mut SimRobot, poses: std::ops::Range<usize>) {
    for index in poses {
        loop {
            match robot.ask(setpoints(&[pose(index)])) {
                Reply::Buffered(waiting) => {
                    assert!((1..=STREAM_CAPACITY).contains(&waiting));
                    break;
                }
                Reply::Refused(Refusal::StreamFull) => {}
                other => panic!("{other:?} to pose {index}"),
            }
        }
    }
}

/// The frames in which the pulses were those of `index` and then the next ones.
fn run_of(pulses: &[Pulses], poses: std::ops::Range<usize>) -> bool {
    pulses.windows(poses.len()).any(|window| {
        window.iter().zip(poses.clone()).all(|(p, index)| servos_on(p) && error_from(&pose(index), p) <= 0.6)
    })
}

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

#[test]
fn a_host_that_dies_during_the_entry_is_noticed() {
    let mut robot = streaming();
    robot.ask(setpoints(&[[90.0; JOINT_COUNT]]));

    robot.run_frames(u64::from(LINK_TIMEOUT_FRAMES) + 2);

    assert_eq!(robot.state(), State::Holding);
    assert_eq!(robot.walk_ends(), [WalkEnd::LinkLost]);
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
    robot.board.chips.unplug(Chip::Ina219);
    let mut index = 40;
    while !matches!(robot.state(), State::Fault(_)) {
        robot.ask(setpoints(&[pose(index)]));
        index += 1;
        assert!(index < 200, "it goes on without its sensor");
    }

    assert_eq!(robot.state(), State::Fault(Fault::SensorLost));
    assert!(!robot.board.chips.pca9685.drives_any());
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
fn a_second_stream_starts_with_an_empty_buffer() {
    let mut robot = streaming();
    robot.ask(setpoints(&[[60.0; JOINT_COUNT]; 4]));
    robot.expect_done(Command::Stop);
    robot.run_until(State::Idle);
    robot.expect_done(Command::Stream);

    assert_eq!(robot.ask(setpoints(&[[1.0; JOINT_COUNT]])), Reply::Buffered(1));
}
