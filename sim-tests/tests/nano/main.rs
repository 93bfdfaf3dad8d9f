//! The real firmware image on the emulated Nano, with chips, supply and body.
//!
//! A missing image fails every test here, and the message says how to build one.

mod chips;
mod faults;
mod port;
mod stack;
mod support;
mod two_ways;

use host::robot::{LegScale, Robot};
use host::sim::World;
use protocol::command::{Record, Storage};
use protocol::{
    Command, Event, FRAME_RATE_HZ, Message, PROTOCOL_VERSION, Refusal, Reply, ResetCause, State, WalkEnd,
};
use sim_tests::body::Bench;
use sim_tests::client::Client;
use sim_tests::fixtures::{self, amplitude};
use sim_tests::nano::{Counters, seconds};
use sim_tests::virtual_robot::VirtualRobot;
use support::*;

#[test]
fn servos_are_switched_off_before_anything_else() {
    let mut robot = robot_with(Box::new(Bench::new(0.1)));

    robot.run_for(0.05).unwrap();

    let first = &robot.take_bursts()[0];
    println!("servos off {:.2} ms after power-on", first.stop_s * 1e3);
    assert!(first.counts.iter().all(Option::is_none));
    assert!(first.stop_s < 2e-3, "{} s", first.stop_s);
}

#[test]
fn hello_is_answered_within_wire_time_and_a_frame() {
    let (mut robot, mut client) = on_the_bench();

    let asked_at = robot.now();
    let (reply, answered_at) = client.ask_timed(&mut robot, hello()).unwrap();

    let Reply::Hello(hello) = reply else { panic!("{reply:?}") };
    assert_eq!(hello.protocol_version, PROTOCOL_VERSION);
    assert_eq!(hello.reset_cause, ResetCause::PowerOn);
    let took_ms = seconds(answered_at - asked_at) * 1e3;
    println!("hello answered after {took_ms:.2} ms: {hello:?}");
    // Two short frames on the wire, and at most one of the robot's 60 a second.
    assert!(took_ms < 17.0 + 5.0, "{took_ms} ms");
}

#[test]
fn another_protocol_version_is_refused_and_says_which_it_speaks() {
    let (mut robot, mut client) = on_the_bench();

    let reply = client.ask(&mut robot, Command::Hello { protocol_version: 99 }).unwrap();

    assert_eq!(reply, Reply::Refused(Refusal::ProtocolVersion { robot: PROTOCOL_VERSION }));
}

#[test]
fn every_pulse_of_full_loops_equals_the_f64_reference_at_60_hertz() {
    let gait = fixtures::medley();
    let (mut robot, mut client) = on_the_bench();
    // Saved meanwhile, and asked for: the frames must not care.
    client.upload(&mut robot, &gait.table(), amplitude(2.2), true).unwrap();
    client.expect_done(&mut robot, Command::StreamTelemetry { every_frames: 1 }).unwrap();
    client
        .expect_done(
            &mut robot,
            Command::Walk { amplitude: None, frames: None, detached: true, dry_run: false },
        )
        .unwrap();
    wait_for(&mut robot, &mut client, State::Walking, 5.0);
    // The outputs follow a frame after the state.
    client.run_for(&mut robot, 0.05).unwrap();
    robot.take_bursts();

    for part in 0..40 {
        client.ask(&mut robot, Command::Read { record: Record::Gait, offset: 64 * (part % 5) }).unwrap();
        client.run_for(&mut robot, gait.period_s / 20.0).unwrap();
    }

    assert_eq!(status(&mut robot, &mut client).storage, Storage::Saved);
    let bursts = robot.take_bursts();
    let bursts = walking_bursts(&bursts);
    let frames_per_loop = gait.period_s * f64::from(FRAME_RATE_HZ);
    assert!(bursts.len() as f64 >= 2.0 * frames_per_loop - 1.0, "{} bursts", bursts.len());

    // The gait began at phase 0 some frames ago: find which frame this is.
    let value = amplitude(2.2).value();
    let phase_of = |frame: usize| (frame as f64 / frames_per_loop).fract();
    let first = (0..frames_per_loop as usize)
        .min_by(|&a, &b| {
            let excess = |frame| excess_deg(&gait, value, phase_of(frame), bursts[0]);
            excess(a).total_cmp(&excess(b))
        })
        .unwrap();
    let worst = bursts
        .iter()
        .enumerate()
        .map(|(i, burst)| excess_deg(&gait, value, phase_of(first + i), burst))
        .fold(f64::MIN, f64::max);
    println!("{} bursts, worst beyond half a count: {worst:.4} degrees", bursts.len());
    assert!(worst <= SETPOINT_ERROR_DEG, "{worst} degrees beyond half a count");

    // Against the exact 60 Hz grid through the first burst.
    let late_us: Vec<f64> = bursts
        .iter()
        .enumerate()
        .map(|(i, burst)| (burst.start_s - bursts[0].start_s - i as f64 / f64::from(FRAME_RATE_HZ)) * 1e6)
        .collect();
    let (early, late) =
        late_us.iter().fold((0.0, 0.0), |(low, high): (f64, f64), &us| (low.min(us), high.max(us)));
    println!("bursts against the 60 Hz grid: {early:.1} to {late:.1} us");
    assert!(late - early < 100.0, "{early} to {late} us");
    assert_eq!(robot.nano().counters(), Counters::default());
}

