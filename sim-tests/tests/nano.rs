//! The real firmware image on the emulated Nano, with chips, supply and body.
//!
//! A missing image fails every test here, with the next move.

use host::robot::Robot;
use host::sim::World;
use protocol::command::Storage;
use protocol::{
    Command, Event, FRAME_RATE_HZ, Fault, JOINT_COUNT, Message, PROTOCOL_VERSION, Refusal, Reply, ResetCause,
    State, Status,
};
use sim_tests::body::{Bench, Body};
use sim_tests::client::Client;
use sim_tests::devices::Chip;
use sim_tests::devices::pca9685::{Burst, NOMINAL_OSCILLATOR_HZ};
use sim_tests::firmware_image::FirmwareImage;
use sim_tests::fixtures::{self, Gait, amplitude};
use sim_tests::nano::{CLOCK_HZ, Counters, seconds};
use sim_tests::virtual_robot::{Truth, VirtualRobot};

/// Half a count of rounding, and what the protocol proves of its setpoints.
const HALF_COUNT: f64 = 0.5;
const SETPOINT_ERROR_DEG: f64 = 0.05;
/// The firmware's default calibration: 5/3 counts a degree about 330.
const COUNTS_PER_DEG: f64 = 5.0 / 3.0;
const NEUTRAL_COUNTS: f64 = 330.0;

fn image() -> FirmwareImage {
    FirmwareImage::load(&FirmwareImage::default_path()).unwrap_or_else(|error| panic!("{error}"))
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

/// Servos in a vice: the fastest body.
fn on_the_bench() -> (VirtualRobot, Client) {
    started(Box::new(Bench::new(0.1)))
}

fn hello() -> Command {
    Command::Hello { protocol_version: PROTOCOL_VERSION }
}

fn status(robot: &mut VirtualRobot, client: &mut Client) -> Status {
    match client.ask(robot, Command::Status).unwrap() {
        Reply::Status(status) => status,
        other => panic!("{other:?}"),
    }
}

/// Runs until the robot is in this state, for at most `patience_s`.
fn wait_for(robot: &mut VirtualRobot, client: &mut Client, state: State, patience_s: f64) {
    let deadline_s = robot.now_s() + patience_s;
    while status(robot, client).state != state {
        assert!(robot.now_s() < deadline_s, "still {:?}, not {state:?}", status(robot, client).state);
        client.run_for(robot, 0.02).unwrap();
    }
}

/// Bursts that set all eight servos, between two moments.
fn walking_bursts(bursts: &[Burst]) -> Vec<&Burst> {
    bursts.iter().filter(|burst| burst.counts[..JOINT_COUNT].iter().all(Option::is_some)).collect()
}

/// Largest difference between a burst and the gait at its best phase, beyond
/// what rounding to a count allows; in degrees.
fn excess_deg(gait: &Gait, amplitude: f64, phase: f64, burst: &Burst) -> f64 {
    (0..JOINT_COUNT)
        .map(|joint| {
            let counts = f64::from(burst.counts[joint].unwrap());
            let expected = NEUTRAL_COUNTS + COUNTS_PER_DEG * gait.angle_deg(joint, phase, amplitude);
            ((counts - expected).abs() - HALF_COUNT) / COUNTS_PER_DEG
        })
        .fold(f64::MIN, f64::max)
}

/// True energy at a moment, between the samples around it.
fn energy_at(truth: &[Truth], time_s: f64) -> f64 {
    let after = truth.partition_point(|sample| sample.time_s < time_s).clamp(1, truth.len() - 1);
    let (a, b) = (&truth[after - 1], &truth[after]);
    a.true_energy_j + (b.true_energy_j - a.true_energy_j) * (time_s - a.time_s) / (b.time_s - a.time_s)
}

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
    client.upload(&mut robot, &gait.table(), amplitude(2.2), false).unwrap();
    client.expect_done(&mut robot, Command::StreamTelemetry { every_frames: 1 }).unwrap();
    client.expect_done(&mut robot, Command::Walk { amplitude: None, frames: None }).unwrap();
    wait_for(&mut robot, &mut client, State::Walking, 5.0);
    // The outputs follow a frame after the state.
    client.run_for(&mut robot, 0.05).unwrap();
    robot.take_bursts();

    client.run_for(&mut robot, 2.0 * gait.period_s).unwrap();

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
    client.expect_done(&mut robot, Command::Walk { amplitude: None, frames: None }).unwrap();
    wait_for(&mut robot, &mut client, State::Walking, 5.0);

    robot.nano_mut().reset(CLOCK_HZ);
    robot.run_for(0.9).unwrap();
    assert!(robot.nano().bus().pca9685.drives_any(), "the chip knows nothing of the reset");
    robot.run_for(0.11).unwrap();

    assert!(!robot.nano().bus().pca9685.drives_any());
}

