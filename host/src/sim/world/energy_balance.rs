//! The energy balance of a walk, of a fall, and the error of the physics step.

use super::*;
use crate::energy::SIMULATED_GRAVITY_M_S2;
use crate::robot::LegScale;
use crate::sim::open_loop::{self, Trial, Walk};

const DURATION_S: f64 = 12.0;

fn ant() -> Robot {
    Robot::ant(LegScale::LONG).expect("the Ant")
}

/// A trot along x with the stroke of the measured gaits.
fn trot(t: f64) -> [f64; JOINT_COUNT] {
    let phase = core::f64::consts::TAU * t / 1.6;
    core::array::from_fn(|j| {
        let leg_phase = phase + core::f64::consts::PI * (j % 2) as f64;
        let swing = if j % LEG_COUNT < 2 { 0.5 } else { -0.5 };
        if j < LEG_COUNT { swing * leg_phase.sin() } else { 0.3 * leg_phase.cos() }
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

/// The work of the servos must equal the change of kinetic and potential energy plus
/// the losses to the ground: friction under feet that slide, and feet that land. The
/// losses are computed from contact forces, not as the difference.
#[test]
fn the_energy_balance_of_a_walk_closes() {
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
        let losses = world.ground_losses(&soles_before, &soles);
        slid_j += losses.slid_j;
        landed_j += losses.landed_j;
        lifted_n_s += losses.lifted_n_s;
    }

    let gained_j = mechanical_energy_j(&world) - before_j;
    println!(
        "servos gave {given_j:.3} J and took {returned_j:.3} J; feet slid {slid_j:.3} J, landed {landed_j:.3} J; gained {gained_j:.3} J"
    );
    let unexplained_j = given_j - returned_j - slid_j - landed_j - gained_j;
    // The error of semi-implicit steps of 1/240 s.
    let moved_j = given_j + returned_j;
    assert!(unexplained_j.abs() < 0.1 * moved_j, "{unexplained_j} J of {moved_j} J are unaccounted for");
    assert!(given_j > 0.5, "the trot is too small to say anything: {given_j} J");
    // The battery's side: electronics, heat of the windings, losses of the drive, and the work.
    let losses_j = given_j * (1.0 / robot.power.efficiency - 1.0);
    let spent_j = robot.power.electronics_w * DURATION_S + holding_j + losses_j + given_j;
    assert!((battery_j / spent_j - 1.0).abs() < 1e-9, "battery {battery_j} J, spent {spent_j} J");
    assert!(battery_j >= given_j / robot.power.efficiency);
    // Windings are heated by the supply and by what the robot returns.
    assert!(holding_j <= heat_j && heat_j <= holding_j + returned_j, "{heat_j} J of heat");
    // The contact forces carry the robot's weight, so none is missing.
    let weight_n_s = robot.mass_kg() * SIMULATED_GRAVITY_M_S2 * DURATION_S;
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
    // The servos set the legs swinging.
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
        world.step(&[None; JOINT_COUNT]);
    }

    let fallen_j = robot.mass_kg() * SIMULATED_GRAVITY_M_S2 * (height_m - world.torso().position_m[2]);
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
