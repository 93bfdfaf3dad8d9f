//! The commands `train` and `record` on the simulated Ant, as a user runs them.
#![cfg(feature = "train")]
#![allow(missing_docs)]

#[cfg(unix)]
mod interrupt;
mod tiny_training;

use host::learn::td3::checkpoint;
use host::run_folder;
use tiny_training::{DIFFERING, TINY, folder, folder_with, host};

/// A training without an end in sight.
fn endless() -> String {
    TINY.replace("epochs = 2", "epochs = 100000")
}

fn json(output: &[u8]) -> serde_json::Value {
    serde_json::from_slice(output).unwrap_or_else(|e| panic!("{e}: {}", String::from_utf8_lossy(output)))
}

#[test]
fn train_leaves_a_run_that_the_next_commands_find() {
    let folder = folder();

    let output =
        host(folder.path()).args(["train", "--config", "tiny.toml", "--seed", "3", "--json"]).assert();

    let result = json(&output.success().get_output().stdout);
    assert_eq!(result["seed"], 3);
    assert_eq!(result["updates"], 80);
    assert_eq!(result["train_env_steps"], 500);
    assert!(result["reward_trained"].as_f64() >= result["reward_untrained"].as_f64());
    let run = folder.path().join(run_folder::LATEST);
    for file in [run_folder::CONFIG, run_folder::POLICY, run_folder::LEARNING_CURVE] {
        assert!(run.join(file).is_file(), "{file}");
    }
    for file in ["robot.toml", "ant.xml"] {
        assert!(run.join(run_folder::ROBOT).join(file).is_file(), "{file}");
    }
    let curve = std::fs::read_to_string(run.join(run_folder::LEARNING_CURVE)).unwrap();
    assert_eq!(curve.lines().count(), 4, "{curve}");
}

/// The Ant cannot be saved; its episode is played again. Only if that leads to
/// the very same state do the networks come out alike.
#[test]
fn an_interrupted_run_of_the_ant_ends_as_if_it_had_not_been() {
    let (one_robot, differing) = (ends_as_if_it_had_not_been(TINY), format!("{TINY}{DIFFERING}"));

    assert_ne!(one_robot, ends_as_if_it_had_not_been(&differing), "the robots did not differ");
}

/// Compares an interrupted run with a whole one; gives its last networks.
fn ends_as_if_it_had_not_been(config: &str) -> Vec<u8> {
    let folder = folder_with(config);
    let train = |args: &[&str]| host(folder.path()).arg("train").args(args).assert().success();
    let longer = config.replace("epochs = 2", "epochs = 4");
    std::fs::write(folder.path().join("longer.toml"), &longer).unwrap();
    train(&["--config", "longer.toml", "--out", "whole"]);

    train(&["--config", "tiny.toml", "--out", "broken"]);
    let config = folder.path().join("broken").join(run_folder::CONFIG);
    let text = std::fs::read_to_string(&config).unwrap();
    std::fs::write(&config, text.replace("epochs = 2", "epochs = 4")).unwrap();
    train(&["--resume", "broken"]);

    let state = |run: &str| {
        // 100 random steps are 2 rounds, 160 updates are 16 more.
        let name = "round-18.safetensors";
        std::fs::read(folder.path().join(run).join(checkpoint::FOLDER).join(name)).unwrap()
    };
    assert_eq!(state("whole"), state("broken"));
    state("whole")
}

#[cfg(unix)]
#[test]
fn ctrl_c_saves_says_how_to_go_on_and_exits_130() {
    let folder = folder_with(&endless());
    let sign = folder.path().join("run").join(checkpoint::FOLDER).join("state.json");

    let args = ["train", "--config", "tiny.toml", "--out", "run"];
    let text = interrupt::interrupted_once(&sign, folder.path(), &args);

    assert!(text.contains("--resume run"), "{text}");
    let config = folder.path().join("run").join(run_folder::CONFIG);
    let resumed = std::fs::read_to_string(&config).unwrap().replace("epochs = 100000", "epochs = 1");
    std::fs::write(&config, resumed).unwrap();
    host(folder.path()).args(["train", "--resume", "run"]).assert().success();
}

/// Side by side, and yet each seed's run is what it is alone.
#[test]
fn seeds_side_by_side_end_as_each_alone_and_the_best_is_taken_over() {
    let folder = folder();
    let train =
        |args: &[&str]| host(folder.path()).args(["train", "--config", "tiny.toml"]).args(args).assert();
    let read = |path: &str| std::fs::read(folder.path().join(path)).unwrap_or_else(|e| panic!("{path}: {e}"));
    train(&["--seed", "4", "--out", "alone"]).success();

    let output = train(&["--seeds", "3..5", "--jobs", "2", "--out", "both", "--json"]).success();

    // 100 random steps are 2 rounds, 80 updates are 8 more.
    let last = |run: &str| read(&format!("{run}/{}/round-10.safetensors", checkpoint::FOLDER));
    assert_eq!(last("both/seed-4"), last("alone"));
    assert_eq!(read("both/seed-4/policy.safetensors"), read("alone/policy.safetensors"));
    let result = json(&output.get_output().stdout);
    let rewards: Vec<f64> =
        result["seeds"].as_array().unwrap().iter().map(|seed| seed["reward"].as_f64().unwrap()).collect();
    let best = if rewards[0] >= rewards[1] { 3 } else { 4 };
    assert_eq!(result["seed"], best);
    let robot = format!("{}/robot.toml", run_folder::ROBOT);
    for file in [run_folder::CONFIG, &robot, run_folder::POLICY, run_folder::LEARNING_CURVE] {
        assert_eq!(read(&format!("both/{file}")), read(&format!("both/seed-{best}/{file}")), "{file}");
    }
    let csv = String::from_utf8(read("both/seeds.csv")).unwrap();
    assert_eq!(csv.lines().count(), 3, "{csv}");
    let latest = folder.path().join(run_folder::LATEST).canonicalize().unwrap();
    assert_eq!(latest, folder.path().join("both").canonicalize().unwrap());
    assert!(read("both/seed-3/events.out.tfevents.psto").len() > 100);
}

