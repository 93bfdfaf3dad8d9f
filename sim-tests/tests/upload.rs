//! Gaits on their way into the robot, and through power cuts.

use firmware::store::{CALIBRATION_PLACES, GAIT_PLACE_LEN, TRIAL_PLACE};
use proptest::prelude::*;
use protocol::command::{CalibrationSource, Storage};
use protocol::gait::{GaitError, MAX_ENCODED_LEN};
use protocol::{Chunk, Command, GAIT_SLOTS, JOINT_COUNT, Refusal, Reply, ResetCause, State};
use sim_tests::fixtures::{self, Gait, amplitude};
use sim_tests::sim_robot::{Pulses, SimRobot, encoded};

const COMMIT: Command = Command::UploadCommit { amplitude: protocol::Amplitude::ONE, persist: false };

/// A noisy cable flips bits that no frame check sees; the table's own does.
#[test]
fn corrupt_upload_is_refused_and_the_old_gait_keeps_playing() {
    let (old, new) = (fixtures::trot(), fixtures::medley());
    let mut undisturbed = SimRobot::playing(&old, amplitude(2.2));
    let mut robot = SimRobot::playing(&old, amplitude(2.2));
    let mut table = encoded(&new);
    table[100] ^= 0x10;
    let before = robot.status().gait;

    let start = robot.board.frames();
    robot.take_pulses();
    robot.send_pieces(&table);
    let reply = robot.ask(COMMIT);
    robot.run_frames(100);
    let took = robot.board.frames() - start;

    assert_eq!(reply, Reply::Refused(Refusal::BadGait(GaitError::Crc)));
    assert_eq!(robot.status().gait, before);
    assert_eq!(robot.state(), State::Walking);
    assert_same_course(&robot.take_pulses(), &undisturbed.pulses_over(took));
}

/// Two robots that were asked things in different frames: compares their
/// pulses from equal poses on.
fn assert_same_course(with: &[Pulses], without: &[Pulses]) {
    let start = with.iter().position(|pulses| *pulses == without[5]).expect("the same gait");
    let len = with.len().min(without.len()) - start.max(5);
    assert!(len > 60, "{len} frames to compare");
    assert_eq!(with[start..][..len], without[5..][..len]);
}

#[test]
fn an_upload_is_active_at_once_and_reads_back() {
    let gait = fixtures::medley();
    let mut robot = SimRobot::new();

    robot.upload(&gait, amplitude(2.2), false);

    let status = robot.status();
    let active = status.gait.unwrap();
    assert_eq!((active.name.as_str(), active.amplitude), ("medley", amplitude(2.2)));
    assert_eq!(status.storage, Storage::RamOnly);
    assert_eq!(read_back(&mut robot), encoded(&gait));
}

fn read_back(robot: &mut SimRobot) -> Vec<u8> {
    let mut bytes = Vec::new();
    loop {
        match robot.ask(Command::Read { record: protocol::command::Record::Gait, offset: bytes.len() as u16 })
        {
            Reply::Piece(chunk) if chunk.as_slice().is_empty() => return bytes,
            Reply::Piece(chunk) => bytes.extend_from_slice(chunk.as_slice()),
            other => panic!("a piece of the gait was asked for, not {other:?}"),
        }
    }
}

#[test]
fn pieces_may_overlap_and_come_twice() {
    let table = encoded(&fixtures::trot());
    let mut robot = SimRobot::new();
    robot.expect_done(Command::UploadBegin { len: table.len() as u16 });

    for (index, piece) in table.chunks(50).enumerate() {
        let offset = (index * 50) as u16;
        robot.expect_done(Command::UploadChunk { offset, data: Chunk::of(piece) });
        robot.expect_done(Command::UploadChunk { offset: 10, data: Chunk::of(&table[10..50]) });
    }

    robot.expect_done(COMMIT);
}

