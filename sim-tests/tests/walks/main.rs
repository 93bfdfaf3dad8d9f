//! How walks begin and end, state by state.

mod button;
mod pace;
mod rehearsal;
mod stop;
mod stop_byte;
mod trial;

use sim_tests::fixtures::{self, amplitude};
use sim_tests::sim_robot::SimRobot;

/// Walking the trot at 2.2, some frames into its stride, and telling every frame.
fn walking() -> SimRobot {
    let mut robot = SimRobot::playing(&fixtures::trot(), amplitude(2.2));
    robot.expect_done(protocol::Command::StreamTelemetry { every_frames: 1 });
    robot.run_frames(20);
    robot
}

/// With the trot, at rest.
fn ready() -> SimRobot {
    let mut robot = SimRobot::new();
    robot.upload(&fixtures::trot(), amplitude(2.2), false);
    robot
}
