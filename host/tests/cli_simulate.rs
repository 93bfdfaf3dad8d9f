//! `host simulate`: gaits that walk, gaits that fall, and bad flags.

mod host_command;

use assert_cmd::Command;
use serde_json::Value;
use std::f64::consts::{PI, TAU};
use std::path::Path;

/// A folder with a gait that walks, `trot.toml`.
struct Desk {
    folder: tempfile::TempDir,
}

impl Desk {
    fn new() -> Self {
        let desk = Self { folder: tempfile::tempdir().unwrap() };
        desk.fit("trot", |phase, joint| {
            let leg_phase = TAU * phase + PI * (joint % 2) as f64;
            let swing = if joint < 2 { 20.0 } else { -20.0 };
            if joint < 4 { swing * leg_phase.sin() } else { 17.0 * leg_phase.cos() }
        });
        desk
    }

    fn host(&self, args: &[&str]) -> Command {
        host_command::host(self.folder.path(), args)
    }

    /// A stride of 1 s, angles in degrees.
    fn fit(&self, name: &str, angle_deg: impl Fn(f64, usize) -> f64) {
        let mut csv = String::from("time_s,hip1,hip2,hip3,hip4,knee1,knee2,knee3,knee4\n");
        for row in 0..60 {
            let phase = f64::from(row) / 60.0;
            let joints: String = (0..8).map(|joint| format!(",{:.5}", angle_deg(phase, joint))).collect();
            csv.push_str(&format!("{phase:.6}{joints}\n"));
        }
        let (table, gait) = (format!("{name}.csv"), format!("{name}.toml"));
        std::fs::write(self.folder.path().join(&table), csv).unwrap();
        let degrees = ["--unit-deg", "1", "--centre-unit-deg", "1", "--limit-deg", "55"];
        self.host(&[&["fit", &table, "--rows", "all", "--out", &gait][..], &degrees].concat())
            .assert()
            .success();
    }

    fn simulate(&self, args: &[&str]) -> String {
        let short = ["simulate", "--duration", "6", "--starts", "4", "--json"];
        let output = self.host(&[&short[..], args].concat()).assert().success();
        String::from_utf8(output.get_output().stdout.clone()).unwrap()
    }

    #[track_caller]
    fn fails(&self, code: i32, args: &[&str]) -> String {
        host_command::refused(self.folder.path(), code, &[&["simulate"], args].concat())
    }
}

fn json(text: &str) -> Value {
    serde_json::from_str(text).unwrap()
}

#[test]
fn a_trot_walks_and_every_start_has_its_row() {
    let desk = Desk::new();

    let result = json(&desk.simulate(&["trot.toml", "--amp", "1"]));

    let mean = |key: &str| result[key]["mean"].as_f64().unwrap();
    assert!(mean("distance_m") > 0.2, "{result:#}");
    assert!((mean("speed_m_s") - mean("distance_m") / 6.0).abs() < 1e-9);
    assert!((0.25..5.0).contains(&mean("mean_power_w")), "{result:#}");
    assert_eq!(result["fell"], 0);
    let walks = result["walks"].as_array().unwrap();
    assert_eq!(walks.len(), 4);
    let speeds: Vec<f64> = walks.iter().map(|walk| walk["speed_m_s"].as_f64().unwrap()).collect();
    assert!((speeds.iter().sum::<f64>() / 4.0 - mean("speed_m_s")).abs() < 1e-9);
    assert!(result["speed_m_s"]["least"].as_f64() < result["speed_m_s"]["most"].as_f64());
}

#[test]
fn a_gait_that_walks_backwards_says_so() {
    let desk = Desk::new();
    let text = std::fs::read_to_string(gait("ant-1L/searched.toml")).unwrap();
    std::fs::write(desk.folder.path().join("back.toml"), with_opposite_legs(&text)).unwrap();
    let warnings = |path: &str| json(&desk.simulate(&[path]))["warnings"].to_string();

    let back = warnings("back.toml");

    assert!(back.contains("it walks backwards: x -") && back.contains("forward is +x"), "{back}");
    assert!(!warnings(&gait("ant-1L/searched.toml")).contains("it walks"));
}

fn gait(path: &str) -> String {
    format!("{}/gaits/{path}", env!("CARGO_MANIFEST_DIR"))
}

/// Legs 1 and 3, and 2 and 4, exchanged by their names.
fn with_opposite_legs(text: &str) -> String {
    let pairs = [("hip1", "hip3"), ("hip2", "hip4"), ("knee1", "knee3"), ("knee2", "knee4")];
    pairs.iter().fold(text.to_owned(), |text, (one, other)| {
        text.replace(one, "\u{1}").replace(other, one).replace('\u{1}', other)
    })
}

