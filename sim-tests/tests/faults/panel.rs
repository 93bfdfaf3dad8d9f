//! What the light and the output enable show of a fault.

use crate::walking;
use protocol::{Fault, State};
use sim_tests::devices::Chip;
use sim_tests::sim_robot::SimRobot;

/// Frames lit, and changes, over 128 frames: two periods of the slowest pattern.
fn light(robot: &mut SimRobot) -> (usize, usize) {
    let mut lit = Vec::new();
    for _ in 0..128 {
        robot.run_frames(1);
        lit.push(robot.board.is_lit());
    }
    (lit.iter().filter(|&&on| on).count(), lit.windows(2).filter(|pair| pair[0] != pair[1]).count())
}

#[test]
fn the_light_tells_idle_walking_and_fault_apart() {
    let mut robot = SimRobot::new();

    let idle = light(&mut robot);
    let mut robot = walking();
    let on_the_way = light(&mut robot);
    robot.board.chips.unplug(Chip::PowerSensor);
    robot.run_until(State::Fault(Fault::SensorLost));
    let faulted = light(&mut robot);

    // Two winks, eight slow turns, and 32 fast ones, give or take one frame at the ends.
    assert!((7..=9).contains(&idle.0) && (3..=4).contains(&idle.1), "{idle:?}");
    assert!((63..=65).contains(&on_the_way.0) && (7..=8).contains(&on_the_way.1), "{on_the_way:?}");
    assert!((63..=65).contains(&faulted.0) && (31..=32).contains(&faulted.1), "{faulted:?}");
}

#[test]
fn the_output_enable_follows_the_servos_and_falls_with_a_fault() {
    let mut robot = SimRobot::new();
    robot.run_frames(5);

    let limp = robot.board.outputs_enabled();
    let mut robot = walking();
    let on_the_way = robot.board.outputs_enabled();
    robot.board.chips.unplug(Chip::PowerSensor);
    robot.run_until(State::Fault(Fault::SensorLost));
    let faulted = robot.board.outputs_enabled();

    assert_eq!((limp, on_the_way, faulted), (false, true, false));
}