#[test]
fn pieces_outside_the_announced_table_are_refused() {
    let mut robot = SimRobot::new();
    let range = Reply::Refused(Refusal::UploadRange);
    let piece = |offset| Command::UploadChunk { offset, data: Chunk::of(&[1; 64]) };

    assert_eq!(robot.ask(piece(0)), range, "nothing announced");
    assert_eq!(robot.ask(Command::UploadBegin { len: 0 }), range);
    assert_eq!(robot.ask(Command::UploadBegin { len: MAX_ENCODED_LEN as u16 + 1 }), range);
    robot.expect_done(Command::UploadBegin { len: 100 });
    robot.expect_done(piece(0));
    assert_eq!(robot.ask(piece(37)), range);
    assert_eq!(robot.ask(piece(u16::MAX)), range);
    robot.expect_done(piece(36));
}

#[test]
fn a_piece_that_leaves_a_gap_is_refused_and_the_table_may_be_completed() {
    let table = encoded(&fixtures::trot());
    let piece = |offset: usize| {
        let end = table.len().min(offset + 64);
        Command::UploadChunk { offset: offset as u16, data: Chunk::of(&table[offset..end]) }
    };
    let mut robot = SimRobot::new();
    robot.expect_done(Command::UploadBegin { len: table.len() as u16 });
    robot.expect_done(piece(0));

    assert_eq!(robot.ask(piece(65)), Reply::Refused(Refusal::UploadRange));
    assert_eq!(robot.ask(COMMIT), Reply::Refused(Refusal::UploadIncomplete));
    for offset in [64, 128, 192, 256].into_iter().filter(|offset| *offset < table.len()) {
        robot.expect_done(piece(offset));
    }
    robot.expect_done(COMMIT);
    assert_eq!(robot.ask(COMMIT), Reply::Refused(Refusal::UploadIncomplete), "one table, one commit");
}

#[test]
fn a_saved_gait_survives_a_power_cycle_and_one_in_ram_does_not() {
    let mut robot = SimRobot::new();
    robot.upload(&fixtures::trot(), amplitude(2.2), true);
    let saving = robot.status().storage;
    robot.run_frames(90);
    let saved = robot.status();
    robot.upload(&fixtures::medley(), amplitude(1.0), false);

    let mut robot = robot.power_cycle();

    assert_eq!((saving, saved.storage), (Storage::Saving, Storage::Saved), "within 1.5 s");
    assert_eq!(robot.status().gait, saved.gait);
    assert_eq!(robot.status().storage, Storage::Saved);
    assert_eq!(read_back(&mut robot), encoded(&fixtures::trot()));
}

#[test]
fn a_power_cut_at_any_moment_of_a_save_leaves_the_old_or_the_new_gait_whole() {
    let (old, new) = (fixtures::trot(), fixtures::medley());
    // In the slot that the new one takes: bytes that are right already are not written.
    let older =
        Gait::of("older", 3.3, [-7.3; JOINT_COUNT], |joint, phase| 9.1 * (7.0 * phase - joint as f64).cos());
    let mut found = [0, 0];
    for cut_after_frames in 0..75 {
        let mut robot = SimRobot::new();
        robot.upload(&older, amplitude(0.5), true);
        robot.run_frames(80);
        robot.upload(&old, amplitude(1.0), true);
        robot.run_frames(80);
        robot.upload(&new, amplitude(2.2), true);
        robot.run_frames(cut_after_frames);

        let mut robot = robot.power_cycle();

        let active = robot.status().gait.expect("a gait after every cut");
        let read = read_back(&mut robot);
        if read == encoded(&old) {
            assert_eq!(active.amplitude, amplitude(1.0));
            found[0] += 1;
        } else {
            assert_eq!((read, active.amplitude), (encoded(&new), amplitude(2.2)));
            found[1] += 1;
        }
    }
    assert!(found[0] > 10 && found[1] > 0, "{found:?} old and new");
}

#[test]
fn saving_goes_on_while_walking_and_moves_no_pulse() {
    let walk = |saves: bool| {
        let mut robot = SimRobot::playing(&fixtures::trot(), amplitude(2.2));
        robot.upload(&fixtures::trot(), amplitude(2.2), saves);
        robot.run_until(State::Walking);
        robot
    };
    let (mut undisturbed, mut robot) = (walk(false), walk(true));
    assert_eq!(robot.status().storage, Storage::Saving);

    let (with, without) = (robot.pulses_over(80), undisturbed.pulses_over(80));

    assert_same_course(&with, &without);
    assert_eq!(robot.status().storage, Storage::Saved);
}

