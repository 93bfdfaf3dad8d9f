use super::*;
use crate::env::Env;
use crate::robot::FIELDS;
use crate::robot::LegScale;
use crate::sim::ant_env::OBSERVATION_LEN;
use crate::sim::{AntEnv, AntEnvConfig, Perturbation, World};
use protocol::JOINT_COUNT;
use std::sync::Arc;

const ALL: Randomisation = Randomisation {
    twin_spread: 2.0,
    friction_share: 0.25,
    mass_share: 0.1,
    latency_s: 0.03,
    supply_share: 0.1,
};

fn ant() -> Robot {
    Robot::ant(LegScale::LONG).expect("the Ant")
}

fn sampled(randomisation: Randomisation, seed: u64) -> Robot {
    Robots::like(&ant(), randomisation).expect("robots differ").sampled(seed)
}

fn env(randomisation: Randomisation) -> AntEnv {
    AntEnv::new(&ant(), AntEnvConfig { start: Perturbation::NONE, randomisation, ..AntEnvConfig::default() })
}

fn reset(env: &mut AntEnv, seed: u64) -> [f32; OBSERVATION_LEN] {
    let mut seen = [0.0; OBSERVATION_LEN];
    env.reset(seed, &mut seen);
    seen
}

/// Least and most of a number over many robots, and what it is in the described one.
fn range_of(name: &str, randomisation: Randomisation) -> [f64; 3] {
    let field = Field::named(name).expect("a field");
    let values: Vec<f64> = (0..400).map(|seed| (field.get)(&sampled(randomisation, seed))).collect();
    let least = values.iter().copied().fold(f64::INFINITY, f64::min);
    let most = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    [least, most, (field.get)(&ant())]
}

fn assert_fills(name: &str, randomisation: Randomisation, deviation: [f64; 2]) {
    let [least, most, described] = range_of(name, randomisation);
    let width = deviation[1] - deviation[0];
    let (low, high) = (least - described - deviation[0], described + deviation[1] - most);
    assert!((-1e-12..0.05 * width).contains(&low), "{name}: least {least} about {described}");
    assert!((-1e-12..0.05 * width).contains(&high), "{name}: most {most} about {described}");
}

#[test]
fn episodes_of_two_seeds_walk_on_two_robots_and_of_one_seed_on_one() {
    let mut env = env(ALL);
    let mut robot_of = |seed| {
        reset(&mut env, seed);
        env.world().robot().clone()
    };

    let [one, other, again] = [3, 4, 3].map(&mut robot_of);

    assert_eq!(one, again);
    assert_eq!(one, sampled(ALL, 3));
    for name in
        ["ground.friction", "mass.torso_kg", "servo.delay_s", "servo.dead_band_deg", "supply.nominal_v"]
    {
        let get = Field::named(name).expect("a field").get;
        assert_ne!(get(&one), get(&other), "{name}");
    }
}

/// What an episode is must not depend on which ones were played before: a
/// checkpoint restores them by their seeds.
#[test]
fn an_episode_is_the_same_in_a_new_environment_and_in_a_used_one() {
    let play = |env: &mut AntEnv| {
        let mut seen = reset(env, 8);
        let rewards: Vec<f32> = (0..30).map(|_| env.step(&[0.4; JOINT_COUNT], &mut seen).reward).collect();
        (rewards, seen)
    };
    let (mut new, mut used) = (env(ALL), env(ALL));
    for seed in 0..3 {
        let mut seen = reset(&mut used, seed);
        used.step(&[-0.7; JOINT_COUNT], &mut seen);
    }

    assert_eq!(play(&mut new), play(&mut used));
}

#[test]
fn without_any_spread_the_robot_is_the_described_one() {
    let mut env = env(Randomisation::NONE);
    reset(&mut env, 5);

    assert!(Robots::like(&ant(), Randomisation::NONE).is_none());
    assert_eq!(env.world().robot(), &ant());
}

#[test]
fn every_fitted_number_fills_its_spread_and_no_other_moves() {
    let randomisation = Randomisation { twin_spread: 2.0, ..Randomisation::NONE };
    let spread = ant().twin.expect("the Ant is fitted").spread;

    for field in FIELDS {
        match spread.get(field.name) {
            Some(deviation) => assert_fills(field.name, randomisation, [-2.0 * deviation, 2.0 * deviation]),
            None => {
                let [least, most, described] = range_of(field.name, randomisation);
                assert_eq!([least, most], [described; 2], "{}", field.name);
            }
        }
    }
    // How a table is played is no part of a robot that walks by a policy.
    let strangers: Vec<_> = spread.keys().filter(|name| Field::named(name).is_none()).collect();
    assert_eq!(strangers, ["twin.sample_s"]);
}

/// Else a refit could spread a number that training silently leaves alone.
#[test]
fn whatever_a_fit_can_change_can_be_drawn_but_for_how_a_table_is_played() {
    for parameter in crate::twin::PARAMETERS {
        match Field::named(parameter.name) {
            Some(field) => assert_eq!((field.get)(&ant()), parameter.value_of(&ant()), "{}", field.name),
            None => assert_eq!(parameter.name, "twin.sample_s"),
        }
    }
}