#[test]
fn a_walk_of_n_frames_plays_n_frames_and_ends_limp() {
    let (mut robot, mut client) = on_the_bench();
    client.upload(&mut robot, &fixtures::trot().table(), amplitude(1.0), false).unwrap();
    client.expect_done(&mut robot, Command::StreamTelemetry { every_frames: 1 }).unwrap();
    client
        .expect_done(
            &mut robot,
            Command::Walk { amplitude: None, frames: Some(90), detached: true, dry_run: false },
        )
        .unwrap();

    client.run_for(&mut robot, 8.0).unwrap();

    assert!(client.heard().iter().any(|(_, m)| *m == Message::Event(Event::WalkEnded(WalkEnd::Finished))));
    let (_, last) = client.telemetry().next_back().unwrap();
    assert_eq!((last.trial_frames, last.state), (90, State::Idle));
    assert!(!robot.nano().bus().servo_driver.drives_any());
}

#[test]
fn amplitude_changes_while_walking_without_a_jump() {
    let gait = fixtures::trot();
    let (mut robot, mut client) = on_the_bench();
    client.upload(&mut robot, &gait.table(), amplitude(1.0), false).unwrap();
    client
        .expect_done(
            &mut robot,
            Command::Walk { amplitude: None, frames: None, detached: true, dry_run: false },
        )
        .unwrap();
    wait_for(&mut robot, &mut client, State::Walking, 5.0);
    robot.take_bursts();

    client.run_for(&mut robot, gait.period_s).unwrap();
    client.expect_done(&mut robot, Command::SetAmplitude(amplitude(2.0))).unwrap();
    client.run_for(&mut robot, 3.0 * gait.period_s).unwrap();

    let bursts = robot.take_bursts();
    let counts: Vec<f64> =
        walking_bursts(&bursts).iter().map(|burst| f64::from(burst.counts[0].unwrap())).collect();
    let span = |counts: &[f64]| {
        counts.iter().fold(f64::MIN, |a, &b| a.max(b)) - counts.iter().fold(f64::MAX, |a, &b| a.min(b))
    };
    let frames = (gait.period_s * f64::from(FRAME_RATE_HZ)) as usize;
    let (before, after) = (span(&counts[..frames]), span(&counts[counts.len() - frames..]));
    println!("hip 1 spans {before} counts before and {after} after");
    assert!((after / before - 2.0).abs() < 0.06, "{before} to {after} counts");
    // 11 degrees at 1.2 s and 2.0x: at most 0.96 degree a frame, 1.6 counts, and rounding.
    let jump = counts.windows(2).map(|w| (w[1] - w[0]).abs()).fold(0.0, f64::max);
    println!("largest step: {jump} counts");
    assert!(jump <= 8.0, "{jump} counts in one frame");
}

#[test]
fn energy_over_12_s_of_walking_is_within_2_per_cent_of_the_batterys() {
    const FRAMES: u32 = 720;
    let ant = Robot::ant(LegScale::LONG).unwrap();
    let (mut robot, mut client) = started(Box::new(World::new(&ant)));
    client.upload(&mut robot, &fixtures::trot().table(), amplitude(2.2), false).unwrap();
    client.expect_done(&mut robot, Command::StreamTelemetry { every_frames: 1 }).unwrap();
    client
        .expect_done(
            &mut robot,
            Command::Walk { amplitude: None, frames: Some(FRAMES), detached: true, dry_run: false },
        )
        .unwrap();
    client.run_for(&mut robot, 18.0).unwrap();
    let truth = robot.take_truth();

    let at = |frames: u32| {
        let (cycle, sample) = client.telemetry().find(|(_, t)| t.trial_frames >= frames).expect("played");
        (seconds(cycle), sample)
    };
    let ((began_s, first), (ended_s, last)) = (at(1), at(FRAMES));
    let reported_j = (last.trial_energy_uj - first.trial_energy_uj) as f64 * 1e-6;
    let true_j = energy_at(&truth, ended_s) - energy_at(&truth, began_s);
    let error = reported_j / true_j - 1.0;

    let x_m = |time_s: f64| truth[truth.partition_point(|t| t.time_s < time_s)].x_m;
    println!(
        "{:.2} s: {reported_j:.3} J reported, {true_j:.3} J true, {:+.2} %; {} samples missed; x {:+.3} m",
        ended_s - began_s,
        100.0 * error,
        last.missed_samples,
        x_m(ended_s) - x_m(began_s),
    );
    assert_eq!(last.trial_frames, FRAMES);
    assert!((ended_s - began_s - 719.0 / 60.0).abs() < 0.01);
    assert!(error.abs() < 0.02, "{:.2} %", 100.0 * error);
}

#[test]
fn equal_inputs_give_equal_runs() {
    let run = || {
        let ant = Robot::ant(LegScale::SHORT).unwrap();
        let mut robot = VirtualRobot::new(&image(), &ant, Some(7)).unwrap();
        let mut client = Client::new();
        client.run_for(&mut robot, 0.3).unwrap();
        client.upload(&mut robot, &fixtures::trot().table(), amplitude(1.5), true).unwrap();
        client.expect_done(&mut robot, Command::StreamTelemetry { every_frames: 1 }).unwrap();
        client
            .expect_done(
                &mut robot,
                Command::Walk { amplitude: None, frames: Some(60), detached: true, dry_run: false },
            )
            .unwrap();
        client.run_for(&mut robot, 4.0).unwrap();
        (robot.take_truth(), robot.take_bursts(), client.heard().to_vec())
    };

    assert_eq!(run(), run());
}
