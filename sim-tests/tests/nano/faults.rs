//! Faults of a robot on the bench: resets, lost chips, a stuck bus. Longer than most
//! files: one test for each fault, on the same bench.

use super::support::*;
use host::robot::{LegScale, Robot};
use protocol::command::Storage;
use protocol::{Command, Event, Fault, Message, Refusal, Reply, ResetCause, State, WalkEnd};
use sim_tests::body::Bench;
use sim_tests::client::Client;
use sim_tests::devices::Chip;
use sim_tests::devices::servo_driver::{Burst, NOMINAL_OSCILLATOR_HZ};
use sim_tests::fixtures::{self, amplitude};
use sim_tests::nano::{CLOCK_HZ, seconds};
use sim_tests::virtual_robot::VirtualRobot;

#[test]
fn a_saved_gait_survives_reset_and_power_cycle_and_one_in_ram_does_not() {
    let (mut robot, mut client) = on_the_bench();
    let (trot, medley) = (fixtures::trot(), fixtures::medley());
    client.upload(&mut robot, &trot.table(), amplitude(1.5), true).unwrap();
    let deadline_s = robot.now_s() + 3.0;
    while status(&mut robot, &mut client).storage != Storage::Saved {
        assert!(robot.now_s() < deadline_s, "{:?}", status(&mut robot, &mut client).storage);
    }
    client.upload(&mut robot, &medley.table(), amplitude(1.0), false).unwrap();
    assert_eq!(status(&mut robot, &mut client).gait.unwrap().name.as_str(), "medley");

    for power_cycle in [false, true] {
        client.forget();
        if power_cycle {
            robot.nano_mut().power_cycle();
        } else {
            robot.nano_mut().reset(CLOCK_HZ);
        }
        client.run_for(&mut robot, 1.5).unwrap();

        let cause = if power_cycle { ResetCause::PowerOn } else { ResetCause::External };
        assert!(client.heard().iter().any(|(_, m)| *m == Message::Event(Event::Started(cause))));
        let status = status(&mut robot, &mut client);
        let gait = status.gait.expect("the saved gait");
        assert_eq!((gait.name.as_str(), gait.amplitude), ("trot", amplitude(1.5)));
        assert_eq!(status.storage, Storage::Saved);
    }
}

#[test]
fn a_reset_in_mid_walk_leaves_the_servos_pulsing_until_the_program_switches_them_off() {
    let (mut robot, mut client) = on_the_bench();
    client.upload(&mut robot, &fixtures::trot().table(), amplitude(1.0), false).unwrap();
    client
        .expect_done(
            &mut robot,
            Command::Walk { amplitude: None, frames: None, detached: true, dry_run: false },
        )
        .unwrap();
    wait_for(&mut robot, &mut client, State::Walking, 5.0);

    robot.nano_mut().reset(CLOCK_HZ);
    robot.run_for(0.9).unwrap();
    assert!(robot.nano().bus().servo_driver.drives_any(), "the chip does not see the reset");
    // And the start-up time that the fuses ask for.
    robot.run_for(0.18).unwrap();

    assert!(!robot.nano().bus().servo_driver.drives_any());
}

#[test]
fn a_brown_out_in_mid_walk_is_told_and_leaves_the_servos_off() {
    let (mut robot, mut client) = on_the_bench();
    client.upload(&mut robot, &fixtures::trot().table(), amplitude(1.0), false).unwrap();
    client
        .expect_done(
            &mut robot,
            Command::Walk { amplitude: None, frames: None, detached: true, dry_run: false },
        )
        .unwrap();
    wait_for(&mut robot, &mut client, State::Walking, 5.0);

    robot.nano_mut().brown_out();
    let mut client = Client::new();
    client.run_for(&mut robot, 0.1).unwrap();

    let started = Message::Event(Event::Started(ResetCause::BrownOut));
    assert!(client.heard().iter().any(|(_, message)| *message == started));
    assert!(!robot.nano().bus().servo_driver.drives_any());
    assert_eq!(status(&mut robot, &mut client).state, State::Idle);
}

