//! What the robot says about a stored amplitude that has changed since.

use protocol::command::Storage;
use protocol::{Command, ResetCause};
use sim_tests::fixtures::{self, amplitude};
use sim_tests::sim_robot::SimRobot;

/// What would be walked after a reset is what was saved, not what was set since.
#[test]
fn an_amplitude_set_after_the_save_is_told_to_be_in_ram_only() {
    let mut robot = SimRobot::new();
    robot.upload(&fixtures::trot(), amplitude(1.0), true);
    robot.run_frames(200);
    assert_eq!(robot.status().storage, Storage::Saved);

    robot.expect_done(Command::SetAmplitude(amplitude(1.0)));
    let unchanged = robot.status().storage;
    robot.expect_done(Command::SetAmplitude(amplitude(2.0)));
    let changed = robot.status().storage;
    let mut robot = robot.reset(ResetCause::External);

    assert_eq!((unchanged, changed), (Storage::Saved, Storage::RamOnly));
    let status = robot.status();
    assert_eq!((status.storage, status.gait.unwrap().amplitude), (Storage::Saved, amplitude(1.0)));
}

#[test]
fn an_amplitude_set_during_the_save_is_not_called_saved_by_its_end() {
    let mut robot = SimRobot::new();
    robot.upload(&fixtures::trot(), amplitude(1.0), true);
    robot.run_frames(2);
    assert_eq!(robot.status().storage, Storage::Saving);

    robot.expect_done(Command::SetAmplitude(amplitude(2.0)));
    robot.run_frames(200);

    assert_eq!(robot.status().storage, Storage::RamOnly);
    let mut robot = robot.power_cycle();
    assert_eq!(robot.status().gait.unwrap().amplitude, amplitude(1.0));
}
