//! What the servos get, frame by frame.

use protocol::{
    Amplitude, Calibration, Command, Event, FRAME_RATE_HZ, JOINT_COUNT, Joint, Refusal, Reply, State, WalkEnd,
};
use sim_tests::fixtures::{self, Gait, amplitude};
use sim_tests::sim_robot::ask::{WALK, walk_for};
use sim_tests::sim_robot::pulses::{
    COUNTS_PER_DEG, NEUTRAL_COUNTS, SLOW_STEP_COUNTS, error_counts, error_from, largest_step, servos_off,
    servos_on, step,
};
use sim_tests::sim_robot::{Pulses, SimRobot};

/// Proven in `protocol`, quantisation included.
const SETPOINT_ERROR_DEG: f64 = 0.05;
#[test]
fn every_pulse_of_two_loops_equals_the_f64_reference() {
    for gait in [fixtures::trot(), fixtures::medley()] {
        let asked = amplitude(2.2);
        let mut robot = SimRobot::playing(&gait, asked);
        robot.take_pulses();

        let frames = (2.0 * gait.period_s * f64::from(FRAME_RATE_HZ)) as u64;
        let pulses = robot.pulses_over(frames + 2);

        // Entering ends with the first pose; the gait starts with it, too.
        let start = pulses.iter().position(|p| error_counts(&gait, asked.value(), 0, p) < 0.6).unwrap();
        let start = start + usize::from(error_counts(&gait, asked.value(), 0, &pulses[start + 1]) < 0.6);
        for (frame, pulses) in pulses[start..].iter().enumerate() {
            let error = error_counts(&gait, asked.value(), frame, pulses);
            assert!(
                error <= 0.5 + SETPOINT_ERROR_DEG * COUNTS_PER_DEG,
                "{}: frame {frame}: {error}",
                gait.name
            );
        }
    }
}

#[test]
fn servos_are_limp_until_a_walk_is_asked_for() {
    let mut robot = SimRobot::new();
    robot.upload(&fixtures::trot(), amplitude(1.0), false);

    let pulses = robot.pulses_over(30);

    assert!(!pulses.is_empty() && pulses.iter().all(servos_off));
    assert_eq!(robot.state(), State::Idle);
}

#[test]
fn walking_for_n_frames_plays_exactly_n_frames_and_ends_limp() {
    for frames in [1, 59, 200] {
        let gait = fixtures::medley();
        let mut robot = SimRobot::new();
        robot.upload(&gait, amplitude(1.5), false);
        robot.expect_done(Command::StreamTelemetry { every_frames: 1 });
        robot.expect_done(walk_for(frames));
        robot.run_until(State::Walking);
        robot.take_pulses();

        robot.run_until(State::Idle);

        let pulses = robot.take_pulses();
        robot.run_frames(3);
        let sample = robot.telemetry().last().unwrap();
        assert_eq!((sample.state, sample.trial_frames), (State::Idle, frames));
        assert_eq!(robot.events().filter(|event| *event == Event::WalkEnded(WalkEnd::Finished)).count(), 1);
        // The last gait frame, and then a stand at the gait's centre.
        let value = amplitude(1.5).value();
        let mut on = pulses.iter().filter(|p| servos_on(p));
        assert!(on.any(|p| error_counts(&gait, value, frames as usize - 1, p) <= 0.6), "{frames} frames");
        assert!(error_from(&gait.centre_deg, on.next_back().unwrap()) <= 0.6, "{frames} frames");
    }
}

#[test]
fn a_walk_of_no_frames_takes_the_first_pose_and_finishes() {
    let mut robot = SimRobot::new();
    robot.upload(&fixtures::trot(), amplitude(1.0), false);

    robot.expect_done(walk_for(0));
    robot.run_until(State::Holding);
    robot.run_until(State::Idle);

    assert!(robot.events().any(|event| event == Event::WalkEnded(WalkEnd::Finished)));
}

