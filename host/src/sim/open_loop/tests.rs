//! Gaits walk as far as they should, and mirrored gaits walk mirrored.

use super::*;
use crate::robot::LegScale;
use core::f64::consts::{PI, TAU};
use protocol::LEG_COUNT;

fn ant() -> Robot {
    Robot::ant(LegScale::LONG).expect("the Ant")
}

/// A trot along x that turns to one side: legs on the left swing wider.
fn veering_trot(t: f64) -> [f64; JOINT_COUNT] {
    let phase = TAU * t / 1.0;
    core::array::from_fn(|j| {
        let leg = j % LEG_COUNT;
        let leg_phase = phase + PI * (leg % 2) as f64;
        // A hip's counter-clockwise turn takes a left foot back and a right foot forward.
        let swing = if leg < 2 { 0.35 } else { -0.25 };
        if j < LEG_COUNT { swing * leg_phase.sin() } else { 0.3 * leg_phase.cos() }
    })
}

/// The same gait in a mirror that holds the x axis: legs 1 and 4, 2 and 3 change places.
fn mirrored(gait: [f64; JOINT_COUNT]) -> [f64; JOINT_COUNT] {
    core::array::from_fn(|j| if j < LEG_COUNT { -gait[3 - j] } else { gait[11 - j] })
}

#[test]
fn a_mirrored_gait_walks_the_mirrored_way() {
    let one = play(&ant(), &Trial::default(), veering_trot);
    let other = play(&ant(), &Trial::default(), |t| mirrored(veering_trot(t)));

    assert!(one.distance_m > 0.5, "{one:?}");
    assert!(one.turned_rad.abs() > 0.1, "{one:?}");
    let tolerance_m = 0.05 * one.distance_m;
    assert!((one.displacement_m[0] - other.displacement_m[0]).abs() < tolerance_m, "{one:?} {other:?}");
    assert!((one.displacement_m[1] + other.displacement_m[1]).abs() < tolerance_m, "{one:?} {other:?}");
    assert!((one.turned_rad + other.turned_rad).abs() < 0.1, "{one:?} {other:?}");
}

#[test]
fn standing_takes_the_electronics_power_and_what_holding_takes_and_gets_nowhere() {
    let robot = ant();

    let walk = play(&robot, &Trial::default(), |_| [0.0; JOINT_COUNT]);

    let servos_w = walk.mean_power_w - robot.power.electronics_w;
    assert!((servos_w - walk.mean_holding_power_w).abs() < 0.005, "{walk:?}");
    assert!(walk.mean_mechanical_power_w < 0.005, "{walk:?}");
    assert!(walk.distance_m < 0.004, "{walk:?}");
    assert!(!walk.fell && walk.dragged_share == 0.0);
    assert!(walk.cost_of_transport > 10.0);
}

#[test]
fn cost_of_transport_is_energy_over_weight_and_distance() {
    let robot = ant();

    let walk = play(&robot, &Trial { duration_s: 6.0, ..Trial::default() }, veering_trot);

    let expected = walk.mean_power_w / (robot.mass_kg() * 9.806_65 * walk.speed_m_s);
    assert!((walk.cost_of_transport / expected - 1.0).abs() < 1e-9);
    assert!((walk.energy_j - 6.0 * walk.mean_power_w).abs() < 1e-9);
}
