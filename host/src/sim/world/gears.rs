//! Back-drivability: gears resist a load that turns them more than their motor.

use super::*;
use crate::energy::SIMULATED_GRAVITY_M_S2;
use crate::robot::LegScale;

/// The Ant, held by its torso in the air.
fn held(backdriven_damping_n_m_s_rad: f64, joint_angles_rad: &[f64; JOINT_COUNT]) -> World {
    let mut robot = Robot::ant(LegScale::LONG).expect("1.0 is a leg scale");
    robot.servo.backdriven_damping_n_m_s_rad = backdriven_damping_n_m_s_rad;
    let mut world = World::new(&robot);
    world.reset(joint_angles_rad, &Start { drop_m: 1.0, ..Start::default() });
    let torso = world.body.torso;
    world.body.physics.bodies[torso].set_body_type(RigidBodyType::Fixed, false);
    world
}

/// Steps until the first hip, told to go to 0.6 rad, is half way.
fn steps_to_half_way(backdriven_damping_n_m_s_rad: f64) -> u32 {
    let mut world = held(backdriven_damping_n_m_s_rad, &[0.0; JOINT_COUNT]);
    let setpoints_rad = [0.6, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0].map(Some);
    for step in 1..1_000 {
        world.step(&setpoints_rad);
        if world.joint_angles_rad()[0] > 0.3 {
            return step;
        }
    }
    panic!("at {} rad after 4 s", world.joint_angles_rad()[0]);
}

#[test]
fn back_driven_damping_does_not_slow_a_joint_that_its_motor_turns() {
    let steps = steps_to_half_way(0.0);

    assert!(steps > 10, "{steps} steps");
    assert!(steps_to_half_way(8.0).abs_diff(steps) <= 1, "{} steps, not {steps}", steps_to_half_way(8.0));
}

#[test]
fn a_limp_shin_sinks_as_fast_as_its_gears_let_it() {
    // Weight times lever of a rod of 20 g and 0.23 m that is nearly level, over the damping.
    let level_rad = -held(0.0, &[0.0; JOINT_COUNT]).robot().geometry.shin_below_horizontal_deg.to_radians();
    for damping_n_m_s_rad in [2.0, 4.0] {
        let mut world = held(damping_n_m_s_rad, &[0.0, 0.0, 0.0, 0.0, level_rad, 0.0, 0.0, 0.0]);
        let mut angle_rad = || {
            (0..24).for_each(|_| _ = world.step(&[None; JOINT_COUNT]));
            world.joint_angles_rad()[4]
        };
        let (before_rad, after_rad) = (angle_rad(), angle_rad());

        let expected_rad_s = 0.02 * SIMULATED_GRAVITY_M_S2 * 0.115 / damping_n_m_s_rad;
        let speed_rad_s = (after_rad - before_rad).abs() / 0.1;
        assert!(
            (speed_rad_s / expected_rad_s - 1.0).abs() < 0.05,
            "{speed_rad_s}, not {expected_rad_s} rad/s"
        );
    }
}

/// A load that turns a joint against its motor: torque and speed have opposite signs.
#[test]
fn damping_is_that_of_back_driving_where_the_load_turns_the_joint_and_never_below_the_motors() {
    let mut servo = Robot::ant(LegScale::LONG).expect("1.0 is a leg scale").servo;
    (servo.damping_n_m_s_rad, servo.backdriven_damping_n_m_s_rad) = (0.25, 2.0);

    assert_eq!([servo.damping_at(0.1, 1.0), servo.damping_at(-0.1, -1.0)], [0.25, 0.25]);
    assert_eq!([servo.damping_at(0.1, -1.0), servo.damping_at(-0.1, 1.0)], [2.0, 2.0]);
    assert_eq!([servo.damping_at(0.0, 1.0), servo.damping_at(0.1, 0.0)], [2.0, 2.0]);
    servo.backdriven_damping_n_m_s_rad = 0.0;
    assert_eq!(servo.damping_at(0.1, -1.0), 0.25);
}

/// A fall on the feet turns knees fast and against hard gears, whose resistance no winding feels.
#[test]
fn friction_in_the_gears_heats_no_winding() {
    let mut robot = Robot::ant(LegScale::LONG).expect("1.0 is a leg scale");
    robot.power.heat_w_per_n2_m2 = 1.0;
    robot.servo.backdriven_damping_n_m_s_rad = 8.0;
    let mut world = World::new(&robot);
    world.reset(&[0.0; JOINT_COUNT], &Start { drop_m: 0.3, ..Start::default() });
    let servo = &robot.servo;

    let mut most_w = 0.0_f64;
    for _ in 0..240 {
        let outcome = world.step(&[Some(0.0); JOINT_COUNT]);
        let fastest_rad_s = world.joint_speeds_rad_s().into_iter().fold(0.0_f64, |most, v| most.max(v.abs()));
        let motor_n_m = servo.torque_limit_n_m + servo.damping_n_m_s_rad * fastest_rad_s;
        assert!(outcome.heat_power_w <= 8.0 * motor_n_m * motor_n_m, "{} W", outcome.heat_power_w);
        most_w = most_w.max(outcome.heat_power_w);
    }

    assert!(most_w > 0.01, "{most_w} W: nothing turned them");
}