#[test]
fn entry_starts_at_neutral_and_never_exceeds_the_speed_bound() {
    let gait = fixtures::medley();
    let mut robot = SimRobot::new();
    robot.upload(&gait, amplitude(3.0), false);
    robot.take_pulses();

    robot.expect_done(WALK);
    robot.run_until(State::Walking);
    robot.run_frames(1);

    let pulses: Vec<Pulses> = robot.take_pulses().into_iter().filter(servos_on).collect();
    let neutral = [Some(NEUTRAL_COUNTS as u16); JOINT_COUNT];
    assert!(pulses.len() > 10, "{} frames of entry", pulses.len());
    assert!(step(&neutral, &pulses[0]) <= SLOW_STEP_COUNTS);
    assert!(largest_step(&pulses) <= SLOW_STEP_COUNTS, "{} counts", largest_step(&pulses));
    assert!(error_counts(&gait, 3.0, 0, pulses.last().unwrap()) <= 0.6);
}

/// The most frames that stand in one place.
fn longest_stand(pulses: &[Pulses]) -> usize {
    pulses.chunk_by(|a, b| a == b).map(<[_]>::len).max().unwrap_or(0)
}

#[test]
fn a_walk_stands_on_its_gaits_centre_for_half_a_second_then_goes_to_the_first_pose() {
    let gait = fixtures::medley();
    let mut robot = SimRobot::new();
    robot.upload(&gait, amplitude(2.2), false);

    robot.expect_done(WALK);
    robot.run_until(State::Walking);
    robot.run_frames(1);

    let pulses: Vec<Pulses> = robot.take_pulses().into_iter().filter(servos_on).collect();
    let stand = longest_stand(&pulses);
    assert!((30..=32).contains(&stand), "{stand} frames");
    let standing = pulses.chunk_by(|a, b| a == b).find(|chunk| chunk.len() == stand).unwrap()[0];
    assert!(error_from(&gait.centre_deg, &standing) <= 0.6);
    assert!(largest_step(&pulses) <= SLOW_STEP_COUNTS, "{} counts", largest_step(&pulses));
    assert!(error_counts(&gait, 2.2, 0, pulses.last().unwrap()) <= 0.6);
}

#[test]
fn a_gait_that_takes_over_in_mid_stride_does_not_stand_on_its_centre_first() {
    let gait = fixtures::medley();
    let mut robot = SimRobot::playing(&fixtures::trot(), amplitude(1.0));
    robot.run_frames(40);
    robot.take_pulses();

    robot.upload(&gait, amplitude(1.0), false);
    assert_eq!(robot.state(), State::Entering);
    robot.run_until(State::Walking);

    assert!(longest_stand(&robot.take_pulses()) <= 3);
}

#[test]
fn amplitude_slides_while_walking_and_arrives() {
    let gait = fixtures::trot();
    let (from, to) = (amplitude(1.0), amplitude(2.2));
    let frames = (gait.period_s * f64::from(FRAME_RATE_HZ)) as u64;
    let mut robot = SimRobot::playing(&gait, to);
    let fastest = largest_step(&robot.pulses_over(frames + 2));
    let mut robot = SimRobot::playing(&gait, from);
    robot.run_frames(10);
    robot.take_pulses();

    robot.expect_done(Command::SetAmplitude(to));
    robot.run_frames(180);

    let pulses = robot.take_pulses();
    // The gait at its widest, half a degree for the slide, and one rounding.
    assert!(largest_step(&pulses) <= fastest + 0.5 * COUNTS_PER_DEG + 1.0);
    let arrived = &pulses[pulses.len() - 1];
    let fits = (0..frames as usize).any(|frame| error_counts(&gait, to.value(), frame, arrived) <= 0.6);
    assert!(fits, "the last pose is none of the gait at {to:?}");
}

#[test]
fn amplitude_set_while_idle_is_the_next_walks() {
    let mut robot = SimRobot::new();
    robot.upload(&fixtures::trot(), amplitude(1.0), false);

    robot.expect_done(Command::SetAmplitude(amplitude(2.0)));

    assert_eq!(robot.status().gait.unwrap().amplitude, amplitude(2.0));
}

