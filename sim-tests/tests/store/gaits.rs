//! Several gaits in one robot: kept, listed, chosen, erased.

use firmware::store::{GAIT_PLACE_LEN, START_PLACE};
use protocol::command::{Record, Storage};
use protocol::{Command, GAIT_SLOTS, Name, Refusal, Reply, ResetCause, State};
use sim_tests::fixtures::{self, Gait, amplitude};
use sim_tests::sim_robot::ask::WALK;
use sim_tests::sim_robot::pulses::{SLOW_STEP_COUNTS, largest_step};
use sim_tests::sim_robot::{SimRobot, encoded};

fn named(name: &'static str) -> Gait {
    Gait { name, ..fixtures::trot() }
}

/// Keeps the trot under these names, at 1.0, 1.5, 2.0.
fn keeping(names: &[&'static str]) -> SimRobot {
    let mut robot = SimRobot::new();
    for (name, value) in names.iter().zip([1.0, 1.5, 2.0]) {
        robot.keep(&named(name), amplitude(value));
    }
    robot
}

/// Name, amplitude, and whether the robot starts with it, of every place.
fn list(robot: &mut SimRobot) -> Vec<Option<(String, f64, bool)>> {
    (0..GAIT_SLOTS)
        .map(|slot| robot.stored_gait(slot))
        .map(|stored| stored.map(|s| (s.name.as_str().to_owned(), s.amplitude.value(), s.at_start)))
        .collect()
}

fn entry(name: &str, value: f64, at_start: bool) -> Option<(String, f64, bool)> {
    Some((name.to_owned(), value, at_start))
}

fn active(robot: &mut SimRobot) -> String {
    robot.status().gait.map_or(String::new(), |gait| gait.name.as_str().to_owned())
}

#[test]
fn an_empty_robot_lists_empty_places_and_no_more_than_there_are() {
    let mut robot = SimRobot::new();

    assert_eq!(list(&mut robot), [None, None, None]);
    for slot in [GAIT_SLOTS, u8::MAX] {
        assert_eq!(robot.ask(Command::StoredGait { slot }), Reply::Refused(Refusal::NoSuchGait));
    }
}

#[test]
fn three_gaits_are_kept_by_name_and_the_last_one_uploaded_is_the_first_one_walked() {
    let robot = keeping(&["a", "b", "c"]);

    let mut robot = robot.power_cycle();

    assert_eq!(list(&mut robot), [entry("a", 1.0, false), entry("b", 1.5, false), entry("c", 2.0, true)]);
    assert_eq!(active(&mut robot), "c");
    assert_eq!(robot.status().storage, Storage::Saved);
}

#[test]
fn a_name_of_16_characters_is_kept_whole() {
    let mut robot = SimRobot::new();
    robot.keep(&named("sixteen letters!"), amplitude(1.0));

    assert_eq!(robot.stored_gait(0).unwrap().name, Name::new("sixteen letters!").unwrap());
}

#[test]
fn a_selected_gait_is_active_at_once_and_after_every_start() {
    let mut robot = keeping(&["a", "b", "c"]);
    for (slot, name, value) in [(0, "a", 1.0), (1, "b", 1.5), (2, "c", 2.0), (0, "a", 1.0)] {
        robot.expect_done(Command::SelectGait { slot });

        let status = robot.status();
        let gait = status.gait.unwrap();
        assert_eq!(
            (gait.name.as_str(), gait.amplitude, status.storage),
            (name, amplitude(value), Storage::Saved)
        );
        assert_eq!(robot.read_record(Record::Gait), encoded(&named(name)));
        robot.run_frames(3);
        robot = robot.reset(ResetCause::External);
        assert_eq!(active(&mut robot), name);
        let starts: Vec<bool> =
            list(&mut robot).into_iter().flatten().map(|(_, _, at_start)| at_start).collect();
        assert_eq!(starts.iter().position(|at_start| *at_start), Some(usize::from(slot)));
    }
}

#[test]
fn an_empty_place_or_none_at_all_cannot_be_selected_and_nothing_changes() {
    let mut robot = keeping(&["a", "b"]);
    for slot in [2, GAIT_SLOTS, u8::MAX] {
        assert_eq!(robot.ask(Command::SelectGait { slot }), Reply::Refused(Refusal::NoSuchGait));
        assert_eq!(robot.ask(Command::EraseGait { slot }), Reply::Refused(Refusal::NoSuchGait));
    }

    assert_eq!(active(&mut robot), "b");
    assert_eq!(list(&mut robot.power_cycle()), [entry("a", 1.0, false), entry("b", 1.5, true), None]);
}

#[test]
fn a_gait_selected_while_walking_is_entered_slowly() {
    let mut robot = SimRobot::new();
    robot.keep(&fixtures::medley(), amplitude(2.0));
    robot.keep(&named("a"), amplitude(1.0));
    robot.expect_done(WALK);
    robot.run_until(State::Walking);
    robot.run_frames(30);

    robot.expect_done(Command::SelectGait { slot: 0 });
    let state = robot.state();
    robot.run_frames(2);
    robot.take_pulses();
    robot.run_until(State::Walking);

    assert_eq!(state, State::Entering);
    assert!(largest_step(&robot.take_pulses()) <= SLOW_STEP_COUNTS);
    assert_eq!(active(&mut robot), "medley");
}

#[test]
fn an_erased_gait_is_gone_and_the_active_one_stays_until_the_next_start() {
    let mut robot = keeping(&["a", "b", "c"]);

    robot.expect_done(Command::EraseGait { slot: 2 });
    robot.run_frames(1);

    assert_eq!(list(&mut robot), [entry("a", 1.0, false), entry("b", 1.5, false), None]);
    let status = robot.status();
    assert_eq!((status.gait.unwrap().name.as_str(), status.storage), ("c", Storage::RamOnly));
    let mut robot = robot.power_cycle();
    assert_eq!(active(&mut robot), "a", "the next one in turn, for the start's own place is empty");
}

#[test]
fn erasing_another_gait_leaves_the_active_one_saved() {
    let mut robot = keeping(&["a", "b", "c"]);

    robot.expect_done(Command::EraseGait { slot: 0 });
    robot.run_frames(1);

    assert_eq!(robot.status().storage, Storage::Saved);
    assert_eq!(list(&mut robot), [None, entry("b", 1.5, false), entry("c", 2.0, true)]);
}

#[test]
fn all_gaits_erased_leave_a_robot_that_starts_without_one() {
    let mut robot = keeping(&["a", "b", "c"]);
    for slot in 0..GAIT_SLOTS {
        assert_eq!(robot.ask_patiently(Command::EraseGait { slot }), Reply::Done);
    }

    let mut robot = robot.power_cycle();

    assert_eq!(robot.ask(WALK), Reply::Refused(Refusal::NoGait));
    assert_eq!(robot.status().gait, None);
    assert_eq!(robot.ask(Command::Read { record: Record::Gait, offset: 0 }), Reply::Refused(Refusal::NoGait));
}

/// Whatever its name: a gait that is replaced needs a place beside it until it is whole.
#[test]
fn a_full_robot_refuses_to_keep_another_gait_and_nothing_changes() {
    for name in ["d", "a"] {
        let mut robot = keeping(&["a", "b", "c"]);
        let before = *robot.board.memory();

        robot.send_pieces(&encoded(&named(name)));
        let full = robot.ask(Command::UploadCommit { amplitude: amplitude(3.0), persist: true });
        robot.run_frames(90);

        assert_eq!(full, Reply::Refused(Refusal::StorageFull));
        assert_eq!(*robot.board.memory(), before);
        let status = robot.status();
        assert_eq!((status.gait.unwrap().name.as_str(), status.storage), ("c", Storage::Saved));
        // The table is still there: it can be walked without being kept,
        robot.expect_done(Command::UploadCommit { amplitude: amplitude(3.0), persist: false });
        assert_eq!(active(&mut robot), name);
        // or kept once there is room.
        robot.expect_done(Command::EraseGait { slot: 0 });
        robot.run_frames(1);
        robot.keep(&named(name), amplitude(3.0));
        assert_eq!(list(&mut robot)[0], entry(name, 3.0, true));
    }
}

#[test]
fn a_gait_of_the_same_name_is_replaced_only_once_the_new_one_is_whole() {
    let mut robot = keeping(&["a", "b"]);
    let newer = Gait { name: "a", ..fixtures::medley() };

    robot.upload(&newer, amplitude(3.0), true);
    robot.run_frames(30);
    let mut interrupted = SimRobot::new();
    interrupted.board.memory_mut().copy_from_slice(robot.board.memory());
    let mut interrupted = interrupted.power_cycle();
    robot.run_frames(60);

    assert_eq!(list(&mut interrupted), [entry("a", 1.0, false), entry("b", 1.5, true), None]);
    assert_eq!(list(&mut robot), [None, entry("b", 1.5, false), entry("a", 3.0, true)]);
    assert_eq!(robot.power_cycle().read_record(Record::Gait), encoded(&newer));
}

#[test]
fn requests_about_stored_gaits_wait_for_a_save_under_way() {
    let mut robot = keeping(&["a"]);
    robot.upload(&named("b"), amplitude(1.0), true);
    let busy = Reply::Refused(Refusal::StorageBusy);

    assert_eq!(robot.ask(Command::StoredGait { slot: 0 }), busy);
    assert_eq!(robot.ask(Command::SelectGait { slot: 0 }), busy);
    assert_eq!(robot.ask(Command::EraseGait { slot: 0 }), busy);
    robot.run_frames(90);

    assert_eq!(list(&mut robot), [entry("a", 1.0, false), entry("b", 1.0, true), None]);
}

/// Read into the same buffer, a stored gait takes the place of what had been sent.
#[test]
fn a_selection_forgets_the_table_that_had_been_sent() {
    let mut robot = keeping(&["a", "b"]);
    robot.send_pieces(&encoded(&fixtures::medley()));

    robot.expect_done(Command::SelectGait { slot: 0 });
    let commit = robot.ask(Command::UploadCommit { amplitude: amplitude(1.0), persist: false });

    assert_eq!(commit, Reply::Refused(Refusal::UploadIncomplete));
    assert_eq!(active(&mut robot), "a");
}

#[test]
fn a_gait_that_rotted_is_not_selected_and_can_be_erased() {
    let mut robot = keeping(&["a", "b"]);
    robot.board.memory_mut()[100] ^= 1;

    assert_eq!(robot.ask(Command::SelectGait { slot: 0 }), Reply::Refused(Refusal::NoSuchGait));
    assert_eq!(active(&mut robot), "b");
    robot.expect_done(Command::EraseGait { slot: 0 });
    robot.run_frames(1);
    assert_eq!(list(&mut robot), [None, entry("b", 1.5, true), None]);
}

/// Only an erasure frees a place, so a place must not look free that is not.
#[test]
fn what_is_listed_as_empty_is_free() {
    for offset in 1..5 {
        let mut robot = keeping(&["a", "b", "c"]);
        robot.board.memory_mut()[usize::from(GAIT_PLACE_LEN) + offset] ^= 0xF0;
        let empty = robot.stored_gait(1).is_none();

        robot.send_pieces(&encoded(&named("d")));
        let kept = robot.ask(Command::UploadCommit { amplitude: amplitude(1.0), persist: true });

        assert_eq!(kept == Reply::Done, empty, "byte {offset}");
    }
}

#[test]
fn a_rotten_start_byte_gives_way_to_the_one_before() {
    let mut robot = keeping(&["a", "b", "c"]);
    robot.expect_done(Command::SelectGait { slot: 0 });
    robot.run_frames(3);
    robot.board.memory_mut()[usize::from(START_PLACE)] ^= 0x81;

    let mut robot = robot.power_cycle();

    assert_eq!(active(&mut robot), "c");
    assert_eq!(list(&mut robot)[2], entry("c", 2.0, true));
}
