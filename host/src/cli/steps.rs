//! Other commands of this program as steps of a longer one, each a process of
//! its own, exactly as a person would type it.
//!
//! Owns their starting, their time and what their exit codes mean. A step's
//! progress and errors go to the terminal, its JSON comes back.

use super::{Cause, Failure};
use serde_json::{Map, Value, json};
use std::path::PathBuf;
use std::process::{Command, ExitStatus, Stdio};
use std::time::Instant;
use thiserror::Error;

/// Why a step, or the virtual robot, did not do its part.
#[derive(Debug, Error)]
pub enum StepError {
    #[error("step `{step}` failed with exit code {code}")]
    Failed { step: &'static str, code: String, cause: Cause },
    #[error("step `{step}` printed no JSON: {source}")]
    Json { step: &'static str, source: serde_json::Error },
    #[error("cannot start {program}: {source}")]
    Start { program: PathBuf, source: std::io::Error },
    #[error("there is no virtual robot at {program}")]
    NoVirtualRobot { program: PathBuf },
    #[error("the virtual robot ended before it offered a port")]
    NoPort,
}

impl StepError {
    /// With the exit code and the next move.
    pub fn into_failure(self) -> Failure {
        let (cause, help) = match &self {
            Self::Failed { cause, .. } => (*cause, "the step's own message stands above"),
            Self::Json { .. } => {
                (Cause::Machine, "host and its steps are of different versions: rebuild both")
            }
            Self::NoVirtualRobot { .. } | Self::Start { .. } => {
                (Cause::Machine, "build it: cargo build -p sim-tests --bin virtual-robot")
            }
            Self::NoPort => {
                (Cause::Link, "its own message stands above; build its firmware with `make firmware`")
            }
        };
        Failure::new(cause, miette::miette!(help = help, "{self}"))
    }
}

/// What a step left.
pub struct Done {
    /// How it ended.
    pub outcome: Result<(), StepError>,
    /// What it printed.
    pub json: Result<Value, serde_json::Error>,
}

/// Runs the steps, timing each.
pub struct Steps {
    host: PathBuf,
    pub wall_s: Map<String, Value>,
}

impl Steps {
    /// Of this very program.
    pub fn new() -> Result<Self, StepError> {
        let host = std::env::current_exe()
            .map_err(|source| StepError::Start { program: PathBuf::from("host"), source })?;
        Ok(Self { host, wall_s: Map::new() })
    }

    /// The program that was built beside this one.
    pub fn beside(&self, name: &str) -> PathBuf {
        self.host.with_file_name(name)
    }

    /// Runs `host STEP ARGS --json`; its progress goes to the terminal.
    pub fn run(&mut self, step: &'static str, args: &[&str]) -> Result<Value, StepError> {
        eprintln!("\n$ host {step} {}", args.join(" "));
        let Done { outcome, json } = self.attempt(step, args)?;
        outcome?;
        json.map_err(|source| StepError::Json { step, source })
    }

    /// The same, where a failure may leave a result too.
    pub fn attempt(&mut self, step: &'static str, args: &[&str]) -> Result<Done, StepError> {
        let start = Instant::now();
        let output = Command::new(&self.host)
            .arg(step)
            .args(args)
            .arg("--json")
            // A step may ask for a distance.
            .stdin(Stdio::inherit())
            .stderr(Stdio::inherit())
            .output()
            .map_err(|source| StepError::Start { program: self.host.clone(), source })?;
        // A step that is done twice counts once, with both.
        let name = step.replace('-', "_");
        let before = self.wall_s.get(&name).and_then(Value::as_f64).unwrap_or(0.0);
        self.wall_s.insert(name, rounded(before + start.elapsed().as_secs_f64()));
        let json = serde_json::from_slice(&output.stdout);
        if output.status.success() {
            return Ok(Done { outcome: Ok(()), json });
        }
        let cause = if was_interrupted(output.status) {
            Cause::Interrupted
        } else {
            Cause::of_code(output.status.code())
        };
        let code = output.status.code().map_or("none (killed)".to_owned(), |code| code.to_string());
        Ok(Done { outcome: Err(StepError::Failed { step, code, cause }), json })
    }
}

/// Whether Ctrl-C killed it, before it had begun to listen.
#[cfg(unix)]
fn was_interrupted(status: ExitStatus) -> bool {
    use std::os::unix::process::ExitStatusExt as _;
    const SIGINT: i32 = 2;
    status.signal() == Some(SIGINT)
}

#[cfg(not(unix))]
fn was_interrupted(_: ExitStatus) -> bool {
    false
}

/// Seconds for a summary.
pub fn rounded(seconds: f64) -> Value {
    json!((seconds * 10.0).round() / 10.0)
}
