//! The trial that is kept.

use crate::{ready, walking};
use firmware::store::TRIAL_PLACE;
use protocol::frame::STOP_BYTE;
use protocol::gait::GaitTable;
use protocol::{
    Amplitude, Command, Fault, JOINT_COUNT, Refusal, Reply, ResetCause, State, TrialRecord, WalkEnd,
};
use sim_tests::devices::Chip;
use sim_tests::fixtures::{self, amplitude};
use sim_tests::sim_robot::ask::{ATTACHED_WALK, WALK, rehearse_for, setpoints, walk_for};
use sim_tests::sim_robot::{SimRobot, encoded};

/// 27 bytes at 3.4 ms, and the walk's own last frames.
const SAVE_FRAMES: u64 = 12;

/// The trial kept, before and after the power was off.
fn kept(mut robot: SimRobot) -> Option<TrialRecord> {
    robot.run_frames(SAVE_FRAMES);
    let before = robot.last_trial();
    let after = robot.power_cycle().last_trial();
    assert_eq!(before, after);
    after
}

#[test]
fn a_robot_that_never_walked_has_none() {
    assert_eq!(kept(SimRobot::new()), None);
}

#[test]
fn a_finished_walk_is_kept_whole() {
    let mut robot = ready();
    robot.board.set_supply(4.992, 0.4);
    robot.expect_done(Command::StreamTelemetry { every_frames: 1 });
    robot.expect_done(walk_for(200));
    robot.run_until(State::Holding);
    robot.run_frames(3);
    let told = robot.telemetry().last().unwrap();

    let trial = kept(robot).unwrap();

    let expected = TrialRecord {
        frames: 200,
        energy_uj: told.trial_energy_uj,
        clipped_frames: told.clipped_frames,
        missed_samples: 0,
        gait_crc32: GaitTable::crc32_of(&encoded(&fixtures::trot())),
        amplitude: amplitude(2.2),
        end: WalkEnd::Finished,
    };
    assert_eq!(trial, expected);
    assert!(trial.energy_uj > 6_000_000);
}

#[test]
fn every_end_of_a_walk_is_kept_with_its_reason() {
    let lost = {
        let mut robot = ready();
        robot.expect_done(ATTACHED_WALK);
        while robot.state() != State::Walking {
            robot.status();
        }
        robot.run_frames(70);
        robot
    };
    let asked = {
        let mut robot = walking();
        robot.expect_done(Command::Stop);
        robot
    };
    let stopped = {
        let mut robot = walking();
        robot.send(&[STOP_BYTE]);
        robot
    };
    let pressed = {
        let mut robot = walking();
        robot.board.is_button_down = true;
        robot
    };
    let broken = {
        let mut robot = walking();
        robot.board.chips.unplug(Chip::PowerSensor);
        robot.run_until(State::Fault(Fault::SensorLost));
        robot
    };
    let sagged = {
        let mut robot = walking();
        robot.board.set_supply(4.0, 1.0);
        robot.run_until(State::Fault(Fault::Undervoltage));
        robot
    };
    for (robot, end) in [
        (lost, WalkEnd::LinkLost),
        (asked, WalkEnd::Asked),
        (stopped, WalkEnd::StopByte),
        (pressed, WalkEnd::Button),
        (broken, WalkEnd::Fault(Fault::SensorLost)),
        (sagged, WalkEnd::Fault(Fault::Undervoltage)),
    ] {
        let trial = kept(robot).unwrap_or_else(|| panic!("none after {end:?}"));
        assert_eq!(trial.end, end);
        assert!(trial.frames > 10, "{trial:?}");
    }
}

#[test]
fn a_stream_is_kept_without_a_gaits_identity() {
    let mut robot = ready();
    robot.expect_done(Command::Stream);
    robot.ask(setpoints(&[[0.0; JOINT_COUNT]; 3]));
    robot.run_frames(20);
    robot.run_until(State::Holding);

    let trial = kept(robot).unwrap();

    assert_eq!((trial.frames, trial.gait_crc32, trial.end), (3, 0, WalkEnd::StreamDry));
}

#[test]
fn the_amplitude_is_the_one_at_the_end() {
    let mut robot = walking();
    robot.expect_done(Command::SetAmplitude(Amplitude::ONE));
    robot.run_frames(200);
    robot.expect_done(Command::Stop);

    assert_eq!(kept(robot).unwrap().amplitude, Amplitude::ONE);
}

#[test]
fn a_rehearsal_and_a_walk_of_no_frames_leave_the_one_before() {
    for walk in [rehearse_for(30), walk_for(0)] {
        let mut robot = ready();
        robot.expect_done(walk_for(50));
        robot.run_until(State::Idle);
        robot.expect_done(walk);
        robot.run_until(State::Idle);

        let trial = kept(robot).unwrap();

        assert_eq!(trial.frames, 50, "{walk:?}");
    }
}

#[test]
fn only_the_last_one_is_kept() {
    let mut robot = ready();
    for frames in [30, 40, 50] {
        robot.expect_done(walk_for(frames));
        robot.run_until(State::Idle);
    }

    assert_eq!(kept(robot).unwrap().frames, 50);
}

#[test]
fn a_walk_asked_for_during_the_save_is_walked_and_then_kept_itself() {
    for frames_after in 0..SAVE_FRAMES {
        let mut robot = ready();
        robot.expect_done(walk_for(50));
        robot.run_until(State::Stopping);
        robot.run_frames(frames_after);

        robot.expect_done(walk_for(70));
        robot.run_until(State::Walking);
        robot.run_until(State::Idle);

        assert_eq!(kept(robot).unwrap().frames, 70);
    }
}

#[test]
fn it_waits_for_a_gait_that_is_being_saved_and_its_reader_is_told_to_wait() {
    let mut robot = SimRobot::new();
    robot.upload(&fixtures::trot(), amplitude(1.0), false);
    robot.expect_done(walk_for(1));
    robot.run_frames(30);
    robot.upload(&fixtures::trot(), amplitude(1.0), true);
    robot.run_until(State::Holding);
    robot.run_frames(3);

    let early = robot.ask(Command::Read { record: protocol::command::Record::LastTrial, offset: 0 });
    robot.run_frames(90);

    assert_eq!(early, Reply::Refused(Refusal::StorageBusy));
    assert_eq!(robot.status().storage, protocol::command::Storage::Saved);
    assert_eq!(kept(robot).unwrap().frames, 1);
}

#[test]
fn a_rotten_one_is_none() {
    for offset in 1..26 {
        let mut robot = ready();
        robot.expect_done(walk_for(50));
        robot.run_until(State::Idle);
        robot.board.memory_mut()[usize::from(TRIAL_PLACE) + offset] ^= 0x20;

        assert_eq!(robot.last_trial(), None, "byte {offset}");
    }
}

#[test]
fn a_reset_in_mid_walk_leaves_the_one_before() {
    let mut robot = ready();
    robot.expect_done(walk_for(50));
    robot.run_until(State::Idle);
    robot.expect_done(WALK);
    robot.run_until(State::Walking);
    robot.run_frames(100);

    let mut robot = robot.reset(ResetCause::External);

    assert_eq!(robot.last_trial().unwrap().frames, 50);
}
