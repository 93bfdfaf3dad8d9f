//! Gears are harder to turn from outside than by their motor.

use super::*;

/// The Ant, held by its torso in the air.
fn held(backdriven_damping_n_m_s_rad: f64, joint_angles_rad: &[f64; 8]) -> World {
    let mut robot = Robot::ant(1.0).expect("1.0 is a leg scale");
    robot.servo.backdriven_damping_n_m_s_rad = backdriven_damping_n_m_s_rad;
    let mut world = World::new(&robot);
    world.reset(joint_angles_rad, &Start { drop_m: 1.0, ..Start::default() });
    let torso = world.body.torso;
    world.body.physics.bodies[torso].set_body_type(RigidBodyType::Fixed, false);
    world
}

/// Steps until the first hip, told to go to 0.6 rad, is half way.
fn steps_to_half_way(backdriven_damping_n_m_s_rad: f64) -> u32 {
    let mut world = held(backdriven_damping_n_m_s_rad, &[0.0; 8]);
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
fn a_motor_turns_its_joint_as_fast_whatever_the_gears_do_from_outside() {
    let steps = steps_to_half_way(0.0);

    assert!(steps > 10, "{steps} steps");
    assert!(steps_to_half_way(8.0).abs_diff(steps) <= 1, "{} steps, not {steps}", steps_to_half_way(8.0));
}

#[test]
fn a_limp_shin_sinks_as_fast_as_its_gears_let_it() {
    // Weight times lever of a rod of 20 g and 0.23 m that is nearly level, over the damping.
    let level_rad = -held(0.0, &[0.0; 8]).robot().geometry.shin_below_horizontal_deg.to_radians();
    for damping_n_m_s_rad in [2.0, 4.0] {
        let mut world = held(damping_n_m_s_rad, &[0.0, 0.0, 0.0, 0.0, level_rad, 0.0, 0.0, 0.0]);
        let mut angle_rad = || {
            (0..24).for_each(|_| _ = world.step(&[None; 8]));
            world.joint_angles_rad()[4]
        };
        let (before_rad, after_rad) = (angle_rad(), angle_rad());

        let expected_rad_s = 0.02 * 9.81 * 0.115 / damping_n_m_s_rad;
        let speed_rad_s = (after_rad - before_rad).abs() / 0.1;
        assert!(
            (speed_rad_s / expected_rad_s - 1.0).abs() < 0.05,
            "{speed_rad_s}, not {expected_rad_s} rad/s"
        );
    }
}

/// A load that the motor pulls against, and turns back: where the pull says one way and the speed another.
#[test]
fn the_load_turns_a_pulling_joint_against_the_gears_and_a_lesser_number_than_the_motors_is_the_motors() {
    let mut servo = Robot::ant(1.0).expect("1.0 is a leg scale").servo;
    (servo.damping_n_m_s_rad, servo.backdriven_damping_n_m_s_rad) = (0.25, 2.0);

    assert_eq!([servo.damping_at(0.1, 1.0), servo.damping_at(-0.1, -1.0)], [0.25, 0.25]);
    assert_eq!([servo.damping_at(0.1, -1.0), servo.damping_at(-0.1, 1.0)], [2.0, 2.0]);
    assert_eq!([servo.damping_at(0.0, 1.0), servo.damping_at(0.1, 0.0)], [2.0, 2.0]);
    servo.backdriven_damping_n_m_s_rad = 0.0;
    assert_eq!(servo.damping_at(0.1, -1.0), 0.25);
}

/// A fall on the feet turns knees fast and against hard gears, whose resistance no winding feels.
#[test]
fn what_the_gears_take_heats_no_winding() {
    let mut robot = Robot::ant(1.0).expect("1.0 is a leg scale");
    robot.power.heat_w_per_n2_m2 = 1.0;
    robot.servo.backdriven_damping_n_m_s_rad = 8.0;
    let mut world = World::new(&robot);
    world.reset(&[0.0; 8], &Start { drop_m: 0.3, ..Start::default() });
    let servo = &robot.servo;

    let mut most_w = 0.0_f64;
    for _ in 0..240 {
        let outcome = world.step(&[Some(0.0); 8]);
        let fastest_rad_s = world.joint_speeds_rad_s().into_iter().fold(0.0_f64, |most, v| most.max(v.abs()));
        let motor_n_m = servo.torque_limit_n_m + servo.damping_n_m_s_rad * fastest_rad_s;
        assert!(outcome.heat_power_w <= 8.0 * motor_n_m * motor_n_m, "{} W", outcome.heat_power_w);
        most_w = most_w.max(outcome.heat_power_w);
    }

    assert!(most_w > 0.01, "{most_w} W: nothing turned them");
}
