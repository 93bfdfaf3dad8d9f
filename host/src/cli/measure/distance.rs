//! Where a trial's distance comes from: a flag, a question, or a tracker.
//!
//! Does not depend on how the trial is walked.

use super::{MeasureError, failure, failure_with_help};
use crate::cli::{Cause, Failure};
use crate::device::tracker::{Track, TrackerError, Walked};
use crate::device::trial::clock::Interval;
use crate::run_folder::FileError;
use std::io::{BufRead as _, IsTerminal as _};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// A tracker that still runs writes its last positions a little later.
const TRACKER_TIMEOUT: Duration = Duration::from_secs(3);

/// Where the distance comes from.
pub enum Source {
    /// Known beforehand.
    Flag(f64),
    /// Asked after the trial.
    Prompt,
    /// Looked up after the trial.
    Tracker(PathBuf),
}

impl Source {
    /// Chosen before the robot walks; a distance that cannot be known afterwards is an error.
    pub fn choose(distance: Option<f64>, tracker: Option<&Path>) -> Result<Self, Failure> {
        match (distance, tracker) {
            (Some(distance_m), _) => Ok(Self::Flag(distance_m)),
            (None, Some(path)) => {
                // At a terminal, the user may export the tracker's file after the trial.
                if !std::io::stdin().is_terminal() {
                    std::fs::metadata(path)
                        .map_err(FileError::on("read", path))
                        .map_err(|e| failure(Cause::Input, e))?;
                }
                Ok(Self::Tracker(path.to_owned()))
            }
            (None, None) if std::io::stdin().is_terminal() => Ok(Self::Prompt),
            (None, None) => Err(failure_with_help(
                Cause::Usage,
                MeasureError::UnknownDistance,
                "give --distance M, or --tracker FILE; at a terminal you would be asked for it. Nothing has moved",
            )),
        }
    }

    /// As in the trials table.
    pub fn name(&self) -> String {
        match self {
            Self::Flag(_) => "flag".into(),
            Self::Prompt => "prompt".into(),
            Self::Tracker(path) => format!("tracker {}", path.display()),
        }
    }

    /// The distance walked during `interval`.
    pub fn walked(&self, interval: Option<Interval>) -> Result<Walked, Failure> {
        match self {
            Self::Flag(distance_m) => Ok(Walked { distance_m: *distance_m, ..Walked::default() }),
            Self::Prompt => ask().map(|distance_m| Walked { distance_m, ..Walked::default() }),
            Self::Tracker(path) => {
                let interval = interval.ok_or_else(|| {
                    failure_with_help(
                        Cause::Link,
                        MeasureError::NoTelemetry,
                        "check the cable and repeat the trial",
                    )
                })?;
                look_up(path, interval)
            }
        }
    }
}

fn ask() -> Result<f64, Failure> {
    let mut lines = std::io::stdin().lock().lines();
    loop {
        eprint!("Distance from start to end, in metres: ");
        let Some(Ok(line)) = lines.next() else {
            return Err(failure(Cause::Usage, MeasureError::NoAnswer));
        };
        // A decimal comma is a habit, not a mistake.
        match line.trim().replace(',', ".").parse::<f64>() {
            Ok(distance_m) if (0.0..=1e4).contains(&distance_m) => return Ok(distance_m),
            _ => eprintln!("{:?} is not a distance; type metres, such as 1.64", line.trim()),
        }
    }
}

fn look_up(path: &Path, interval: Interval) -> Result<Walked, Failure> {
    let deadline = Instant::now() + TRACKER_TIMEOUT;
    loop {
        let walked =
            Track::load(path).and_then(|track| track.walked(interval.start_unix_s, interval.end_unix_s));
        match walked {
            Err(TrackerError::NotCovered { .. } | TrackerError::Empty { .. })
                if Instant::now() < deadline =>
            {
                std::thread::sleep(Duration::from_millis(100));
            }
            outcome => return outcome.map_err(unusable),
        }
    }
}

fn unusable(error: TrackerError) -> Failure {
    let help = "the trial is noted without a distance; its telemetry has the Unix times of its frames";
    failure_with_help(Cause::Input, error, help)
}
