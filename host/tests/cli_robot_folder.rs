//! `host robot new`, `check` and `export`, and servos by name, as processes.

use assert_cmd::Command;
use host::robot::Robot;
use host::robot::servo_presets::preset;
use host::sim::World;
use std::path::Path;

const ROBOTS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/robots");

/// An empty folder to work in.
struct Desk(tempfile::TempDir);

impl Desk {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn path(&self) -> &Path {
        self.0.path()
    }

    fn host(&self, args: &[&str]) -> Command {
        let mut command = Command::cargo_bin("host").unwrap();
        command.current_dir(self.path()).env("NO_COLOR", "1").env("COLUMNS", "400").args(args);
        command
    }

    fn says(&self, args: &[&str]) -> String {
        String::from_utf8(self.host(args).assert().success().get_output().stdout.clone()).unwrap()
    }

    /// What is there, hidden files too.
    fn names(&self) -> Vec<String> {
        let entries = std::fs::read_dir(self.path()).unwrap();
        let mut names: Vec<String> =
            entries.map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned()).collect();
        names.sort();
        names
    }
}

fn fails(command: &mut Command, code: i32) -> String {
    let assert = command.assert().code(code);
    String::from_utf8_lossy(&assert.get_output().stderr).into_owned()
}

fn shipped(name: &str) -> String {
    format!("{ROBOTS}/{name}")
}

/// Whether a robot still stands on four feet after three seconds.
fn stands(robot: &Robot) -> bool {
    let mut world = World::new(robot);
    for _ in 0..720 {
        world.step(&[Some(0.0); 8]);
    }
    world.foot_contacts() == [true; 4] && !world.body_touches_ground() && world.torso().tilt_rad() < 0.05
}

#[test]
fn a_new_robot_of_either_mounting_loads_passes_the_check_and_stands() {
    for mounting in ["sprawling", "mammal"] {
        let desk = Desk::new();

        let said = desk.says(&["robot", "new", "mine", "--yes", "--name", "Mine", "--mounting", mounting]);

        assert!(
            said.contains("Mine: no errors") && said.contains("Next: cargo run -p host -- robot check mine"),
            "{said}"
        );
        assert_eq!(desk.names(), ["mine"]);
        let robot = Robot::load(&desk.path().join("mine")).unwrap();
        assert_eq!(robot.servo.model.as_deref(), Some("MG90S"));
        assert_eq!(robot.servo, preset("MG90S").unwrap().at(5.0).unwrap().servo);
        assert!(stands(&robot), "{mounting}");
        let said = desk.says(&["robot", "check", "mine"]);
        assert!(said.contains("Next: cargo run -p host -- optimise --robot mine"), "{said}");
        assert!(desk.path().join("runs/mine-views.svg").is_file());
    }
}

#[test]
fn answers_are_asked_for_again_until_they_fit_and_empty_ones_take_the_default() {
    let desk = Desk::new();
    // Name, mounting, servo, then twelve numbers.
    let answers = "a/b\nTiny\nlike a crab\nmammal\nMG9S\nSG90\n3\n40\n50\n\n\n\n100\n\n\n\n9\n4.8\n\n";

    let assert = desk.host(&["robot", "new"]).write_stdin(answers).assert().success();

    let asked = String::from_utf8_lossy(&assert.get_output().stderr).into_owned();
    for part in [
        "the name is \"a/b\"",
        "answer sprawling or mammal",
        "did you mean MG90S",
        "within 15 to 300 mm",
        "4.8 V",
    ] {
        assert!(asked.contains(part), "{part}: {asked}");
    }
    let robot = Robot::load(&desk.path().join("tiny")).unwrap();
    assert_eq!((robot.name.as_str(), robot.servo.model.as_deref()), ("Tiny", Some("SG90")));
    assert!((robot.mass_kg() - (0.1 + 8.0 * 0.009 + 8.0 * 0.014)).abs() < 1e-6, "{}", robot.mass_kg());
    assert_eq!(robot.supply.nominal_v, 4.8);
}

#[test]
fn nothing_is_left_of_a_robot_that_is_given_up_or_cannot_stand() {
    let desk = Desk::new();

    let message = fails(desk.host(&["robot", "new", "mine"]).write_stdin("Mine\nmammal\n"), 2);
    assert!(message.contains("the input ended") && message.contains("--yes"), "{message}");
    assert!(desk.names().is_empty(), "{:?}", desk.names());

    let heavy = ["robot", "new", "mine", "--yes", "--body-g", "8000"];
    let message = fails(&mut desk.host(&heavy), 3);
    assert!(message.contains("nothing was written"), "{message}");
    assert!(desk.names().is_empty(), "{:?}", desk.names());

    let message = fails(&mut desk.host(&["robot", "new", "mine", "--yes", "--thigh-mm", "1"]), 2);
    assert!(message.contains("within 15 to 300 mm"), "{message}");
    assert!(desk.names().is_empty(), "{:?}", desk.names());
}

