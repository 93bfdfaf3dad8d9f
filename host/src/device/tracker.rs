//! The robot's positions from a motion tracker, and the distance walked.
//!
//! Holds two formats: CSV with `time_s,x_m,y_m`, and the virtual robot's JSON lines
//! with `unix_time_s`, `x_m`, `y_m`. Positions are never extrapolated beyond the
//! recording or interpolated over a gap of more than half a second. Does not depend
//! on how the robot was ordered to walk.

use crate::run_folder::FileError;
use serde::Deserialize;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Positions farther apart than this are not joined by a straight line.
const MAX_GAP_S: f64 = 0.5;
/// Times above this, 2001 in Unix time, are not seconds since a trial's start.
const UNIX_FROM_S: f64 = 1e9;

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
    tilt_rad: Option<f64>,
    true_energy_j: Option<f64>,
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
}

/// Why a track cannot be used.
#[derive(Debug, Error)]
// The messages say what each field is.
#[allow(missing_docs)]
pub enum TrackerError {
    /// The file cannot be read.
    #[error(transparent)]
    File(#[from] FileError),
    /// The text is neither format.
    #[error("{path}, line {line}: {text:?} is neither {what}")]
    Row {
        path: PathBuf,
        line: usize,
        /// Its first 60 characters.
        text: String,
        /// The two things it could be.
        what: &'static str,
    },
    /// A column is not there.
    #[error("{path} has no column {column}; its columns are {columns}")]
    MissingColumn {
        path: PathBuf,
        column: &'static str,
        /// The columns that it has, by commas.
        columns: String,
    },
    /// Time runs backwards.
    #[error("{path}, line {line}: time goes back from {before_s} to {after_s}")]
    Backwards { path: PathBuf, line: usize, before_s: f64, after_s: f64 },
    /// The file holds no positions.
    #[error("{path} holds no positions")]
    Empty { path: PathBuf },
    /// The trial is not, or not wholly, in the recording.
    #[error(
        "{path} does not cover the trial: it has {first_s:.3} to {last_s:.3} s, the trial is {start_s:.3} to {end_s:.3} s \
         ({})", .epoch.words()
    )]
    NotCovered { path: PathBuf, first_s: f64, last_s: f64, start_s: f64, end_s: f64, epoch: Epoch },
    /// The tracker lost the robot at an end of the trial.
    #[error(
        "{path} has no position from {from_s:.3} to {to_s:.3} s, and the trial has an end at {at_s:.3} s"
    )]
    Gap {
        path: PathBuf,
        /// Time of the last position before.
        from_s: f64,
        /// Time of the first position after.
        to_s: f64,
        /// The end of the trial that lies between.
        at_s: f64,
    },
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
        let text = std::fs::read_to_string(path).map_err(FileError::on("read", path))?;
        let lines =
            if text.trim_start().starts_with('{') { read_json(path, &text) } else { read_csv(path, &text) };
        let lines = lines?;
        let pairs = lines.iter().zip(lines.iter().skip(1));
        for ((_, before), (line, after)) in pairs {
            if after.time_s < before.time_s {
                return Err(TrackerError::Backwards {
                    path: path.to_owned(),
                    line: *line,
                    before_s: before.time_s,
                    after_s: after.time_s,
                });
            }
        }
        if lines.is_empty() {
            return Err(TrackerError::Empty { path: path.to_owned() });
        }
        Ok(Self { path: path.to_owned(), points: lines.into_iter().map(|(_, point)| point).collect() })
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
    /// [`TrackerError::NotCovered`] or [`TrackerError::Gap`], naming the interval.
    pub fn walked(&self, start_unix_s: f64, end_unix_s: f64) -> Result<Walked, TrackerError> {
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
        let energies = start.true_energy_j.zip(end.true_energy_j);
        let meanwhile = self.points.iter().filter(|point| (start_s..=end_s).contains(&point.time_s));
        let displacement_m = [end.x_m - start.x_m, end.y_m - start.y_m];
        Ok(Walked {
            distance_m: displacement_m[0].hypot(displacement_m[1]),
            displacement_m: Some(displacement_m),
            max_tilt_rad: meanwhile.filter_map(|point| point.tilt_rad).max_by(f64::total_cmp),
            true_energy_j: energies.map(|(start, end)| end - start),
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
            tilt_rad: a.tilt_rad.zip(b.tilt_rad).map(|(a, b)| between(a, b)),
            true_energy_j: a.true_energy_j.zip(b.true_energy_j).map(|(a, b)| between(a, b)),
        })
    }
}

fn read_json(path: &Path, text: &str) -> Result<Vec<(usize, Point)>, TrackerError> {
    let mut points = Vec::new();
    let count = text.lines().count();
    for (i, line) in text.lines().enumerate() {
        let is_last = i + 1 == count && !text.ends_with('\n');
        match serde_json::from_str::<JsonPoint>(line) {
            Ok(JsonPoint { unix_time_s: time_s, x_m, y_m, tilt_rad, true_energy_j }) => {
                points.push((i + 1, Point { time_s, x_m, y_m, tilt_rad, true_energy_j }));
            }
            // The virtual robot may be writing its last line.
            Err(_) if is_last || line.trim().is_empty() => {}
            Err(_) => {
                let what = "JSON with unix_time_s, x_m and y_m, nor an unfinished last line";
                return Err(bad_row(path, i + 1, line, what));
            }
        }
    }
    Ok(points)
}

fn read_csv(path: &Path, text: &str) -> Result<Vec<(usize, Point)>, TrackerError> {
    let mut lines = text.trim_start_matches('\u{FEFF}').lines().enumerate();
    let Some((_, header)) = lines.next() else { return Ok(Vec::new()) };
    let columns: Vec<&str> = header.split(',').map(str::trim).collect();
    let place = |column: &'static str| {
        columns.iter().position(|c| *c == column).ok_or_else(|| TrackerError::MissingColumn {
            path: path.to_owned(),
            column,
            columns: columns.join(", "),
        })
    };
    let places = [place("time_s")?, place("x_m")?, place("y_m")?];
    let mut points = Vec::new();
    for (i, line) in lines.filter(|(_, line)| !line.trim().is_empty()) {
        let fields: Vec<&str> = line.split(',').map(str::trim).collect();
        let number = |place: usize| fields.get(place)?.parse::<f64>().ok().filter(|v| v.is_finite());
        let [Some(time_s), Some(x_m), Some(y_m)] = places.map(number) else {
            return Err(bad_row(path, i + 1, line, "finite time_s, x_m and y_m, nor empty"));
        };
        points.push((i + 1, Point { time_s, x_m, y_m, tilt_rad: None, true_energy_j: None }));
    }
    Ok(points)
}

fn bad_row(path: &Path, line: usize, text: &str, what: &'static str) -> TrackerError {
    let text = text.chars().take(60).collect();
    TrackerError::Row { path: path.to_owned(), line, text, what }
}

#[cfg(test)]
mod tests;
