//! Learning curves over several seeds.
//!
//! Holds the reading of a run folder, of one seed or of several, and the statistics
//! over seeds; `figure` draws them. Does not depend on the learner. Seeds of one run
//! must be evaluated after the same updates: a mean over different schedules would
//! mean nothing.

mod figure;

pub use figure::{Band, TooManyRuns, of as figure};

use crate::learn::td3::curve::{self, CurveError, CurvePoint};
use crate::run_folder;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Prefix of a seed's folder in `train --seeds`, before its number.
const SEED_FOLDER: &str = "seed-";

/// Why a run has no curves.
#[derive(Debug, Error)]
pub enum CurvesError {
    /// There is no learning curve.
    #[error("{folder} holds no {}, and no {SEED_FOLDER}N with one", run_folder::LEARNING_CURVE)]
    NoCurve {
        /// The folder.
        folder: PathBuf,
    },
    /// A learning curve cannot be read.
    #[error(transparent)]
    Curve(#[from] CurveError),
    /// Seeds have different schedules.
    #[error(
        "{folder}: evaluation {row} of {seed} is after {updates} updates and {env_steps} steps, that of \
         {other} after {other_updates} and {other_env_steps}"
    )]
    Grid {
        /// Folder of the run.
        folder: PathBuf,
        /// Row, from 1.
        row: usize,
        /// One of two seeds that differ.
        seed: String,
        /// Its updates.
        updates: u64,
        /// Its control steps.
        env_steps: u64,
        /// The other seed.
        other: String,
        /// Its updates.
        other_updates: u64,
        /// Its control steps.
        other_env_steps: u64,
    },
}

/// The learning curve of one seed.
#[derive(Debug, Clone, PartialEq)]
pub struct SeedCurve {
    /// Name of its folder.
    pub name: String,
    /// All evaluations, at least one.
    pub points: Vec<CurvePoint>,
}

impl SeedCurve {
    /// The latest evaluation.
    #[must_use]
    pub fn last(&self) -> &CurvePoint {
        &self.points[self.points.len() - 1]
    }

    /// The first evaluation of maximum reward, whose policy the run keeps.
    #[must_use]
    pub fn best(&self) -> &CurvePoint {
        let better = |a: &&CurvePoint, b: &&CurvePoint| a.reward.total_cmp(&b.reward);
        self.points.iter().rev().max_by(better).unwrap_or(self.last())
    }
}

/// Statistics of a value over seeds.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Spread {
    /// Arithmetic mean.
    pub mean: f64,
    /// Standard deviation of the sample (n - 1); 0 of a single seed.
    pub deviation: f64,
    /// Minimum.
    #[serde(rename = "least")]
    pub min: f64,
    /// Maximum.
    #[serde(rename = "most")]
    pub max: f64,
}

impl Spread {
    /// Statistics of at least one value.
    fn of(values: impl Iterator<Item = f64> + Clone) -> Self {
        let count = values.clone().count().max(1) as f64;
        let mean = values.clone().sum::<f64>() / count;
        let squares: f64 = values.clone().map(|value| (value - mean).powi(2)).sum();
        let deviation = (squares / (count - 1.0).max(1.0)).sqrt();
        let (min, max) = values
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(min, max), value| (min.min(value), max.max(value)));
        Self { mean, deviation, min, max }
    }
}

/// Reward and speed over seeds.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Score {
    /// Reward of an evaluation episode.
    pub reward: Spread,
    /// Mean forward speed.
    pub speed_m_s: Spread,
}

impl Score {
    fn of<'a>(points: impl Iterator<Item = &'a CurvePoint> + Clone) -> Self {
        Self {
            reward: Spread::of(points.clone().map(|point| point.reward)),
            speed_m_s: Spread::of(points.map(|point| point.speed_m_s)),
        }
    }
}

/// All seeds after the same number of updates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Row {
    /// Updates done.
    pub updates: u64,
    /// Control steps gathered.
    pub env_steps: u64,
    /// Seeds with this evaluation.
    pub seeds: usize,
    /// Statistics over those seeds.
    pub score: Score,
}

/// A run's curves.
#[derive(Debug, Clone, PartialEq)]
pub struct RunCurves {
    /// Label in the legend.
    pub label: String,
    /// Seeds with a curve, at least one.
    pub seeds: Vec<SeedCurve>,
    /// Seeds without an evaluation yet.
    pub without_curve: Vec<String>,
}

