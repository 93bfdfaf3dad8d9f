//! Other commands of this program as steps of a longer one, each a process of its
//! own, as a user would type it.
//!
//! Holds their start, their time and the meaning of their exit codes. A step's
//! progress and errors go to the terminal, its result comes back. Does not depend on
//! what a step does.

use super::{Cause, Failure};
use serde::de::DeserializeOwned;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::process::{Command, ExitStatus, Stdio};
use std::time::Instant;
use thiserror::Error;

/// Why a step or the virtual robot failed.
#[derive(Debug, Error)]
pub enum StepError {
    #[error("step `{step}` failed with exit code {code}")]
    Failed { step: &'static str, code: String, cause: Cause },
    #[error("step `{step}` printed something other than its result: {source}")]
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
            Self::Failed { cause, .. } => (*cause, "see the step's own message above"),
            Self::Json { .. } => {
                (Cause::Machine, "host and its steps are of different versions: rebuild both")
            }
            Self::NoVirtualRobot { .. } | Self::Start { .. } => {
                (Cause::Machine, "build it: cargo build -p sim-tests --bin virtual-robot")
            }
            Self::NoPort => {
                (Cause::Link, "see its own message above; build its firmware with `make firmware`")
            }
        };
        Failure::new(cause, miette::miette!(help = help, "{self}"))
    }
}

/// What a step left; `T` is the type of what it prints with `--json`.
pub struct Done<T> {
    /// How it ended.
    pub outcome: Result<(), StepError>,
    /// What it printed; a step that failed may have printed nothing.
    pub result: Result<T, serde_json::Error>,
}

/// Runs the steps, timing each.
pub struct Steps {
    host: PathBuf,
    /// Seconds that each command took, by its name with underscores; a step that is run twice
    /// counts with both.
    pub wall_s: BTreeMap<String, f64>,
}

impl Steps {
    /// Of this very program.
    pub fn new() -> Result<Self, StepError> {
        let host = std::env::current_exe()
            .map_err(|source| StepError::Start { program: PathBuf::from("host"), source })?;
        Ok(Self { host, wall_s: BTreeMap::new() })
    }

    /// The program that was built beside this one.
    pub fn beside(&self, name: &str) -> PathBuf {
        self.host.with_file_name(name)
    }

    /// Runs `host STEP ARGS --json`; its progress goes to the terminal.
    pub fn run<T: DeserializeOwned>(&mut self, step: &'static str, args: &[&str]) -> Result<T, StepError> {
        eprintln!("\n$ host {step} {}", args.join(" "));
        let Done { outcome, result } = self.attempt(step, args)?;
        outcome?;
        result.map_err(|source| StepError::Json { step, source })
    }

    /// The same, where a failure may leave a result too.
    pub fn attempt<T: DeserializeOwned>(
        &mut self,
        step: &'static str,
        args: &[&str],
    ) -> Result<Done<T>, StepError> {
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
        let wall_s = self.wall_s.entry(step.replace('-', "_")).or_default();
        *wall_s = rounded_s(*wall_s + start.elapsed().as_secs_f64());
        let result = serde_json::from_slice(&output.stdout);
        if output.status.success() {
            return Ok(Done { outcome: Ok(()), result });
        }
        let cause = if was_interrupted(output.status) {
            Cause::Interrupted
        } else {
            Cause::of_code(output.status.code())
        };
        let code = output.status.code().map_or("none (killed)".to_owned(), |code| code.to_string());
        Ok(Done { outcome: Err(StepError::Failed { step, code, cause }), result })
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

/// To a tenth of a second, as summaries have it.
pub fn rounded_s(seconds: f64) -> f64 {
    (seconds * 10.0).round() / 10.0
}
