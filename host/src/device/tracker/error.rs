//! Why a tracker's file cannot be used, and what to do about it.
//!
//! Holds messages. Does not depend on how a file is read.

use super::Epoch;
use super::top_speed::TopSpeed;
use crate::run_folder::FileError;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// What a file must be like, for whoever has another one.
const WANTED: &str = "three columns are wanted: time_s (Unix time, or seconds from the first gait frame), \
                      x_m and y_m, the place on the floor in metres (x_mm, y_mm and x_cm, y_cm are read, \
                      too); the height is left out. Where y points up, as in Motive's exports, x and z are \
                      the floor: name them x_m and y_m";

/// Why a track cannot be used.
#[derive(Debug, Error)]
// The messages say what each field is.
#[allow(missing_docs)]
pub enum TrackerError {
    /// The file cannot be read.
    #[error(transparent)]
    File(#[from] FileError),
    /// A spreadsheet's own format, C3D, or another that is not text.
    #[error("{path} is not text, so it is neither CSV nor the virtual robot's JSON lines")]
    NotText { path: PathBuf },
    /// A program's own export, which holds more than one track, or other axes.
    #[error("{path} is an export of {program}, which is not read as it is")]
    Export { path: PathBuf, program: &'static str },
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
    /// Commas that end integers and commas that separate columns look alike.
    #[error(
        "{path}, line {line}: {found} values in {expected} columns: are there decimal commas in a file with \
         commas between its columns?"
    )]
    DecimalCommas { path: PathBuf, line: usize, found: usize, expected: usize },
    /// A column is not there.
    #[error("{path} has no column {column}; its columns are {columns}")]
    MissingColumn {
        path: PathBuf,
        column: &'static str,
        /// The columns that it has, by commas, shortened to a line.
        columns: String,
    },
    /// A position without a unit in its name.
    #[error("{path} does not say in which unit column {column:?} is; its columns are {columns}")]
    NoUnit {
        path: PathBuf,
        column: String,
        /// The columns that it has, by commas, shortened to a line.
        columns: String,
    },
    /// Time runs backwards.
    #[error("{path}, line {line}: time goes back from {before_s} to {after_s}")]
    Backwards { path: PathBuf, line: usize, before_s: f64, after_s: f64 },
    /// Times beyond every calendar.
    #[error("{path} begins at {first_s} s, which is no Unix time: are its times in milliseconds?")]
    NotSeconds { path: PathBuf, first_s: f64 },
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
    /// All of the track is too fast: another unit.
    #[error(
        "{path}: {distance_m:.3} m in {duration_s:.2} s is {:.3} m/s, and {top}: are the positions in {unit}?",
        .distance_m / .duration_s
    )]
    Unit { path: PathBuf, distance_m: f64, duration_s: f64, top: TopSpeed, unit: &'static str },
    /// One step of the track is too long.
    #[error(
        "{path}, line {line}: the position jumps {step_m:.3} m in {step_s:.3} s, and {top}: did the tracker \
         take another marker for the robot?"
    )]
    Jump { path: PathBuf, line: usize, step_m: f64, step_s: f64, top: TopSpeed },
    /// The height moves as only a place on the floor does.
    #[error(
        "{path}: z changes by {dz_m:.3} m during the trial, x and y by {distance_m:.3} m: does y point up in \
         this file?"
    )]
    YUp { path: PathBuf, dz_m: f64, distance_m: f64 },
}

impl TrackerError {
    pub(super) fn row(path: &Path, line: usize, text: &str, what: &'static str) -> Self {
        Self::Row { path: path.to_owned(), line, text: text.chars().take(60).collect(), what }
    }

    /// What the user can do about it.
    #[must_use]
    pub const fn help(&self) -> &'static str {
        match self {
            Self::File(_) => "name the file that the tracker writes",
            Self::NotText { .. } | Self::Export { .. } | Self::MissingColumn { .. } => WANTED,
            Self::Row { .. } => {
                "correct the line; a row without a sighting has a time and empty cells, NaN or null"
            }
            Self::DecimalCommas { .. } => {
                "export with semicolons between the columns, or with decimal points: both are read"
            }
            Self::NoUnit { .. } => {
                "name the columns of the place on the floor x_m and y_m (metres), x_cm and y_cm, or x_mm and \
                 y_mm; where y points up, those of x and z"
            }
            Self::Backwards { .. } => "sort the rows by time, one track a file",
            Self::NotSeconds { .. } => "write seconds, or name the column time_ms",
            Self::Empty { .. } => "let the tracker record during the walk",
            Self::NotCovered { .. } => {
                "record from before the walk to after it; times are Unix time in seconds, or count from the \
                 first gait frame"
            }
            Self::Gap { .. } => {
                "gaps of up to 0.5 s are bridged; if the times are milliseconds, name the column time_ms, and \
                 write seconds in place of frame numbers"
            }
            Self::Unit { .. } => {
                "write metres, or name the columns for what they hold: x_mm and y_mm, or x_cm and y_cm"
            }
            Self::Jump { .. } => {
                "correct or empty the cells of the rows that are not the robot; gaps of up to 0.5 s are bridged"
            }
            Self::YUp { .. } => "name the columns of the floor x_m and y_m, and leave the height out",
        }
    }
}
