//! `--robot FOLDER`: the commands that are about a robot are about that one.

mod bench_host;
mod fake_robot;
#[cfg(feature = "train")]
mod tiny_training;

use bench_host::Setting;
use fake_robot::Troubles;
use host::robot::{LegScale, Robot};
use host::run_folder;
use std::path::Path;

const PONY: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/robots/pony");

fn pony() -> Robot {
    Robot::load(Path::new(PONY)).unwrap()
}

fn json(command: &mut assert_cmd::Command) -> serde_json::Value {
    serde_json::from_slice(&command.assert().success().get_output().stdout).unwrap()
}

fn fails(command: &mut assert_cmd::Command, code: i32) -> String {
    let assert = command.env("COLUMNS", "400").assert().code(code);
    let message = String::from_utf8_lossy(&assert.get_output().stderr).into_owned();
    let words: Vec<&str> = message.split_whitespace().filter(|word| *word != "│").collect();
    words.join(" ")
}

const MEASURE: [&str; 8] = ["measure", "--duration", "0.5", "--distance", "0.1", "--out", ".", "--json"];

#[test]
fn measure_takes_the_mass_of_the_named_robot_or_of_its_run() {
    let setting = Setting::new(Troubles::default());
    let ant_kg = Robot::ant(LegScale::LONG).unwrap().mass_kg();
    let mass_kg = |more: &[&str]| json(&mut setting.host(&[&MEASURE[..], more].concat()))["mass_kg"].as_f64();

    assert!((mass_kg(&[]).unwrap() - ant_kg).abs() < 1e-8);
    assert_eq!(mass_kg(&["--robot", PONY]), Some(1.8));
    pony().save(&setting.folder.path().join(run_folder::ROBOT)).unwrap();
    assert_eq!(mass_kg(&[]), Some(1.8));
}

#[test]
fn a_run_of_an_older_release_is_refused_with_the_next_move() {
    let setting = Setting::new(Troubles::default());
    let old = "name = \"Ant\"\njoint_limit_deg = 55.0\n[geometry]\nthigh_m = 0.1414\n";
    std::fs::write(setting.folder.path().join("robot.toml"), old).unwrap();

    let message = fails(&mut setting.host(&MEASURE), 3);

    for part in ["./robot.toml", "older release", "name a robot's folder"] {
        assert!(message.contains(part), "{message}");
    }
    assert_eq!(setting.done().len(), 0, "the robot was asked before that was known");
}

#[test]
fn an_upload_is_held_to_the_servos_of_the_named_robot() {
    let setting = Setting::new(Troubles::default());
    let dry_run = ["upload-gait", "--dry-run", "--gait", "gait.toml", "--amp", "2.2", "--json"];

    let of_ant = json(&mut setting.host(&dry_run));
    let of_pony = json(&mut setting.host(&[&dry_run[..], &["--robot", PONY]].concat()));

    let lags = |result: &serde_json::Value| result["warnings"].to_string().contains("its servo does");
    assert!(lags(&of_ant), "{of_ant:#}");
    // 344 degrees a second, nearly twice the Ant's.
    assert!(!lags(&of_pony), "{of_pony:#}");
}

#[cfg(feature = "train")]
#[test]
fn a_run_of_another_robot_lives_on_without_its_folder() {
    let setting = Setting::new(Troubles::default());
    let here = setting.folder.path();
    pony().save(&here.join("mine")).unwrap();
    std::fs::write(here.join("tiny.toml"), tiny_training::TINY).unwrap();
    let host = |args: &[&str]| {
        let mut command = tiny_training::host(here);
        command.args(args);
        command
    };
    host(&["train", "--config", "tiny.toml", "--robot", "mine", "--out", "run"]).assert().success();

    std::fs::remove_dir_all(here.join("mine")).unwrap();

    assert_eq!(Robot::of_run(&here.join("run")).unwrap(), Some(pony()));
    // It gets as far as to see that such a short training has learnt no stride.
    let message = fails(&mut host(&["record", "--run", "run", "--trials", "2"]), 3);
    assert!(message.contains("this policy's trajectory cannot be recorded"), "{message}");
}
