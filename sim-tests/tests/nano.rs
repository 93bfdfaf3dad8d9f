//! The real firmware image on the emulated Nano, with chips, supply and body.
//!
//! A missing image fails every test here, with the next move.

use host::robot::Robot;
use protocol::{Amplitude, Command, Event, Message, PROTOCOL_VERSION, Reply, ResetCause, State};
use sim_tests::body::{Bench, Body};
use sim_tests::client::Client;
use sim_tests::devices::pca9685::NOMINAL_OSCILLATOR_HZ;
use sim_tests::firmware_image::FirmwareImage;
use sim_tests::fixtures;
use sim_tests::nano::{CLOCK_HZ, Counters, seconds};
use sim_tests::virtual_robot::VirtualRobot;

fn image() -> FirmwareImage {
    let path = FirmwareImage::default_path();
    FirmwareImage::load(&path).unwrap_or_else(|error| panic!("{error}"))
}

fn robot_with(body: Box<dyn Body>) -> VirtualRobot {
    let ant = Robot::ant(1.0).unwrap();
    VirtualRobot::with_body(&image(), &ant, body, NOMINAL_OSCILLATOR_HZ).unwrap()
}

/// Powered on and done with starting up.
fn started(body: Box<dyn Body>) -> (VirtualRobot, Client) {
    let mut robot = robot_with(body);
    let mut client = Client::new();
    client.run_for(&mut robot, 0.3).unwrap();
    (robot, client)
}

fn hello() -> Command {
    Command::Hello { protocol_version: PROTOCOL_VERSION }
}

#[test]
fn hello_is_answered_within_wire_time_and_a_frame() {
    let (mut robot, mut client) = started(Box::new(Bench::new(0.1)));

    let asked_at = robot.now();
    let (reply, answered_at) = client.ask_timed(&mut robot, hello()).unwrap();

    let Reply::Hello(hello) = reply else { panic!("{reply:?}") };
    assert_eq!(hello.protocol_version, PROTOCOL_VERSION);
    assert_eq!(hello.reset_cause, ResetCause::PowerOn);
    let took_ms = seconds(answered_at - asked_at) * 1e3;
    println!("hello answered after {took_ms:.2} ms: {hello:?}");
    assert!(took_ms < 17.0 + 5.0, "{took_ms} ms");
    println!("heard: {:?}", client.heard());
}
