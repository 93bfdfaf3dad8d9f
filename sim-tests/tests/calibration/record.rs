//! How a calibration is taken, kept and refused.

use crate::{another_build, with_board};
use firmware::store::CALIBRATION_PLACES;
use protocol::calibration::{CALIBRATION_LEN, CalibrationError};
use protocol::command::{CalibrationSource, Record};
use protocol::{Calibration, Command, Refusal, Reply, ResetCause, State};
use sim_tests::fixtures::{self, amplitude};
use sim_tests::sim_robot::SimRobot;
use sim_tests::sim_robot::ask::{WALK, rehearse_for};

#[test]
fn a_new_robot_has_the_authors_and_says_that_it_is_none_of_its_own() {
    let mut robot = SimRobot::new();

    assert_eq!(robot.status().calibration, CalibrationSource::Default);
    assert_eq!(robot.calibration(), Ok(Calibration::authors()));
}

#[test]
fn it_survives_resets_and_power_cycles_and_the_newest_of_many_is_found() {
    let mut robot = SimRobot::new();
    for autostart_s in [1, 2, 3, 4, 5] {
        robot.calibrate(&with_board(|board| board.autostart_s = autostart_s));
        assert_eq!(robot.status().calibration, CalibrationSource::Stored);
        robot = if autostart_s % 2 == 0 { robot.reset(ResetCause::External) } else { robot.power_cycle() };

        assert_eq!(robot.status().calibration, CalibrationSource::Stored);
        assert_eq!(robot.calibration().unwrap().board().autostart_s, autostart_s);
    }
}

#[test]
fn one_cut_off_while_it_was_saved_leaves_the_one_before() {
    for frames in [0, 1, 5, 10] {
        let mut robot = SimRobot::new();
        robot.calibrate(&with_board(|board| board.autostart_s = 1));
        let (_, other) = another_build();
        assert_eq!(robot.send_calibration(&other), Reply::Done);
        assert_eq!(robot.calibration(), Ok(other), "in use at once");
        robot.run_frames(frames);

        let mut robot = robot.power_cycle();

        assert_eq!(robot.calibration().unwrap().board().autostart_s, 1, "{frames} frames");
    }
}

/// Both places are whole when the power goes between the new mark and the old one's end.
#[test]
fn a_rotten_copy_gives_way_to_the_other_and_without_one_to_the_authors() {
    let mut robot = SimRobot::new();
    robot.calibrate(&with_board(|board| board.autostart_s = 1));
    robot.calibrate(&with_board(|board| board.autostart_s = 2));
    // The first copy was given up; here it was not yet.
    robot.board.memory_mut()[usize::from(CALIBRATION_PLACES[0])] = 0xA5;
    for (rotten, expected) in [(0, Some(2)), (1, None)] {
        robot.board.memory_mut()[usize::from(CALIBRATION_PLACES[rotten]) + 40] ^= 4;
        robot = robot.power_cycle();

        let found = robot.calibration().unwrap();

        assert_eq!(
            found,
            expected.map_or(Calibration::authors(), |s| with_board(|board| board.autostart_s = s))
        );
        let source = if expected.is_some() { CalibrationSource::Stored } else { CalibrationSource::Damaged };
        assert_eq!(robot.status().calibration, source);
    }

    // It does not walk as another robot would, until it is told again how it is built.
    robot.upload(&fixtures::trot(), amplitude(1.0), false);
    let damaged = Reply::Refused(Refusal::CalibrationDamaged);
    assert_eq!(robot.ask(WALK), damaged);
    assert_eq!(robot.ask(Command::Stream), damaged);
    robot.calibrate(&Calibration::authors());
    robot.expect_done(WALK);
}

#[test]
fn a_worn_cell_leaves_it_in_use_and_says_that_it_is_not_saved() {
    let mut robot = SimRobot::new();
    robot.board.worn_cell = Some(CALIBRATION_PLACES[0] + 20);

    robot.calibrate(&with_board(|board| board.autostart_s = 9));

    assert_eq!(robot.status().calibration, CalibrationSource::NotSaved);
    assert_eq!(robot.calibration().unwrap().board().autostart_s, 9);
    assert_eq!(robot.power_cycle().status().calibration, CalibrationSource::Default);
}