#[test]
fn a_walk_of_n_frames_plays_n_frames_and_ends_limp() {
    let (mut robot, mut client) = on_the_bench();
    client.upload(&mut robot, &fixtures::trot().table(), amplitude(1.0), false).unwrap();
    client.expect_done(&mut robot, Command::StreamTelemetry { every_frames: 1 }).unwrap();
    client.expect_done(&mut robot, Command::Walk { amplitude: None, frames: Some(90) }).unwrap();

    client.run_for(&mut robot, 8.0).unwrap();

    assert!(client.heard().iter().any(|(_, m)| *m == Message::Event(Event::WalkFinished)));
    let (_, last) = client.telemetry().next_back().unwrap();
    assert_eq!((last.trial_frames, last.state), (90, State::Idle));
    assert!(!robot.nano().bus().pca9685.drives_any());
}

#[test]
fn amplitude_changes_while_walking_without_a_jump() {
    let gait = fixtures::trot();
    let (mut robot, mut client) = on_the_bench();
    client.upload(&mut robot, &gait.table(), amplitude(1.0), false).unwrap();
    client.expect_done(&mut robot, Command::Walk { amplitude: None, frames: None }).unwrap();
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
fn a_lost_sensor_stops_the_walk_and_the_fault_is_told() {
    let (mut robot, mut client) = on_the_bench();
    client.upload(&mut robot, &fixtures::trot().table(), amplitude(1.0), false).unwrap();
    client.expect_done(&mut robot, Command::Walk { amplitude: None, frames: None }).unwrap();
    wait_for(&mut robot, &mut client, State::Walking, 5.0);

    robot.nano_mut().bus_mut().unplug(Chip::Ina219);
    client.run_for(&mut robot, 2.0).unwrap();

    assert!(client.heard().iter().any(|(_, m)| *m == Message::Event(Event::Fault(Fault::SensorLost))));
    assert_eq!(status(&mut robot, &mut client).state, State::Fault(Fault::SensorLost));
    assert!(!robot.nano().bus().pca9685.drives_any());
}

#[test]
fn a_sensor_that_lost_its_configuration_is_noticed() {
    let (mut robot, mut client) = on_the_bench();
    client.upload(&mut robot, &fixtures::trot().table(), amplitude(1.0), false).unwrap();
    client.expect_done(&mut robot, Command::Walk { amplitude: None, frames: None }).unwrap();
    wait_for(&mut robot, &mut client, State::Walking, 5.0);
    let configured = robot.nano().bus().ina219.configuration();

    let now_s = robot.now_s();
    robot.nano_mut().bus_mut().ina219.brown_out(now_s);
    client.run_for(&mut robot, 3.0).unwrap();

    let faulted = status(&mut robot, &mut client).state == State::Fault(Fault::SensorLost);
    let restored = robot.nano().bus().ina219.configuration() == configured;
    println!("faulted: {faulted}, configured again: {restored}");
    assert!(faulted || restored, "it walks on with a sensor that measures something else");
}

#[test]
fn a_stuck_bus_neither_hangs_nor_crashes_and_the_robot_still_answers() {
    let (mut robot, mut client) = on_the_bench();
    client.upload(&mut robot, &fixtures::trot().table(), amplitude(1.0), false).unwrap();
    client.expect_done(&mut robot, Command::Walk { amplitude: None, frames: None }).unwrap();
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
    assert!(!robot.nano().bus().pca9685.drives_any());
}

#[test]
fn energy_over_12_s_of_walking_is_within_2_per_cent_of_the_batterys() {
    const FRAMES: u32 = 720;
    let ant = Robot::ant(1.0).unwrap();
    let (mut robot, mut client) = started(Box::new(World::new(&ant)));
    client.upload(&mut robot, &fixtures::trot().table(), amplitude(2.2), false).unwrap();
    client.expect_done(&mut robot, Command::StreamTelemetry { every_frames: 1 }).unwrap();
    client.expect_done(&mut robot, Command::Walk { amplitude: None, frames: Some(FRAMES) }).unwrap();
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
        let ant = Robot::ant(0.6).unwrap();
        let mut robot = VirtualRobot::new(&image(), &ant, Some(7)).unwrap();
        let mut client = Client::new();
        client.run_for(&mut robot, 0.3).unwrap();
        client.upload(&mut robot, &fixtures::trot().table(), amplitude(1.5), true).unwrap();
        client.expect_done(&mut robot, Command::StreamTelemetry { every_frames: 1 }).unwrap();
        client.expect_done(&mut robot, Command::Walk { amplitude: None, frames: Some(60) }).unwrap();
        client.run_for(&mut robot, 4.0).unwrap();
        (robot.take_truth(), robot.take_bursts(), client.heard().to_vec())
    };

    assert_eq!(run(), run());
}
