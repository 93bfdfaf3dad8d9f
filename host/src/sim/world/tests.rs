//! The world stands, falls, repeats itself and obeys its servos.

use super::*;
use crate::robot::LegScale;
use crate::sim::Perturbation;

fn ant() -> Robot {
    Robot::ant(LegScale::LONG).expect("the Ant")
}

fn hold(world: &mut World, setpoints_rad: &[Option<f64>; JOINT_COUNT], duration_s: f64) -> f64 {
    let steps = (duration_s / World::STEP_S).round() as usize;
    (0..steps).map(|_| world.step(setpoints_rad).mechanical_power_w * World::STEP_S).sum()
}

const NEUTRAL: [Option<f64>; JOINT_COUNT] = [Some(0.0); JOINT_COUNT];

/// A trot-like wave: hips swing, knees lift.
fn wave(t: f64, hip_sign: f64) -> [Option<f64>; JOINT_COUNT] {
    core::array::from_fn(|j| {
        let phase = core::f64::consts::TAU * t / 0.9 + core::f64::consts::PI * (j % 2) as f64;
        Some(if j < LEG_COUNT { hip_sign * 0.35 * phase.sin() } else { 0.3 * phase.cos() })
    })
}

#[test]
fn it_stands_without_creeping_or_sinking() {
    let mut world = World::new(&ant());
    // Gears that are hard to turn from outside let it sink into its stand slowly, and
    // with soles near the limit of their friction what trembles creeps a little.
    hold(&mut world, &NEUTRAL, 6.0);
    let settled = world.torso();

    let energy_j = hold(&mut world, &NEUTRAL, 10.0);

    let later = world.torso();
    for axis in 0..3 {
        let moved_m = (later.position_m[axis] - settled.position_m[axis]).abs();
        assert!(moved_m < 0.002, "axis {axis} moved {moved_m} m");
    }
    assert!((later.yaw_rad() - settled.yaw_rad()).abs() < 0.005);
    assert!(energy_j < 0.01, "standing took {energy_j} J of work");
    assert_eq!(world.foot_contacts(), [true; LEG_COUNT]);
    assert!(!world.body_touches_ground());
}

#[test]
fn the_same_calls_give_the_same_bits() {
    let start = Start::sampled(&Perturbation::default(), 7);
    let run = |world: &mut World| {
        world.reset(&[0.0; JOINT_COUNT], &start);
        let energy_j: f64 =
            (0..960).map(|i| world.step(&wave(f64::from(i) / 240.0, 1.0)).servo_power_w).sum();
        (world.torso(), world.joint_angles_rad(), energy_j.to_bits())
    };
    let mut fresh = World::new(&ant());
    let mut used = World::new(&ant());
    hold(&mut used, &[None; JOINT_COUNT], 0.7);

    assert_eq!(run(&mut fresh), run(&mut used));
}

#[test]
fn a_setpoint_step_is_followed_no_faster_than_the_servo_turns() {
    let mut world = World::new(&ant());
    hold(&mut world, &NEUTRAL, 0.5);
    let limit_rad_s = world.robot().servo.top_speed_rad_s();
    let mut asked = NEUTRAL;
    asked[4] = Some(0.7);

    let mut fastest_rad_s = 0.0_f64;
    for _ in 0..480 {
        world.step(&asked);
        fastest_rad_s = fastest_rad_s.max(world.joint_speeds_rad_s()[4]);
    }

    assert!(fastest_rad_s < 1.1 * limit_rad_s, "{fastest_rad_s} rad/s");
    // The knee lifts a quarter of the robot and lags, but it does turn.
    assert!(fastest_rad_s > 0.05 * limit_rad_s, "{fastest_rad_s} rad/s");
    // It carries half the robot then, and sags under it as far as its torque does not reach.
    assert!((0.1..0.7).contains(&world.joint_angles_rad()[4]), "{}", world.joint_angles_rad()[4]);
}

#[test]
fn a_limp_robot_collapses_and_draws_nothing() {
    let mut world = World::new(&ant());

    let energy_j = hold(&mut world, &[None; JOINT_COUNT], 8.0);

    assert!(world.torso().position_m[2] < 0.05, "torso at {} m", world.torso().position_m[2]);
    assert!(world.body_touches_ground());
    assert_eq!(energy_j, 0.0);
    assert_eq!(world.step(&[None; JOINT_COUNT]).servo_power_w, 0.0);
}

#[test]
fn a_setpoint_that_is_no_number_moves_nothing() {
    let mut world = World::new(&ant());
    hold(&mut world, &[Some(f64::NAN); JOINT_COUNT], 1.0);

    assert!(world.torso().position_m[2] > 0.1);
    assert!(world.joint_angles_rad().iter().all(|angle| angle.abs() < 0.2));
}

#[test]
fn a_servo_pulls_no_harder_than_its_limit() {
    let mut robot = ant();
    robot.servo.torque_limit_n_m = 0.05;
    let mut world = World::new(&robot);

    hold(&mut world, &NEUTRAL, 4.0);

    assert!(world.torso().position_m[2] < 0.12, "it still stands at {} m", world.torso().position_m[2]);
}

#[test]
fn a_servo_stops_at_its_end_stop() {
    let mut robot = ant();
    robot.servo.end_stop_deg = 60.0;
    let mut world = World::new(&robot);
    let mut asked = NEUTRAL;
    asked[0] = Some(3.0);

    hold(&mut world, &asked, 4.0);

    let reached_deg = world.joint_angles_rad()[0].to_degrees();
    assert!((50.0..61.0).contains(&reached_deg), "{reached_deg} degrees");
}