#[test]
fn a_lost_sensor_stops_the_walk_and_the_fault_is_told() {
    let (mut robot, mut client) = on_the_bench();
    client.upload(&mut robot, &fixtures::trot().table(), amplitude(1.0), false).unwrap();
    client
        .expect_done(
            &mut robot,
            Command::Walk { amplitude: None, frames: None, detached: true, dry_run: false },
        )
        .unwrap();
    wait_for(&mut robot, &mut client, State::Walking, 5.0);

    robot.nano_mut().bus_mut().unplug(Chip::PowerSensor);
    client.run_for(&mut robot, 2.0).unwrap();

    assert!(client.heard().iter().any(|(_, m)| *m == Message::Event(Event::Fault(Fault::SensorLost))));
    assert_eq!(status(&mut robot, &mut client).state, State::Fault(Fault::SensorLost));
    assert!(!robot.nano().bus().servo_driver.drives_any());
}

#[test]
fn a_sensor_that_lost_its_configuration_is_noticed() {
    let (mut robot, mut client) = on_the_bench();
    client.upload(&mut robot, &fixtures::trot().table(), amplitude(1.0), false).unwrap();
    client
        .expect_done(
            &mut robot,
            Command::Walk { amplitude: None, frames: None, detached: true, dry_run: false },
        )
        .unwrap();
    wait_for(&mut robot, &mut client, State::Walking, 5.0);
    let configured = robot.nano().bus().power_sensor.configuration();

    let now_s = robot.now_s();
    robot.nano_mut().bus_mut().power_sensor.brown_out(now_s);
    client.run_for(&mut robot, 3.0).unwrap();

    let faulted = status(&mut robot, &mut client).state == State::Fault(Fault::SensorLost);
    let restored = robot.nano().bus().power_sensor.configuration() == configured;
    println!("faulted: {faulted}, configured again: {restored}");
    assert!(faulted || restored, "it walks on with a sensor that measures something else");
}

#[test]
fn a_stuck_bus_neither_hangs_nor_crashes_and_the_robot_still_answers() {
    let (mut robot, mut client) = on_the_bench();
    client.upload(&mut robot, &fixtures::trot().table(), amplitude(1.0), false).unwrap();
    client
        .expect_done(
            &mut robot,
            Command::Walk { amplitude: None, frames: None, detached: true, dry_run: false },
        )
        .unwrap();
    wait_for(&mut robot, &mut client, State::Walking, 5.0);

    robot.nano_mut().bus_mut().set_stuck(true);
    client.run_for(&mut robot, 1.0).unwrap();
    let state = status(&mut robot, &mut client).state;
    println!("with the bus stuck: {state:?}, {:?}", robot.nano().counters());
    assert!(matches!(state, State::Fault(_)), "{state:?}");

    robot.nano_mut().bus_mut().set_stuck(false);
    client.run_for(&mut robot, 1.0).unwrap();
    client.expect_done(&mut robot, Command::ClearFault).unwrap();

    assert_eq!(status(&mut robot, &mut client).state, State::Idle);
    assert!(!robot.nano().bus().servo_driver.drives_any());
}

/// The watchdog is on from the start, and each look at a stuck bus takes its time.
#[test]
fn a_start_with_a_stuck_bus_is_no_hang_and_the_robot_answers() {
    for clocks in [0, 9, u8::MAX] {
        let mut robot = robot_with(Box::new(Bench::new(0.1)));
        robot.nano_mut().bus_mut().set_stuck(clocks == 0);
        robot.nano_mut().bus_mut().hold_data(clocks);
        let mut client = Client::new();

        client.run_for(&mut robot, 0.5).unwrap();

        assert_eq!(robot.nano().counters().watchdog_resets, 0);
        assert_eq!(status(&mut robot, &mut client).state, State::Idle);
    }
}

