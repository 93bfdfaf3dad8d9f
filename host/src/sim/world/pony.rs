//! A second robot, from its folder: other axes, other sizes, URDF.

use super::*;
use crate::sim::open_loop::{self, Trial};
use std::path::Path;

fn pony() -> Robot {
    Robot::load(Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/robots/pony"))).expect("a robot")
}

#[test]
fn it_stands_as_drawn_and_stays_there() {
    let mut world = World::new(&pony());
    let drawn_m = world.torso().position_m[2];
    // Thigh and shin of 0.1 m slope by 60 degrees, the foot's ball stands upright.
    assert!((drawn_m - (0.75_f64.sqrt() * 0.19 + 0.01)).abs() < 1e-5, "{drawn_m} m");
    for _ in 0..480 {
        world.step(&[Some(0.0); JOINT_COUNT]);
    }
    let settled = world.torso();

    for _ in 0..2400 {
        world.step(&[Some(0.0); JOINT_COUNT]);
    }

    let later = world.torso();
    for axis in 0..3 {
        let moved_m = (later.position_m[axis] - settled.position_m[axis]).abs();
        assert!(moved_m < 0.001, "axis {axis} moved {moved_m} m");
    }
    assert_eq!(world.foot_contacts(), [true; LEG_COUNT]);
    assert!(!world.body_touches_ground());
    // Its servos sag under it, but not far.
    assert!((0.0..0.01).contains(&(drawn_m - later.position_m[2])), "{} m", later.position_m[2]);
}

#[test]
fn a_joint_stops_where_its_own_range_ends_although_its_servo_goes_on() {
    let robot = pony();
    let mut world = World::new(&robot);
    // In the air, so that nothing else stops it.
    world.reset(&[0.0; JOINT_COUNT], &Start { drop_m: 5.0, ..Start::default() });
    let mut asked = [Some(0.0); JOINT_COUNT];
    (asked[4], asked[5]) = (Some(1.5), Some(-1.5));

    for _ in 0..200 {
        world.step(&asked);
    }

    let angles_rad = world.joint_angles_rad();
    for (joint, end_rad) in [(4, 0.9), (5, -0.8)] {
        let beyond_rad = angles_rad[joint] / end_rad - 1.0;
        assert!((-0.01..0.06).contains(&beyond_rad), "joint {joint} is at {} rad", angles_rad[joint]);
    }
    assert!((world.servo_setpoints_rad()[4] - 1.5).abs() < 1e-9);
}

#[test]
fn a_positive_hip_takes_the_foot_back_and_a_positive_knee_folds_the_leg() {
    let mut world = World::new(&pony());
    let foot_in_torso = |world: &World| {
        let (foot, torso) = (world.feet_m()[0], world.torso().position_m);
        [foot[0] - torso[0], foot[2] - torso[2]]
    };
    let neutral = foot_in_torso(&world);

    world.reset(&[0.3, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0], &Start::default());
    assert!(foot_in_torso(&world)[0] < neutral[0] - 0.03);

    world.reset(&[0.0, 0.0, 0.0, 0.0, 0.4, 0.0, 0.0, 0.0], &Start::default());
    assert!(foot_in_torso(&world)[1] > neutral[1] + 0.01);
}

#[test]
fn it_trots_forwards() {
    let trot = |t: f64| {
        let phase = core::f64::consts::TAU * t / 0.6;
        core::array::from_fn(|j| {
            let leg_phase = phase + core::f64::consts::PI * (j % 2) as f64;
            if j < LEG_COUNT { 0.25 * leg_phase.sin() } else { 0.4 * (-leg_phase.cos()).max(0.0) }
        })
    };

    let walk = open_loop::play(&pony(), &Trial::default(), trot);

    println!("{walk:?}");
    assert!(walk.displacement_m[0] > 1.0, "{walk:?}");
    assert!(!walk.fell && walk.dragged_share == 0.0, "{walk:?}");
    assert!(walk.displacement_m[1].abs() < 0.3 * walk.displacement_m[0], "{walk:?}");
    // Walking is worth its power: neither nothing nor what such servos cannot give.
    assert!((0.5..8.0).contains(&walk.mean_power_w), "{walk:?}");
}
