//! Pause, speed and amplitude while walking: never a jump.

use crate::{ready, walking};
use protocol::{Command, JOINT_COUNT, Refusal, Reply, Speed, State, WalkEnd};
use sim_tests::fixtures::{self, Gait, amplitude};
use sim_tests::sim_robot::SimRobot;
use sim_tests::sim_robot::ask::{ATTACHED_WALK, WALK, setpoints, walk_for};
use sim_tests::sim_robot::pulses::{error_counts, largest_step, servos_on};

fn speed(value: f64) -> Command {
    Command::SetSpeed(Speed::from_f64(value).unwrap())
}

/// The trot's largest step at 2.2 and its own speed, in counts.
fn own_step() -> f64 {
    let mut robot = walking();
    largest_step(&robot.pulses_over(74))
}

/// Gait frames counted, and strides made, over so many frames.
fn pace_over(robot: &mut SimRobot, frames: u64) -> (u32, f64) {
    robot.run_frames(2);
    let first = robot.telemetry().last().unwrap();
    robot.run_frames(frames);
    let phases: Vec<u16> =
        robot.telemetry().skip_while(|t| t.uptime_frames < first.uptime_frames).map(|t| t.phase).collect();
    let strides: f64 =
        phases.windows(2).map(|pair| f64::from(pair[1].wrapping_sub(pair[0])) / 65_536.0).sum();
    (robot.telemetry().last().unwrap().trial_frames - first.trial_frames, strides)
}

#[test]
fn a_pause_slows_down_to_a_stand_in_mid_stride_and_goes_on_without_a_jump() {
    let mut robot = walking();
    robot.take_pulses();

    robot.expect_done(Command::SetSpeed(Speed::PAUSED));
    robot.run_frames(40);
    let paused = robot.state();
    let (counted, _) = pace_over(&mut robot, 100);
    let stand = robot.take_pulses();
    robot.expect_done(speed(1.0));
    robot.run_frames(100);
    let resumed = robot.take_pulses();

    assert_eq!((paused, counted), (State::Holding, 0));
    assert!(stand.iter().all(servos_on) && largest_step(&stand[stand.len() - 90..]) == 0.0);
    let all: Vec<_> = stand.into_iter().chain(resumed).collect();
    assert!(largest_step(&all) <= own_step() + 1.0, "{} counts", largest_step(&all));
    assert_eq!(robot.state(), State::Walking);
    let arrived = all.last().unwrap();
    assert!((0..72).any(|frame| (0..8).any(|eighth| {
        let gait = fixtures::trot();
        let shifted = Gait { period_s: gait.period_s * 8.0, ..gait };
        error_counts(&shifted, 2.2, 8 * frame + eighth, arrived) <= 1.0
    })));
}

#[test]
fn half_and_double_speed_make_half_and_double_the_strides() {
    for (value, expected) in [(0.5, 2.5), (1.0, 5.0), (2.0, 10.0)] {
        let mut robot = walking();
        robot.take_pulses();
        robot.expect_done(speed(value));
        robot.run_frames(40);
        let changing = robot.take_pulses();

        let (counted, strides) = pace_over(&mut robot, 360);

        assert_eq!(counted, 360, "every frame counts, at any speed");
        assert!((strides - expected).abs() < 0.01, "{strides} strides at {value}");
        let bound = own_step() * f64::max(value, 1.0) + 1.0;
        assert!(largest_step(&changing) <= bound, "{} counts at {value}", largest_step(&changing));
        assert!(largest_step(&robot.take_pulses()) <= bound);
    }
}

#[test]
fn an_amplitude_set_during_a_pause_slides_in_after_it() {
    let mut robot = walking();
    robot.expect_done(Command::SetSpeed(Speed::PAUSED));
    robot.run_frames(60);
    robot.take_pulses();

    robot.expect_done(Command::SetAmplitude(amplitude(1.0)));
    let stand = robot.pulses_over(60);
    robot.expect_done(speed(1.0));
    robot.run_frames(300);
    let resumed = robot.take_pulses();

    assert!(largest_step(&stand) == 0.0, "a paused robot moves");
    let all: Vec<_> = stand.into_iter().chain(resumed.iter().copied()).collect();
    assert!(largest_step(&all) <= own_step() + 0.5 * 5.0 / 3.0 + 1.0, "{} counts", largest_step(&all));
    let largest = largest_step(&resumed[resumed.len() - 72..]);
    assert!((largest - own_step() / 2.2).abs() <= 1.0, "{largest} counts at 1.0");
}