/// A chip that lost its master in the middle of a byte waits for the rest of
/// it, and holds SDA meanwhile: no START gets through until it is clocked free.
#[test]
fn a_chip_that_holds_the_data_line_is_clocked_free_and_the_walk_goes_on() {
    let (mut robot, mut client) = on_the_bench();
    client.upload(&mut robot, &fixtures::trot().table(), amplitude(1.0), false).unwrap();
    client
        .expect_done(
            &mut robot,
            Command::Walk { amplitude: None, frames: None, detached: true, dry_run: false },
        )
        .unwrap();
    wait_for(&mut robot, &mut client, State::Walking, 5.0);

    for clocks in [1, 9] {
        robot.nano_mut().bus_mut().hold_data(clocks);
        client.run_for(&mut robot, 0.5).unwrap();

        assert!(!robot.nano().bus().is_data_held(), "of {clocks} clocks some are missing");
        assert_eq!(status(&mut robot, &mut client).state, State::Walking);
    }
    robot.nano_mut().bus_mut().hold_data(u8::MAX);
    client.run_for(&mut robot, 0.2).unwrap();
    assert_eq!(status(&mut robot, &mut client).state, State::Fault(Fault::ServoDriverLost));
}

/// A panic ends in such a loop: interrupts go on, and with them the last burst.
#[test]
fn a_hung_program_is_reset_by_the_watchdog_servos_off_and_the_fault_is_told() {
    let (mut robot, mut client) = on_the_bench();
    client.upload(&mut robot, &fixtures::trot().table(), amplitude(1.0), true).unwrap();
    client
        .expect_done(
            &mut robot,
            Command::Walk { amplitude: None, frames: None, detached: true, dry_run: false },
        )
        .unwrap();
    wait_for(&mut robot, &mut client, State::Walking, 5.0);
    client.run_for(&mut robot, 2.0).unwrap();

    assert!(robot.nano_mut().hang(), "the image has no endless loop to hang in");
    robot.run_for(0.02).unwrap();
    let pulses_on = robot.nano().bus().servo_driver.drives_any();
    let mut client = Client::new();
    client.run_for(&mut robot, 0.1).unwrap();

    assert!(pulses_on, "it hung and went on pulsing");
    assert_eq!(robot.nano().counters().watchdog_resets, 1);
    assert!(!robot.nano().bus().servo_driver.drives_any());
    let status = status(&mut robot, &mut client);
    assert_eq!(status.state, State::Fault(Fault::Watchdog));
    assert_eq!(status.gait.unwrap().name.as_str(), "trot");
    client.expect_done(&mut robot, Command::ClearFault).unwrap();
}

/// A robot whose battery has this voltage and resistance, and servos of this
/// power, is told to walk; returns the frames in which the servos had pulses.
fn frames_on(nominal_v: f64, resistance_ohm: f64, servo_w: f64, fault: Fault) -> usize {
    let mut ant = Robot::ant(LegScale::LONG).unwrap();
    (ant.supply.nominal_v, ant.supply.resistance_ohm) = (nominal_v, resistance_ohm);
    let body = Box::new(Bench::new(servo_w));
    let mut robot = VirtualRobot::with_body(&image(), &ant, body, NOMINAL_OSCILLATOR_HZ).unwrap();
    let mut client = Client::new();
    client.run_for(&mut robot, 0.3).unwrap();
    client.upload(&mut robot, &fixtures::medley().table(), amplitude(1.0), false).unwrap();
    let walk = Command::Walk { amplitude: None, frames: None, detached: true, dry_run: false };
    client.expect_done(&mut robot, walk).unwrap();
    robot.take_bursts();

    client.run_for(&mut robot, 1.0).unwrap();

    assert!(client.heard().iter().any(|(_, m)| *m == Message::Event(Event::Fault(fault))));
    assert_eq!(status(&mut robot, &mut client).state, State::Fault(fault));
    assert!(!robot.nano().bus().servo_driver.drives_any());
    walking_bursts(&robot.take_bursts()).len()
}

