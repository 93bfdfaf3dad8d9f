//! Observations, the slew limit and the ends of episodes.

use super::*;
use crate::robot::LegScale;

fn env(config: AntEnvConfig) -> AntEnv {
    AntEnv::new(&Robot::ant(LegScale::LONG).expect("the Ant"), config)
}

fn calm() -> AntEnvConfig {
    AntEnvConfig { start: Perturbation::NONE, ..AntEnvConfig::default() }
}

fn assert_near(value: f32, expected: f64, tolerance: f64) {
    assert!((f64::from(value) - expected).abs() < tolerance, "{value} is not {expected}");
}

#[test]
fn observations_stand_where_the_table_says() {
    let mut env = env(calm());
    let mut seen = [f32::NAN; OBSERVATION_LEN];
    env.reset(0, &mut seen);
    assert_near(seen[0], env.world.torso().position_m[2], 1e-6);
    assert_eq!(seen[1..5], [0.0, 0.0, 0.0, 1.0]);
    assert_eq!(seen[5..27], [0.0; 22]);

    let mut action = [0.0; JOINT_COUNT];
    action[1] = 0.4;
    action[6] = -0.3;
    for _ in 0..20 {
        env.step(&action, &mut seen);
    }

    let angles = env.world.joint_angles_rad();
    let speeds = env.world.joint_speeds_rad_s();
    let torso = env.world.torso();
    assert!(angles[1] > 0.1 && angles[6] < -0.05, "{angles:?}");
    for j in 0..8 {
        assert_near(seen[5 + j], angles[j] / core::f64::consts::FRAC_PI_4, 1e-6);
        assert_near(seen[19 + j], 0.1 * speeds[j], 1e-6);
    }
    for axis in 0..3 {
        assert_near(seen[13 + axis], torso.velocity_m_s[axis], 1e-6);
        assert_near(seen[16 + axis], torso.angular_velocity_rad_s[axis], 1e-6);
    }
    let norm: f32 = seen[1..5].iter().map(|q| q * q).sum();
    assert_near(norm, 1.0, 1e-4);
}

#[test]
fn the_same_seed_starts_the_same_episode_and_another_does_not() {
    let mut env = env(AntEnvConfig::default());
    let mut start = |seed| {
        let mut seen = [0.0; OBSERVATION_LEN];
        env.reset(seed, &mut seen);
        env.step(&[0.3; JOINT_COUNT], &mut seen);
        seen
    };

    assert_eq!(start(3), start(3));
    assert_ne!(start(3), start(4));
}

#[test]
fn the_setpoint_moves_no_faster_than_the_slew_limit() {
    let mut env = env(AntEnvConfig { slew_limit_rad_s: Some(1.5), ..calm() });
    let mut seen = [0.0; OBSERVATION_LEN];
    env.reset(0, &mut seen);
    let reach = 1.5 / core::f64::consts::FRAC_PI_4 / 60.0;

    env.step(&[1.0, -1.0, 0.01, 0.0, 0.0, 0.0, 0.0, f32::NAN], &mut seen);

    let setpoint = env.setpoint_action();
    assert!((setpoint[0] - reach).abs() < 1e-12);
    assert!((setpoint[1] + reach).abs() < 1e-12);
    assert!((setpoint[2] - 0.01).abs() < 1e-7);
    assert_eq!(setpoint[7], 0.0);
}

#[test]
fn an_action_outside_the_range_is_clipped() {
    let mut env = env(calm());
    let mut seen = [0.0; OBSERVATION_LEN];
    env.reset(0, &mut seen);

    env.step(&[7.0, -7.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0], &mut seen);

    assert_eq!(env.setpoint_action()[..2], [1.0, -1.0]);
}

#[test]
fn the_setpoint_stays_within_its_limit() {
    let mut env = env(AntEnvConfig { setpoint_limit: 0.9, ..calm() });
    let mut seen = [0.0; OBSERVATION_LEN];
    env.reset(0, &mut seen);

    env.step(&[1.0, -1.0, 0.5, 0.0, 0.0, 0.0, 0.0, 0.0], &mut seen);

    assert_eq!(env.setpoint_action()[..3], [0.9, -0.9, 0.5]);
}

