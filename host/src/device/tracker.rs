//! The robot's positions from a motion tracker, and the distance walked.
//!
//! Holds two formats: tables with `time_s`, `x_m`, `y_m` (`table`), and the virtual
//! robot's JSON lines with `unix_time_s`, `x_m`, `y_m`. Positions are never
//! extrapolated beyond the recording or interpolated over a gap of more than half a
//! second, and a speed that no legs can make is an error ([`plausible`]). Does not
//! depend on how the robot was ordered to walk.

mod error;
pub mod plausible;
mod table;
pub mod top_speed;

pub use error::TrackerError;

use crate::gait::csv_text;
use crate::run_folder::FileError;
use serde::Deserialize;
use std::path::{Path, PathBuf};
use top_speed::TopSpeed;

/// Positions farther apart than this are not joined by a straight line.
const MAX_GAP_S: f64 = 0.5;
/// Times above this, 2001 in Unix time, are not seconds since a trial's start.
const UNIX_FROM_S: f64 = 1e9;
/// Times above this, the year 5138 in Unix time, are not in seconds.
const SECONDS_BELOW: f64 = 1e11;

/// What the times of a track count from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Epoch {
    /// Unix time: the trial is found in it.
    Unix,
    /// The first gait frame: time 0 is the start of the trial.
    TrialStart,
}

/// One position.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Point {
    time_s: f64,
    x_m: f64,
    y_m: f64,
    /// Height, where a table has it: to see whether y is the height instead.
    z_m: Option<f64>,
    tilt_rad: Option<f64>,
    true_energy_j: Option<f64>,
    /// Line of the file, from 1.
    line: usize,
}

/// Positions in order of time.
#[derive(Debug, Clone, PartialEq)]
pub struct Track {
    path: PathBuf,
    points: Vec<Point>,
}

/// From the first gait frame to the end of the last.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Walked {
    /// Net horizontal displacement.
    pub distance_m: f64,
    /// The same along x and y, from a tracker.
    pub displacement_m: Option<[f64; 2]>,
    /// Largest tilt of a virtual robot meanwhile.
    pub max_tilt_rad: Option<f64>,
    /// Energy from a virtual robot's battery meanwhile, without sensor error.
    pub true_energy_j: Option<f64>,
    /// How often a tracker saw something else for a moment, in mid-trial.
    pub jumps: usize,
}

impl Epoch {
    const fn words(self) -> &'static str {
        match self {
            Self::Unix => "Unix time",
            Self::TrialStart => "counted from the first gait frame",
        }
    }
}

/// A line of the virtual robot's file; other fields are ignored.
#[derive(Debug, Deserialize)]
struct JsonPoint {
    unix_time_s: f64,
    x_m: f64,
    y_m: f64,
    tilt_rad: Option<f64>,
    true_energy_j: Option<f64>,
}

impl Track {
    /// Reads either format; JSON lines begin with `{`.
    ///
    /// # Errors
    /// [`TrackerError`] with file and line.
    pub fn load(path: &Path) -> Result<Self, TrackerError> {
        let bytes = std::fs::read(path).map_err(FileError::on("read", path))?;
        let text = csv_text::decode(&bytes).ok_or_else(|| TrackerError::NotText { path: path.to_owned() })?;
        let is_json = text.trim_start().starts_with('{');
        let points = if is_json { read_json(path, &text)? } else { table::read(path, &text)? };
        for pair in points.windows(2) {
            let [before, after] = [pair[0], pair[1]];
            if after.time_s < before.time_s {
                return Err(TrackerError::Backwards {
                    path: path.to_owned(),
                    line: after.line,
                    before_s: before.time_s,
                    after_s: after.time_s,
                });
            }
        }
        let first = points.first().ok_or_else(|| TrackerError::Empty { path: path.to_owned() })?;
        if first.time_s > SECONDS_BELOW {
            return Err(TrackerError::NotSeconds { path: path.to_owned(), first_s: first.time_s });
        }
        Ok(Self { path: path.to_owned(), points })
    }

    /// Looks at a file before a walk: whether it will be read, as far as that can be
    /// known; a file that holds no positions yet may get them during the walk.
    ///
    /// # Errors
    /// [`TrackerError`] that no walk will mend.
    pub fn check(path: &Path) -> Result<Option<Epoch>, TrackerError> {
        match Self::load(path) {
            Ok(track) => Ok(Some(track.epoch())),
            Err(TrackerError::Empty { .. }) => Ok(None),
            Err(error) => Err(error),
        }
    }

