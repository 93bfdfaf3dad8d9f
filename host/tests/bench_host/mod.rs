//! The `host` program at the other end of the fake robot's terminal.
// Every test file uses another part of it.
#![allow(dead_code)]

use crate::fake_robot::bench::Bench;
use crate::fake_robot::{FakeRobot, Troubles};
use assert_cmd::Command;
use host::gait::gait_file::{GaitFile, JointSeries, Provenance, Source};
use protocol::Joint;
use std::time::Duration;

pub fn gait(name: &str) -> GaitFile {
    let mut coefficients_deg = [0.0; 11];
    coefficients_deg[2] = 10.0;
    let series = JointSeries { min_deg: -55.0, max_deg: 55.0, coefficients_deg, ..Default::default() };
    GaitFile {
        name: name.into(),
        period_s: 0.6,
        unit_deg: 24.0,
        provenance: Provenance::of(Source::Trained),
        joints: Joint::ALL.map(|_| series.clone()),
    }
}

/// A robot with an old gait, and a folder with a new one.
pub struct Setting {
    pub folder: tempfile::TempDir,
    pub bench: Bench,
}

impl Setting {
    pub fn new(troubles: Troubles) -> Self {
        Self::with(FakeRobot::with_gait(troubles, &gait("old").encoded().unwrap(), 1.0))
    }

    pub fn with(robot: FakeRobot) -> Self {
        let folder = tempfile::tempdir().unwrap();
        gait("new").save(&folder.path().join("gait.toml")).unwrap();
        Self { folder, bench: Bench::new(robot) }
    }

    pub fn host(&self, args: &[&str]) -> Command {
        let mut command = Command::cargo_bin("host").unwrap();
        command.current_dir(self.folder.path()).env("NO_COLOR", "1");
        command.args(args).args(["--port", &self.bench.port]).timeout(Duration::from_secs(60));
        command
    }

    pub fn upload(&self) -> Command {
        self.host(&["upload-gait", "--amp", "2.2", "--gait", "gait.toml", "--json"])
    }

    /// A trial, of 0.5 s if not said otherwise.
    pub fn measure(&self, more: &[&str]) -> Command {
        let duration: &[&str] = if more.contains(&"--duration") { &[] } else { &["--duration", "0.5"] };
        self.host(&[&["measure", "--mass-kg", "1", "--out", ".", "--json"], duration, more].concat())
    }

    pub fn active_gait(&self) -> String {
        self.bench.robot(|robot| robot.active.unwrap().name.as_str().to_owned())
    }

    pub fn trials(&self) -> Vec<csv::StringRecord> {
        let mut reader = csv::Reader::from_path(self.folder.path().join("trials.csv")).unwrap();
        reader.records().map(Result::unwrap).collect()
    }

    /// What the robot was told, in order.
    pub fn done(&self) -> Vec<protocol::Command> {
        self.bench.robot(|robot| robot.done.clone())
    }
}

pub fn words(bytes: &[u8]) -> String {
    let text = String::from_utf8_lossy(bytes);
    text.split_whitespace().filter(|word| *word != "│").collect::<Vec<_>>().join(" ")
}

/// What it says on standard error when it fails with `code`, wrapping undone.
#[track_caller]
pub fn fails(command: &mut Command, code: i32) -> String {
    words(&command.assert().code(code).get_output().stderr)
}

/// What it says on standard output, columns undone.
#[track_caller]
pub fn says(command: &mut Command) -> String {
    words(&command.assert().success().get_output().stdout)
}

#[track_caller]
pub fn json(command: &mut Command) -> serde_json::Value {
    serde_json::from_slice(&command.assert().success().get_output().stdout).unwrap()
}