#[test]
fn a_pause_of_an_attached_walk_still_needs_its_host() {
    let mut robot = ready();
    robot.expect_done(ATTACHED_WALK);
    while robot.state() != State::Walking {
        robot.status();
    }
    robot.expect_done(Command::SetSpeed(Speed::PAUSED));
    for _ in 0..40 {
        robot.run_frames(10);
        robot.status();
    }
    let paused = robot.state();

    robot.run_frames(62);

    assert_eq!(paused, State::Holding);
    assert_eq!(robot.walk_ends(), [WalkEnd::LinkLost]);
    robot.run_until(State::Idle);
}

#[test]
fn a_stop_during_a_pause_goes_to_a_stand() {
    let mut robot = walking();
    robot.expect_done(Command::SetSpeed(Speed::PAUSED));
    robot.run_frames(60);

    robot.expect_done(Command::Stop);
    let state = robot.state();
    robot.run_until(State::Idle);

    assert_eq!(state, State::Stopping);
    assert_eq!(robot.walk_ends(), [WalkEnd::Asked]);
}

#[test]
fn a_new_walk_starts_at_its_own_speed() {
    let mut robot = walking();
    robot.expect_done(Command::SetSpeed(Speed::PAUSED));
    robot.run_frames(40);
    robot.expect_done(Command::Stop);
    robot.run_until(State::Idle);

    robot.expect_done(WALK);
    robot.run_until(State::Walking);
    robot.run_frames(5);
    let (counted, strides) = pace_over(&mut robot, 72);

    assert_eq!(counted, 72);
    assert!((strides - 1.0).abs() < 0.001, "{strides}");
}

#[test]
fn a_walk_of_n_frames_counts_no_frame_of_a_pause() {
    let mut robot = ready();
    robot.expect_done(Command::StreamTelemetry { every_frames: 1 });
    robot.expect_done(walk_for(100));
    robot.run_until(State::Walking);
    robot.run_frames(20);
    robot.expect_done(Command::SetSpeed(Speed::PAUSED));
    robot.run_frames(200);
    assert_eq!(robot.state(), State::Holding);

    robot.expect_done(speed(0.5));
    robot.run_until(State::Idle);
    robot.run_frames(2);

    assert_eq!(robot.telemetry().last().unwrap().trial_frames, 100);
    assert_eq!(robot.walk_ends(), [WalkEnd::Finished]);
}

#[test]
fn a_speed_beyond_double_is_refused() {
    let mut robot = walking();
    // Off the wire a speed may be anything; here it comes by its bytes.
    let deserializer = serde::de::value::U16Deserializer::<serde::de::value::Error>::new(16_385);
    let sequence =
        serde::de::value::SeqDeserializer::<_, serde::de::value::Error>::new(std::iter::once(deserializer));
    let wild: Speed = serde::Deserialize::deserialize(sequence).unwrap();

    assert_eq!(robot.ask(Command::SetSpeed(wild)), Reply::Refused(Refusal::Range));
    assert_eq!(robot.ask(setpoints(&[[0.0; JOINT_COUNT]])), Reply::Refused(Refusal::NoStream));
    let (_, strides) = pace_over(&mut robot, 72);
    assert!((strides - 1.0).abs() < 0.001, "{strides}");
}

#[test]
fn a_gait_uploaded_during_a_pause_waits_in_its_first_pose() {
    let mut robot = walking();
    robot.expect_done(Command::SetSpeed(Speed::PAUSED));
    robot.run_frames(60);

    robot.upload(&fixtures::medley(), amplitude(1.0), false);
    robot.run_until(State::Holding);
    robot.run_frames(3);

    let stand = robot.pulses_over(30);
    assert!(largest_step(&stand) == 0.0);
    assert!(error_counts(&fixtures::medley(), 1.0, 0, &stand[0]) <= 0.6);
}