#[test]
fn the_same_seed_prints_the_same_bytes_and_another_seed_others() {
    let desk = Desk::new();

    let first = desk.simulate(&["trot.toml", "--amp", "1", "--seed", "7"]);

    assert_eq!(first, desk.simulate(&["trot.toml", "--amp", "1", "--seed", "7"]));
    assert_ne!(first, desk.simulate(&["trot.toml", "--amp", "1", "--seed", "8"]));
}

/// On stilts of 46 cm, upright, it stands on a narrow base and is rocked off it.
#[test]
fn a_gait_that_falls_is_counted_and_said_so() {
    let desk = Desk::new();
    let mut stilts = host::robot::Robot::ant(host::robot::LegScale::new(2.0).unwrap()).unwrap();
    stilts.geometry.shin_below_horizontal_deg = 85.0;
    stilts.save(&desk.folder.path().join("stilts")).unwrap();
    desk.fit("rock", |phase, joint| {
        let lean = 25.0 * (TAU * phase).sin();
        match joint {
            0..4 => 0.0,
            4 | 5 => lean,
            _ => -lean,
        }
    });

    let fallen = json(&desk.simulate(&["rock.toml", "--amp", "1", "--robot", "stilts"]));
    let walked = json(&desk.simulate(&["trot.toml", "--amp", "1", "--robot", "stilts"]));
    let few =
        ["simulate", "rock.toml", "--amp", "1", "--robot", "stilts", "--duration", "6", "--starts", "2"];
    let words = desk.host(&few).assert().success();

    assert_eq!(fallen["fell"], 4, "{fallen:#}");
    assert!(fallen["walks"].as_array().unwrap().iter().all(|walk| walk["fell"] == true));
    assert_eq!(walked["fell"], 0, "{walked:#}");
    let words = String::from_utf8_lossy(&words.get_output().stdout).into_owned();
    assert!(words.contains("it FELL from 2 of 2 starts"), "{words}");
}

#[test]
fn the_robot_is_the_runs_or_the_named_one() {
    let desk = Desk::new();
    let pony = concat!(env!("CARGO_MANIFEST_DIR"), "/robots/pony");
    let robot =
        |args: &[&str]| json(&desk.simulate(&[&["trot.toml", "--amp", "1"], args].concat()))["robot"].clone();

    assert_eq!(robot(&[]), "Ant");
    assert_eq!(robot(&["--robot", pony]), "Pony");
    let ours = desk.folder.path().join(host::run_folder::ROBOT);
    host::robot::Robot::load(Path::new(pony)).unwrap().save(&ours).unwrap();
    assert_eq!(robot(&[]), "Pony");
    assert_eq!(robot(&["--leg", "0.6"]), "Ant");
}

/// Hips that are drawn to turn 5 degrees either way; the wave is 20.
#[test]
fn a_gait_beyond_the_drawn_range_is_warned_of_and_neither_fitted_nor_uploaded() {
    let desk = Desk::new();
    let narrow = desk.folder.path().join("narrow");
    host::robot::Robot::ant(host::robot::LegScale::LONG).unwrap().save(&narrow).unwrap();
    let model = narrow.join("ant.xml");
    let text = std::fs::read_to_string(&model).unwrap();
    let hips = (1..=4).fold(text, |text, leg| {
        let name = format!("name=\"hip{leg}\"");
        assert!(text.contains(&name), "the model names its hips otherwise");
        text.replace(&name, &format!("{name} range=\"-5 5\""))
    });
    std::fs::write(&model, hips).unwrap();

    let warnings =
        json(&desk.simulate(&["trot.toml", "--amp", "0.6", "--robot", "narrow"]))["warnings"].to_string();
    let upload = ["upload-gait", "--gait", "trot.toml", "--robot", "narrow", "--amp", "0.6", "--dry-run"];
    let uploaded = host_command::refused(desk.folder.path(), 3, &upload);
    let fit = ["fit", "trot.csv", "--unit-deg", "1", "--centre-unit-deg", "1", "--robot", "narrow"];
    let fitted = host_command::refused(desk.folder.path(), 3, &[&fit[..], &["--out", "g.toml"]].concat());

    let said = |asked: &str| format!("hip1 turns 5.0 degrees either way, but is asked for {asked}");
    assert!(warnings.contains(&said("12.")), "{warnings}");
    assert!(uploaded.contains(&said("12.")), "{uploaded}");
    assert!(fitted.contains(&said("20.")), "{fitted}");
    assert!(!desk.folder.path().join("g.toml").exists());
}