/// The debounce is 5 frames, the first of which may have begun in the time
/// before; the stop may take 3 frames.
#[test]
fn a_battery_that_cannot_carry_the_servos_stops_them_and_says_why() {
    for (nominal_v, resistance_ohm, servo_w, fault) in [
        // 6 W through 0.6 ohm, the shunt's 0.1 among them: 4.13 V.
        (5.0, 0.5, 0.75, Fault::Undervoltage),
        // 17.2 W from 6 V: 3.1 A; 20 W: beyond the sensor's range.
        (6.0, 0.05, 2.15, Fault::Overcurrent),
        (6.0, 0.05, 2.5, Fault::Overcurrent),
    ] {
        let frames = frames_on(nominal_v, resistance_ohm, servo_w, fault);

        println!("{fault:?}: {frames} frames with pulses");
        assert!((5..=9).contains(&frames), "{fault:?} after {frames} frames");
    }
}

#[test]
fn an_empty_battery_is_told_before_anything_moves() {
    let mut ant = Robot::ant(LegScale::LONG).unwrap();
    ant.supply.nominal_v = 4.4;
    let body = Box::new(Bench::new(0.1));
    let mut robot = VirtualRobot::with_body(&image(), &ant, body, NOMINAL_OSCILLATOR_HZ).unwrap();
    let mut client = Client::new();
    client.run_for(&mut robot, 0.3).unwrap();
    client.upload(&mut robot, &fixtures::trot().table(), amplitude(1.0), false).unwrap();

    let walk = Command::Walk { amplitude: None, frames: None, detached: true, dry_run: false };
    let reply = client.ask(&mut robot, walk).unwrap();

    // What the electronics draw costs it a few millivolts.
    let is_told = matches!(reply, Reply::Refused(Refusal::SupplyTooLow { bus_mv: 4_370..=4_400 }));
    assert!(is_told, "{reply:?}");
    assert_eq!(status(&mut robot, &mut client).state, State::Idle);
}

/// From the answer to the last command: a second and two frames to the end of the
/// walk, then the way to a stand at a degree a frame.
#[test]
fn an_attached_walk_without_a_host_ends_within_a_second_and_stands_soon_after() {
    let (mut robot, mut client) = on_the_bench();
    let gait = fixtures::medley();
    client.upload(&mut robot, &gait.table(), amplitude(2.2), false).unwrap();
    let walk = Command::Walk { amplitude: None, frames: None, detached: false, dry_run: false };
    client.expect_done(&mut robot, walk).unwrap();
    wait_for(&mut robot, &mut client, State::Walking, 5.0);
    for _ in 0..12 {
        client.run_for(&mut robot, 0.25).unwrap();
        assert_eq!(status(&mut robot, &mut client).state, State::Walking);
    }
    let last_s = robot.now_s();
    robot.take_bursts();

    client.run_for(&mut robot, 4.0).unwrap();

    let told = client.heard().iter().find(|(_, m)| *m == Message::Event(Event::WalkEnded(WalkEnd::LinkLost)));
    let told_s = seconds(told.expect("it says so").0) - last_s;
    let bursts = robot.take_bursts();
    let is_move = |pair: &[Burst]| pair[0].counts != pair[1].counts && pair[1].counts[0].is_some();
    let moved = bursts.windows(2).filter(|pair| is_move(pair)).map(|pair| pair[1].start_s);
    let still_s = moved.fold(f64::MIN, f64::max) - last_s;
    println!("the walk ends {told_s:.3} s after the last answer, the last move comes after {still_s:.3} s");
    assert!(told_s > 0.9 && told_s <= 1.0 + 2.0 / 60.0, "{told_s} s");
    assert!(still_s <= told_s + 1.0, "{still_s} s");
    assert!(!robot.nano().bus().servo_driver.drives_any(), "limp in the end");
}
