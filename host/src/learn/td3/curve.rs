//! The learning curve, `train.csv`: one row an evaluation.
//!
//! Holds the rows and their file format. Does not depend on the learner. Rows with NaN,
//! impossible numbers or a wrong order are refused.

use crate::run_folder::FileError;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Maximum magnitude of rewards, speeds and times that a figure can show.
const MAX_MAGNITUDE: f64 = 1e12;

/// Why a learning curve cannot be read.
#[derive(Debug, Error)]
pub enum CurveError {
    /// The disk's reason.
    #[error(transparent)]
    File(#[from] FileError),
    /// A column is missing, or a value of another kind.
    #[error("{path} is not a learning curve")]
    Csv {
        /// The file.
        path: PathBuf,
        /// Where and why.
        source: csv::Error,
    },
    /// The file has no row.
    #[error("{path} has no evaluation yet")]
    Empty {
        /// The file.
        path: PathBuf,
    },
    /// A value is NaN or too large to be drawn.
    #[error("{path}, line {line}: {column} is {value}; it must be within {MAX_MAGNITUDE:e} either way")]
    Absurd {
        /// The file.
        path: PathBuf,
        /// Line number; the header is line 1.
        line: u64,
        /// Name of the column.
        column: &'static str,
        /// Its value.
        value: f64,
    },
    /// Updates do not increase.
    #[error("{path}, evaluation {row}: {updates} updates after {before}")]
    Order {
        /// The file.
        path: PathBuf,
        /// Row, from 1.
        row: usize,
        /// Updates of that row.
        updates: u64,
        /// Updates of the row before.
        before: u64,
    },
}

/// One evaluation: a row of the learning curve.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct CurvePoint {
    /// Control steps gathered.
    pub env_steps: u64,
    /// Updates done.
    pub updates: u64,
    /// Wall-clock time learning, interruptions left out.
    pub wall_s: f64,
    /// Mean reward of an evaluation episode.
    pub reward: f64,
    /// Mean forward speed.
    pub speed_m_s: f64,
    /// Mean control steps of an evaluation episode.
    pub episode_steps: f64,
    /// Mean squared error of both critics, summed, in the latest update.
    pub critic_loss: f64,
    /// Minus the mean value of the actor's actions, in the latest update of the actor.
    pub actor_loss: f64,
    /// Mean value of the batch over both critics, in the latest update.
    pub q_mean: f64,
}

/// The learning curve as CSV.
pub fn to_csv(curve: &[CurvePoint]) -> String {
    let mut csv = String::from(
        "env_steps,updates,wall_s,reward,speed_m_s,episode_steps,critic_loss,actor_loss,q_mean\n",
    );
    for p in curve {
        csv += &format!(
            "{},{},{:.2},{:.4},{:.5},{:.1},{:.6},{:.6},{:.6}\n",
            p.env_steps,
            p.updates,
            p.wall_s,
            p.reward,
            p.speed_m_s,
            p.episode_steps,
            p.critic_loss,
            p.actor_loss,
            p.q_mean
        );
    }
    csv
}

/// Reads what [`to_csv`] wrote; additional columns are ignored.
///
/// # Errors
/// [`CurveError`] with file, row and value.
pub fn read(path: &Path) -> Result<Vec<CurvePoint>, CurveError> {
    let bytes = std::fs::read(path).map_err(FileError::on("read", path))?;
    let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(bytes.as_slice());
    let mut curve: Vec<CurvePoint> = Vec::new();
    let unreadable = |source| CurveError::Csv { path: path.to_owned(), source };
    let header = reader.headers().map_err(unreadable)?.clone();
    for (index, record) in reader.records().enumerate() {
        let record = record.map_err(unreadable)?;
        let line = record.position().map_or(0, csv::Position::line);
        let point: CurvePoint = record.deserialize(Some(&header)).map_err(unreadable)?;
        let (path, row) = (path.to_owned(), index + 1);
        let drawn = [("wall_s", point.wall_s), ("reward", point.reward), ("speed_m_s", point.speed_m_s)];
        if let Some((column, value)) =
            drawn.into_iter().find(|(_, value)| !(-MAX_MAGNITUDE..=MAX_MAGNITUDE).contains(value))
        {
            return Err(CurveError::Absurd { path, line, column, value });
        }
        if let Some(before) = curve.last().map(|before| before.updates).filter(|&b| b >= point.updates) {
            return Err(CurveError::Order { path, row, updates: point.updates, before });
        }
        curve.push(point);
    }
    if curve.is_empty() { Err(CurveError::Empty { path: path.to_owned() }) } else { Ok(curve) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read_text(text: &str) -> Result<Vec<CurvePoint>, CurveError> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("train.csv");
        std::fs::write(&path, text).unwrap();
        read(&path)
    }

    fn curve() -> Vec<CurvePoint> {
        let point = |updates: u64| CurvePoint {
            env_steps: 10 * updates,
            updates,
            wall_s: 0.5,
            reward: -1.25,
            speed_m_s: 0.125,
            episode_steps: 300.0,
            critic_loss: 0.5,
            actor_loss: -0.5,
            q_mean: 2.0,
        };
        vec![point(0), point(2500)]
    }

    #[test]
    fn a_curve_is_read_as_it_was_written_and_additional_columns_are_ignored() {
        let text = to_csv(&curve());
        let wider: String = text.lines().map(|line| format!("{line},9\n")).collect();

        assert_eq!(read_text(&text).unwrap(), curve());
        assert_eq!(read_text(&wider.replacen(",9", ",power_w", 1)).unwrap(), curve());
    }

    #[test]
    fn a_damaged_curve_is_refused_with_the_place() {
        let text = to_csv(&curve());
        let refused = |text: &str| read_text(text).unwrap_err();

        assert!(matches!(refused(""), CurveError::Empty { .. }));
        assert!(matches!(refused(&text.replace("speed_m_s", "speed")), CurveError::Csv { .. }));
        assert!(matches!(refused(&text[..text.len() - 9]), CurveError::Csv { .. }));
        assert!(matches!(
            refused(&text.replacen("-1.2500", "NaN", 1)),
            CurveError::Absurd { line: 2, column: "reward", .. }
        ));
        assert!(matches!(
            refused(&text.replace("2500,0.50,-1.2500", "2500,0.50,-1e100")),
            CurveError::Absurd { line: 3, column: "reward", .. }
        ));
        assert!(matches!(
            refused(&text.replace(",2500,", ",0,")),
            CurveError::Order { row: 2, updates: 0, before: 0, .. }
        ));
        assert!(matches!(read(Path::new("nowhere/train.csv")), Err(CurveError::File(_))));
    }
}
