//! Starts the programs under test, and ends them even if the test fails.

use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;
use protocol::JOINT_COUNT;
use serde::Deserialize;
use std::f64::consts::TAU;
use std::io::{BufRead as _, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// Longest that a host command may take; the longest walks for 12 s.
const PATIENCE: Duration = Duration::from_secs(90);

/// A line of ground truth, as far as these tests care.
#[derive(Debug, Clone, Deserialize)]
pub struct Sample {
    pub time_s: f64,
    pub x_m: f64,
    pub y_m: f64,
    pub true_energy_j: f64,
}

#[derive(Deserialize)]
struct PulseLine {
    time_s: f64,
    counts: [Option<f64>; JOINT_COUNT],
}

/// A virtual robot that ends with the test.
pub struct RobotProcess {
    child: Child,
    port: String,
    folder: PathBuf,
}

impl RobotProcess {
    /// Starts one with its files in `folder`, and waits for its port.
    pub fn start(folder: &Path, arguments: &[&str]) -> Self {
        let mut child = Command::new(env!("CARGO_BIN_EXE_virtual-robot"))
            .current_dir(folder)
            .args(["--truth", "truth.jsonl", "--pulses", "pulses.jsonl", "--link", "port"])
            // A stopped test must not leave it behind.
            .args(["--max-seconds", "120"])
            .args(arguments)
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let mut port = String::new();
        BufReader::new(child.stdout.take().unwrap()).read_line(&mut port).unwrap();
        assert!(!port.is_empty(), "the virtual robot offered no port; its message stands above");
        Self { child, port: port.trim().to_owned(), folder: folder.to_owned() }
    }

    pub fn port(&self) -> &str {
        &self.port
    }

    pub fn truth_path(&self) -> PathBuf {
        self.folder.join("truth.jsonl")
    }

    pub fn truth(&self) -> Vec<Sample> {
        lines(&self.truth_path())
    }

    /// Returns once the servos get pulses, within 20 s.
    pub fn wait_until_walking(&self) {
        let deadline = Instant::now() + Duration::from_secs(20);
        while self.pulses().is_empty() {
            assert!(Instant::now() < deadline, "the robot does not walk");
            std::thread::sleep(Duration::from_millis(50));
        }
    }

    /// Bursts that drive all eight joints: when, and counts.
    pub fn pulses(&self) -> Vec<(f64, [f64; JOINT_COUNT])> {
        lines::<PulseLine>(&self.folder.join("pulses.jsonl"))
            .into_iter()
            .filter(|line| line.counts.iter().all(Option::is_some))
            .map(|line| (line.time_s, line.counts.map(Option::unwrap)))
            .collect()
    }
}

impl Drop for RobotProcess {
    fn drop(&mut self) {
        let _ = kill(Pid::from_raw(self.child.id() as i32), Signal::SIGTERM);
        let deadline = Instant::now() + Duration::from_secs(5);
        while matches!(self.child.try_wait(), Ok(None)) && Instant::now() < deadline {
            std::thread::sleep(Duration::from_millis(10));
        }
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// Whole lines of a file that may still be growing.
fn lines<T: for<'de> Deserialize<'de>>(path: &Path) -> Vec<T> {
    let text = std::fs::read_to_string(path).unwrap();
    let (whole, _) = text.rsplit_once('\n').unwrap_or(("", ""));
    whole.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

/// Runs a host command; returns its exit code, standard output and standard error.
pub fn host_outcome(folder: &Path, arguments: &[&str]) -> (i32, String, String) {
    finish(start_host(folder, arguments))
}

/// Starts a host command.
pub fn start_host(folder: &Path, arguments: &[&str]) -> Child {
    Command::new(env!("CARGO_BIN_EXE_host-without-training"))
        .current_dir(folder)
        .args(arguments)
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap()
}

/// Waits for a host command, but not for ever.
pub fn finish(mut child: Child) -> (i32, String, String) {
    let deadline = Instant::now() + PATIENCE;
    while child.try_wait().unwrap().is_none() {
        if Instant::now() > deadline {
            let _ = child.kill();
            let _ = child.wait();
            panic!("a host command takes longer than {PATIENCE:?}");
        }
        std::thread::sleep(Duration::from_millis(20));
    }
    let output = child.wait_with_output().unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8_lossy(&bytes).into_owned();
    (output.status.code().unwrap_or(-1), text(output.stdout), text(output.stderr))
}

/// Runs a host command that is to succeed; returns its standard output.
pub fn host(folder: &Path, arguments: &[&str]) -> String {
    let (code, out, err) = host_outcome(folder, arguments);
    assert_eq!(code, 0, "host {arguments:?}\n{out}\n{err}");
    out
}

/// As [`host`] with `--json`, parsed.
pub fn host_json(folder: &Path, arguments: &[&str]) -> serde_json::Value {
    let mut arguments = arguments.to_vec();
    arguments.push("--json");
    serde_json::from_str(&host(folder, &arguments)).unwrap()
}

/// Plays wave.csv, in degrees; the robot's buffer forgives 50 ms, a machine that
/// is busy with something else may take longer, and then says so.
pub fn play_patiently(folder: &Path, more: &[&str]) -> serde_json::Value {
    for _ in 0..8 {
        let arguments = [&["play", "wave.csv", "--degrees", "--json"], more].concat();
        let (code, out, err) = host_outcome(folder, &arguments);
        if code == 0 {
            return serde_json::from_str(&out).unwrap();
        }
        assert!(err.contains("the next setpoint did not arrive in time"), "{err}");
    }
    panic!("this machine is too busy to stream: eight times the robot's buffer ran dry");
}

/// Measures; the robot stops by itself when this computer, busy with something
/// else, is silent for most of a second, and `measure` then says so.
pub fn measure_patiently(folder: &Path, more: &[&str]) -> serde_json::Value {
    for _ in 0..4 {
        let (code, out, err) = host_outcome(folder, &[&["measure", "--json"], more].concat());
        if code == 0 {
            return serde_json::from_str(&out).unwrap();
        }
        assert!(err.contains("the robot heard nothing from this computer"), "{err}");
    }
    panic!("this machine is too busy to measure: four times the robot heard nothing from it");
}

/// One stride of a wave, degrees from neutral, 60 rows a second.
pub fn pose_deg(frame: usize, frames: usize) -> [f64; JOINT_COUNT] {
    std::array::from_fn(|joint| 12.0 * (TAU * frame as f64 / frames as f64 + joint as f64).sin())
}

/// Such a stride as a file.
pub fn recording(folder: &Path, name: &str, frames: usize) {
    let mut text = String::from("time_s,hip1,hip2,hip3,hip4,knee1,knee2,knee3,knee4\n");
    for frame in 0..frames {
        let joints = pose_deg(frame, frames).map(|deg| format!(",{deg:.5}")).concat();
        text.push_str(&format!("{:.6}{joints}\n", frame as f64 / 60.0));
    }
    std::fs::write(folder.join(name), text).unwrap();
}
