//! Setpoints from the host, a pose a frame.

mod buffer;
mod motion;

use protocol::{Command, JOINT_COUNT, Refusal, Reply, STREAM_CAPACITY};
use sim_tests::fixtures::{self, amplitude};
use sim_tests::sim_robot::ask::setpoints;
use sim_tests::sim_robot::pulses::{error_from, servos_on};
use sim_tests::sim_robot::{Pulses, SimRobot};

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