/// One seed was done and the other had not begun when the power failed.
#[test]
fn seeds_go_on_where_they_were() {
    let folder = folder();
    let train = |args: &[&str]| host(folder.path()).arg("train").args(args).assert().success();
    let policy = || std::fs::read(folder.path().join("both/seed-1/policy.safetensors")).unwrap();
    train(&["--config", "tiny.toml", "--seeds", "0..2", "--out", "both"]);
    let whole = policy();
    std::fs::remove_dir_all(folder.path().join("both/seed-1").join(checkpoint::FOLDER)).unwrap();
    std::fs::remove_file(folder.path().join("both/seed-1/policy.safetensors")).unwrap();

    train(&["--resume", "both"]);

    assert_eq!(policy(), whole);
}

/// The other seeds are none the worse for one that goes wrong.
#[test]
fn a_seed_that_diverges_is_named_and_only_if_all_do_is_there_no_best() {
    let folder = folder();
    host(folder.path())
        .args(["train", "--config", "tiny.toml", "--seeds", "0..2", "--out", "both"])
        .assert()
        .success();
    let make_diverge = |seed: &str| {
        let run = folder.path().join("both").join(seed);
        // Wide critics in steps of 1: beyond every bound after an update or two.
        let steep = TINY
            .replace("hidden_layers = 1", "hidden_layers = 4\ncritic_learning_rate = 1.0")
            .replace("hidden_width = 16", "hidden_width = 512")
            .replace("round_updates = 10", "round_updates = 1");
        std::fs::remove_dir_all(run.join(checkpoint::FOLDER)).unwrap();
        std::fs::write(run.join(run_folder::CONFIG), steep).unwrap();
    };
    let resume = |code: i32| {
        let output = host(folder.path()).args(["train", "--resume", "both", "--json"]).assert().code(code);
        let output = output.get_output().clone();
        (output.stdout, String::from_utf8_lossy(&output.stderr).into_owned())
    };

    make_diverge("seed-1");
    let (stdout, stderr) = resume(0);

    assert!(stderr.contains("seed 1: learning diverged"), "{stderr}");
    assert_eq!(json(&stdout)["seeds"][0]["ending"], "done");
    assert_eq!(json(&stdout)["seeds"][1]["ending"], "diverged");

    make_diverge("seed-0");
    let (stdout, stderr) = resume(1);

    assert!(stdout.is_empty() && stderr.contains("learning diverged"), "{stderr}");
}

#[test]
fn flags_and_files_that_no_run_can_use_have_their_exit_codes() {
    let folder = folder_with("[td3]\nbatchsize = 3\n");
    let fails = |args: &[&str], code: i32, says: &str| {
        let output = host(folder.path()).args(args).assert().code(code);
        let text = String::from_utf8_lossy(&output.get_output().stderr).into_owned();
        assert!(text.contains(says), "{text}");
    };

    fails(&["train", "--config", "tiny.toml"], 3, "batchsize");
    fails(&["train", "--config", "none.toml"], 3, "none.toml");
    fails(&["train", "--robot", "none.toml"], 3, "none.toml");
    let pony = concat!(env!("CARGO_MANIFEST_DIR"), "/robots/pony");
    let unfitted = "robot Pony has no fitted spread";
    fails(&["train", "--preset", "robust", "--robot", pony], 3, unfitted);
    fails(&["train", "--seeds", "4..4"], 2, "1 to 1000 seeds");
    fails(&["train", "--seeds", "0..2", "--seed", "1"], 2, "--seed");
    fails(&["train", "--leg", "7"], 2, "leg_scale is 7");
    fails(&["train", "--resume", "nowhere"], 3, "nowhere");
    fails(&["train", "--resume", "nowhere", "--seed", "1"], 2, "--seed");
    fails(&["record"], 3, "runs/latest");
    fails(&["record", "--trials", "0"], 2, "0");
    fails(&["record", "--window"], 3, "runs/latest");
    fails(&["record", "--window", "7"], 2, "0.5 to 5 s");
    assert!(!folder.path().join(run_folder::LATEST).exists());
}

#[test]
fn a_run_is_not_trained_over() {
    let folder = folder();
    let args = ["train", "--config", "tiny.toml", "--out", "run"];
    host(folder.path()).args(args).assert().success();

    let output = host(folder.path()).args(args).assert().code(2);

    let text = String::from_utf8_lossy(&output.get_output().stderr).into_owned();
    assert!(text.contains("already holds a run"), "{text}");
}

/// An untrained network stands or twitches; a stride made of that would be a lie.
#[test]
fn record_refuses_a_policy_that_has_no_gait_and_writes_nothing() {
    let folder = folder();
    host(folder.path()).args(["train", "--config", "tiny.toml"]).assert().success();

    let output = host(folder.path()).args(["record", "--trials", "4"]).assert().code(3);

    let text = String::from_utf8_lossy(&output.get_output().stderr).into_owned();
    assert!(text.contains("cannot be recorded"), "{text}");
    assert!(!folder.path().join(run_folder::LATEST).join(run_folder::TRAJECTORY).exists());
}
