//! Why a trajectory was refused, with file, line, column and value.

use super::{SKIPPED_COLUMN, TIME_COLUMN};
use crate::run_folder::FileError;
use protocol::JOINT_COUNT;
use std::path::PathBuf;
use thiserror::Error;

/// Why a trajectory was refused.
#[derive(Debug, Error)]
// The messages say what each field is.
#[allow(missing_docs)]
pub enum TrajectoryError {
    /// The file cannot be read.
    #[error(transparent)]
    File(#[from] FileError),
    /// A spreadsheet's own format, or another that is not text.
    #[error("{path} is not text: export it as CSV")]
    NotText { path: PathBuf },
    /// The text is not CSV.
    #[error("{path} is not a CSV file")]
    Csv { path: PathBuf, source: csv::Error },
    /// There is nothing in it.
    #[error("{path} has no rows")]
    Empty { path: PathBuf },
    /// Numbers from the first line on, without a header.
    #[error("{path} has no header: its first line is {first_line:?}")]
    NoHeader {
        path: PathBuf,
        /// What stands where the header should.
        first_line: String,
    },
    /// A column was given a name that means nothing.
    #[error(
        "column {name:?} is neither a joint (hip1 to hip4, knee1 to knee4 or ank1 to ank4), {TIME_COLUMN}, nor {SKIPPED_COLUMN}"
    )]
    UnknownColumn {
        /// The name.
        name: String,
    },
    /// Not all eight joints are there.
    #[error("{path} has {found} of {JOINT_COUNT} joints: {missing} missing; its columns are {columns}")]
    MissingJoints {
        path: PathBuf,
        found: usize,
        /// Which are not.
        missing: String,
        /// What there is.
        columns: String,
    },
    /// Two columns for the same thing.
    #[error("{path} has {name} twice: columns {first} and {second}")]
    RepeatedColumn {
        path: PathBuf,
        /// Joint or time.
        name: &'static str,
        /// Column, from 1.
        first: usize,
        /// Column, from 1.
        second: usize,
    },
    /// A row is longer or shorter than the header.
    #[error("{path}, line {line}: {found} values where there are {expected} columns")]
    RowLength {
        path: PathBuf,
        line: u64,
        /// Columns.
        expected: usize,
        /// Values.
        found: usize,
    },
    /// Text, NaN or infinity where a number belongs.
    #[error("{path}, line {line}: {column} is {text:?}, which is not a finite number")]
    Number {
        path: PathBuf,
        line: u64,
        column: &'static str,
        /// What stands there.
        text: String,
    },
    /// Time stands still, runs backwards, or jumps.
    #[error(
        "line {line}: {TIME_COLUMN} goes from {before_s} to {after_s}, where rows are {usual_s:.4} s apart elsewhere; \
         a fit needs an even interval"
    )]
    UnevenTime {
        /// Line of the later row.
        line: u64,
        /// Time of the earlier row.
        before_s: f64,
        /// Time of the later row.
        after_s: f64,
        /// Median interval.
        usual_s: f64,
    },
    /// A range that the file does not have.
    #[error("rows {first}..{end} are not in the file, which has rows 0..{available}")]
    NoSuchRows {
        /// First row.
        first: usize,
        /// First row after.
        end: usize,
        /// Rows there are.
        available: usize,
    },
}
