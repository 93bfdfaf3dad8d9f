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
    assert_eq!(mass_kg(&["--robot", PONY, "--anyway"]), Some(1.8));
    pony().save(&setting.folder.path().join(run_folder::ROBOT)).unwrap();
    assert_eq!(mass_kg(&["--anyway"]), Some(1.8));
}

/// Its servos take other pulses: whatever it walked, the trial would be of no gait of the Pony's.
#[test]
fn a_robot_that_is_not_calibrated_as_described_neither_gets_a_gait_nor_walks() {
    let setting = Setting::new(Troubles::default());
    let upload = ["upload-gait", "--gait", "gait.toml", "--amp", "2", "--robot", PONY];
    let measure = [&MEASURE[..], &["--robot", PONY]].concat();

    for arguments in [&upload[..], &measure] {
        let refused = fails(&mut setting.host(arguments), 5);

        for part in [
            "is not calibrated as Pony is described",
            "all joints: neutral at 1346 us, but 1500 us in the description, 15 degrees apart",
            "all joints: 6.80 us a degree, but 10.00 in the description",
            "host calibrate --from-robot FOLDER",
            "--anyway",
        ] {
            assert!(refused.contains(part), "{part}: {refused}");
        }
    }
    assert_eq!(setting.active_gait(), "old");

    let trial = json(&mut setting.host(&[&measure[..], &["--anyway"]].concat()));
    let remark = trial["remark"].as_str().unwrap();
    assert!(remark.starts_with("calibrated otherwise than Pony is described: all joints"), "{trial:#}");
    let table = std::fs::read_to_string(setting.folder.path().join("trials.csv")).unwrap();
    assert!(table.contains("calibrated otherwise than Pony"), "{table}");
}

#[test]
fn a_robot_calibrated_from_its_description_takes_its_gait() {
    let setting = Setting::new(Troubles::default());
    let upload = ["upload-gait", "--gait", "gait.toml", "--amp", "2", "--robot", PONY, "--json"];

    setting.host(&["calibrate", "--from-robot", PONY]).assert().success();
    json(&mut setting.host(&upload));

    assert_eq!(setting.active_gait(), "new");
    let trial = json(&mut setting.host(&[&MEASURE[..], &["--robot", PONY]].concat()));
    assert_eq!(trial["remark"], serde_json::Value::Null, "{trial:#}");
    // And it is not the Ant any more.
    let refused = fails(&mut setting.host(&MEASURE), 5);
    assert!(refused.contains("not calibrated as Ant is described"), "{refused}");
}

#[test]
fn a_gait_of_another_robot_is_refused_unless_told_otherwise() {
    let setting = Setting::new(Troubles::default());
    let mut gait = bench_host::gait("trot");
    gait.provenance = gait.provenance.with_robot(&pony());
    gait.save(&setting.folder.path().join("gait.toml")).unwrap();
    let simulate = ["simulate", "gait.toml", "--starts", "1", "--duration", "1", "--json"];
    let simulate_with = |more: &[&str]| {
        let mut command = assert_cmd::Command::cargo_bin("host").unwrap();
        command.current_dir(setting.folder.path()).env("NO_COLOR", "1").args(simulate).args(more);
        command
    };

    let upload = fails(&mut setting.upload(), 3);
    let played = fails(&mut simulate_with(&[]), 3);

    for refused in [upload, played] {
        assert!(refused.contains("gait.toml is a gait of Pony, but the robot is Ant"), "{refused}");
        assert!(refused.contains("--robot FOLDER"), "{refused}");
    }
    assert_eq!(
        json(&mut simulate_with(&["--robot", PONY]))["warnings"].to_string().matches("made for").count(),
        0
    );
    let on_the_ant = json(&mut simulate_with(&["--anyway"]));
    assert!(
        on_the_ant["warnings"].to_string().contains("the gait was made for Pony, not for Ant"),
        "{on_the_ant:#}"
    );
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