#[test]
fn friction_and_mass_fill_their_shares_and_no_more() {
    let (friction, torso_kg, robot_kg) = (ant().ground.friction, ant().mass.torso_kg, ant().mass_kg());

    let slippery = Randomisation { friction_share: 0.25, ..Randomisation::NONE };
    assert_fills("ground.friction", slippery, [-0.25 * friction, 0.25 * friction]);
    let loaded = Randomisation { mass_share: 0.1, ..Randomisation::NONE };
    assert_fills("mass.torso_kg", loaded, [-0.1 * robot_kg, 0.1 * robot_kg]);
    let heavier = sampled(loaded, 1);
    assert!((heavier.mass_kg() - robot_kg - (heavier.mass.torso_kg - torso_kg)).abs() < 1e-12);
}

#[test]
fn one_kind_of_difference_moves_no_other_and_no_start() {
    let alone = sampled(Randomisation { latency_s: 0.03, ..Randomisation::NONE }, 6);

    assert_eq!(sampled(ALL, 6).servo.delay_s, alone.servo.delay_s);
    let start = |randomisation| {
        let mut env = AntEnv::new(&ant(), AntEnvConfig { randomisation, ..AntEnvConfig::default() });
        reset(&mut env, 6);
        (env.world().joint_angles_rad(), env.world().torso().yaw_rad())
    };
    assert_eq!(start(ALL), start(Randomisation::NONE));
}

/// Whatever a record says of its spread, what is sampled can be built.
#[test]
fn a_drawn_robot_keeps_within_what_a_description_may_say() {
    let mut wide = ant();
    // A knee that its frame stops 20 degrees from where it is drawn.
    let knee = &mut Arc::make_mut(&mut wide.drawn).legs[0].knee;
    knee.range_rad = Some([-20.0_f64, 20.0].map(f64::to_radians));
    let spread = &mut wide.twin.as_mut().expect("the Ant is fitted").spread;
    for field in FIELDS {
        spread.insert(field.name.to_owned(), 500.0);
    }
    wide.check().expect("a spread is no bound");
    let wildest = Randomisation {
        twin_spread: 5.0,
        friction_share: 0.9,
        mass_share: 0.3,
        latency_s: 0.1,
        supply_share: 0.5,
    };
    let robots = Robots::like(&wide, wildest).expect("robots differ");

    for seed in 0..300 {
        let robot = robots.sampled(seed);

        robot.check().unwrap_or_else(|error| panic!("seed {seed}: {error}"));
        assert!(robot.power.efficiency <= 1.0);
    }
}

/// A hip that is told to turn at the start does so after the sampled delay.
#[test]
fn latency_delays_what_the_servos_do() {
    let mut env = env(Randomisation { latency_s: 0.1, ..Randomisation::NONE });
    let mut delays = Vec::new();

    for seed in 0..6 {
        let mut seen = reset(&mut env, seed);
        let mut action = [0.0; JOINT_COUNT];
        action[0] = 1.0;
        let still = (0..20).take_while(|_| {
            env.step(&action, &mut seen);
            env.world().servo_setpoints_rad()[0] == 0.0
        });
        let still_steps = still.count();

        let delay_s = env.world().robot().servo.delay_s;
        // The control step in which the delay's last physics step lies.
        let expected = (delay_s / World::STEP_S).round() as usize / 4;
        assert_eq!(still_steps, expected, "seed {seed}: a delay of {delay_s} s");
        delays.push(still_steps);
    }

    assert!(delays.iter().max() > delays.iter().min(), "{delays:?}");
}

#[test]
fn a_low_supply_slows_the_servos_and_a_high_one_hurries_them() {
    let mut env = env(Randomisation { supply_share: 0.3, ..Randomisation::NONE });
    let mut top_of = |seed| {
        let mut seen = reset(&mut env, seed);
        let mut top_rad_s: f64 = 0.0;
        for _ in 0..15 {
            env.step(&[0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0], &mut seen);
            top_rad_s = top_rad_s.max(env.world().joint_speeds_rad_s()[4]);
        }
        (env.world().robot().supply.nominal_v, top_rad_s)
    };

    let mut tops: Vec<(f64, f64)> = (0..6).map(&mut top_of).collect();

    tops.sort_by(|a, b| a.0.total_cmp(&b.0));
    assert!(tops[0].0 < 4.5 && tops[5].0 > 5.5, "{tops:?}");
    assert!(tops.windows(2).all(|pair| pair[0].1 < pair[1].1), "{tops:?}");
}

#[test]
fn voltage_moves_speed_and_torque_alike_and_leaves_the_damping() {
    let (robot, described) = (sampled(Randomisation { supply_share: 0.3, ..Randomisation::NONE }, 2), ant());

    let (now, then) = (&robot.servo, &described.servo);
    let share = robot.supply.nominal_v / described.supply.nominal_v;
    for (now, then) in [
        (now.no_load_speed_rad_s, then.no_load_speed_rad_s),
        (now.torque_limit_n_m, then.torque_limit_n_m),
        (now.stiffness_n_m_rad, then.stiffness_n_m_rad),
    ] {
        assert!((now / then - share).abs() < 1e-12, "{now} of {then} at {share}");
    }
    assert!((share - 1.0).abs() > 0.01 && now.damping_n_m_s_rad == then.damping_n_m_s_rad);
}

#[test]
fn a_robot_without_a_fit_lacks_a_spread_to_draw_from() {
    let mut unfitted = ant();
    unfitted.twin = None;

    assert!(ALL.lacks_spread(&unfitted) && !ALL.lacks_spread(&ant()));
    assert!(!Randomisation { twin_spread: 0.0, ..ALL }.lacks_spread(&unfitted));
}
