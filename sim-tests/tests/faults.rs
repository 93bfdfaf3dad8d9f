//! Chips that break, supplies that sag, programs that hang.

use firmware::limits;
use host::link::words;
use protocol::{Calibration, Command, Event, Fault, Refusal, Reply, ResetCause, State};
use sim_tests::devices::pca9685::NOMINAL_OSCILLATOR_HZ;
use sim_tests::devices::{Chip, Pca9685};
use sim_tests::fixtures::{self, amplitude};
use sim_tests::sim_robot::SimRobot;

const WALK: Command = Command::Walk { amplitude: None, frames: None, detached: true, dry_run: false };

fn walking() -> SimRobot {
    let mut robot = SimRobot::playing(&fixtures::trot(), amplitude(2.2));
    robot.run_frames(20);
    robot
}

fn has_limp_servos(robot: &SimRobot) -> bool {
    !robot.board.chips.pca9685.drives_any()
}

/// 16 V range, /8 gain, 10 bits on both channels, continuous.
const SENSOR_CONFIGURATION: u16 = 0x188F;

#[test]
fn start_up_configures_both_chips() {
    let mut robot = SimRobot::new();

    let chips = &mut robot.board.chips;
    // Prescaler 101 from 25 MHz.
    assert!((chips.pca9685.count_us() - 4.08).abs() < 1e-9, "{} us", chips.pca9685.count_us());
    assert!(!chips.pca9685.is_asleep());
    assert!(!chips.start(0x70, false, 1.0), "ALLCALL still answers");
    assert_eq!(chips.ina219.configuration(), SENSOR_CONFIGURATION);
}

#[test]
fn losing_the_sensor_stops_the_robot_until_the_fault_is_cleared() {
    let mut robot = walking();

    let fault = State::Fault(Fault::SensorLost);
    robot.board.chips.unplug(Chip::Ina219);
    robot.run_until(fault);
    assert!(has_limp_servos(&robot), "at once, not with the next burst");
    robot.run_frames(10);

    assert_eq!(robot.state(), fault);
    assert!(has_limp_servos(&robot));
    assert!(robot.events().any(|event| event == Event::Fault(Fault::SensorLost)));
    assert_eq!(robot.ask(WALK), Reply::Refused(Refusal::Faulted(Fault::SensorLost)));
    let missing = Reply::Refused(Refusal::ChipMissing(Fault::SensorLost));
    assert_eq!(robot.ask(Command::ClearFault), missing, "its cause is still there");
    robot.board.chips.replug(Chip::Ina219);
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

    robot.board.chips.unplug(Chip::Pca9685);
    robot.run_frames(6);
    let lost = robot.state();
    robot.board.chips.replug(Chip::Pca9685);
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

    robot.board.chips.unplug(Chip::Pca9685);
    robot.run_frames(1);
    robot.board.chips.replug(Chip::Pca9685);
    robot.run_frames(30);

    assert_eq!(robot.state(), State::Walking);
}

#[test]
fn a_sensor_that_lost_its_configuration_is_noticed_within_half_a_second() {
    let mut robot = walking();
    let now_s = robot.board.now_s();

    robot.board.chips.ina219.brown_out(now_s);
    robot.run_frames(30);

    assert_eq!(robot.state(), State::Fault(Fault::SensorLost));
    robot.expect_done(Command::ClearFault);
    assert_eq!(robot.board.chips.ina219.configuration(), SENSOR_CONFIGURATION);
}

