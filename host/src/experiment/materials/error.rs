//! Why gaits cannot be had.

use crate::gait::gait_file::GaitFileError;
use crate::gait::sampled_gait::SampleError;
use crate::gait::trajectory::TrajectoryError;
use crate::learn::curves::CurvesError;
use crate::robot::LegScale;
use crate::run_folder::FileError;
use std::path::PathBuf;
use thiserror::Error;

/// Why there are no gaits.
#[derive(Debug, Error)]
pub enum MaterialsError {
    /// The disk's reason.
    #[error(transparent)]
    File(#[from] FileError),
    /// A gait file's fault.
    #[error(transparent)]
    Gait(#[from] GaitFileError),
    /// The stride's fault.
    #[error(transparent)]
    Stride(#[from] TrajectoryError),
    /// No table holds the stride.
    #[error("{path} cannot be played sample by sample")]
    Sampled {
        /// Which file.
        path: PathBuf,
        /// Why.
        source: SampleError,
    },
    /// The stride's file does not say how long it lasts.
    #[error("{path} has no {}: how long the stride lasts is unknown", crate::gait::trajectory::TIME_COLUMN)]
    NoTime {
        /// Which file.
        path: PathBuf,
    },
    /// A stride and its spread that do not belong together.
    #[error("{path} has {rows} rows, the stride beside it {expected}")]
    Spread {
        /// Which file.
        path: PathBuf,
        /// Its rows.
        rows: usize,
        /// The stride's.
        expected: usize,
    },
    /// The learning curve's fault.
    #[error(transparent)]
    Curves(#[from] CurvesError),
    /// The commands cannot be read.
    #[error("{path} does not say how gaits were made")]
    Made {
        /// Which file.
        path: PathBuf,
        /// Where and why.
        source: toml::de::Error,
    },
    /// Legs that nothing comes with.
    #[error("no gaits come with the program for {robot} with legs of {leg}")]
    NoneKnown {
        /// Which robot.
        robot: String,
        /// Which legs.
        leg: LegScale,
    },
}
