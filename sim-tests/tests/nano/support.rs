//! A robot on the bench, and what its pulses and its energy are held against.

use host::robot::{LegScale, Robot};
use protocol::{Command, JOINT_COUNT, PROTOCOL_VERSION, Reply, State, Status};
use sim_tests::body::{Bench, Body};
use sim_tests::client::Client;
use sim_tests::devices::servo_driver::{Burst, NOMINAL_OSCILLATOR_HZ};
use sim_tests::firmware_image::FirmwareImage;
use sim_tests::fixtures::Gait;
use sim_tests::virtual_robot::{Truth, VirtualRobot};

/// Half a count of rounding, and what the protocol proves of its setpoints.
pub const HALF_COUNT: f64 = 0.5;
pub const SETPOINT_ERROR_DEG: f64 = 0.05;
/// The firmware's default calibration: 5/3 counts a degree about 330.
pub const COUNTS_PER_DEG: f64 = 5.0 / 3.0;
pub const NEUTRAL_COUNTS: f64 = 330.0;

pub fn image() -> FirmwareImage {
    FirmwareImage::load(&FirmwareImage::default_path()).unwrap_or_else(|error| panic!("{error}"))
}

pub fn robot_with(body: Box<dyn Body>) -> VirtualRobot {
    let ant = Robot::ant(LegScale::LONG).unwrap();
    VirtualRobot::with_body(&image(), &ant, body, NOMINAL_OSCILLATOR_HZ).unwrap()
}

/// Powered on and done with starting up.
pub fn started(body: Box<dyn Body>) -> (VirtualRobot, Client) {
    let mut robot = robot_with(body);
    let mut client = Client::new();
    client.run_for(&mut robot, 0.3).unwrap();
    (robot, client)
}

/// Servos in a vice: the fastest body.
pub fn on_the_bench() -> (VirtualRobot, Client) {
    started(Box::new(Bench::new(0.1)))
}

pub fn hello() -> Command {
    Command::Hello { protocol_version: PROTOCOL_VERSION }
}

pub fn status(robot: &mut VirtualRobot, client: &mut Client) -> Status {
    match client.ask(robot, Command::Status).unwrap() {
        Reply::Status(status) => status,
        other => panic!("{other:?}"),
    }
}

/// Runs until the robot is in this state, for at most `patience_s`.
pub fn wait_for(robot: &mut VirtualRobot, client: &mut Client, state: State, patience_s: f64) {
    let deadline_s = robot.now_s() + patience_s;
    while status(robot, client).state != state {
        assert!(robot.now_s() < deadline_s, "still {:?}, not {state:?}", status(robot, client).state);
        client.run_for(robot, 0.02).unwrap();
    }
}

/// Bursts that set all eight servos, between two moments.
pub fn walking_bursts(bursts: &[Burst]) -> Vec<&Burst> {
    bursts.iter().filter(|burst| burst.counts[..JOINT_COUNT].iter().all(Option::is_some)).collect()
}

/// Largest difference between a burst and the gait at its best phase, beyond
/// what rounding to a count allows; in degrees.
pub fn excess_deg(gait: &Gait, amplitude: f64, phase: f64, burst: &Burst) -> f64 {
    (0..JOINT_COUNT)
        .map(|joint| {
            let counts = f64::from(burst.counts[joint].unwrap());
            let expected = NEUTRAL_COUNTS + COUNTS_PER_DEG * gait.angle_deg(joint, phase, amplitude);
            ((counts - expected).abs() - HALF_COUNT) / COUNTS_PER_DEG
        })
        .fold(f64::MIN, f64::max)
}

/// True energy at a moment, between the samples around it.
pub fn energy_at(truth: &[Truth], time_s: f64) -> f64 {
    let after = truth.partition_point(|sample| sample.time_s < time_s).clamp(1, truth.len() - 1);
    let (a, b) = (&truth[after - 1], &truth[after]);
    a.true_energy_j + (b.true_energy_j - a.true_energy_j) * (time_s - a.time_s) / (b.time_s - a.time_s)
}
