//! A limp shin is a physical pendulum, and those have an exact period.

use super::*;
use crate::energy::SIMULATED_GRAVITY_M_S2;
use crate::robot::LegScale;

/// The Ant with servos that do not brake.
fn limp_ant() -> Robot {
    let mut robot = Robot::ant(LegScale::LONG).expect("the Ant");
    let servo = &mut robot.servo;
    (servo.damping_n_m_s_rad, servo.backdriven_damping_n_m_s_rad, servo.friction_n_m) = (0.0, 0.0, 0.0);
    robot.servo.end_stop_deg = 180.0;
    robot
}

/// The knee's angle at which the shin hangs straight down.
fn hanging_rad(robot: &Robot) -> f64 {
    (90.0 - robot.geometry.shin_below_horizontal_deg).to_radians()
}

/// Held by its torso: mean over ten swings of the first knee, and the largest angle of the last.
fn measured(robot: &Robot, amplitude_rad: f64) -> (f64, f64) {
    let hanging_rad = hanging_rad(robot);
    let mut angles_rad = [0.0, 0.0, 0.0, 0.0, hanging_rad, hanging_rad, hanging_rad, hanging_rad];
    angles_rad[4] += amplitude_rad;
    let mut world = World::new(robot);
    world.reset(&angles_rad, &Start { drop_m: 1.0, ..Start::default() });
    let torso = world.body.torso;
    world.body.physics.bodies[torso].set_body_type(RigidBodyType::Fixed, false);
    let (mut before_rad, mut largest_rad) = (amplitude_rad, 0.0_f64);
    let mut crossings_s = Vec::new();
    for step in 1..10_000 {
        world.step(&[None; JOINT_COUNT]);
        let now_rad = world.joint_angles_rad()[4] - hanging_rad;
        if before_rad < 0.0 && now_rad >= 0.0 {
            crossings_s.push((f64::from(step) - now_rad / (now_rad - before_rad)) * World::STEP_S);
            if crossings_s.len() < 11 {
                largest_rad = 0.0;
            } else {
                break;
            }
        }
        largest_rad = largest_rad.max(now_rad);
        before_rad = now_rad;
    }
    assert_eq!(crossings_s.len(), 11, "it stopped swinging");
    ((crossings_s[10] - crossings_s[0]) / 10.0, largest_rad)
}

/// `2 pi sqrt(I / (m g l)) / agm(1, cos(amplitude / 2))`: the complete elliptic
/// integral by the arithmetic-geometric mean.
fn exact_s(robot: &Robot, amplitude_rad: f64) -> f64 {
    let limbs = Limbs::of(robot);
    let leg = &limbs.legs[0];
    let shin = &leg.shin.inertia;
    let knee = leg.knee.in_child;
    let axis = knee.rotation * nalgebra::Vector3::x();
    let lever = shin.centre_m.coords - knee.translation.vector;
    let lever_m = (lever - axis * axis.dot(&lever)).norm();
    let about_knee = axis.dot(&(shin.tensor_kg_m2 * axis)) + shin.mass_kg * lever_m * lever_m;
    let small_s =
        core::f64::consts::TAU * (about_knee / (shin.mass_kg * SIMULATED_GRAVITY_M_S2 * lever_m)).sqrt();
    let (mut a, mut g) = (1.0, (amplitude_rad / 2.0).cos());
    for _ in 0..8 {
        (a, g) = ((a + g) / 2.0, (a * g).sqrt());
    }
    small_s / a
}

#[test]
fn a_limp_shin_swings_with_the_period_of_a_physical_pendulum() {
    let robot = limp_ant();
    // By hand: a rod of 20 g and 0.23 m, hung 0.115 m above its middle.
    let rod_s = core::f64::consts::TAU
        * ((0.0529 / 12.0 + 0.000_012 + 0.013_225) / (SIMULATED_GRAVITY_M_S2 * 0.115_f64)).sqrt();
    assert!((exact_s(&robot, 0.0) / rod_s - 1.0).abs() < 1e-4, "{} s", exact_s(&robot, 0.0));

    for amplitude_deg in [3.0_f64, 60.0, 120.0] {
        let amplitude_rad = amplitude_deg.to_radians();
        let (period_s, last_rad) = measured(&robot, amplitude_rad);

        let exact_s = exact_s(&robot, amplitude_rad);
        println!(
            "{amplitude_deg} degrees: {period_s:.5} s, exactly {exact_s:.5} s, last swing {last_rad:.4} rad"
        );
        assert!((period_s / exact_s - 1.0).abs() < 2e-4, "{amplitude_deg}: {period_s} s, not {exact_s} s");
        assert!((last_rad / amplitude_rad - 1.0).abs() < 0.002, "{amplitude_deg}: ends at {last_rad} rad");
    }
}