/// The Ant with its first knee stopped by the frame, 20 degrees either way of its drawn 58.
#[test]
fn a_range_in_the_drawing_stops_a_joint_before_its_servo() {
    let folder = tempfile::tempdir().expect("a folder");
    ant().save(folder.path()).expect("written");
    let path = folder.path().join("ant.xml");
    let text = std::fs::read_to_string(&path).expect("read");
    let narrow = "<joint name=\"knee1\" range=\"-20 20\"";
    std::fs::write(&path, text.replacen("<joint name=\"knee1\"", narrow, 1)).expect("written");
    let robot = Robot::load(folder.path()).expect("a robot");
    let mut world = World::new(&robot);
    let mut asked = NEUTRAL;
    asked[4] = Some(-1.2);

    hold(&mut world, &asked, 2.0);

    // Neutral is not quite as drawn: the range is of the drawing.
    let end_deg = -20.0 + 58.0 - robot.geometry.shin_below_horizontal_deg;
    let reached_deg = world.joint_angles_rad()[4].to_degrees();
    assert!((end_deg - 3.0..end_deg + 0.1).contains(&reached_deg), "{reached_deg} degrees");
}

/// What the servos are after, a row a step, when all joints are asked to go somewhere.
fn setpoints_with_delay(delay_s: f64, substeps: u32) -> Vec<[f64; JOINT_COUNT]> {
    let mut robot = ant();
    robot.servo.delay_s = delay_s;
    // Else a servo's speed depends on what all draw.
    robot.supply.resistance_ohm = 0.0;
    let mut world = World::refined(&robot, substeps);
    (0..100)
        .map(|step| {
            world.step(&wave(f64::from(step) * World::STEP_S, 1.0));
            world.servo_setpoints_rad()
        })
        .collect()
}

#[test]
fn a_servo_acts_on_a_pulse_its_delay_later_to_the_step() {
    for substeps in [1, 3] {
        let prompt = setpoints_with_delay(0.0, substeps);
        for delay_steps in [1, 12, 48] {
            let late = setpoints_with_delay(f64::from(delay_steps as u32) * World::STEP_S, substeps);

            // It holds what it held, then does the same, later.
            assert!(
                late[..delay_steps].iter().all(|row| *row == [0.0; JOINT_COUNT]),
                "{:?}",
                &late[..delay_steps]
            );
            assert!(prompt[0] != [0.0; JOINT_COUNT]);
            assert_eq!(late[delay_steps..], prompt[..100 - delay_steps]);
        }
    }
}

#[test]
fn pulses_that_end_are_missed_a_delay_later() {
    let mut robot = ant();
    robot.servo.delay_s = 0.1;
    let mut world = World::new(&robot);
    hold(&mut world, &NEUTRAL, 6.0);
    let stood_m = world.torso().position_m[2];

    hold(&mut world, &[None; JOINT_COUNT], 0.1);
    assert!((world.torso().position_m[2] - stood_m).abs() < 1e-4);

    hold(&mut world, &[None; JOINT_COUNT], 1.0);
    assert!(world.torso().position_m[2] < stood_m - 0.01);
}

#[test]
fn electrical_power_covers_the_mechanical_work() {
    let mut robot = ant();
    robot.power.efficiency = 0.5;
    let mut world = World::new(&robot);

    let outcomes: Vec<_> = (0..960).map(|i| world.step(&wave(f64::from(i) / 240.0, 1.0))).collect();

    assert!(outcomes.iter().any(|o| o.mechanical_power_w > 0.1));
    for outcome in outcomes {
        let expected_w = 2.0 * outcome.mechanical_power_w + outcome.holding_power_w;
        assert!((outcome.servo_power_w - expected_w).abs() < 1e-12);
        assert!(outcome.holding_power_w <= outcome.heat_power_w);
    }
}

#[test]
fn a_positive_hip_turns_counter_clockwise_and_a_positive_knee_folds_inward() {
    let mut world = World::new(&ant());
    let distance_m = |world: &World| {
        let torso = world.torso().position_m;
        let foot = world.feet_m()[0];
        (foot[0] - torso[0]).hypot(foot[1] - torso[1])
    };
    let (neutral_azimuth, neutral_m) = (azimuth_rad(&world), distance_m(&world));

    world.reset(&[0.3, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0], &Start::default());
    assert!(azimuth_rad(&world) > neutral_azimuth + 0.1);

    world.reset(&[0.0, 0.0, 0.0, 0.0, 0.3, 0.3, 0.3, 0.3], &Start::default());
    assert!(distance_m(&world) < neutral_m - 0.02);
}

/// Of the first leg's foot, from the torso's middle.
fn azimuth_rad(world: &World) -> f64 {
    let foot = world.feet_m()[0];
    foot[1].atan2(foot[0])
}

#[test]
fn neutral_stands_as_high_as_the_shins_slope_says() {
    for leg_scale in [LegScale::LONG, LegScale::SHORT] {
        let robot = Robot::ant(leg_scale).expect("a leg scale");
        let world = World::new(&robot);

        let (radius_m, slope) = (robot.geometry.foot_radius_m, robot.geometry.shin_below_horizontal_deg);
        // The drawn shin is 0.23 m long, foot included.
        let expected_m = radius_m + (0.23 * leg_scale.value() - radius_m) * slope.to_radians().sin();

        assert!((world.torso().position_m[2] - expected_m).abs() < 1e-6);
        assert_eq!(world.foot_contacts(), [true; LEG_COUNT]);
    }
}

#[test]
fn the_engine_weighs_what_the_description_says() {
    let robot = ant();
    let world = World::new(&robot);

    let total_kg: f64 = world.body.physics.bodies.iter().map(|(_, body)| f64::from(body.mass())).sum();

    assert!((total_kg - robot.mass_kg()).abs() < 1e-5, "{total_kg} kg");
}
