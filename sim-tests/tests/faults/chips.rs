//! Lost chips, stuck buses, resets.

use crate::{WALK, has_limp_servos, walking};
use protocol::{Command, Event, Fault, Refusal, Reply, ResetCause, State};
use sim_tests::devices::Chip;
use sim_tests::fixtures::{self, amplitude};
use sim_tests::sim_robot::SimRobot;

/// 16 V range, /8 gain, 10 bits on both channels, continuous.
const SENSOR_CONFIGURATION: u16 = 0x188F;

#[test]
fn start_up_configures_both_chips() {
    let mut robot = SimRobot::new();

    let chips = &mut robot.board.chips;
    // Prescaler 101 from 25 MHz.
    assert!((chips.servo_driver.count_us() - 4.08).abs() < 1e-9, "{} us", chips.servo_driver.count_us());
    assert!(!chips.servo_driver.is_asleep());
    assert!(!chips.start(0x70, false, 1.0), "ALLCALL still answers");
    assert_eq!(chips.power_sensor.configuration(), SENSOR_CONFIGURATION);
}

#[test]
fn losing_the_sensor_stops_the_robot_until_the_fault_is_cleared() {
    let mut robot = walking();

    let fault = State::Fault(Fault::SensorLost);
    robot.board.chips.unplug(Chip::PowerSensor);
    robot.run_until(fault);
    assert!(has_limp_servos(&robot), "at once, not with the next burst");
    robot.run_frames(10);

    assert_eq!(robot.state(), fault);
    assert!(has_limp_servos(&robot));
    assert!(robot.events().any(|event| event == Event::Fault(Fault::SensorLost)));
    assert_eq!(robot.ask(WALK), Reply::Refused(Refusal::Faulted(Fault::SensorLost)));
    let missing = Reply::Refused(Refusal::ChipMissing(Fault::SensorLost));
    assert_eq!(robot.ask(Command::ClearFault), missing, "its cause is still there");
    robot.board.chips.replug(Chip::PowerSensor);
    robot.run_frames(60);
    robot.expect_done(Command::Stop);
    assert_eq!(robot.state(), fault, "nothing else clears it");

    robot.expect_done(Command::ClearFault);

    assert_eq!(robot.state(), State::Idle);
    robot.expect_done(WALK);
}

#[test]
fn losing_the_servo_driver_stops_the_robot_and_its_return_finds_it_limp() {
    let mut robot = walking();

    robot.board.chips.unplug(Chip::ServoDriver);
    robot.run_frames(6);
    let lost = robot.state();
    robot.board.chips.replug(Chip::ServoDriver);
    let pulses_on = !has_limp_servos(&robot);
    robot.run_frames(2);

    assert_eq!(lost, State::Fault(Fault::ServoDriverLost));
    assert!(pulses_on, "out of reach it went on pulsing");
    assert!(has_limp_servos(&robot), "in reach again it was switched off");
    assert_eq!(robot.events().filter(|event| matches!(event, Event::Fault(_))).count(), 1);
}

#[test]
fn a_single_failed_burst_does_not_stop_the_robot() {
    let mut robot = walking();

    robot.board.chips.unplug(Chip::ServoDriver);
    robot.run_frames(1);
    robot.board.chips.replug(Chip::ServoDriver);
    robot.run_frames(30);

    assert_eq!(robot.state(), State::Walking);
}

#[test]
fn a_sensor_that_lost_its_configuration_is_noticed_within_half_a_second() {
    let mut robot = walking();
    let now_s = robot.board.now_s();

    robot.board.chips.power_sensor.brown_out(now_s);
    robot.run_frames(30);

    assert_eq!(robot.state(), State::Fault(Fault::SensorLost));
    robot.expect_done(Command::ClearFault);
    assert_eq!(robot.board.chips.power_sensor.configuration(), SENSOR_CONFIGURATION);
}

#[test]
fn a_servo_driver_that_lost_its_configuration_is_noticed_within_half_a_second() {
    let mut robot = walking();

    robot.board.chips.power_cycle(Chip::ServoDriver);
    robot.run_frames(30);

    assert_eq!(robot.state(), State::Fault(Fault::ServoDriverLost));
}

#[test]
fn a_stuck_bus_stops_the_robot_and_it_still_answers() {
    let mut robot = walking();

    robot.board.chips.set_stuck(true);
    robot.run_frames(6);
    let state = robot.status().state;
    robot.run_frames(60);
    robot.board.chips.set_stuck(false);
    robot.run_frames(2);

    assert_eq!(state, State::Fault(Fault::ServoDriverLost));
    assert!(robot.board.longest_unfed_s() < 0.02, "{} s in one turn", robot.board.longest_unfed_s());
    assert!(has_limp_servos(&robot));
}

#[test]
fn a_robot_without_chips_starts_answers_and_refuses_to_walk() {
    for (chip, fault) in [(Chip::ServoDriver, Fault::ServoDriverLost), (Chip::PowerSensor, Fault::SensorLost)]
    {
        let mut robot = SimRobot::new();
        robot.board.chips.unplug(chip);
        let mut robot = robot.reset(ResetCause::External);
        robot.upload(&fixtures::trot(), amplitude(1.0), false);
        robot.run_frames(60);

        let refused = robot.ask(WALK);
        let state = robot.state();
        robot.board.chips.replug(chip);

        assert_eq!(refused, Reply::Refused(Refusal::ChipMissing(fault)));
        assert_eq!(state, State::Idle, "nothing moved: no fault");
        robot.expect_done(WALK);
    }
}

#[test]
fn a_reset_in_mid_walk_switches_the_servos_off() {
    let robot = walking();
    assert!(!has_limp_servos(&robot));

    let robot = robot.reset(ResetCause::External);

    assert!(has_limp_servos(&robot));
    assert_eq!(robot.state(), State::Idle);
}

#[test]
fn a_watchdog_reset_in_mid_walk_is_a_fault() {
    let mut robot = walking().reset(ResetCause::Watchdog);
    robot.run_frames(2);

    assert_eq!(robot.state(), State::Fault(Fault::Watchdog));
    assert!(has_limp_servos(&robot));
    let events: Vec<Event> = robot.events().collect();
    assert_eq!(events, [Event::Started(ResetCause::Watchdog), Event::Fault(Fault::Watchdog)]);
    robot.expect_done(Command::ClearFault);
}

#[test]
fn a_watchdog_reset_while_limp_is_reported_and_no_fault() {
    let robot = SimRobot::new().reset(ResetCause::Watchdog);

    let mut robot = robot;
    robot.run_frames(2);

    assert_eq!(robot.state(), State::Idle);
    assert!(robot.events().any(|event| event == Event::Started(ResetCause::Watchdog)));
}

#[test]
fn a_sagging_supply_that_takes_both_chips_leaves_a_limp_robot() {
    let mut robot = walking();
    let now_s = robot.board.now_s();

    robot.board.chips.power_cycle(Chip::ServoDriver);
    robot.board.chips.power_sensor.brown_out(now_s);
    let mut robot = robot.reset(ResetCause::BrownOut);
    robot.run_frames(2);

    assert_eq!(robot.state(), State::Idle);
    assert!(has_limp_servos(&robot));
}
