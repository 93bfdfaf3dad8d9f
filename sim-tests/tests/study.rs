//! `host experiment` through the firmware: on virtual robots that it starts
//! itself, and on a port.
//!
//! Needs the `host` program beside the virtual robot's, which a build or test of
//! the whole workspace makes; a missing one is reported.

#[allow(dead_code, reason = "other tests use the rest")]
mod processes;

use processes::{RobotProcess, finish};
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

fn program() -> Option<PathBuf> {
    let host = Path::new(env!("CARGO_BIN_EXE_virtual-robot")).with_file_name("host");
    if !host.is_file() {
        println!("skipped: {} is not built; cargo build --workspace makes it", host.display());
    }
    Some(host).filter(|host| host.is_file())
}

/// One condition, one short trial.
fn study(host: &Path, folder: &Path, arguments: &[&str]) -> Value {
    let child = Command::new(host)
        .current_dir(folder)
        .args(["experiment", "--leg", "1", "--method", "psto", "--amp", "1.6", "--trials", "1"])
        .args(["--duration", "10", "--json"])
        .args(arguments)
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let (code, out, error) = finish(child);
    assert_eq!(code, 0, "{error}");
    serde_json::from_str(&out).unwrap()
}

fn figure(study: &Value, name: &str) -> f64 {
    study["conditions"][0][name]["mean"].as_f64().unwrap_or_else(|| panic!("{study:#}"))
}

#[test]
fn a_study_on_virtual_robots_and_on_a_port_comes_to_what_the_twin_says() {
    let Some(host) = program() else { return };
    let desk = tempfile::tempdir().unwrap();
    let twin = study(&host, desk.path(), &["--out", "twin"]);

    let on_virtual = ["--out", "virtual", "--on", "virtual-robot"];
    let virtual_robot = study(&host, desk.path(), &on_virtual);
    let robot = RobotProcess::start(desk.path(), &[]);
    let truth = robot.truth_path().display().to_string();
    let port = study(&host, desk.path(), &["--out", "on-port", "--port", robot.port(), "--tracker", &truth]);

    // One start each, and not the same: as near as that allows.
    for through_firmware in [&virtual_robot, &port] {
        for (name, tolerance) in [("speed_m_s", 0.03), ("cost_of_transport", 0.04)] {
            let (there, here) = (figure(through_firmware, name), figure(&twin, name));
            assert!((there / here - 1.0).abs() < tolerance, "{name}: {there} for {here}");
        }
    }
    assert_eq!(virtual_robot["on"].as_str(), Some("virtual-robot"));

    // Nothing is left to be walked.
    let again = study(&host, desk.path(), &on_virtual);
    assert_eq!(again["conditions"], virtual_robot["conditions"]);
}
