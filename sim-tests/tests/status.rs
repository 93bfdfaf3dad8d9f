//! What the robot says about itself when asked.

use protocol::calibration::CALIBRATION_LEN;
use protocol::command::{CalibrationSource, Record, Storage};
use protocol::trial::TRIAL_LEN;
use protocol::{
    Command, GAIT_SLOTS, LINK_TIMEOUT_FRAMES, PROTOCOL_VERSION, Refusal, Reply, ResetCause, STREAM_CAPACITY,
    State,
};
use sim_tests::devices::Chip;
use sim_tests::fixtures::{self, amplitude};
use sim_tests::sim_robot::ask::{WALK, walk_for};
use sim_tests::sim_robot::{SimRobot, encoded};

#[test]
fn a_new_robot_has_nothing_and_nothing_has_gone_wrong() {
    let mut robot = SimRobot::new();
    robot.run_frames(2);

    let status = robot.status();

    assert_eq!((status.state, status.gait, status.storage), (State::Idle, None, Storage::RamOnly));
    assert_eq!((status.calibration, status.reset_cause), (CalibrationSource::Default, ResetCause::PowerOn));
    assert_eq!((status.bad_frames, status.dropped_bytes, status.bus_errors), (0, 0, 0));
    assert_eq!(status.bus_mv, 5_008, "5 V, to the nearest step of 16 mV");
    assert_eq!(status.stack_left, 300, "the bench's figure");
}

#[test]
fn the_hello_tells_what_the_robot_can_take() {
    let Reply::Hello(hello) = SimRobot::new().ask(Command::Hello { protocol_version: PROTOCOL_VERSION })
    else {
        panic!("no hello")
    };

    assert_eq!(hello.protocol_version, PROTOCOL_VERSION);
    assert_eq!(hello.firmware_version, firmware::FIRMWARE_VERSION);
    assert_eq!((hello.limits.gait_slots, hello.limits.stream_capacity), (GAIT_SLOTS, STREAM_CAPACITY));
    assert_eq!((hello.limits.frame_rate_hz, hello.limits.max_chunk_len), (60, 64));
}

#[test]
fn uptime_counts_frames_and_every_reset_tells_its_cause() {
    let mut robot = SimRobot::new();
    let first = robot.status().uptime_frames;
    robot.run_frames(1_000);
    let later = robot.status().uptime_frames;
    assert!((later - first).abs_diff(1_000) <= 2, "{first} and {later}");
    for cause in [ResetCause::External, ResetCause::BrownOut, ResetCause::Watchdog, ResetCause::Unknown] {
        robot = robot.reset(cause);
        let status = robot.status();
        assert_eq!(status.reset_cause, cause);
        assert!(status.uptime_frames < 5);
    }
}

/// Answers are longer than questions: a host that only asks finds no ear in the end.
#[test]
fn bytes_that_find_no_room_are_counted() {
    let mut robot = SimRobot::new();
    for _ in 0..60 {
        let question = robot.framed(Command::Read { record: Record::Calibration, offset: 0 });
        robot.send(&question);
    }
    robot.run_frames(120);
    robot.send(&[0]);
    let flooded = robot.status();
    robot.run_frames(60);

    assert!((100..500).contains(&flooded.dropped_bytes), "{} bytes", flooded.dropped_bytes);
    assert!(flooded.bad_frames > 0, "what was left of them made no sense");
    assert_eq!(robot.status().dropped_bytes, flooded.dropped_bytes, "silence drops nothing");
}

#[test]
fn damaged_frames_are_counted_and_intact_ones_are_not() {
    let mut robot = SimRobot::new();
    for number in 1..=10 {
        let mut frame = robot.framed(Command::Status);
        frame[2] ^= 0x08;
        robot.send(&frame);
        robot.run_frames(1);
        assert_eq!(robot.status().bad_frames, number);
    }
}

#[test]
fn failed_transfers_are_counted() {
    let mut robot = SimRobot::new();
    robot.run_frames(2);
    assert_eq!(robot.status().bus_errors, 0);

    robot.board.chips.unplug(Chip::PowerSensor);
    robot.run_frames(10);
    robot.board.chips.replug(Chip::PowerSensor);
    let counted = robot.status().bus_errors;
    robot.run_frames(60);

    // Nine readings a frame.
    assert!((80..=100).contains(&counted), "{counted}");
    assert_eq!(robot.status().bus_errors, counted);
}

#[test]
fn every_record_can_be_read_in_pieces_from_any_offset() {
    let mut robot = SimRobot::new();
    robot.upload(&fixtures::medley(), amplitude(1.0), false);
    robot.expect_done(walk_for(30));
    robot.run_until(State::Idle);
    let gait = encoded(&fixtures::medley());
    for (record, len) in
        [(Record::Gait, gait.len()), (Record::Calibration, CALIBRATION_LEN), (Record::LastTrial, TRIAL_LEN)]
    {
        let whole = robot.read_record(record);
        assert_eq!(whole.len(), len);
        for offset in 0..len + 2 {
            let reply = robot.ask(Command::Read { record, offset: offset as u16 });
            let Reply::Piece(piece) = reply else { panic!("{reply:?}") };
            let expected = whole.get(offset..).unwrap_or(&[]);
            assert_eq!(piece.as_slice(), &expected[..expected.len().min(64)], "{record:?} from {offset}");
        }
        let Reply::Piece(piece) = robot.ask(Command::Read { record, offset: u16::MAX }) else {
            panic!("none")
        };
        assert!(piece.as_slice().is_empty());
    }
    assert_eq!(robot.read_record(Record::Gait), gait);
}

#[test]
fn a_gait_that_is_not_there_is_refused_and_a_trial_that_is_not_is_empty() {
    let mut robot = SimRobot::new();

    assert_eq!(robot.ask(Command::Read { record: Record::Gait, offset: 0 }), Reply::Refused(Refusal::NoGait));
    assert!(robot.read_record(Record::LastTrial).is_empty());
}

/// Repeats count, too: the host that sends them is there.
#[test]
fn any_command_and_any_repeat_is_a_sign_of_life() {
    let mut robot = SimRobot::new();
    robot.upload(&fixtures::trot(), amplitude(1.0), false);
    let walk = Command::Walk { amplitude: None, frames: None, detached: false, dry_run: false };
    let frame = robot.framed(walk);
    for _ in 0..20 {
        robot.send(&frame);
        assert_eq!(robot.answer(), Reply::Done);
        robot.run_frames(u64::from(LINK_TIMEOUT_FRAMES) / 2);
    }
    assert_eq!(robot.state(), State::Walking);
    for _ in 0..20 {
        assert_eq!(robot.ask(WALK), Reply::Refused(Refusal::AlreadyWalking), "a refusal is one, too");
        robot.run_frames(u64::from(LINK_TIMEOUT_FRAMES) / 2);
    }

    assert_eq!(robot.state(), State::Walking);
    assert!(robot.walk_ends().is_empty());
}
