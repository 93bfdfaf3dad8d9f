//! `play` as a process, in real time, against the fake robot. Linux only: the
//! terminal is.
#![cfg(target_os = "linux")]

mod bench_host;
mod fake_robot;
#[cfg(feature = "train")]
mod tiny_training;

use bench_host::{Setting, fails, json, says};
use fake_robot::Troubles;
use protocol::{State, WalkEnd};

fn patient() -> Troubles {
    Troubles { forgives_late_setpoints: true, ..Default::default() }
}

/// One second at 20 Hz: hip1 goes from 0 to 19 of `unit`, all else stays.
fn recording(setting: &Setting, unit: f64) {
    let row = |i: usize| format!("{:.3},{:.4},0,0,0,0,0,0,0\n", i as f64 / 20.0, unit * i as f64);
    let header = "time_s,hip1,hip2,hip3,hip4,knee1,knee2,knee3,knee4\n";
    let text = format!("{header}{}", (0..20).map(row).collect::<String>());
    std::fs::write(setting.folder.path().join("walk.csv"), text).unwrap();
}

#[test]
fn a_csv_in_degrees_is_played_at_60_hertz_along_straight_lines() {
    let setting = Setting::new(patient());
    recording(&setting, 1.0);

    let text = says(&mut setting.host(&["play", "walk.csv", "--degrees"]));

    assert!(text.contains("played walk.csv for"), "{text}");
    assert!(text.contains("mean power 0.900 W"), "{text}");
    let played = setting.bench.robot(|robot| robot.played.clone());
    assert!((58..=60).contains(&played.len()), "{}", played.len());
    // A third of a degree each frame, up to 19 degrees and no farther.
    for (frame, pose) in played.iter().enumerate() {
        let expected_deg = (frame as f64 / 3.0).min(19.0);
        assert!((f64::from(pose[0]) / 256.0 - expected_deg).abs() < 0.01, "{frame}: {pose:?}");
    }
    let end = setting.bench.robot(|robot| robot.last_trial.unwrap().end);
    assert!(matches!(end, WalkEnd::Asked | WalkEnd::StreamDry), "{end:?}");
}

/// Actions scale about their mean as in a gait: 45 degrees of it, and 24 a unit around.
#[test]
fn actions_are_scaled_about_their_mean_and_a_stride_is_repeated() {
    let setting = Setting::new(patient());
    recording(&setting, 0.02);

    let result = json(&mut setting.host(&["play", "walk.csv", "--amp", "1.5", "--seconds", "2", "--json"]));

    let frames = result["frames_played"].as_u64().unwrap();
    assert!((118..=120).contains(&frames), "{result:#}");
    let played = setting.bench.robot(|robot| robot.played.clone());
    let lowest_deg = 45.0 * 0.19 - 1.5 * 24.0 * 0.19;
    assert!((f64::from(played[0][0]) / 256.0 - lowest_deg).abs() < 0.01, "{:?}", played[0]);
    assert_eq!(played[0], played[60]);
    assert_eq!(result["clipped_frames"], 0);
}

#[test]
fn what_leaves_the_limits_is_refused_before_anything_moves_and_held_with_clip() {
    let setting = Setting::new(patient());
    recording(&setting, 4.0);

    let message = fails(&mut setting.host(&["play", "walk.csv", "--degrees"]), 3);
    assert!(message.contains("hip1 would go to 76.0 degrees at 0.98 s; its limit is 45"), "{message}");
    assert!(setting.done().is_empty());

    let result = json(&mut setting.host(&["play", "walk.csv", "--degrees", "--clip", "--json"]));
    assert!(result["clipped_frames"].as_u64().unwrap() > 10, "{result:#}");
    let played = setting.bench.robot(|robot| robot.played.clone());
    assert_eq!(played.iter().map(|pose| pose[0]).max(), Some(45 * 256));
}

#[test]
fn a_dry_stream_fails_with_what_to_do() {
    let setting = Setting::new(Troubles { runs_dry_at: Some(20), ..Default::default() });
    recording(&setting, 1.0);

    let message = fails(&mut setting.host(&["play", "walk.csv", "--degrees"]), 5);

    assert!(message.contains("the next setpoint did not arrive in time"), "{message}");
    assert!(message.contains("low_latency"), "{message}");
    assert_eq!(setting.bench.robot(|robot| robot.state), State::Holding);
}

#[test]
fn a_policy_needs_a_run_with_one() {
    let setting = Setting::new(patient());

    let code = if cfg!(feature = "train") { 3 } else { 2 };
    let message = fails(&mut setting.host(&["play", "--policy", "nowhere"]), code);

    let expected = if cfg!(feature = "train") { "train first" } else { "built without training" };
    assert!(message.contains(expected), "{message}");
}

/// What the simulated robot is told, the other one does: the same setpoints again.
#[cfg(feature = "train")]
#[test]
fn a_policy_walks_in_simulation_and_the_robot_does_as_it_is_told() {
    use host::env::Env as _;
    use host::learn::run_config::RunConfig;
    use host::learn::td3::policy::Policy;
    use host::learn::td3::random::{Purpose, episode_seed};
    use host::sim::{AntEnv, AntEnvConfig, Randomisation};

    let setting = Setting::new(patient());
    let tiny = [tiny_training::TINY, tiny_training::DIFFERING].concat();
    std::fs::write(setting.folder.path().join("tiny.toml"), tiny).unwrap();
    let mut train = tiny_training::host(setting.folder.path());
    train.args(["train", "--config", "tiny.toml", "--seed", "3"]).assert().success();

    let text = says(&mut setting.host(&["play", "--policy", "--seconds", "0.5"]));

    assert!(text.contains("played the policy of runs/latest for"), "{text}");
    let run = setting.folder.path().join("runs/latest");
    let config = RunConfig::load(&run.join("config.toml")).unwrap();
    let robot = host::robot::Robot::load(&run.join(host::run_folder::ROBOT)).unwrap();
    let mut policy = Policy::load(&run.join("policy.safetensors")).unwrap();
    // On whatever robots it was learned, it is played for the described one.
    assert_ne!(config.env.randomisation, Randomisation::NONE);
    let env = AntEnvConfig { randomisation: Randomisation::NONE, ..config.env };
    let mut env = AntEnv::new(&robot, env);
    let (mut observation, mut action) = ([0.0; 27], [0.0; 8]);
    env.reset(episode_seed(config.seed, Purpose::RecordedTrial, 0), &mut observation);
    let played = setting.bench.robot(|robot| robot.played.clone());
    assert!(played.len() >= 28, "{}", played.len());
    for (frame, pose) in played.iter().enumerate() {
        policy.act(&observation, &mut action);
        env.step(&action, &mut observation);
        // 1.875 times 24 degrees: its own stroke.
        for (joint, (&units, asked)) in pose.iter().zip(env.setpoint_action()).enumerate() {
            let error_deg = f64::from(units) / 256.0 - 45.0 * asked;
            assert!(error_deg.abs() < 0.01, "frame {frame}, joint {joint}: {error_deg}");
        }
    }
}
