//! Reads joint trajectories from CSV, in this project's own format or another's.
//!
//! Holds the columns and the sampling interval; [`loop_finder`] finds a stride in a
//! long recording. A missing joint, a row of another length and a value that is not a
//! number are errors. Does not depend on degrees: actions stay as they are in the file.

mod error;
pub mod loop_finder;

pub use error::TrajectoryError;

use crate::gait::csv_text;
use crate::run_folder::FileError;
use csv::StringRecord;
use protocol::{JOINT_COUNT, Joint};
use sha2::{Digest as _, Sha256};
use std::path::Path;

/// Name of the column that holds the time of each row.
pub const TIME_COLUMN: &str = "time_s";
/// Stands for a column that is of no interest.
pub const SKIPPED_COLUMN: &str = "-";

/// A recording: one row a sample.
#[derive(Debug, Clone, PartialEq)]
pub struct Trajectory {
    /// Time of each row, if the file has it.
    pub times_s: Option<Vec<f64>>,
    /// Actions of each row, in [`Joint::ALL`] order.
    pub actions: Vec<[f64; JOINT_COUNT]>,
    /// Line of the file that each row stands on.
    pub lines: Vec<u64>,
    /// Whether the columns are exactly those that `record` writes: then the file is one stride.
    pub is_own_stride: bool,
    /// SHA-256 of the file.
    pub sha256: String,
}

/// What a column holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Column {
    Time,
    Joint(Joint),
    Other,
}

impl Column {
    fn from_name(name: &str) -> Option<Self> {
        match name.to_ascii_lowercase().as_str() {
            TIME_COLUMN => Some(Self::Time),
            SKIPPED_COLUMN => Some(Self::Other),
            name => Joint::from_name(name).map(Self::Joint),
        }
    }
}

impl Trajectory {
    /// Reads a CSV; `columns` says what each column holds where no header does.
    ///
    /// # Errors
    /// [`TrajectoryError`] with file, line, column and value.
    pub fn read(path: &Path, columns: Option<&[String]>) -> Result<Self, TrajectoryError> {
        let bytes = std::fs::read(path).map_err(FileError::on("read", path))?;
        let text =
            csv_text::decode(&bytes).ok_or_else(|| TrajectoryError::NotText { path: path.to_owned() })?;
        let first_line = csv_text::lines(&text).into_iter().find(|line| {
            let line = line.trim();
            !line.is_empty() && !line.starts_with('#')
        });
        let separator = csv_text::separator(first_line.unwrap_or_default());
        let mut reader = csv::ReaderBuilder::new()
            .delimiter(separator as u8)
            .has_headers(false)
            .flexible(true)
            .trim(csv::Trim::All)
            .comment(Some(b'#'))
            .from_reader(text.as_bytes());
        let mut records = Vec::new();
        for record in reader.records() {
            records.push(record.map_err(|source| TrajectoryError::Csv { path: path.to_owned(), source })?);
        }
        let Some(first) = records.first() else {
            return Err(TrajectoryError::Empty { path: path.to_owned() });
        };
        let has_header = first.iter().all(|field| csv_text::number(field, separator).is_none());
        let columns = match columns {
            Some(names) => given_columns(names)?,
            None if has_header => {
                first.iter().map(|name| Column::from_name(name).unwrap_or(Column::Other)).collect()
            }
            None => {
                let first_line = csv_text::shortened(&first.iter().collect::<Vec<_>>().join(","));
                return Err(TrajectoryError::NoHeader { path: path.to_owned(), first_line });
            }
        };
        let layout = Layout::of(path, &columns, first)?;
        let rows = &records[usize::from(has_header)..];
        if rows.is_empty() {
            return Err(TrajectoryError::Empty { path: path.to_owned() });
        }
        layout.read_rows(path, rows, &bytes, separator)
    }

    /// Mean interval between the rows `first..end`; `None` without times.
    ///
    /// # Errors
    /// [`TrajectoryError::UnevenTime`] if an interval is off by more than a quarter.
    pub fn interval_s(&self, first: usize, end: usize) -> Result<Option<f64>, TrajectoryError> {
        let Some(times) = self.times_s.as_ref().and_then(|t| t.get(first..end)) else { return Ok(None) };
        let [start, .., stop] = times else { return Ok(None) };
        let mut steps: Vec<f64> = times.windows(2).map(|pair| pair[1] - pair[0]).collect();
        steps.sort_by(f64::total_cmp);
        // The median, so that the jump is blamed and not the rows around it.
        let usual_s = steps[steps.len() / 2];
        for (i, pair) in times.windows(2).enumerate() {
            let step = pair[1] - pair[0];
            // Times are often rounded to milliseconds: 16, 17, 17 ms at 60 Hz.
            if !(usual_s > 0.0 && (step - usual_s).abs() <= 0.25 * usual_s) {
                return Err(TrajectoryError::UnevenTime {
                    line: self.lines[first + i + 1],
                    before_s: pair[0],
                    after_s: pair[1],
                    usual_s,
                });
            }
        }
        Ok(Some((stop - start) / (times.len() - 1) as f64))
    }