impl RunCurves {
    /// Reads a run of one seed, or all seeds of a `train --seeds`.
    ///
    /// # Errors
    /// [`CurvesError`] if there is no curve, one is damaged, or the seeds' schedules differ.
    pub fn read(folder: &Path, label: String) -> Result<Self, CurvesError> {
        let (mut seeds, mut without_curve) = (Vec::new(), Vec::new());
        for (name, path) in seed_folders(folder) {
            let file = path.join(run_folder::LEARNING_CURVE);
            match file.exists().then(|| curve::read(&file)) {
                Some(Ok(points)) => seeds.push(SeedCurve { name, points }),
                // Started, but not evaluated yet.
                None | Some(Err(CurveError::Empty { .. })) => without_curve.push(name),
                Some(Err(error)) => return Err(error.into()),
            }
        }
        // A folder of seeds also holds a copy of the best one's curve, which must not count twice.
        if seeds.is_empty() && without_curve.is_empty() {
            let file = folder.join(run_folder::LEARNING_CURVE);
            if !file.exists() {
                return Err(CurvesError::NoCurve { folder: folder.to_owned() });
            }
            seeds.push(SeedCurve { name: name_of(folder), points: curve::read(&file)? });
        }
        if seeds.is_empty() {
            return Err(CurvesError::NoCurve { folder: folder.to_owned() });
        }
        let run = Self { label, seeds, without_curve };
        run.check_grid(folder)?;
        Ok(run)
    }

    fn check_grid(&self, folder: &Path) -> Result<(), CurvesError> {
        let longest = self.longest();
        for seed in &self.seeds {
            let mut pairs = seed.points.iter().zip(&longest.points).enumerate();
            let differ = |(_, (a, b)): &(usize, (&CurvePoint, &CurvePoint))| {
                (a.updates, a.env_steps) != (b.updates, b.env_steps)
            };
            if let Some((index, (point, other))) = pairs.find(differ) {
                return Err(CurvesError::Grid {
                    folder: folder.to_owned(),
                    row: index + 1,
                    seed: seed.name.clone(),
                    updates: point.updates,
                    env_steps: point.env_steps,
                    other: longest.name.clone(),
                    other_updates: other.updates,
                    other_env_steps: other.env_steps,
                });
            }
        }
        Ok(())
    }

    fn longest(&self) -> &SeedCurve {
        let first = &self.seeds[0];
        self.seeds.iter().rev().max_by_key(|seed| seed.points.len()).unwrap_or(first)
    }

    /// Statistics of each evaluation, over the seeds that have it.
    #[must_use]
    pub fn rows(&self) -> Vec<Row> {
        let row = |(index, point): (usize, &CurvePoint)| {
            let reached = self.seeds.iter().filter_map(move |seed| seed.points.get(index));
            Row {
                updates: point.updates,
                env_steps: point.env_steps,
                seeds: reached.clone().count(),
                score: Score::of(reached),
            }
        };
        self.longest().points.iter().enumerate().map(row).collect()
    }

    /// Statistics over each seed's latest evaluation.
    #[must_use]
    pub fn last(&self) -> Score {
        Score::of(self.seeds.iter().map(SeedCurve::last))
    }

    /// Statistics over each seed's best evaluation by reward.
    #[must_use]
    pub fn best(&self) -> Score {
        Score::of(self.seeds.iter().map(SeedCurve::best))
    }

    /// Seeds that have fewer evaluations than the longest.
    pub fn behind(&self) -> impl Iterator<Item = &SeedCurve> {
        let most = self.longest().points.len();
        self.seeds.iter().filter(move |seed| seed.points.len() < most)
    }
}

fn name_of(folder: &Path) -> String {
    // Canonical, because `runs/latest` is a link and not a name.
    let real = folder.canonicalize().unwrap_or_else(|_| folder.to_owned());
    real.file_name().unwrap_or(real.as_os_str()).to_string_lossy().into_owned()
}

/// Default label of a run: its folder and the length of its robot's shins.
#[must_use]
pub fn default_label(folder: &Path) -> String {
    let name = name_of(folder);
    // A curve can be drawn without a robot; the label then lacks the length.
    let robot = crate::robot::Robot::of_run(folder).ok().flatten();
    robot.map_or(name.clone(), |robot| format!("{name} ({})", robot.geometry.leg_scale))
}

/// The seed folders in a folder, sorted by number.
fn seed_folders(folder: &Path) -> Vec<(String, PathBuf)> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let mut seeds: Vec<(u64, String, PathBuf)> = entries
        .filter_map(|entry| {
            let name = entry.file_name().into_string().ok()?;
            let number: u64 = name.strip_prefix(SEED_FOLDER)?.parse().ok()?;
            // `seed-02` is not ours, but a copy that would count a seed twice.
            if name != format!("{SEED_FOLDER}{number}") {
                return None;
            }
            entry.path().is_dir().then(|| (number, name, entry.path()))
        })
        .collect();
    seeds.sort();
    seeds.into_iter().map(|(_, name, path)| (name, path)).collect()
}

#[cfg(test)]
mod tests;