#[test]
fn it_is_refused_while_servos_are_on_or_a_walk_is_rehearsed() {
    let mut robot = SimRobot::new();
    robot.upload(&fixtures::trot(), amplitude(1.0), false);
    let on = Reply::Refused(Refusal::ServosOn);
    robot.expect_done(Command::Nudge { channel: 0, counts: 330 });
    assert_eq!(robot.send_calibration(&Calibration::authors()), on);
    robot.expect_done(Command::Nudge { channel: 0, counts: 0 });
    for walk in [WALK, rehearse_for(500)] {
        robot.expect_done(walk);
        assert_eq!(robot.send_calibration(&Calibration::authors()), on);
        robot.run_until(State::Walking);
        assert_eq!(robot.ask(Command::CalibrationCommit), on);
        if walk == WALK {
            robot.expect_done(Command::Stop);
            robot.run_until(State::Holding);
            assert_eq!(robot.ask(Command::CalibrationCommit), on);
        }
        robot.expect_done(Command::Stop);
        robot.run_until(State::Idle);
    }

    robot.expect_done(Command::CalibrationCommit);
}

#[test]
fn it_waits_for_a_save_under_way() {
    let mut robot = SimRobot::new();
    robot.upload(&fixtures::trot(), amplitude(1.0), true);

    let busy = robot.send_calibration(&with_board(|board| board.autostart_s = 9));
    let meanwhile = robot.calibration();
    robot.run_frames(90);

    assert_eq!(busy, Reply::Refused(Refusal::StorageBusy));
    assert_eq!(meanwhile, Ok(Calibration::authors()));
    robot.expect_done(Command::CalibrationCommit);
    assert_eq!(robot.calibration().unwrap().board().autostart_s, 9);
}

#[test]
fn bytes_that_are_none_are_refused_with_what_is_wrong_and_the_old_one_stays() {
    let good = *with_board(|board| board.autostart_s = 9).bytes();
    let damaged = |at: usize, byte: u8| {
        let mut bytes = good.to_vec();
        bytes[at] = byte;
        bytes
    };
    for (bytes, error) in [
        (good[..CALIBRATION_LEN - 1].to_vec(), CalibrationError::Length),
        ([&good[..], &[0]].concat(), CalibrationError::Length),
        (damaged(0, 8), CalibrationError::Channel(0)),
        (damaged(9, 0), CalibrationError::Channel(1)),
        (damaged(9, 0x80), CalibrationError::Channel(1)),
        (damaged(2 * 9 + 6, 0xFF), CalibrationError::Pulse(2)),
        (damaged(7 * 9 + 8, 0xFF), CalibrationError::Pulse(7)),
        (damaged(8 * 9, 3), CalibrationError::Board),
    ] {
        let mut robot = SimRobot::new();
        robot.send_pieces(&bytes);

        let refused = robot.ask(Command::CalibrationCommit);
        robot.run_frames(40);

        assert_eq!(refused, Reply::Refused(Refusal::BadCalibration(error)));
        assert_eq!(robot.calibration(), Ok(Calibration::authors()));
        assert_eq!(robot.status().calibration, CalibrationSource::Default);
    }
    let mut robot = SimRobot::new();
    assert_eq!(robot.ask(Command::CalibrationCommit), Reply::Refused(Refusal::UploadIncomplete));
}

#[test]
fn a_gait_is_no_calibration_and_a_calibration_no_gait() {
    let mut robot = SimRobot::new();
    robot.send_pieces(Calibration::authors().bytes());
    let commit = Command::UploadCommit { amplitude: amplitude(1.0), persist: false };

    assert!(matches!(robot.ask(commit), Reply::Refused(Refusal::BadGait(_))));
    assert_eq!(robot.ask(Command::Read { record: Record::Gait, offset: 0 }), Reply::Refused(Refusal::NoGait));
    robot.expect_done(Command::CalibrationCommit);
}