#[test]
fn a_servo_driver_that_lost_its_configuration_is_noticed_within_half_a_second() {
    let mut robot = walking();

    robot.board.chips.pca9685 = Pca9685::new(NOMINAL_OSCILLATOR_HZ);
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
    for (chip, fault) in [(Chip::Pca9685, Fault::ServoDriverLost), (Chip::Ina219, Fault::SensorLost)] {
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

    robot.board.chips.pca9685 = Pca9685::new(NOMINAL_OSCILLATOR_HZ);
    robot.board.chips.ina219.brown_out(now_s);
    let mut robot = robot.reset(ResetCause::BrownOut);
    robot.run_frames(2);

    assert_eq!(robot.state(), State::Idle);
    assert!(has_limp_servos(&robot));
}

/// Samples in a row that the supply must be wrong for, and the frames that a
/// stop may take after them.
const DEBOUNCE_FRAMES: u64 = 5;
const STOP_FRAMES: u64 = 3;

/// Frames from a change of the supply to the last pulse.
fn frames_to_limp(robot: &mut SimRobot, bus_v: f64, current_a: f64) -> u64 {
    robot.board.set_supply(bus_v, current_a);
    let from = robot.board.frames();
    while !has_limp_servos(robot) {
        robot.run_frames(1);
        assert!(robot.board.frames() < from + 60, "it walks on at {bus_v} V and {current_a} A");
    }
    robot.board.frames() - from
}

#[test]
fn a_bad_supply_stops_the_robot_after_five_samples_and_it_stays_stopped() {
    for (bus_v, current_a, fault) in [
        (4.19, 1.0, Fault::Undervoltage),
        (0.0, 0.0, Fault::Undervoltage),
        (5.0, 3.0, Fault::Overcurrent),
        (5.0, 3.5, Fault::Overcurrent),
        (4.0, 3.1, Fault::Overcurrent),
    ] {
        let mut robot = walking();

        let frames = frames_to_limp(&mut robot, bus_v, current_a);
        robot.board.set_supply(5.0, 0.0);
        robot.run_frames(60);

        assert!(frames >= DEBOUNCE_FRAMES, "{bus_v} V, {current_a} A: {frames} frames");
        assert!(frames <= DEBOUNCE_FRAMES + STOP_FRAMES, "{bus_v} V, {current_a} A: {frames} frames");
        assert_eq!(robot.state(), State::Fault(fault), "{bus_v} V, {current_a} A");
        let told: Vec<Event> = robot.events().filter(|event| matches!(event, Event::Fault(_))).collect();
        assert_eq!(told, [Event::Fault(fault)]);
        assert_eq!(robot.ask(WALK), Reply::Refused(Refusal::Faulted(fault)));
        robot.expect_done(Command::ClearFault);
        robot.expect_done(WALK);
    }
}

#[test]
fn a_supply_just_within_its_limits_carries_a_walk() {
    let mut robot = walking();

    robot.board.set_supply(4.2, 2.99);
    robot.run_frames(300);

    assert_eq!(robot.state(), State::Walking);
}

#[test]
fn dips_and_peaks_shorter_than_the_debounce_do_not_stop_the_robot() {
    let mut robot = walking();

    for _ in 0..20 {
        for (bus_v, current_a) in [(4.0, 1.0), (5.0, 0.4), (5.0, 3.5), (5.0, 0.4)] {
            robot.board.set_supply(bus_v, current_a);
            robot.run_frames(DEBOUNCE_FRAMES - 1);
        }
    }

    assert_eq!(robot.state(), State::Walking);
}

#[test]
fn a_walk_on_a_low_supply_is_refused_with_its_voltage_and_nothing_moves() {
    for (bus_v, bus_mv) in [(4.592, 4_592), (3.296, 3_296), (0.0, 0)] {
        let mut robot = SimRobot::new();
        robot.upload(&fixtures::trot(), amplitude(1.0), false);
        robot.board.set_supply(bus_v, 0.0);
        robot.run_frames(3);

        let refused = robot.ask(WALK);

        assert_eq!(refused, Reply::Refused(Refusal::SupplyTooLow { bus_mv }));
        assert_eq!(robot.state(), State::Idle, "limp: no fault");
        assert!(has_limp_servos(&robot));
        robot.board.set_supply(4.6, 0.0);
        robot.run_frames(3);
        robot.expect_done(WALK);
    }
}

#[test]
fn an_undervoltage_is_not_cleared_while_the_supply_is_still_low() {
    let mut robot = walking();
    frames_to_limp(&mut robot, 4.1, 1.0);
    robot.board.set_supply(4.4, 0.0);
    robot.run_frames(3);

    let refused = robot.ask(Command::ClearFault);

    assert_eq!(refused, Reply::Refused(Refusal::SupplyTooLow { bus_mv: 4_400 }));
    assert_eq!(robot.state(), State::Fault(Fault::Undervoltage));
}

/// The host's texts are constants of their own: they must not drift.
#[test]
fn the_host_names_the_limits_that_the_robot_keeps() {
    let board = Calibration::authors().board();
    let volts = format!("{} V", f64::from(board.undervoltage_mv) / 1e3);
    let amperes = format!("{} A", f64::from(board.overcurrent_ma) / 1e3);

    assert!(words::fault(Fault::Undervoltage).contains(&volts), "{volts}");
    assert!(words::fault(Fault::Overcurrent).contains(&amperes), "{amperes}");
    assert_eq!(u64::from(limits::SUPPLY_FAULT_FRAMES), DEBOUNCE_FRAMES);
}

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
    robot.board.chips.unplug(Chip::Ina219);
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
    robot.board.chips.unplug(Chip::Ina219);
    robot.run_until(State::Fault(Fault::SensorLost));
    let faulted = robot.board.outputs_enabled();

    assert_eq!((limp, on_the_way, faulted), (false, true, false));
}
