//! The host's short commands against the real image in the emulator, as
//! separate processes with a pseudo-terminal between them, in real time. A
//! missing firmware image fails these tests and says how to build one.

// `host_link` uses the rest of it.
#[allow(dead_code)]
mod processes;

use processes::{RobotProcess, host, host_json, host_outcome, play_patiently, recording};

/// A command for this robot.
fn on_port<'a>(robot: &'a RobotProcess, arguments: &[&'a str]) -> Vec<&'a str> {
    [arguments, &["--port", robot.port()]].concat()
}

/// Flags that read such a file as degrees.
const DEGREES: [&str; 4] = ["--unit-deg", "1", "--centre-unit-deg", "1"];

#[test]
fn gaits_of_both_kinds_are_stored_selected_and_walked_without_the_host() {
    let folder = tempfile::tempdir().unwrap();
    let robot = RobotProcess::start(folder.path(), &["--no-reset-on-open"]);
    recording(folder.path(), "wave.csv", 54);
    host(folder.path(), &[&["fit", "wave.csv", "--out", "gait.toml"], &DEGREES[..]].concat());
    host(folder.path(), &on_port(&robot, &["upload-gait", "--gait", "gait.toml", "--amp", "1.5"]));
    let sampled = [&["upload-gait", "wave.csv", "--sampled", "--name", "raw", "--amp", "1"], &DEGREES[..]];
    let raw = host_json(folder.path(), &on_port(&robot, &sampled.concat()));
    assert_eq!(raw["sampled"]["rows"], 27, "{raw}");

    let gaits = host_json(folder.path(), &on_port(&robot, &["gaits", "--select", "wave"]));
    assert_eq!(gaits["gaits"].as_array().unwrap().len(), 2, "{gaits}");
    assert_eq!(gaits["active"], "wave");
    let walk = host_json(folder.path(), &on_port(&robot, &["walk", "--detached", "--for", "60"]));
    assert_eq!(walk["gait_name"], "wave");
    host(folder.path(), &on_port(&robot, &["set", "--amp", "1.2", "--speed", "0.5"]));
    let status = host_json(folder.path(), &on_port(&robot, &["status"]));
    let stopped = host(folder.path(), &on_port(&robot, &["stop"]));
    let last = host_json(folder.path(), &on_port(&robot, &["measure", "--last", "--distance", "0.2"]));

    assert!(["entering", "walking"].contains(&status["state"].as_str().unwrap()), "{status}");
    assert_eq!(status["gait"]["amplitude"], 1.2);
    assert_eq!((&status["bad_frames"], &status["bus_errors"]), (&0.into(), &0.into()), "{status}");
    assert!(stopped.contains("standing still") || stopped.contains("idle"), "{stopped}");
    assert_eq!(last["ended"], "stop-byte", "{last}");
    // Where the slide from 1.5 had come to.
    assert!((1.2..=1.5).contains(&last["amplitude"].as_f64().unwrap()), "{last}");
}

#[test]
fn an_attached_walk_tells_what_the_robot_remembers_of_it() {
    let folder = tempfile::tempdir().unwrap();
    let robot = RobotProcess::start(folder.path(), &["--no-reset-on-open"]);
    recording(folder.path(), "wave.csv", 54);
    host(folder.path(), &[&["fit", "wave.csv", "--out", "gait.toml"], &DEGREES[..]].concat());
    host(folder.path(), &on_port(&robot, &["upload-gait", "--gait", "gait.toml", "--amp", "1"]));

    let rehearsed = host_json(folder.path(), &on_port(&robot, &["walk", "--for", "1", "--dry-run"]));
    assert!(robot.pulses().is_empty(), "a rehearsal moved the servos");
    let walked = host_json(folder.path(), &on_port(&robot, &["walk", "--for", "2", "--period", "1.8"]));
    let last = host_json(folder.path(), &on_port(&robot, &["measure", "--last"]));

    assert_eq!(rehearsed["frames_played"], 60, "{rehearsed}");
    assert_eq!((&walked["frames_played"], &walked["speed"]), (&120.into(), &0.5.into()), "{walked}");
    assert_eq!((&last["ended"], &last["frames_played"]), (&"finished".into(), &120.into()), "{last}");
    let (told_j, kept_j) = (walked["energy_j"].as_f64().unwrap(), last["energy_j"].as_f64().unwrap());
    assert!((told_j - kept_j).abs() < 0.02 * kept_j, "{told_j} J told, {kept_j} J kept");
}

#[test]
fn a_calibration_is_read_changed_written_and_walked_by() {
    let folder = tempfile::tempdir().unwrap();
    let robot = RobotProcess::start(folder.path(), &["--no-reset-on-open", "--eeprom", "eeprom.bin"]);
    let port = ["--port", robot.port()];
    host(folder.path(), &[&["calibrate", "--read", "robot.toml.txt"], &port[..]].concat());
    let path = folder.path().join("robot.toml.txt");
    let text = std::fs::read_to_string(&path).unwrap();
    // 10 counts of 4.08 us more, for all joints.
    std::fs::write(&path, text.replace("neutral_us = 1346.4", "neutral_us = 1387.2")).unwrap();

    host(folder.path(), &[&["calibrate", "--write", "robot.toml.txt"], &port[..]].concat());
    recording(folder.path(), "wave.csv", 60);
    play_patiently(folder.path(), &[&["--amp", "0.1"], &port[..]].concat());
    let status = host_json(folder.path(), &[&["status"], &port[..]].concat());

    assert_eq!(status["calibration"], "stored", "{status}");
    // 1.2 degrees about neutral are two counts.
    let pulses = robot.pulses();
    let (_, counts) = pulses.last().unwrap();
    assert!(counts.iter().all(|c| (338.0..=342.0).contains(c)), "{counts:?}");
    drop(robot);
    let robot = RobotProcess::start(folder.path(), &["--eeprom", "eeprom.bin"]);
    let status = host_json(folder.path(), &["status", "--port", robot.port()]);
    assert_eq!(status["calibration"], "stored", "{status}");
}

#[test]
fn a_robot_without_a_gait_says_so_to_every_command_that_needs_one() {
    let folder = tempfile::tempdir().unwrap();
    let robot = RobotProcess::start(folder.path(), &[]);

    for arguments in [&["walk", "--for", "1"][..], &["measure", "--duration", "1", "--distance", "1"]] {
        let (code, out, err) = host_outcome(folder.path(), &[arguments, &["--port", robot.port()]].concat());
        assert_eq!(code, 5, "{out}\n{err}");
        assert!(err.contains("it has no gait") && err.contains("upload-gait"), "{err}");
    }
    let (code, _, err) = host_outcome(folder.path(), &["measure", "--last", "--port", robot.port()]);
    assert_eq!(code, 5, "{err}");
    assert!(err.contains("remembers no walk"), "{err}");
}
