//! What the firmware asks of its chips, and whether the data sheets allow it.

use super::support::*;
use host::robot::{LegScale, Robot};
use protocol::{Command, State};
use sim_tests::body::Bench;
use sim_tests::client::Client;
use sim_tests::devices::servo_driver::{NOMINAL_OSCILLATOR_HZ, OSCILLATOR_SPREAD_HZ};
use sim_tests::fixtures::{self, amplitude};
use sim_tests::nano::{CLOCK_HZ, OutputEnable};
use sim_tests::virtual_robot::VirtualRobot;

fn walk(robot: &mut VirtualRobot, client: &mut Client) {
    client.upload(robot, &fixtures::trot().table(), amplitude(1.0), true).unwrap();
    client
        .expect_done(robot, Command::Walk { amplitude: None, frames: None, detached: true, dry_run: false })
        .unwrap();
    wait_for(robot, client, State::Walking, 5.0);
}

/// Cold start, walk, reset in mid-walk with the servo driver awake and pulsing,
/// a hung program, and the walk's orderly end.
#[test]
fn the_servo_driver_is_never_asked_for_what_its_data_sheet_forbids() {
    let (mut robot, mut client) = on_the_bench();
    walk(&mut robot, &mut client);
    robot.nano_mut().reset(CLOCK_HZ);
    let mut client = Client::new();
    client.run_for(&mut robot, 1.5).unwrap();
    walk(&mut robot, &mut client);
    assert!(robot.nano_mut().hang());
    let mut client = Client::new();
    client.run_for(&mut robot, 0.5).unwrap();
    client.expect_done(&mut robot, Command::ClearFault).unwrap();
    walk(&mut robot, &mut client);
    client.expect_done(&mut robot, Command::Stop).unwrap();
    client.run_for(&mut robot, 3.0).unwrap();

    let bus = robot.nano().bus();

    assert_eq!(bus.servo_driver.misuses(), []);
    assert!(!bus.servo_driver.drives_any());
}

/// The first frame's burst, before which no frame was computed, once wrote zeros
/// over the configuration: who walked from before it on stopped as the chip's loss.
#[test]
fn a_nudge_in_the_first_moments_finds_the_servo_driver_as_it_was_configured() {
    let mut robot = robot_with(Box::new(Bench::new(0.1)));
    let mut client = Client::new();
    client.run_for(&mut robot, 0.005).unwrap();

    client.expect_done(&mut robot, Command::Nudge { channel: 3, counts: 330 }).unwrap();
    assert!(robot.now_s() < 1.0 / 60.0, "too late to tell: {} s", robot.now_s());
    client.run_for(&mut robot, 0.5).unwrap();

    assert_eq!(status(&mut robot, &mut client).state, State::Holding);
}

/// What a calibration of the board's oscillator has to make up for.
#[test]
fn an_uncalibrated_oscillator_stretches_every_pulse_by_its_own_error() {
    for oscillator_hz in OSCILLATOR_SPREAD_HZ {
        let ant = Robot::ant(LegScale::LONG).unwrap();
        let body = Box::new(Bench::new(0.1));
        let mut robot = VirtualRobot::with_body(&image(), &ant, body, oscillator_hz).unwrap();
        let mut client = Client::new();
        client.run_for(&mut robot, 0.3).unwrap();
        walk(&mut robot, &mut client);

        let now_s = robot.now_s();
        let mut bus = robot.nano_mut().bus_mut();
        let pulse_us = bus.servo_driver.pulses_us(now_s)[0].unwrap();
        let counts = f64::from(bus.servo_driver.counts()[0].unwrap());

        // 102 periods a count; a frame may lie between registers and pins.
        let stretch = pulse_us / (counts * 4.08);
        assert!((stretch - NOMINAL_OSCILLATOR_HZ / oscillator_hz).abs() < 0.01, "{oscillator_hz}: {stretch}");
    }
}

/// The two pins that a person may wire: OE low only while servos are on, and the button heard.
#[test]
fn the_output_enable_on_d4_follows_the_servos_and_the_button_on_d2_stops_them() {
    let (mut robot, mut client) = on_the_bench();
    robot.nano_mut().wire_output_enable(OutputEnable::PulledUp);
    let limp = robot.nano().bus().servo_driver.is_enabled();
    walk(&mut robot, &mut client);
    client.run_for(&mut robot, 0.1).unwrap();
    let walking = robot.nano().bus().servo_driver.is_enabled();

    robot.nano_mut().press_button(true);
    client.run_for(&mut robot, 0.2).unwrap();
    let pressed = status(&mut robot, &mut client).state;
    client.run_for(&mut robot, 2.0).unwrap();

    assert_eq!((limp, walking), (false, true));
    assert_eq!(pressed, State::Holding);
    assert!(!robot.nano().bus().servo_driver.is_enabled());
}