#[test]
fn a_gait_by_itself_walks_on_the_legs_that_it_was_made_for() {
    let desk = Desk::new();
    let path = desk.folder.path().join("trot.toml");
    let text = std::fs::read_to_string(&path).unwrap();
    let leg = |text: &str, args: &[&str]| {
        std::fs::write(&path, text).unwrap();
        let result = json(&desk.simulate(&[&["trot.toml", "--amp", "1"], args].concat()));
        (result["leg_scale"].as_f64().unwrap(), result["warnings"].to_string())
    };
    let short = text.replacen("[provenance]", "[provenance]\nleg_scale = 0.6", 1);

    assert_eq!(leg(&text, &[]).0, 1.0);
    let (own, warnings) = leg(&short, &[]);
    assert_eq!((own, warnings.contains("legs")), (0.6, false), "{warnings}");
    let (other, warnings) = leg(&short, &["--leg", "1"]);
    assert_eq!(other, 1.0);
    assert!(warnings.contains("made for legs of 0.6 L, Ant has 1 L"), "{warnings}");
    let message = {
        std::fs::write(&path, text.replacen("[provenance]", "[provenance]\nleg_scale = 70.0", 1)).unwrap();
        desk.fails(3, &["trot.toml", "--amp", "1"])
    };
    assert!(message.contains("leg_scale is 70") && message.contains("0.3 to 2"), "{message}");
}

/// A ramp of 10 degrees in a stride and back at once; fit and simulate say the same of it.
#[test]
fn a_jump_at_the_seam_is_named_apart_and_does_not_make_a_curve_too_fast() {
    let desk = Desk::new();
    let mut csv = String::from("time_s,hip1,hip2,hip3,hip4,knee1,knee2,knee3,knee4\n");
    for row in 0..60 {
        let phase = f64::from(row) / 60.0;
        csv.push_str(&format!("{phase:.6},{:.5},0,0,0,0,0,0,0\n", 10.0 * phase - 5.0));
    }
    std::fs::write(desk.folder.path().join("ramp.csv"), csv).unwrap();
    let degrees = ["--unit-deg", "1", "--centre-unit-deg", "1", "--seam", "free", "--out", "ramp.toml"];
    desk.host(&[&["fit", "ramp.csv"][..], &degrees].concat()).assert().success();

    let result = json(&desk.simulate(&["ramp.toml", "--amp", "1"]));

    let warnings = result["warnings"].to_string();
    assert!(warnings.contains("hip1: strides meet with a step of -9.8 degrees at 1x"), "{warnings}");
    assert!(warnings.contains("its servo takes 3.4 frames"), "{warnings}");
    assert!(!warnings.contains("degrees/s"), "{warnings}");
}

/// 20 degrees of hip at 3x are 60, beyond the limit of 55.
#[test]
fn what_is_clipped_and_too_fast_is_warned_of() {
    let desk = Desk::new();

    let result = json(&desk.simulate(&["trot.toml", "--amp", "3"]));

    let warnings = result["warnings"].to_string();
    assert!(result["clipped_share"].as_f64().unwrap() > 0.05, "{result:#}");
    assert!(warnings.contains("held at their limits"), "{warnings}");
    assert!(warnings.contains("its servo does 175"), "{warnings}");
}

#[test]
fn bad_flags_and_gaits_are_refused_with_value_limit_and_next_move() {
    let desk = Desk::new();
    std::fs::write(desk.folder.path().join("text.toml"), "a gait, honestly").unwrap();
    let cases: [(i32, &[&str], &[&str]); 8] = [
        (2, &["trot.toml", "--amp", "9"], &["--amp is 9; it must be within 0.5 to 3"]),
        (2, &["trot.toml", "--duration", "nan"], &["--duration is NaN; it must be within 0.1 to 3600"]),
        (2, &["trot.toml", "--starts", "0"], &["0 is not in 1..=1000"]),
        (2, &["trot.toml", "--leg", "1", "--robot", "."], &["cannot be used with"]),
        (2, &["trot.toml", "--leg", "9"], &["9", "0.3", "2"]),
        (3, &["trot.toml", "--robot", "nowhere"], &["nowhere"]),
        (3, &["text.toml"], &["text.toml is no", "host fit"]),
        (3, &[], &["cannot read runs/latest/gait.toml", "`host fit` writes"]),
    ];
    for (code, args, expected) in cases {
        let message = desk.fails(code, args);

        for part in expected {
            assert!(message.contains(part), "{args:?}: {message}");
        }
    }
}

/// Numbers that pass the robot's checks, but that no solver holds.
#[test]
fn a_robot_that_the_engine_cannot_hold_is_an_error_and_no_panic() {
    let desk = Desk::new();
    let mut robot = host::robot::Robot::ant(host::robot::LegScale::LONG).unwrap();
    robot.mass.torso_kg = 0.01;
    robot.servo.stiffness_n_m_rad = 200.0;
    robot.servo.damping_n_m_s_rad = 0.0;
    robot.servo.torque_limit_n_m = 50.0;
    robot.servo.no_load_speed_rad_s = 50.0;
    robot.save(&desk.folder.path().join("wild")).unwrap();

    let message =
        desk.fails(3, &["trot.toml", "--amp", "3", "--duration", "3", "--starts", "2", "--robot", "wild"]);

    assert!(message.contains("the simulation of start 0 diverged"), "{message}");
    assert!(message.contains("stiffness and the masses in its robot.toml"), "{message}");
    assert!(!message.contains("panicked"), "{message}");
}
