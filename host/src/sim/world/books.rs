//! Where the battery's energy goes, and what the physics step's length changes.

use super::*;
use crate::sim::open_loop::{self, Trial, Walk};

const DURATION_S: f64 = 12.0;

fn ant() -> Robot {
    Robot::ant(1.0).expect("1.0 is a leg scale")
}

/// A trot along x with the stroke of the measured gaits.
fn trot(t: f64) -> [f64; 8] {
    let phase = core::f64::consts::TAU * t / 1.6;
    core::array::from_fn(|j| {
        let leg_phase = phase + core::f64::consts::PI * (j % 2) as f64;
        let swing = if j % 4 < 2 { 0.5 } else { -0.5 };
        if j < 4 { swing * leg_phase.sin() } else { 0.3 * leg_phase.cos() }
    })
}

/// Kinetic and potential energy of all links.
fn mechanical_energy_j(world: &World) -> f64 {
    let gravity_m_s2 = f64::from(-world.body.physics.gravity.z);
    let of = |body: &RigidBody| {
        let height_m = f64::from(body.center_of_mass().z);
        f64::from(body.kinetic_energy()) + f64::from(body.mass()) * gravity_m_s2 * height_m
    };
    world.body.physics.bodies.iter().filter(|(_, body)| body.is_dynamic()).map(|(_, body)| of(body)).sum()
}

/// What the servos' horns gave must be found again as motion, height, and what
/// the ground took: by friction under soles that slide, and by stopping feet
/// that land. The ground's part is computed from its contact forces, not as
/// what is missing.
#[test]
fn the_energy_books_balance_over_a_walk() {
    let robot = ant();
    let mut world = World::new(&robot);
    let before_j = mechanical_energy_j(&world);
    let (mut given_j, mut returned_j, mut slid_j, mut landed_j) = (0.0, 0.0, 0.0, 0.0);
    let (mut battery_j, mut heat_j, mut holding_j, mut lifted_n_s) = (0.0, 0.0, 0.0, 0.0);

    for step in 0..(DURATION_S / World::STEP_S) as usize {
        let soles_before = world.sole_velocities_m_s();
        let outcome = world.step(&trot(step as f64 * World::STEP_S).map(Some));
        let soles = world.sole_velocities_m_s();
        given_j += outcome.mechanical_power_w * World::STEP_S;
        returned_j += outcome.returned_power_w * World::STEP_S;
        battery_j += (outcome.servo_power_w + robot.power.electronics_w) * World::STEP_S;
        heat_j += outcome.heat_power_w * World::STEP_S;
        holding_j += outcome.holding_power_w * World::STEP_S;
        let taken = world.taken_by_ground(&soles_before, &soles);
        slid_j += taken.slid_j;
        landed_j += taken.landed_j;
        lifted_n_s += taken.lifted_n_s;
    }

    let gained_j = mechanical_energy_j(&world) - before_j;
    println!(
        "horns gave {given_j:.3} J and took {returned_j:.3} J; soles slid {slid_j:.3} J, landed {landed_j:.3} J; gained {gained_j:.3} J"
    );
    let unexplained_j = given_j - returned_j - slid_j - landed_j - gained_j;
    // Semi-implicit steps of 1/240 s are no better than that.
    let moved_j = given_j + returned_j;
    assert!(unexplained_j.abs() < 0.1 * moved_j, "{unexplained_j} J of {moved_j} J are unaccounted for");
    assert!(given_j > 0.5, "the trot is too small to say anything: {given_j} J");
    // The battery's side: electronics, heat of the windings, losses of the drive, and the work.
    let losses_j = given_j * (1.0 / robot.power.efficiency - 1.0);
    let spent_j = robot.power.electronics_w * DURATION_S + holding_j + losses_j + given_j;
    assert!((battery_j / spent_j - 1.0).abs() < 1e-9, "battery {battery_j} J, spent {spent_j} J");
    assert!(battery_j >= given_j / robot.power.efficiency);
    // A winding is heated by the supply, or by what the robot returns, which may be more.
    assert!(holding_j <= heat_j && heat_j <= holding_j + returned_j, "{heat_j} J of heat");
    // The contact forces carry the robot, so they are all of them.
    let weight_n_s = robot.mass_kg() * 9.81 * DURATION_S;
    assert!((lifted_n_s / weight_n_s - 1.0).abs() < 0.02, "{lifted_n_s} N s carry {weight_n_s} N s");
}

/// Motors off and no damping: a robot in the air only falls and swings.
#[test]
fn a_limp_robot_in_the_air_keeps_its_energy() {
    let pony = concat!(env!("CARGO_MANIFEST_DIR"), "/robots/pony");
    for robot in [ant(), Robot::load(pony.as_ref()).expect("a robot")] {
        keeps_its_energy(robot);
    }
}

fn keeps_its_energy(mut robot: Robot) {
    let servo = &mut robot.servo;
    (servo.damping_n_m_s_rad, servo.backdriven_damping_n_m_s_rad, servo.friction_n_m) = (0.0, 0.0, 0.0);
    // Strong servos without damping would shake light legs by themselves.
    robot.servo.stiffness_n_m_rad = robot.servo.stiffness_n_m_rad.min(2.5);
    let mut world = World::new(&robot);
    let start = Start { drop_m: 5.0, ..Start::default() };
    world.reset(&[0.3, -0.2, 0.1, 0.0, 0.4, 0.2, -0.3, 0.1], &start);
    // A kick of the servos' own makes the legs swing.
    for _ in 0..24 {
        world.step(&[
            Some(0.8),
            Some(-0.8),
            Some(0.5),
            Some(-0.5),
            Some(0.9),
            Some(-0.4),
            Some(0.6),
            Some(0.0),
        ]);
    }
    let before_j = mechanical_energy_j(&world);
    let height_m = world.torso().position_m[2];

    for _ in 0..120 {
        world.step(&[None; 8]);
    }

    let fallen_j = robot.mass_kg() * 9.81 * (height_m - world.torso().position_m[2]);
    let change_j = mechanical_energy_j(&world) - before_j;
    assert!(fallen_j > 10.0, "it fell by {fallen_j} J only");
    assert!(change_j.abs() < 0.03 * fallen_j, "{change_j} J of {fallen_j} J came or went");
}

fn walk_in(substeps: u32) -> Walk {
    open_loop::play_in(&mut World::refined(&ant(), substeps), &Trial::default(), &mut trot)
}

#[test]
fn half_the_step_walks_as_far_for_the_same_energy() {
    let (coarse, fine) = (walk_in(1), walk_in(2));

    let speed = coarse.speed_m_s / fine.speed_m_s - 1.0;
    let cost = coarse.cost_of_transport / fine.cost_of_transport - 1.0;
    println!("half the step: speed {:+.1} %, cost of transport {:+.1} %", -100.0 * speed, -100.0 * cost);
    assert!(coarse.speed_m_s > 0.02, "{coarse:?}");
    assert!(speed.abs() < 0.05, "speed {} and {} m/s", coarse.speed_m_s, fine.speed_m_s);
    assert!(cost.abs() < 0.05, "{} and {}", coarse.cost_of_transport, fine.cost_of_transport);
}
