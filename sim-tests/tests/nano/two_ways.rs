//! One gait, measured twice: by the simulation alone, and by the firmware in
//! the emulated Nano with its buses, pulses and supply around the same body.

use crate::support::image;
use host::energy::STANDARD_GRAVITY_M_S2;
use host::gait::gait_file::GaitFile;
use host::robot::{LegScale, Limbs, Robot};
use host::sim::open_loop::{self, Trial};
use host::sim::{Perturbation, Start};
use protocol::{Command, Joint};
use sim_tests::client::Client;
use sim_tests::devices::SHUNT_OHM;
use sim_tests::fixtures;
use sim_tests::nano::seconds;
use sim_tests::virtual_robot::VirtualRobot;
use std::path::Path;

const FRAMES: u32 = 720;
const STARTS: u64 = 5;
/// As long as it takes a person to ask for a walk, or longer than it takes to lie down.
const LIMP_S: f64 = 6.0;
/// Before it has sunk far.
const BRIEFLY_LIMP_S: f64 = 0.2;
/// How high the torso of a robot that lies on its belly is at most, by its height at neutral.
const LYING_SHARE: f64 = 0.75;

/// Speed and cost of transport.
type Result2 = [f64; 2];

/// A robot, and what it plays.
struct Case {
    robot: Robot,
    gait: GaitFile,
    amplitude: f64,
    /// Limp before the walk.
    limp_s: f64,
}

fn direct(Case { robot: description, gait, amplitude, .. }: &Case, seed: u64) -> Result2 {
    let start = Start::sampled(&Perturbation::default(), seed);
    // The robot's first walking frame is the gait's first, as here.
    let trial = Trial { start, duration_s: f64::from(FRAMES - 1) / 60.0, ..Trial::default() };
    let walk = open_loop::play(description, &trial, |t| {
        let phase = (t / gait.period_s).fract();
        Joint::ALL.map(|joint| gait.angle_deg(joint, phase, *amplitude).to_radians())
    });
    [walk.speed_m_s, walk.cost_of_transport]
}

fn through_the_firmware(Case { robot: description, gait, amplitude, limp_s }: &Case, seed: u64) -> Result2 {
    let mut robot = VirtualRobot::new(&image(), description, Some(seed)).unwrap();
    let mut client = Client::new();
    client.run_for(&mut robot, *limp_s).unwrap();
    let lying = *robot.take_truth().last().expect("a body");
    let lying_m = LYING_SHARE * Limbs::of(description).standing_height_m(&[0.0; 8]);
    let is_lying = lying.z_m < lying_m;
    assert!(
        is_lying || *limp_s < LIMP_S,
        "limp for {limp_s} s, its torso is at {} m, not below {lying_m}",
        lying.z_m
    );
    let (table, amplitude) = (gait.table().unwrap(), fixtures::amplitude(*amplitude));
    client.upload(&mut robot, &table, amplitude, false).unwrap();
    client.expect_done(&mut robot, Command::StreamTelemetry { every_frames: 1 }).unwrap();
    let walk = Command::Walk { amplitude: None, frames: Some(FRAMES), detached: true, dry_run: false };
    client.expect_done(&mut robot, walk).unwrap();
    client.run_for(&mut robot, 18.0).unwrap();
    let truth = robot.take_truth();
    let played = |frames: u32| {
        let found = client.telemetry().find(|(_, t)| t.trial_frames >= frames);
        let last = client.telemetry().last();
        let (cycle, sample) = found.unwrap_or_else(|| panic!("{frames} frames were not played: {last:?}"));
        (seconds(cycle), sample.trial_energy_uj)
    };
    let ((began_s, began_uj), (ended_s, ended_uj)) = (played(1), played(FRAMES));
    let at = |time_s: f64| truth[truth.partition_point(|sample| sample.time_s < time_s)];
    let (from, to) = (at(began_s), at(ended_s));
    let distance_m = (to.x_m - from.x_m).hypot(to.y_m - from.y_m);
    // The robot measures what leaves the battery; the simulation alone has no shunt that heats.
    let walking = truth.iter().filter(|sample| (began_s..ended_s).contains(&sample.time_s));
    let shunt_j = walking.map(|sample| sample.supply_a.powi(2) * SHUNT_OHM / 60.0).sum::<f64>();
    let energy_j = (ended_uj - began_uj) as f64 * 1e-6 - shunt_j;
    [
        distance_m / (ended_s - began_s),
        energy_j / (description.mass_kg() * STANDARD_GRAVITY_M_S2 * distance_m),
    ]
}

