//! The learning curve: one row an evaluation.
//!
//! Owns the rows and their file format; refuses to judge them, but reads none
//! that is no number or out of order.

use crate::run_folder::FileError;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Rewards, speeds and times of a run are far below it; beyond, an axis has no numbers left.
const MOST: f64 = 1e12;

/// Why a file is no learning curve.
#[derive(Debug, Error)]
pub enum CurveError {
    /// The disk's reason.
    #[error(transparent)]
    File(#[from] FileError),
    /// A column is missing, or a value of another kind.
    #[error("{path} is no learning curve")]
    Csv {
        /// Which file.
        path: PathBuf,
        /// Where and why.
        source: csv::Error,
    },
    /// A header at most.
    #[error("{path} has no evaluation yet")]
    Empty {
        /// Which file.
        path: PathBuf,
    },
    /// Not to be drawn: no number, or one that no run comes to.
    #[error("{path}, line {line}: {column} is {value}; it must be within {MOST:e} either way")]
    Absurd {
        /// Which file.
        path: PathBuf,
        /// Which line, from 1; the header is the first.
        line: u64,
        /// Of what.
        column: &'static str,
        /// What it is.
        value: f64,
    },
    /// Learning does not go back.
    #[error("{path}, evaluation {row}: {updates} updates after {before}")]
    Order {
        /// Which file.
        path: PathBuf,
        /// Which row, from 1.
        row: usize,
        /// Of that row.
        updates: u64,
        /// Of the row before.
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
    /// Of the latest round.
    pub critic_loss: f64,
    /// Of the latest round.
    pub actor_loss: f64,
    /// Of the latest round.
    pub q_mean: f64,
}

/// The learning curve as people and plots read it.
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

/// Reads what [`to_csv`] wrote; other columns may stand beside.
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
        if let Some((column, value)) = drawn.into_iter().find(|(_, value)| !(-MOST..=MOST).contains(value)) {
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
    fn a_curve_is_read_as_it_was_written_and_further_columns_do_no_harm() {
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
