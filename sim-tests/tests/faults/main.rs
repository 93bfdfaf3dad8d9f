//! Chips that break, supplies that sag, programs that hang.

mod chips;
mod panel;
mod supply;

use protocol::Command;
use sim_tests::fixtures::{self, amplitude};
use sim_tests::sim_robot::SimRobot;

const WALK: Command = Command::Walk { amplitude: None, frames: None, detached: true, dry_run: false };

fn walking() -> SimRobot {
    let mut robot = SimRobot::playing(&fixtures::trot(), amplitude(2.2));
    robot.run_frames(20);
    robot
}

fn has_limp_servos(robot: &SimRobot) -> bool {
    !robot.board.chips.servo_driver.drives_any()
}