#[test]
fn a_worn_memory_cell_is_reported_and_the_gait_saved_before_stays() {
    // In the second slot, where the next save goes: in its table, and its mark.
    for worn_cell in [GAIT_PLACE_LEN + 100, GAIT_PLACE_LEN] {
        let mut robot = SimRobot::new();
        robot.upload(&fixtures::trot(), amplitude(1.0), true);
        robot.run_frames(80);
        robot.board.worn_cell = Some(worn_cell);

        robot.upload(&fixtures::medley(), amplitude(2.0), true);
        robot.run_frames(80);
        let status = robot.status();
        let mut robot = robot.power_cycle();

        assert_eq!(status.storage, Storage::Failed);
        assert_eq!(status.gait.unwrap().name.as_str(), "medley", "in RAM it is active all the same");
        assert_eq!(robot.status().gait.unwrap().name.as_str(), "trot");
    }
}

#[test]
fn a_saved_gait_that_rotted_gives_way_to_the_one_before() {
    // One bit anywhere in the newer slot: generation, amplitude, length, table, CRC.
    for offset in [1, 3, 4, 5, 6, 7, 100, 255, 257] {
        let mut robot = SimRobot::new();
        robot.upload(&fixtures::trot(), amplitude(1.0), true);
        robot.run_frames(80);
        robot.upload(&fixtures::medley(), amplitude(2.0), true);
        robot.run_frames(80);

        robot.board.memory_mut()[usize::from(GAIT_PLACE_LEN) + offset] ^= 0x04;
        let mut robot = robot.power_cycle();

        let active = robot.status().gait.unwrap();
        assert_eq!((active.name.as_str(), active.amplitude), ("trot", amplitude(1.0)), "byte {offset}");
    }
}

#[test]
fn a_table_may_arrive_during_the_save_before_it_and_waits_with_its_commit() {
    let mut robot = SimRobot::new();
    robot.upload(&fixtures::trot(), amplitude(1.0), true);

    robot.send_pieces(&encoded(&fixtures::medley()));
    let busy = robot.ask(COMMIT);
    let active = robot.status().gait.unwrap();
    robot.run_frames(80);

    assert_eq!(busy, Reply::Refused(Refusal::StorageBusy));
    assert_eq!(active.name.as_str(), "trot");
    robot.expect_done(COMMIT);
    assert_eq!(robot.status().gait.unwrap().name.as_str(), "medley");
}

#[test]
fn the_newest_of_many_saves_is_found() {
    let mut robot = SimRobot::new();
    for value in [0.5, 1.0, 1.5, 2.0, 2.5] {
        robot.upload(&fixtures::trot(), amplitude(value), true);
        robot.run_frames(80);
        robot = robot.power_cycle();
        assert_eq!(robot.status().gait.unwrap().amplitude, amplitude(value));
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, rng_seed: proptest::test_runner::RngSeed::Fixed(7), ..ProptestConfig::default() })]

    #[test]
    fn no_memory_contents_stop_the_robot_from_starting(
        bytes in proptest::collection::vec(any::<u8>(), 1024), marks in any::<[bool; 6]>()
    ) {
        let mut robot = SimRobot::new();
        robot.board.memory_mut().copy_from_slice(&bytes);
        let places = (0..u16::from(GAIT_SLOTS)).map(|slot| slot * GAIT_PLACE_LEN);
        for (at, _) in places.chain(CALIBRATION_PLACES).chain([TRIAL_PLACE]).zip(marks).filter(|(_, marked)| *marked) {
            robot.board.memory_mut()[usize::from(at)] = 0xA5;
        }

        let mut robot = robot.reset(ResetCause::External);

        prop_assert!(robot.status().gait.is_none());
        let is_marked = CALIBRATION_PLACES.into_iter().any(|at| robot.board.memory_mut()[usize::from(at)] == 0xA5);
        let source = if is_marked { CalibrationSource::Damaged } else { CalibrationSource::Default };
        prop_assert_eq!(robot.status().calibration, source);
    }
}