#[test]
fn an_amplitude_outside_the_limits_is_refused_everywhere() {
    // Off the wire an amplitude may be anything; here it comes by its bytes.
    let wild: Amplitude = postcard_of(40_000);
    let mut robot = SimRobot::new();
    robot.upload(&fixtures::trot(), amplitude(1.0), false);

    assert_eq!(robot.ask(Command::SetAmplitude(wild)), Reply::Refused(Refusal::Amplitude));
    let walk = Command::Walk { amplitude: Some(wild), frames: None, detached: true, dry_run: false };
    assert_eq!(robot.ask(walk), Reply::Refused(Refusal::Amplitude));
    let commit = Command::UploadCommit { amplitude: wild, persist: false };
    assert_eq!(robot.ask(commit), Reply::Refused(Refusal::Amplitude));

    assert_eq!(robot.state(), State::Idle);
    assert_eq!(robot.status().gait.unwrap().amplitude, amplitude(1.0));
}

fn postcard_of(units: u16) -> Amplitude {
    let deserializer = serde::de::value::U16Deserializer::<serde::de::value::Error>::new(units);
    serde::Deserialize::deserialize(serde::de::value::SeqDeserializer::<_, serde::de::value::Error>::new(
        std::iter::once(deserializer),
    ))
    .unwrap()
}

#[test]
fn joints_are_held_at_their_limits_and_the_frames_are_counted() {
    let mut gait = fixtures::trot();
    gait.limit_deg = 20.0;
    let mut robot = SimRobot::new();
    robot.upload(&gait, amplitude(2.2), false);
    robot.expect_done(Command::StreamTelemetry { every_frames: 1 });
    robot.expect_done(walk_for(72));
    robot.take_pulses();

    robot.run_until(State::Idle);

    let reach = (20.0 * COUNTS_PER_DEG).round() as u16;
    let within = 330 - reach..=330 + reach;
    assert!(robot.take_pulses().iter().flatten().flatten().all(|counts| within.contains(counts)));
    let clipped = robot.telemetry().last().unwrap().clipped_frames;
    let expected = (0..72)
        .filter(|&frame| {
            let phase = f64::from(frame) / 72.0;
            let free = Gait { limit_deg: 90.0, ..gait.clone() };
            (0..JOINT_COUNT).any(|joint| free.angle_deg(joint, phase, 2.2).abs() > 20.0)
        })
        .count();
    assert!(clipped.abs_diff(expected as u32) <= 2, "{clipped} frames clipped, {expected} expected");
}

/// Limits come with the gait; a servo's own end stops do not.
#[test]
fn no_angle_whatever_leaves_the_servos_reach() {
    let calibration = Calibration::authors();

    for units in i16::MIN..=i16::MAX {
        let counts = calibration.joint(Joint::Knee4).counts(units);
        assert!((147..=515).contains(&counts), "{counts} counts at {units} / 256 degree");
    }
}

#[test]
fn a_gait_uploaded_while_walking_is_entered_slowly_and_the_count_goes_on() {
    let mut robot = SimRobot::new();
    robot.upload(&fixtures::trot(), amplitude(1.0), false);
    robot.expect_done(walk_for(300));
    robot.run_until(State::Walking);
    robot.expect_done(Command::StreamTelemetry { every_frames: 1 });
    robot.run_frames(50);

    robot.upload(&fixtures::medley(), amplitude(2.2), false);
    robot.take_pulses();
    assert_eq!(robot.state(), State::Entering);
    let played = robot.telemetry().last().unwrap().trial_frames;
    robot.run_until(State::Walking);
    let entry = robot.take_pulses();
    robot.run_until(State::Idle);
    robot.run_frames(2);

    assert!(played < 300, "{played} frames before the change");
    assert!(largest_step(&entry) <= SLOW_STEP_COUNTS, "{}", largest_step(&entry));
    assert_eq!(robot.telemetry().last().unwrap().trial_frames, 300);
}

#[test]
fn walking_is_refused_with_the_reason() {
    let mut robot = SimRobot::new();
    let walk = WALK;

    let without_gait = robot.ask(walk);
    robot.upload(&fixtures::trot(), amplitude(1.0), false);
    robot.expect_done(walk);
    let entering = robot.ask(walk);
    robot.run_until(State::Walking);
    let walking = robot.ask(walk);

    assert_eq!(without_gait, Reply::Refused(Refusal::NoGait));
    assert_eq!(entering, Reply::Refused(Refusal::AlreadyWalking));
    assert_eq!(walking, Reply::Refused(Refusal::AlreadyWalking));
}