#[test]
fn a_folder_that_is_there_is_never_replaced() {
    let desk = Desk::new();
    std::fs::create_dir(desk.path().join("mine")).unwrap();
    std::fs::write(desk.path().join("mine/robot.toml"), "precious").unwrap();

    let message = fails(&mut desk.host(&["robot", "new", "mine", "--yes"]), 2);

    assert!(message.contains("mine is there already"), "{message}");
    assert_eq!(std::fs::read_to_string(desk.path().join("mine/robot.toml")).unwrap(), "precious");
}

#[test]
fn the_shipped_robots_pass_the_check_and_are_drawn() {
    for name in ["ant", "pony", "newt"] {
        let desk = Desk::new();

        let said = desk.says(&["robot", "check", &shipped(name), "--json", "--svg", "views.svg"]);

        let json: serde_json::Value = serde_json::from_str(&said).unwrap();
        assert_eq!(json["errors"], 0, "{json:#}");
        let robot = Robot::load(Path::new(&shipped(name))).unwrap();
        assert!((json["mass_kg"].as_f64().unwrap() - robot.mass_kg()).abs() < 1e-12);
        let findings = json["findings"].as_array().unwrap();
        for topic in [
            "mass",
            "span",
            "standing_height",
            "ground_contact",
            "knee_torque_on_two",
            "peak_power",
            "leg_order",
        ] {
            let finding = findings.iter().find(|finding| finding["topic"] == topic).expect(topic);
            assert!(finding["mark"].is_string() && finding["value"].is_number(), "{finding}");
        }
        let svg = std::fs::read_to_string(desk.path().join("views.svg")).unwrap();
        assert!(svg.starts_with("<svg") && svg.trim_end().ends_with("</svg>"));
    }
}

#[test]
fn a_robot_that_its_servos_cannot_carry_fails_the_check_with_exit_code_3() {
    let desk = Desk::new();
    let mut robot = Robot::load(Path::new(&shipped("newt"))).unwrap();
    robot.mass.torso_kg = 12.0;
    robot.save(&desk.path().join("heavy")).unwrap();

    let assert = desk.host(&["robot", "check", "heavy", "--svg", "views.svg"]).assert().code(3);

    let said = String::from_utf8_lossy(&assert.get_output().stdout).into_owned();
    assert!(
        said.lines().any(|line| line.starts_with("ERROR") && line.contains("knee torque, 4 feet")),
        "{said}"
    );
    assert!(said.contains("the servos cannot carry the robot") && !said.contains("Next:"), "{said}");
    let message = String::from_utf8_lossy(&assert.get_output().stderr).into_owned();
    assert!(message.contains("heavy has") && message.contains("error"), "{message}");
}

#[test]
fn a_robot_that_cannot_be_read_fails_the_check_with_exit_code_3() {
    let desk = Desk::new();
    std::fs::create_dir(desk.path().join("typo")).unwrap();
    let text = std::fs::read_to_string(format!("{ROBOTS}/newt/robot.toml")).unwrap();
    std::fs::write(desk.path().join("typo/robot.toml"), text.replace("\"MG90S\"", "\"MG-90X\"")).unwrap();

    let message = fails(&mut desk.host(&["robot", "check", "typo"]), 3);

    assert!(message.contains("MG-90X") && message.contains("did you mean MG90"), "{message}");
}

#[test]
fn an_export_is_written_where_asked_and_never_over_the_robots_own_drawing() {
    let desk = Desk::new();

    let said = desk.says(&["robot", "export", &shipped("newt"), "--urdf"]);
    assert!(said.contains("newt.urdf") && said.contains("0.45"), "{said}");
    assert!(
        std::fs::read_to_string(desk.path().join("newt.urdf")).unwrap().contains("<robot name=\"Newt\">")
    );

    desk.says(&["robot", "new", "mine", "--yes", "--name", "Mine"]);
    let drawing = std::fs::read(desk.path().join("mine/mine.xml")).unwrap();
    let message = fails(&mut desk.host(&["robot", "export", "mine", "--mjcf", "--out", "mine/mine.xml"]), 2);
    assert!(message.contains("--out"), "{message}");
    assert_eq!(std::fs::read(desk.path().join("mine/mine.xml")).unwrap(), drawing);

    fails(&mut desk.host(&["robot", "export", "mine"]), 2);
    assert!(
        desk.says(&["robot", "export", "mine", "--mjcf", "--out", "-"]).contains("<mujoco model=\"Mine\">")
    );
}

#[test]
fn the_newt_stands_and_weighs_what_its_parts_do() {
    let newt = Robot::load(Path::new(&shipped("newt"))).unwrap();

    assert!((newt.mass_kg() - 0.45).abs() < 0.002, "{} kg", newt.mass_kg());
    assert!(stands(&newt));
}
