use super::*;
use crate::cause_chain::message_of;
use crate::sim::Randomisation;
use crate::sim::reward::{Electricity, RewardConfig};

fn parse(text: &str) -> Result<RunConfig, ConfigError> {
    RunConfig::parse(text, Path::new("mine.toml"))
}

#[test]
fn the_paper_preset_is_table_1() {
    let paper = RunConfig::preset(Preset::Paper).unwrap();

    assert_eq!(paper, RunConfig { env: paper.env, ..RunConfig::default() });
    assert_eq!(paper.td3.buffer_size, 20_000);
    assert_eq!((paper.td3.actor_learning_rate, paper.td3.critic_learning_rate), (3e-4, 1e-3));
    assert_eq!((paper.td3.gamma, paper.td3.tau, paper.td3.policy_delay), (0.99, 0.005, 2));
    assert_eq!((paper.td3.policy_noise, paper.td3.exploration_noise), (0.2, 0.1));
    assert_eq!((paper.td3.batch_size, paper.td3.hidden_layers, paper.td3.hidden_width), (128, 3, 128));
    assert_eq!((paper.schedule.training_envs, paper.schedule.evaluation_episodes), (8, 50));
    assert_eq!(paper.schedule.total_updates(), 250_000);
    assert_eq!(paper.schedule.env_steps_per_update, 10);
    // 45 degrees either way, all of it, and no help with the servos.
    assert_eq!((paper.env.setpoint_limit, paper.env.slew_limit_rad_s), (1.0, None));
    assert_eq!(paper.env.reward, RewardConfig::default());
}

/// The paper's preset must not change when a default does.
#[test]
fn the_paper_preset_names_every_number() {
    let named: toml::Table = toml::from_str(Preset::Paper.text()).unwrap();
    let all = toml::Table::try_from(RunConfig::default()).unwrap();

    let names = |table: &toml::Table| -> Vec<String> {
        fn walk(prefix: &str, table: &toml::Table, names: &mut Vec<String>) {
            for (name, value) in table {
                match value {
                    toml::Value::Table(inner) => walk(&format!("{prefix}{name}."), inner, names),
                    _ => names.push(format!("{prefix}{name}")),
                }
            }
        }
        let mut names = Vec::new();
        walk("", table, &mut names);
        names.sort();
        names
    };
    assert_eq!(names(&named), names(&all));
}

#[test]
fn walk_keeps_the_papers_learner_and_budget_but_charges_true_power() {
    let (paper, walk) = (RunConfig::preset(Preset::Paper).unwrap(), RunConfig::preset(Preset::Walk).unwrap());

    assert_eq!(walk.td3, Td3Config { exploration_correlation: 0.95, ..paper.td3 });
    assert_eq!(
        walk.schedule,
        Schedule { round_updates: 25, warm_up_env_steps: 20_000, evaluation_episodes: 20, ..paper.schedule }
    );
    assert_eq!(walk.env.reward.electricity_form, Electricity::ServoPower);
}

#[test]
fn robust_is_walk_on_robots_that_differ_and_the_others_know_one_robot() {
    let [paper, walk, quick, robust] = [Preset::Paper, Preset::Walk, Preset::Quick, Preset::Robust]
        .map(|preset| RunConfig::preset(preset).unwrap());

    for config in [&paper, &walk, &quick] {
        assert_eq!(config.env.randomisation, Randomisation::NONE);
    }
    let mut one_robot = robust.clone();
    one_robot.env.randomisation = Randomisation::NONE;
    assert_eq!(one_robot, walk);
    let Randomisation { twin_spread, friction_share, mass_share, latency_s, supply_share } =
        robust.env.randomisation;
    assert!([twin_spread, friction_share, mass_share, latency_s, supply_share].iter().all(|&on| on > 0.0));
}

#[test]
fn psto_is_walk_with_the_papers_electricity() {
    let [paper, walk, psto] =
        [Preset::Paper, Preset::Walk, Preset::Psto].map(|preset| RunConfig::preset(preset).unwrap());
    let RewardConfig { electricity_form, electricity, .. } = paper.env.reward;
    let mut expected = walk;
    expected.env.reward = RewardConfig { electricity_form, electricity, ..expected.env.reward };

    assert_eq!(psto, expected);
}

#[test]
fn a_file_can_stand_on_any_preset() {
    let config = parse("based_on = \"quick\"\nseed = 4\n").unwrap();

    assert_eq!(config, RunConfig { seed: 4, ..RunConfig::preset(Preset::Quick).unwrap() });
}

#[test]
fn the_quick_preset_is_usable_and_short() {
    let quick = RunConfig::preset(Preset::Quick).unwrap();

    assert!(quick.schedule.total_updates() <= 100_000);
}

#[test]
fn a_file_changes_what_it_names_and_leaves_the_papers_rest() {
    let config = parse("[env.reward]\nforward = 3.5\n").unwrap();

    let mut expected = RunConfig::preset(Preset::Paper).unwrap();
    expected.env.reward.forward = 3.5;
    assert_eq!(config, expected);
}

#[test]
fn a_saved_configuration_comes_back_as_it_was() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("config.toml");
    let mut config = RunConfig::preset(Preset::Robust).unwrap();
    config.seed = 12;

    config.save(&path).unwrap();

    assert_eq!(RunConfig::load(&path).unwrap(), config);
}

#[test]
fn an_unknown_name_or_a_bad_number_is_refused_with_its_name() {
    for (text, named) in [
        ("[td3]\nbatchsize = 3", "batchsize"),
        ("[td3]\nbatch_size = 0", "td3.batch_size is 0"),
        ("[td3]\nhidden_width = 4096", "td3.hidden_width is 4096, it must be 1 to 1,024"),
        ("[td3]\ngamma = 1.0", "td3.gamma is 1"),
        ("[td3]\ntau = nan", "td3.tau is NaN"),
        (
            "[schedule]\nupdates_per_epoch = 100000\nround_updates = 100000\nenv_steps_per_update = 10000",
            "schedule.round_updates times schedule.env_steps_per_update is 1000000000",
        ),
        ("[schedule]\nround_updates = 7", "schedule.updates_per_epoch is 2500"),
        ("[env]\nepisode_steps = 0", "env.episode_steps is 0"),
        ("[env]\nslew_limit_rad_s = -1.0", "env.slew_limit_rad_s is -1"),
        ("[env]\nmax_tilt_rad = 0.0", "env.max_tilt_rad is 0"),
        ("[env.start]\njoint_rad = nan", "env.start.joint_rad is NaN"),
        (
            "[env.randomisation]\ntwin_spread = -1.0",
            "env.randomisation.twin_spread is -1, it must be 0 to 5 standard deviations",
        ),
        ("[env.randomisation]\nfriction_share = nan", "env.randomisation.friction_share is NaN"),
        ("[env.randomisation]\nmass_share = 0.5", "env.randomisation.mass_share is 0.5, it must be 0 to 0.3"),
        ("[env.randomisation]\nlatency_s = 30.0", "env.randomisation.latency_s is 30, it must be 0 to 0.1"),
        ("[env.randomisation]\nsupply_share = inf", "env.randomisation.supply_share is inf"),
        ("[env.randomisation]\nwind = 0.1", "wind"),
        ("[env.reward]\nforward = inf", "env.reward.forward is inf"),
        ("leg_scale = 9.0", "leg_scale is 9"),
        ("based_on = \"lunch\"", "lunch"),
    ] {
        let error = message_of(&parse(text).unwrap_err());

        assert!(error.contains(named) && error.contains("mine.toml"), "{error}");
    }
}
