//! `host sinusoid`: a short search, what it leaves, and bad flags.
#![cfg(feature = "train")]

mod host_command;
#[cfg(unix)]
mod interrupt;

use host_command::host;
use serde_json::Value;
use std::path::Path;

/// The least search there is.
const LEAST_S: &str = "2934";

/// What it prints as JSON, on so many cores.
fn search(folder: &Path, out: &str, cores: &str) -> Value {
    let args = ["sinusoid", "--budget-s", LEAST_S, "--seed", "3", "--out", out, "--json"];
    let output = host(folder, &args).env("RAYON_NUM_THREADS", cores).assert().success();
    serde_json::from_slice(&output.get_output().stdout).unwrap()
}

#[track_caller]
fn refused(folder: &Path, code: i32, args: &[&str]) -> String {
    host_command::refused(folder, code, &[&["sinusoid"], args].concat())
}

#[test]
fn the_same_seed_finds_the_same_gait_on_one_core_and_two_and_it_can_be_played() {
    let desk = tempfile::tempdir().unwrap();

    let [first, second] = [("a", "1"), ("b", "2")].map(|(out, cores)| search(desk.path(), out, cores));

    for figure in ["wall_s", "simulated_s", "reward_per_step", "period_s", "speed_m_s", "cost_of_transport"] {
        assert!(first[figure].is_number() || figure == "cost_of_transport", "{figure}: {first:#}");
    }
    assert_eq!((first["leg"].as_f64(), first["seed"].as_u64()), (Some(1.0), Some(3)));
    assert!(first["simulated_s"].as_f64().unwrap() <= LEAST_S.parse().unwrap());
    assert_eq!(first["gait_sha256"], second["gait_sha256"]);
    assert_eq!(first["reward_per_step"], second["reward_per_step"]);
    for file in ["gait.toml", "gait.bin", "summary.json", "evaluations.csv", "robot/robot.toml"] {
        assert!(desk.path().join("a").join(file).is_file(), "{file}");
    }
    let tables = ["a", "b"].map(|out| std::fs::read(desk.path().join(out).join("evaluations.csv")).unwrap());
    assert_eq!(tables[0], tables[1]);
    let rows = String::from_utf8(tables[0].clone()).unwrap().lines().count();
    assert_eq!(rows as u64, 1 + first["evaluations"].as_u64().unwrap());
    let gait = std::fs::read_to_string(desk.path().join("a/gait.toml")).unwrap();
    assert!(gait.contains("source = \"sinusoid\"") && gait.contains("seed = 3"), "{gait}");
    host(desk.path(), &["simulate", "a/gait.toml", "--amp", "1.875", "--duration", "2", "--starts", "2"])
        .assert()
        .success();
}

#[test]
fn bad_flags_name_the_value_the_limit_and_the_next_move() {
    let desk = tempfile::tempdir().unwrap();
    std::fs::create_dir(desk.path().join("run")).unwrap();
    std::fs::write(desk.path().join("run/config.toml"), "").unwrap();

    let budget = refused(desk.path(), 2, &["--budget-s", "100"]);
    let no_number = refused(desk.path(), 2, &["--budget-s", "NaN"]);
    let name = refused(desk.path(), 2, &["--name", "a name of seventeen"]);
    let leg = refused(desk.path(), 2, &["--leg", "7"]);
    let pairs = refused(desk.path(), 2, &["--pairs", "odd"]);
    let taken = refused(desk.path(), 2, &["--out", "run"]);

    assert!(budget.contains("--budget-s is 100; it must be within 2934 to"), "{budget}");
    assert!(budget.contains("without --budget-s the search has the budget of `train`"), "{budget}");
    assert!(no_number.contains("--budget-s is NaN"), "{no_number}");
    assert!(name.contains("a name of seventeen") && name.contains("1 to 16"), "{name}");
    assert!(leg.contains("leg_scale"), "{leg}");
    assert!(pairs.contains("diagonal") && pairs.contains("ends"), "{pairs}");
    assert!(taken.contains("exists already: name another folder with --out"), "{taken}");
    assert_eq!(std::fs::read_dir(desk.path()).unwrap().count(), 1, "nothing is left behind");
}

#[cfg(unix)]
#[test]
fn ctrl_c_keeps_the_best_so_far_says_so_and_exits_130() {
    let desk = tempfile::tempdir().unwrap();
    // Signals are caught before the folder is made.
    let sign = desk.path().join("run/robot/robot.toml");

    let text = interrupt::interrupted_once(&sign, desk.path(), &["sinusoid", "--out", "run"]);

    assert!(
        text.contains("interrupted after 4 evaluations; the best gait so far is in run/gait.toml"),
        "{text}"
    );
    host(desk.path(), &["simulate", "run/gait.toml", "--duration", "1", "--starts", "1"]).assert().success();
}