#[test]
fn a_fall_costs_its_weight_once() {
    let cost = |fall| {
        let reward = RewardConfig { fall, ..RewardConfig::default() };
        let mut env = env(AntEnvConfig { max_tilt_rad: 0.0, reward, ..calm() });
        let mut seen = [0.0; OBSERVATION_LEN];
        env.reset(0, &mut seen);
        let step = env.step(&[0.5, 0.0, 0.0, 0.0, 0.9, 0.0, 0.0, 0.0], &mut seen);
        assert!(step.terminated);
        step.reward
    };

    assert!((cost(0.0) - cost(-5.0) - 5.0).abs() < 1e-5);
}

#[test]
fn the_time_limit_truncates_and_is_not_terminal() {
    let mut env = env(AntEnvConfig { episode_steps: 50, ..calm() });
    let mut seen = [0.0; OBSERVATION_LEN];
    env.reset(0, &mut seen);

    let steps: Vec<_> = (0..50).map(|_| env.step(&[0.0; JOINT_COUNT], &mut seen)).collect();

    assert!(steps[..49].iter().all(|step| !step.truncated && !step.terminated));
    assert!(steps[49].truncated && !steps[49].terminated);
}

#[test]
fn lying_down_is_terminal() {
    let mut env = env(calm());
    let mut seen = [0.0; OBSERVATION_LEN];
    env.reset(0, &mut seen);
    let lie_down = [0.0, 0.0, 0.0, 0.0, -1.0, -1.0, -1.0, -1.0];

    let last = (0..240).map(|_| env.step(&lie_down, &mut seen)).find(|step| step.terminated);

    let last = last.expect("the robot lay down within four seconds");
    assert!(!last.truncated);
    assert!(last.reward < 0.0);
}

/// The step that ends by a fall differs from the same step with no price on it by the price.
#[test]
fn a_fall_costs_once_what_the_configuration_says() {
    let last_reward = |fall: f64| {
        let reward = RewardConfig { fall, ..RewardConfig::default() };
        // A lean that nothing but standing perfectly still avoids.
        let mut env = env(AntEnvConfig { max_tilt_rad: 0.02, reward, ..calm() });
        let mut observation = [0.0; OBSERVATION_LEN];
        env.reset(0, &mut observation);
        let push = [0.0, 0.0, 0.0, 0.0, 1.0, 1.0, -1.0, -1.0];
        (0..600)
            .map(|_| env.step(&push, &mut observation))
            .find(|step| step.terminated)
            .map(|step| step.reward)
    };

    let (free, priced) = (last_reward(0.0).unwrap(), last_reward(-5.0).unwrap());

    assert_near(free - priced, 5.0, 1e-4);
}

#[test]
fn legs_that_swing_together_are_seen_to_touch() {
    let a = [[0.0, 0.0, 0.1], [0.1, 0.0, 0.0]];
    let crossing = [[0.05, -0.1, 0.05], [0.05, 0.1, 0.05]];
    let beside = [[0.0, 0.03, 0.1], [0.1, 0.03, 0.0]];
    let beyond = [[0.2, 0.0, 0.0], [0.3, 0.0, 0.0]];

    assert!(segment_distance_m(a, crossing) < 1e-12);
    assert!((segment_distance_m(a, beside) - 0.03).abs() < 1e-12);
    assert!((segment_distance_m(a, beyond) - 0.1).abs() < 1e-12);
}

#[test]
fn standing_still_earns_the_alive_bonus_and_next_to_nothing_else() {
    let mut env = env(calm());
    let mut seen = [0.0; OBSERVATION_LEN];
    env.reset(0, &mut seen);
    for _ in 0..60 {
        env.step(&[0.0; JOINT_COUNT], &mut seen);
    }

    let step = env.step(&[0.0; JOINT_COUNT], &mut seen);

    assert_near(step.reward, 1.0, 0.005);
    assert_near(step.forward_speed_m_s, 0.0, 0.005);
}