    /// What the times count from.
    #[must_use]
    pub fn epoch(&self) -> Epoch {
        match self.points.first() {
            Some(point) if point.time_s > UNIX_FROM_S => Epoch::Unix,
            _ => Epoch::TrialStart,
        }
    }

    /// Net horizontal displacement over a trial given in Unix time.
    ///
    /// # Errors
    /// [`TrackerError::NotCovered`] or [`TrackerError::Gap`], naming the interval; else
    /// positions that no robot with this top speed can have had.
    pub fn walked(&self, start_unix_s: f64, end_unix_s: f64, top: TopSpeed) -> Result<Walked, TrackerError> {
        let epoch = self.epoch();
        let (start_s, end_s) = match epoch {
            Epoch::Unix => (start_unix_s, end_unix_s),
            Epoch::TrialStart => (0.0, end_unix_s - start_unix_s),
        };
        let (first_s, last_s) = match self.points.as_slice() {
            [] => return Err(TrackerError::Empty { path: self.path.clone() }),
            [first, ..] => (first.time_s, self.points[self.points.len() - 1].time_s),
        };
        if start_s < first_s || end_s > last_s {
            let path = self.path.clone();
            return Err(TrackerError::NotCovered { path, first_s, last_s, start_s, end_s, epoch });
        }
        let start = self.at(start_s)?;
        let end = self.at(end_s)?;
        let jumps = plausible::check(&self.path, &self.points, &start, &end, top)?;
        let energies = start.true_energy_j.zip(end.true_energy_j);
        let meanwhile = self.points.iter().filter(|point| (start_s..=end_s).contains(&point.time_s));
        let displacement_m = [end.x_m - start.x_m, end.y_m - start.y_m];
        Ok(Walked {
            distance_m: displacement_m[0].hypot(displacement_m[1]),
            displacement_m: Some(displacement_m),
            max_tilt_rad: meanwhile.filter_map(|point| point.tilt_rad).max_by(f64::total_cmp),
            true_energy_j: energies.map(|(start, end)| end - start),
            jumps,
        })
    }

    /// Interpolated at a time within the recording.
    fn at(&self, time_s: f64) -> Result<Point, TrackerError> {
        let next = self.points.partition_point(|point| point.time_s < time_s).min(self.points.len() - 1);
        let (a, b) = (self.points[next.saturating_sub(1)], self.points[next]);
        if b.time_s - a.time_s > MAX_GAP_S && b.time_s != time_s {
            return Err(TrackerError::Gap {
                path: self.path.clone(),
                from_s: a.time_s,
                to_s: b.time_s,
                at_s: time_s,
            });
        }
        let share = if b.time_s > a.time_s { (time_s - a.time_s) / (b.time_s - a.time_s) } else { 0.0 };
        let between = |a: f64, b: f64| a + share * (b - a);
        Ok(Point {
            time_s,
            x_m: between(a.x_m, b.x_m),
            y_m: between(a.y_m, b.y_m),
            z_m: a.z_m.zip(b.z_m).map(|(a, b)| between(a, b)),
            line: b.line,
            tilt_rad: a.tilt_rad.zip(b.tilt_rad).map(|(a, b)| between(a, b)),
            true_energy_j: a.true_energy_j.zip(b.true_energy_j).map(|(a, b)| between(a, b)),
        })
    }
}

fn read_json(path: &Path, text: &str) -> Result<Vec<Point>, TrackerError> {
    let mut points = Vec::new();
    let count = text.lines().count();
    for (i, line) in text.lines().enumerate() {
        let is_last = i + 1 == count && !text.ends_with('\n');
        match serde_json::from_str::<JsonPoint>(line) {
            Ok(JsonPoint { unix_time_s: time_s, x_m, y_m, tilt_rad, true_energy_j }) => {
                points.push(Point { time_s, x_m, y_m, z_m: None, tilt_rad, true_energy_j, line: i + 1 });
            }
            // The virtual robot may be writing its last line.
            Err(_) if is_last || line.trim().is_empty() => {}
            Err(_) => {
                let what = "JSON with unix_time_s, x_m and y_m, nor an unfinished last line";
                return Err(TrackerError::row(path, i + 1, line, what));
            }
        }
    }
    Ok(points)
}

#[cfg(test)]
mod tests;
