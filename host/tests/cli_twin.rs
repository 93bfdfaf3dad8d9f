//! `host twin` from the outside: files in, a description and numbers out.

mod host_command;

use assert_cmd::Command;
use host::robot::Robot;
use predicates::prelude::*;
use predicates::str::contains;
use std::path::PathBuf;

struct Desk {
    folder: tempfile::TempDir,
}

const TRIALS: &str = "\
leg_length,method,amplification,power_w,speed_m_s,cost_of_transport,duration_s
1.0,trot,0.8,0.55,0.04,1.375,3
1.0,trot,1,0.6,0.05,1.2,3
1.0,trot,1,0.62,0.05,1.24,3
1.0,trot,1.2,0.7,0.06,1.1667,3
1.0,wide,1,0.65,0.06,1.0833,3
0.6,trot,1,0.5,0.05,1.0,3
";

impl Desk {
    fn new() -> Self {
        let desk = Self { folder: tempfile::tempdir().unwrap() };
        let mut tables = "method,amplification,sample,hip1,hip2,hip3,hip4,ank1,ank2,ank3,ank4\n".to_owned();
        for (method, amplification) in [("trot", 0.8), ("trot", 1.0), ("trot", 1.2), ("wide", 1.0)] {
            for sample in 0..12 {
                let ticks = (0..8).map(|j| {
                    let phase = f64::from(sample) / 12.0 + 0.5 * f64::from(j % 2);
                    let phase = core::f64::consts::TAU * phase;
                    let swing = if j % 4 < 2 { 45.0 } else { -45.0 };
                    let deviation = if j < 4 { swing * phase.sin() } else { 30.0 * phase.cos() };
                    format!(",{:.0}", 330.0 + amplification * deviation)
                });
                tables += &format!("{method},{amplification},{sample}{}\n", ticks.collect::<String>());
            }
        }
        desk.write("tables.csv", &tables);
        desk.write("trials.csv", TRIALS);
        desk
    }

    fn write(&self, name: &str, text: &str) {
        std::fs::write(self.path(name), text).unwrap();
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn twin(&self, what: &str, more: &[&str]) -> Command {
        let files = ["twin", what, "--tables", "tables.csv", "--trials", "trials.csv"];
        host_command::host(self.folder.path(), &[&files[..], more].concat())
    }

    fn json(&self, what: &str, more: &[&str]) -> serde_json::Value {
        let output = self.twin(what, more).arg("--json").assert().success().get_output().stdout.clone();
        serde_json::from_slice(&output).unwrap()
    }
}

#[test]
fn validate_tells_scripts_every_number_that_it_promises() {
    let desk = Desk::new();

    let report = desk.json("validate", &["--sample-time", "0.12"]);

    let conditions = report["conditions"].as_array().unwrap();
    assert_eq!(conditions.len(), 4);
    let of = |key: &str, side: &str| conditions[1][key][side].as_f64().unwrap();
    assert_eq!((conditions[1]["method"].as_str(), conditions[1]["trials"].as_u64()), (Some("trot"), Some(2)));
    assert!((of("power_w", "measured") - 0.61).abs() < 1e-9);
    assert!((of("cost_of_transport", "measured") - 1.22).abs() < 1e-9);
    let predicted = of("power_w", "predicted") / (10.0 * of("speed_m_s", "predicted"));
    assert!((of("cost_of_transport", "predicted") / predicted - 1.0).abs() < 1e-3);
    for key in ["speed_mare", "power_mare", "cot_mare"] {
        assert!(report["methods"]["wide"][key].as_f64().unwrap() > 0.0, "{report}");
    }
    for key in ["spearman_speed", "spearman_cot", "baseline_power_mare"] {
        assert!(report[key].as_f64().unwrap().is_finite(), "{report}");
    }
    let pair = &report["pairs"][0];
    assert_eq!((pair["a"].as_str(), pair["b"].as_str()), (Some("trot"), Some("wide")));
    assert!(pair["faster_agrees"].is_boolean() && pair["cheaper_agrees"].is_boolean());
    let short = desk.json("validate", &["--leg", "0.6"]);
    assert_eq!(short["conditions"].as_array().unwrap().len(), 1);
}

#[test]
fn fit_writes_a_description_that_every_command_reads() {
    let desk = Desk::new();
    let fit = ["--method", "trot", "--vary", "ground.friction", "--budget", "20", "--out", "fitted"];

    let found = desk.json("fit", &fit);

    let robot = Robot::load(&desk.path("fitted")).unwrap();
    let record = robot.twin.clone().unwrap();
    assert_eq!(record.methods, ["trot"]);
    assert!(record.spread.contains_key("ground.friction"));
    let friction = found["parameters"]["ground.friction"]["value"].as_f64().unwrap();
    assert!((friction - robot.ground.friction).abs() < 1e-12);
    let again = desk.json("validate", &["--robot", "fitted", "--method", "trot"]);
    assert_eq!(again, found["validation"]);
    let errors = &again["methods"]["trot"];
    let score = ["speed_mare", "power_mare", "cot_mare"].map(|key| errors[key].as_f64().unwrap());
    assert!((score.iter().sum::<f64>() / 3.0 - record.score).abs() < 1e-9, "{score:?} {record:?}");
}

#[test]
fn what_is_wrong_with_files_and_flags_is_told_with_its_exit_code() {
    let desk = Desk::new();
    desk.twin("validate", &["--leg", "0.8"]).assert().code(3).stderr(contains("0.6"));
    desk.twin("validate", &["--leg", "9"]).assert().code(2).stderr(contains("leg_scale"));
    desk.twin("validate", &["--method", "gallop"]).assert().code(3).stderr(contains("trot, wide"));
    desk.twin("validate", &["--sample-time", "9"]).assert().code(2).stderr(contains("0.02 to 1"));
    desk.twin("fit", &["--vary", "colour"]).assert().code(2).stderr(contains("ground.friction"));
    desk.twin("fit", &["--vary", "ground.friction=0.9:0.2"]).assert().code(2).stderr(contains("MIN:MAX"));
    let elsewhere = ["--vary", "ground.friction=1:2", "--budget", "20"];
    desk.twin("fit", &elsewhere).assert().code(3).stderr(contains("from 1 to 2").and(contains("--vary")));
    desk.twin("fit", &["--budget", "10000000000000000000"]).assert().code(2).stderr(contains("1000000"));
    desk.twin("fit", &["--method", "wide"]).assert().code(3).stderr(contains("too few"));
    desk.twin("fit", &["--budget", "3"]).assert().code(3).stderr(contains("20"));
    desk.write("trials.csv", &format!("{TRIALS}1.0,trot,1,0.6,0,1.2,3\n"));
    desk.twin("validate", &[]).assert().code(3).stderr(contains("line 8").and(contains("speed_m_s is 0")));
    desk.write("trials.csv", &format!("{TRIALS}1.0,trot,3,0.6,0.05,1.2,3\n"));
    desk.twin("validate", &[]).assert().code(3).stderr(contains("trot 3x"));
    std::fs::remove_file(desk.path("tables.csv")).unwrap();
    desk.twin("validate", &[]).assert().code(3).stderr(contains("tables.csv"));
}
