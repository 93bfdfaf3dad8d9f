//! What the robot tells about a trial, above all its energy.

use protocol::{Command, State, Telemetry};
use sim_tests::devices::Chip;
use sim_tests::fixtures::{self, amplitude};
use sim_tests::sim_robot::SimRobot;

fn streaming() -> SimRobot {
    let mut robot = SimRobot::new();
    robot.upload(&fixtures::trot(), amplitude(2.2), false);
    robot.expect_done(Command::StreamTelemetry { every_frames: 1 });
    robot
}

fn walk(robot: &mut SimRobot, frames: u32) -> Telemetry {
    robot.expect_done(Command::Walk {
        amplitude: None,
        frames: Some(frames),
        detached: true,
        dry_run: false,
    });
    robot.run_until(State::Holding);
    robot.run_frames(3);
    robot.telemetry().last().unwrap()
}

/// A voltage that a conversion of 10 bits has a step for: 312 of 16 mV, 1,248 counts.
const BUS_V: f64 = 4.992;

/// Energy of `frames` at this voltage and 0.4 A: nine readings of 1,248 by 4,000
/// counts, 360,351 for the shunt's 40 mV, 1,350 products a microjoule.
const fn energy_at_0_4_a_uj(frames: u64) -> u64 {
    frames * (9 * 1_248 * 4_000 + 360_351) / 1_350
}

/// The sensor sees 4.992 V behind its 0.1 ohm: 5.032 V leave the battery at 0.4 A.
#[test]
fn energy_of_a_constant_load_is_power_times_time_and_the_shunts_own_counts() {
    let mut robot = streaming();
    robot.board.set_supply(BUS_V, 0.4);

    let sample = walk(&mut robot, 720);

    let expected_uj = 5.032 * 0.4 * 12.0 * 1e6;
    let energy_uj = sample.trial_energy_uj as f64;
    assert!((energy_uj / expected_uj - 1.0).abs() < 1e-5, "{energy_uj} of {expected_uj}");
    assert_eq!((sample.bus_mv, sample.current_ua), (4_992, 400_000));
    assert_eq!((sample.trial_frames, sample.missed_samples), (720, 0));
}

/// 1,252 counts by four are 33.387 microjoules a frame: only the carried remainder
/// makes anything of the thousandths.
#[test]
fn energy_below_a_microjoule_is_carried_from_frame_to_frame() {
    let mut robot = streaming();
    robot.board.set_supply(5.008, 0.000_4);

    let sample = walk(&mut robot, 720);

    assert_eq!(sample.trial_energy_uj, 720 * 9 * 1_252 * 4 / 1_350);
}

#[test]
fn energy_counts_gait_frames_only() {
    let mut robot = streaming();
    robot.board.set_supply(BUS_V, 0.4);
    robot.expect_done(Command::Walk { amplitude: None, frames: Some(60), detached: true, dry_run: false });

    robot.run_frames(5);
    let entering = robot.telemetry().last().unwrap();
    robot.run_until(State::Idle);
    robot.board.set_supply(BUS_V, 1.0);
    robot.run_frames(60);
    let after = robot.telemetry().last().unwrap();

    assert_eq!((entering.state, entering.trial_frames, entering.trial_energy_uj), (State::Entering, 0, 0));
    assert_eq!(
        (after.trial_frames, after.trial_energy_uj),
        (60, energy_at_0_4_a_uj(60)),
        "frozen with the last frame"
    );
    assert_eq!(after.current_ua, 1_000_000, "while the sensor is still read");
}

#[test]
fn a_second_trial_starts_from_zero() {
    let mut robot = streaming();
    robot.board.set_supply(BUS_V, 0.4);
    walk(&mut robot, 60);

    let second = walk(&mut robot, 30);

    assert_eq!((second.trial_frames, second.trial_energy_uj), (30, energy_at_0_4_a_uj(30)));
}

#[test]
fn energy_follows_a_changing_load_to_within_a_sample() {
    let mut robot = streaming();
    robot.expect_done(Command::Walk { amplitude: None, frames: Some(300), detached: true, dry_run: false });
    robot.run_until(State::Walking);
    let mut expected_uj = 0.0;
    while robot.state() == State::Walking {
        // Changes every 10 frames, between 0.5 and 6 W.
        let load_a = 0.1 + 0.1 * ((robot.board.frames() / 10) % 12) as f64;
        robot.board.set_supply(BUS_V, load_a);
        robot.run_frames(1);
        expected_uj += (BUS_V + 0.1 * load_a) * load_a / 60.0 * 1e6;
    }
    robot.run_frames(3);

    let energy_uj = robot.telemetry().last().unwrap().trial_energy_uj as f64;

    // Two frames of the largest load at either end.
    assert!((energy_uj - expected_uj).abs() < 2.0 * 6.0 / 60.0 * 1e6, "{energy_uj} of {expected_uj}");
}

#[test]
fn a_missed_sample_is_counted_and_the_one_before_stands_in() {
    let mut robot = streaming();
    robot.board.set_supply(BUS_V, 0.4);
    robot.expect_done(Command::Walk { amplitude: None, frames: Some(120), detached: true, dry_run: false });
    robot.run_until(State::Walking);
    robot.run_frames(20);

    robot.board.chips.unplug(Chip::PowerSensor);
    robot.run_frames(3);
    robot.board.chips.replug(Chip::PowerSensor);
    robot.run_until(State::Holding);
    robot.run_frames(3);

    let sample = robot.telemetry().last().unwrap();
    assert_eq!(sample.missed_samples, 3);
    assert_eq!((sample.trial_frames, sample.trial_energy_uj), (120, energy_at_0_4_a_uj(120)));
}