/// Means over the starts must agree within 3 %.
#[track_caller]
fn agree(case: &Case) {
    let mean = |measure: fn(&Case, u64) -> Result2| {
        let of: Vec<Result2> = (0..STARTS).map(|seed| measure(case, seed)).collect();
        [0, 1].map(|k| of.iter().map(|one| one[k]).sum::<f64>() / STARTS as f64)
    };

    let (simulated, robot) = (mean(direct), mean(through_the_firmware));

    println!(
        "speed {:.4} and {:.4} m/s, cost of transport {:.4} and {:.4}",
        simulated[0], robot[0], simulated[1], robot[1]
    );
    for (k, what) in ["speed", "cost of transport"].into_iter().enumerate() {
        let apart = robot[k] / simulated[k] - 1.0;
        assert!(apart.abs() < 0.03, "{what}: {} and {}, {:+.1} %", simulated[k], robot[k], 100.0 * apart);
    }
}

#[test]
fn simulation_and_firmware_agree_on_speed_and_cost_of_transport_within_3_per_cent() {
    let table = GaitFile::from_table(&fixtures::trot().table());
    agree(&Case { robot: Robot::ant(LegScale::LONG).unwrap(), gait: table, amplitude: 2.2, limp_s: LIMP_S });
}

#[test]
fn they_agree_on_the_searched_gaits_of_both_legs() {
    for leg in [LegScale::LONG, LegScale::SHORT] {
        let gait = host::search::bundled_gaits::gait(leg).unwrap().unwrap();
        agree(&Case { robot: Robot::ant(leg).unwrap(), gait, amplitude: 1.0, limp_s: LIMP_S });
    }
}

/// A searched gait of the robot that comes as an example: other servos, pulses, lengths and masses.
#[test]
fn they_agree_on_the_pony_calibrated_as_its_description_says() {
    let pony = Robot::load(Path::new("../host/robots/pony")).unwrap();
    let gait = GaitFile::parse(include_bytes!("pony.toml"), Path::new("pony.toml")).unwrap();
    // Standing up from its belly, it draws more than the board allows, 3 A.
    agree(&Case { robot: pony, gait, amplitude: 1.0, limp_s: BRIEFLY_LIMP_S });
}

/// No robot that anybody had in mind: lengths, masses, pulses, outputs and directions by chance.
#[test]
fn they_agree_on_a_robot_drawn_at_random() {
    let mut random = Random(18);
    let mut robot = Robot::ant(LegScale::new(random.within(0.7, 1.3)).unwrap()).unwrap();
    robot.name = "Random".into();
    robot.mass.torso_kg *= random.within(0.7, 1.5);
    robot.servo.neutral_pulse_us = random.within(1300.0, 1700.0);
    robot.servo.pulse_us_per_deg = random.within(6.0, 11.0);
    robot.servo.end_stop_deg = random.within(60.0, 90.0);
    robot.servo.pulse_range_us = None;
    let mut channels = robot.servo.channels();
    for last in (1..channels.len()).rev() {
        channels.swap(last, random.within(0.0, last as f64 + 1.0) as usize);
    }
    robot.servo.channels = Some(channels);
    robot.servo.reversed = Some(std::array::from_fn(|_| random.within(0.0, 1.0) < 0.5));
    robot.check().unwrap();
    let gait = GaitFile::from_table(&fixtures::trot().table());
    agree(&Case { robot, gait, amplitude: 2.0, limp_s: LIMP_S });
}

/// A linear congruential generator: the same robot on every machine, whatever a library does.
///
/// # Source
/// Knuth, MMIX.
struct Random(u64);

impl Random {
    fn within(&mut self, least: f64, most: f64) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        least + (most - least) * (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }
}
