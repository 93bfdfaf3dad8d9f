//! `host optimise`: a short search, what it leaves, and bad flags.
#![cfg(feature = "train")]

use assert_cmd::Command;
use serde_json::Value;
use std::path::Path;

fn host(folder: &Path, args: &[&str]) -> Command {
    let mut command = Command::cargo_bin("host").unwrap();
    command.current_dir(folder).env("NO_COLOR", "1").env("COLUMNS", "400").args(args);
    command
}

/// The least search there is; what it prints as JSON.
fn search(folder: &Path, out: &str, more: &[&str]) -> Value {
    let args = ["optimise", "--budget", "300", "--draws", "8", "--seed", "3", "--out", out, "--json"];
    let output = host(folder, &[&args[..], more].concat()).assert().success();
    serde_json::from_slice(&output.get_output().stdout).unwrap()
}

#[track_caller]
fn refused(folder: &Path, code: i32, args: &[&str]) -> String {
    let assert = host(folder, &[&["optimise"], args].concat()).assert().code(code);
    assert!(assert.get_output().stdout.is_empty());
    let message = String::from_utf8_lossy(&assert.get_output().stderr).into_owned();
    message.split_whitespace().filter(|word| *word != "│").collect::<Vec<_>>().join(" ")
}

#[test]
fn a_search_leaves_a_gait_that_a_robot_can_play_and_says_what_is_known_of_it() {
    let desk = tempfile::tempdir().unwrap();

    let found = search(desk.path(), "first", &[]);

    for figure in [
        "wall_s",
        "period_s",
        "cost_of_transport_median",
        "cost_of_transport_p90",
        "speed_m_s_median",
        "speed_m_s_p10",
        "yaw_deg_median",
        "setpoint_speed_max_rad_s",
        "servo_speed_rad_s",
    ] {
        assert!(found[figure].as_f64().is_some_and(f64::is_finite), "{figure}: {found:#}");
    }
    assert_eq!((found["leg"].as_f64(), found["seed"].as_u64()), (Some(1.0), Some(3)));
    assert!(found["evaluations"].as_u64().unwrap() >= 300);
    let (asked, servo) = (&found["setpoint_speed_max_rad_s"], &found["servo_speed_rad_s"]);
    assert!(asked.as_f64().unwrap() <= 0.9 * servo.as_f64().unwrap() + 1e-3, "{asked} of {servo}");
    let books = &found["power"];
    let parts = ["electronics_w", "slipping_w", "landing_w", "braking_w", "drive_w", "rest_w"];
    let sum: f64 = parts.iter().map(|part| books[part].as_f64().unwrap()).sum();
    assert!((sum - books["total_w"].as_f64().unwrap()).abs() < 1e-9, "{books}");

    for file in ["gait.toml", "gait.bin", "summary.json", "amplitudes.svg", "robot/robot.toml"] {
        assert!(desk.path().join("first").join(file).is_file(), "{file}");
    }
    let gait = std::fs::read_to_string(desk.path().join("first/gait.toml")).unwrap();
    assert!(gait.contains("source = \"searched\"") && gait.contains("seed = 3"), "{gait}");
    host(desk.path(), &["simulate", "first/gait.toml", "--amp", "1", "--duration", "3", "--starts", "2"])
        .assert()
        .success();
}

#[test]
fn the_same_seed_and_budget_find_the_same_gait_from_wherever_they_are_told_to_begin() {
    let desk = tempfile::tempdir().unwrap();

    let [first, second] = ["a", "b"].map(|out| search(desk.path(), out, &["--start", "nothing"]));
    let sinusoid = search(desk.path(), "c", &[]);
    let from_gait = search(desk.path(), "d", &["--start", "a", "--start-amp", "1"]);

    assert_eq!(first["gait_sha256"], second["gait_sha256"]);
    assert_eq!(first["over_draws"], second["over_draws"]);
    assert_ne!(first["gait_sha256"], sinusoid["gait_sha256"]);
    assert_ne!(first["gait_sha256"], from_gait["gait_sha256"]);
}

#[test]
fn a_front_has_a_gait_for_each_speed_beside_what_was_measured() {
    let desk = tempfile::tempdir().unwrap();

    let found = search(desk.path(), "front", &["--objective", "pareto"]);

    let front = found["front"].as_array().unwrap();
    assert_eq!(front.len(), 8);
    for point in front {
        assert!(desk.path().join(point["gait"].as_str().unwrap()).is_file(), "{point}");
    }
    let picture = std::fs::read_to_string(desk.path().join("front/front.svg")).unwrap();
    assert!(picture.contains("measured by the authors"));
    assert_eq!(std::fs::read_to_string(desk.path().join("front/front.csv")).unwrap().lines().count(), 9);
}

#[test]
fn bad_flags_name_the_value_and_what_is_allowed() {
    let desk = tempfile::tempdir().unwrap();

    let budget = refused(desk.path(), 2, &["--budget", "10"]);
    let speed = refused(desk.path(), 2, &["--min-speed", "9"]);
    let amplitude = refused(desk.path(), 2, &["--start-amp", "NaN"]);
    let start = refused(desk.path(), 3, &["--start", "nowhere.toml"]);
    let leg = refused(desk.path(), 3, &["--leg", "7"]);
    let draws = refused(desk.path(), 2, &["--draws", "1"]);

    assert!(budget.contains("\"10\" is no budget") && budget.contains("10m"), "{budget}");
    assert!(speed.contains("--min-speed is 9; it must be within 0.02 to 2 m/s"), "{speed}");
    assert!(amplitude.contains("--start-amp is NaN"), "{amplitude}");
    assert!(start.contains("cannot read nowhere.toml") && start.contains("sinusoid"), "{start}");
    assert!(leg.contains("leg_scale"), "{leg}");
    assert!(draws.contains("8..=1000"), "{draws}");
    assert_eq!(std::fs::read_dir(desk.path()).unwrap().count(), 0, "nothing is left behind");
}

#[test]
fn beyond_the_amplitudes_that_a_searched_gait_declares_is_a_warning() {
    let desk = tempfile::tempdir().unwrap();
    let gait = concat!(env!("CARGO_MANIFEST_DIR"), "/gaits/ant-1L/searched.toml");
    let said = |amplitude: &str| {
        let args = ["simulate", gait, "--amp", amplitude, "--duration", "1", "--starts", "1"];
        let output = host(desk.path(), &args).assert().success();
        String::from_utf8_lossy(&output.get_output().stderr).into_owned()
    };

    assert!(said("1.2").contains("found safe at amplitudes 0.5 to 1; at 1.2"));
    assert!(!said("1").contains("found safe"));
}
