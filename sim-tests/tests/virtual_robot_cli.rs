//! The virtual robot asked for what it cannot do: a message that says what to do, no
//! panic, and no file of others touched.

use host::calibration::RobotCalibration;
use host::robot::Robot;
use sim_tests::calibrated::calibration_in;
use std::path::Path;
use std::process::{Command, Stdio};

/// Runs it; returns whether it succeeded, and what it said, on one line.
fn outcome(folder: &Path, arguments: &[&str]) -> (bool, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_virtual-robot"))
        .current_dir(folder)
        // Whatever it accepts by mistake must end.
        .args(["--max-seconds", "0.2"])
        .args(arguments)
        .stdin(Stdio::null())
        .output()
        .unwrap();
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(!message.contains("panicked"), "{message}");
    // The report wraps its lines, and draws a rule beside them.
    let words: Vec<&str> = message.split_whitespace().filter(|word| *word != "│").collect();
    (output.status.success(), words.join(" "))
}

#[test]
fn a_missing_firmware_image_is_an_error_with_the_next_move() {
    let folder = tempfile::tempdir().unwrap();

    let (succeeded, message) = outcome(folder.path(), &["--elf", "no/such/nano.elf"]);

    assert!(!succeeded);
    assert!(message.contains("`make firmware`"), "{message}");
}

#[test]
fn it_ends_after_the_seconds_it_was_given_and_takes_its_link_along() {
    let folder = tempfile::tempdir().unwrap();

    let (succeeded, message) = outcome(folder.path(), &["--link", "port", "--truth", "truth.jsonl"]);

    assert!(succeeded, "{message}");
    assert!(folder.path().join("port").symlink_metadata().is_err());
    let truth = std::fs::read_to_string(folder.path().join("truth.jsonl")).unwrap();
    assert!(truth.lines().count() >= 10 && truth.ends_with('\n'), "{truth}");
}

/// The pony stands 17 cm high, the Ant 19 cm.
#[test]
fn it_is_whichever_robot_its_folder_describes() {
    let folder = tempfile::tempdir().unwrap();
    let pony = concat!(env!("CARGO_MANIFEST_DIR"), "/../host/robots/pony");

    let (succeeded, message) = outcome(folder.path(), &["--robot", pony, "--truth", "truth.jsonl"]);

    assert!(succeeded, "{message}");
    let truth = std::fs::read_to_string(folder.path().join("truth.jsonl")).unwrap();
    let first: serde_json::Value = serde_json::from_str(truth.lines().next().unwrap()).unwrap();
    assert!((first["z_m"].as_f64().unwrap() - 0.1745).abs() < 0.001, "{first}");
}

#[test]
fn impossible_arguments_are_refused_by_name() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("short.bin"), [0xFF; 1000]).unwrap();
    std::fs::write(folder.path().join("robot.toml"), "mass = \"heavy\"").unwrap();
    for (arguments, said) in [
        (["--boot-delay-ms", "60001"], "60001"),
        (["--boot-delay-ms", "-1"], "-1"),
        (["--truth", "no/such/truth.jsonl"], "no/such/truth.jsonl"),
        (["--pulses", "."], "cannot create ."),
        (["--eeprom", "short.bin"], "1000 bytes"),
        (["--eeprom", "."], "cannot read ."),
        (["--robot", "robot.toml"], "robot.toml"),
        (["--robot", "no/such/robot.toml"], "no/such/robot.toml"),
        (["--robot", "nowhere"], "nowhere/robot.toml"),
        (["--leg", "nan"], "--leg"),
        (["--leg=-1", "--seed=1"], "--leg"),
        (["--link", "short.bin"], "short.bin"),
        (["--link", "no/such/port"], "no/such/port"),
    ] {
        let (succeeded, message) = outcome(folder.path(), &arguments);

        assert!(!succeeded, "{arguments:?}");
        assert!(message.contains(said), "{arguments:?}: {message}");
    }
    assert_eq!(std::fs::read(folder.path().join("short.bin")).unwrap(), [0xFF; 1000]);
}

#[test]
fn a_time_that_cannot_pass_is_refused() {
    for seconds in ["--max-seconds=nan", "--max-seconds=-1", "--max-seconds=0", "--max-seconds=soon"] {
        let output = Command::new(env!("CARGO_BIN_EXE_virtual-robot")).arg(seconds).output().unwrap();

        assert!(!output.status.success(), "{seconds}");
        assert!(String::from_utf8_lossy(&output.stderr).contains("--max-seconds"), "{seconds}");
    }
}

/// As a real robot after `host calibrate`; and what was calibrated later is kept.
#[test]
fn its_board_is_calibrated_as_its_robot_is_described_unless_it_is_fresh_or_was_calibrated_before() {
    let folder = tempfile::tempdir().unwrap();
    let robots = Path::new(env!("CARGO_MANIFEST_DIR")).join("../host/robots");
    let pony = robots.join("pony").display().to_string();
    let described = |name: &str| {
        let robot = Robot::load(&robots.join(name)).unwrap();
        RobotCalibration::of_robot(&robot).record().unwrap()
    };
    let calibration = |file: &str, arguments: &[&str]| {
        let (succeeded, message) = outcome(folder.path(), &[&["--eeprom", file], arguments].concat());
        assert!(succeeded, "{message}");
        let bytes = std::fs::read(folder.path().join(file)).ok();
        bytes.and_then(|bytes| calibration_in(&bytes.try_into().unwrap()))
    };

    assert_eq!(calibration("ant.bin", &[]), Some(described("ant")));
    assert_eq!(calibration("pony.bin", &["--robot", &pony]), Some(described("pony")));
    assert_eq!(calibration("fresh.bin", &["--robot", &pony, "--uncalibrated"]), None);
    assert_eq!(
        calibration("ant.bin", &["--robot", &pony]),
        Some(described("ant")),
        "it was calibrated before"
    );
}