    /// The rows `first..end`.
    ///
    /// # Errors
    /// [`TrajectoryError::NoSuchRows`].
    pub fn rows(&self, first: usize, end: usize) -> Result<&[[f64; JOINT_COUNT]], TrajectoryError> {
        let available = self.actions.len();
        match self.actions.get(first..end) {
            Some(rows) if !rows.is_empty() => Ok(rows),
            _ => Err(TrajectoryError::NoSuchRows { first, end, available }),
        }
    }
}

fn given_columns(names: &[String]) -> Result<Vec<Column>, TrajectoryError> {
    names
        .iter()
        .map(|name| {
            Column::from_name(name.trim())
                .ok_or_else(|| TrajectoryError::UnknownColumn { name: name.clone() })
        })
        .collect()
}

/// Where in a row to find what.
struct Layout {
    column_count: usize,
    time: Option<usize>,
    joints: [usize; JOINT_COUNT],
    is_own: bool,
}

impl Layout {
    fn of(path: &Path, columns: &[Column], first: &StringRecord) -> Result<Self, TrajectoryError> {
        let place = |column: Column, name: &'static str| {
            let mut places = columns.iter().enumerate().filter(|(_, c)| **c == column).map(|(i, _)| i);
            match (places.next(), places.next()) {
                (Some(first), Some(second)) => Err(TrajectoryError::RepeatedColumn {
                    path: path.to_owned(),
                    name,
                    first: first + 1,
                    second: second + 1,
                }),
                (place, _) => Ok(place),
            }
        };
        let time = place(Column::Time, TIME_COLUMN)?;
        let mut joints = [None; JOINT_COUNT];
        for joint in Joint::ALL {
            joints[joint.index()] = place(Column::Joint(joint), joint.name())?;
        }
        let missing: Vec<_> =
            Joint::ALL.into_iter().filter(|j| joints[j.index()].is_none()).map(Joint::name).collect();
        if !missing.is_empty() {
            return Err(TrajectoryError::MissingJoints {
                path: path.to_owned(),
                found: JOINT_COUNT - missing.len(),
                missing: missing.join(", "),
                columns: csv_text::shortened(&first.iter().collect::<Vec<_>>().join(", ")),
            });
        }
        let own = std::iter::once(Column::Time).chain(Joint::ALL.map(Column::Joint));
        Ok(Self {
            column_count: columns.len(),
            time,
            joints: joints.map(Option::unwrap_or_default),
            is_own: columns.iter().copied().eq(own),
        })
    }

    fn read_rows(
        &self,
        path: &Path,
        rows: &[StringRecord],
        file: &[u8],
        separator: char,
    ) -> Result<Trajectory, TrajectoryError> {
        let mut times_s = Vec::new();
        let mut actions = Vec::with_capacity(rows.len());
        let mut lines = Vec::with_capacity(rows.len());
        for row in rows {
            let line = row.position().map_or(0, csv::Position::line);
            // Some programs end their rows with a separator, but not their header.
            let has_end = row.len() == self.column_count + 1 && row.get(self.column_count) == Some("");
            if row.len() != self.column_count && !has_end {
                let (expected, found) = (self.column_count, row.len());
                return Err(TrajectoryError::RowLength { path: path.to_owned(), line, expected, found });
            }
            let number = |place: usize, column: &'static str| {
                let text = row.get(place).unwrap_or("");
                csv_text::number(text, separator).ok_or_else(|| TrajectoryError::Number {
                    path: path.to_owned(),
                    line,
                    column,
                    text: text.into(),
                })
            };
            if let Some(place) = self.time {
                times_s.push(number(place, TIME_COLUMN)?);
            }
            let mut action = [0.0; JOINT_COUNT];
            for joint in Joint::ALL {
                action[joint.index()] = number(self.joints[joint.index()], joint.name())?;
            }
            actions.push(action);
            lines.push(line);
        }
        Ok(Trajectory {
            times_s: self.time.map(|_| times_s),
            actions,
            lines,
            is_own_stride: self.is_own,
            sha256: Sha256::digest(file).iter().map(|byte| format!("{byte:02x}")).collect(),
        })
    }
}

#[cfg(test)]
mod tests;
