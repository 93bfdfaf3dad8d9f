//! Where a trial's distance comes from: a flag, a question, or a tracker.
//!
//! Holds the check that legs can make it. Does not depend on how the trial is walked.

use super::{MeasureError, failure, failure_with_help};
use crate::cli::{Cause, Failure};
use crate::device::tracker::top_speed::TopSpeed;
use crate::device::tracker::{Track, TrackerError, Walked};
use crate::device::trial::clock::Interval;
use crate::robot::{Limbs, Robot};
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
                check_tracker(path)?;
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

    /// The distance walked during `interval`, or in `duration_s` by the robot's clock.
    pub fn walked(
        &self,
        interval: Option<Interval>,
        duration_s: f64,
        top: TopSpeed,
    ) -> Result<Walked, Failure> {
        match self {
            Self::Flag(distance_m) => believed(Some(*distance_m), duration_s, top),
            Self::Prompt => believed(None, duration_s, top),
            Self::Tracker(path) => {
                let interval = interval.ok_or_else(|| {
                    failure_with_help(
                        Cause::Link,
                        MeasureError::NoTelemetry,
                        "check the cable and repeat the trial",
                    )
                })?;
                look_up(path, interval, top)
            }
        }
    }
}

/// How fast legs like a robot's may be, by the longest of them.
pub fn top_speed(robot: &Robot) -> TopSpeed {
    let lengths = Limbs::of(robot).legs.map(|leg| {
        let [hip, knee] = [&leg.hip.in_child, &leg.knee.in_parent].map(|frame| frame.translation.vector);
        (knee - hip).norm() + (leg.foot_m.coords - leg.knee.in_child.translation.vector).norm()
    });
    TopSpeed::of_legs(lengths.into_iter().fold(0.0, f64::max))
}

/// Refuses a file that cannot be read, while nothing has moved.
pub fn check_tracker(path: &Path) -> Result<(), Failure> {
    // At a terminal, the user may export the tracker's file after the trial.
    if !path.exists() && std::io::stdin().is_terminal() {
        return Ok(());
    }
    std::fs::metadata(path).map_err(FileError::on("read", path)).map_err(|e| failure(Cause::Input, e))?;
    match Track::check(path) {
        Ok(_) => Ok(()),
        Err(error) => {
            let help = format!("{}. Nothing has moved", error.help());
            Err(failure_with_help(Cause::Input, error, help))
        }
    }
}

/// A typed distance; an unlikely one is asked for again where somebody is there.
fn believed(mut typed: Option<f64>, duration_s: f64, top: TopSpeed) -> Result<Walked, Failure> {
    let is_there = std::io::stdin().is_terminal();
    let mut doubted = None;
    loop {
        let distance_m = match typed.take() {
            Some(distance_m) => distance_m,
            None => ask()?,
        };
        let speed_m_s = distance_m / duration_s;
        if duration_s <= 0.0 || top.allows(speed_m_s) {
            return Ok(Walked { distance_m, ..Walked::default() });
        }
        let unit = top.likely_unit(speed_m_s);
        let error = MeasureError::TooFast { distance_m, duration_s, speed_m_s, top, unit };
        if !is_there || doubted == Some(distance_m) {
            let help = "the trial is noted as not valid; give the distance in metres";
            return Err(failure_with_help(Cause::Input, error, help));
        }
        eprintln!("{error} Type it in metres, or the same again to note the trial as not valid.");
        doubted = Some(distance_m);
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

/// The distance of a track during `interval`.
pub fn look_up(path: &Path, interval: Interval, top: TopSpeed) -> Result<Walked, Failure> {
    let deadline = Instant::now() + TRACKER_TIMEOUT;
    loop {
        let walked =
            Track::load(path).and_then(|track| track.walked(interval.start_unix_s, interval.end_unix_s, top));
        match walked {
            Err(TrackerError::NotCovered { .. } | TrackerError::Empty { .. })
                if Instant::now() < deadline =>
            {
                std::thread::sleep(Duration::from_millis(100));
            }
            outcome => {
                let walked = outcome.map_err(unusable)?;
                if walked.jumps > 0 {
                    eprintln!(
                        "warning: the tracker took something else for the robot {} times, for less than half \
                         a second each; those positions are left out",
                        walked.jumps
                    );
                }
                return Ok(walked);
            }
        }
    }
}

fn unusable(error: TrackerError) -> Failure {
    let help = format!(
        "{}. The trial is noted without a distance; when the file is mended: host measure --last --tracker FILE",
        error.help()
    );
    failure_with_help(Cause::Input, error, help)
}