#[test]
fn a_saturated_sensor_is_counted_and_not_believed() {
    let mut robot = streaming();
    robot.board.set_supply(BUS_V, 0.4);
    robot.expect_done(Command::Walk { amplitude: None, frames: Some(120), detached: true, dry_run: false });
    robot.run_until(State::Walking);
    robot.run_frames(20);

    // 3.2 A is the end of the range.
    robot.board.set_supply(BUS_V, 3.5);
    robot.run_frames(3);
    robot.board.set_supply(BUS_V, 0.4);
    robot.run_until(State::Holding);
    robot.run_frames(3);

    let sample = robot.telemetry().last().unwrap();
    assert!((2..=5).contains(&sample.missed_samples), "{} missed", sample.missed_samples);
    // Averages on the way in and out may be anything below 3.2 A.
    assert!(sample.trial_energy_uj < 4_000_000 + 4 * 16 * 1_000_000 / 60, "{}", sample.trial_energy_uj);
}

/// Servos that all jump at once may draw more than the sensor can tell, again
/// and again; the chip is there all the same, and a fault only what lasts.
#[test]
fn a_sensor_saturated_now_and_then_is_no_lost_sensor() {
    let mut robot = streaming();
    robot.expect_done(Command::Walk { amplitude: None, frames: None, detached: true, dry_run: false });
    robot.run_until(State::Walking);

    for _ in 0..15 {
        robot.board.set_supply(BUS_V, 3.5);
        robot.run_frames(4);
        robot.board.set_supply(BUS_V, 0.4);
        robot.run_frames(2);
    }

    assert_eq!(robot.state(), State::Walking);
    assert!(robot.telemetry().last().unwrap().missed_samples > 40);
}

#[test]
fn a_walk_right_after_a_stop_is_a_trial_of_its_own() {
    for stopped_after in [None, Some(70)] {
        let mut robot = streaming();
        robot.board.set_supply(BUS_V, 0.4);
        robot.expect_done(Command::Walk {
            amplitude: None,
            frames: stopped_after,
            detached: true,
            dry_run: false,
        });
        robot.run_until(State::Walking);
        if stopped_after.is_none() {
            robot.run_frames(70);
            let stop = robot.framed(Command::Stop);
            robot.send(&stop);
        }
        robot.run_until(State::Holding);

        // At once: frames of the walk before are still on their way to the servos.
        let sample = walk(&mut robot, 60);

        assert_eq!(
            (sample.trial_frames, sample.trial_energy_uj),
            (60, energy_at_0_4_a_uj(60)),
            "{stopped_after:?}"
        );
    }
}

/// What flows back is a debt, 0.5 W for twenty frames here, that the next frames pay.
#[test]
fn a_braking_servo_that_feeds_the_supply_is_subtracted_from_what_comes_after() {
    let mut robot = streaming();
    robot.board.set_supply(BUS_V, 0.4);
    robot.expect_done(Command::Walk { amplitude: None, frames: Some(120), detached: true, dry_run: false });
    robot.run_until(State::Walking);
    robot.run_frames(60);

    robot.board.set_supply(BUS_V, -0.1);
    robot.run_frames(20);
    let braking = robot.telemetry().last().unwrap();
    robot.board.set_supply(BUS_V, 0.4);
    robot.run_until(State::Holding);
    robot.run_frames(3);

    let sample = robot.telemetry().last().unwrap();
    assert_eq!(braking.current_ua, -100_000);
    assert_eq!(sample.trial_frames, 120);
    // 100 frames at 0.4 A, 20 at -0.1 A; a frame of mixed readings at each change.
    let expected_uj = energy_at_0_4_a_uj(100) as f64 - 20.0 * BUS_V * 0.1 / 60.0 * 1e6;
    let error_uj = (sample.trial_energy_uj as f64 - expected_uj).abs();
    assert!(error_uj < 2.0 * 0.5 * BUS_V / 60.0 * 1e6, "{error_uj} uJ off {expected_uj}");
}

#[test]
fn telemetry_comes_as_often_as_asked_and_stops() {
    let mut robot = streaming();
    let count = |robot: &mut SimRobot, every_frames| {
        robot.expect_done(Command::StreamTelemetry { every_frames });
        robot.run_frames(2);
        let before = robot.telemetry().count();
        robot.run_frames(60);
        robot.telemetry().count() - before
    };

    assert_eq!(count(&mut robot, 1), 60);
    assert_eq!(count(&mut robot, 6), 10);
    assert_eq!(count(&mut robot, 0), 0);
    let clock: Vec<u32> = robot.telemetry().take(50).map(|sample| sample.uptime_frames).collect();
    assert!(clock.windows(2).all(|pair| pair[1] == pair[0] + 1), "{clock:?}");
}

/// Whatever goes missing goes missing whole: the bench panics on half a frame.
#[test]
fn a_flood_of_commands_is_answered_in_full_between_whole_telemetry_frames() {
    let mut robot = streaming();
    robot.expect_done(Command::Walk { amplitude: None, frames: None, detached: true, dry_run: false });
    let answered = robot.answers();

    // 8 questions at once fill the ring back for 3 frames.
    let mut asked = 0;
    for _ in 0..30 {
        for _ in 0..8 {
            let frame = robot.framed(Command::Read { record: protocol::command::Record::Gait, offset: 0 });
            robot.send(&frame);
            asked += 1;
        }
        robot.run_frames(5);
    }
    robot.run_frames(60);

    assert_eq!(robot.answers() - answered, asked);
    // 150 frames under the flood, 60 after it.
    let told = robot.telemetry().count();
    assert!((100..205).contains(&told), "{told} samples: some, not all, found room");
}
