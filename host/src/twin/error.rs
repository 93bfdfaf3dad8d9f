//! What can be wrong with tables, trials and a fit.

use crate::robot::LegScale;
use crate::robot::RobotError;
use crate::run_folder::FileError;
use std::path::PathBuf;
use thiserror::Error;

/// Why a twin can be neither fitted nor validated.
#[derive(Debug, Error)]
pub enum TwinError {
    /// The file cannot be read.
    #[error(transparent)]
    File(#[from] FileError),
    /// Not comma-separated values.
    #[error("{path} is not a CSV file")]
    Csv {
        /// Which file.
        path: PathBuf,
        /// Where and why.
        source: csv::Error,
    },
    /// A column is not there.
    #[error("{path} has no column {column:?}; it has {has}")]
    Column {
        /// Which file.
        path: PathBuf,
        /// What was looked for.
        column: String,
        /// The header.
        has: String,
    },
    /// A field that must be a number is none.
    #[error("{path}, line {line}: {column} is {text:?}, but must be a number")]
    NoNumber {
        /// Which file.
        path: PathBuf,
        /// Counted from 1, the header included.
        line: u64,
        /// Which.
        column: String,
        /// What stands there.
        text: String,
    },
    /// A number that no trial and no table can have.
    #[error(
        "{path}, line {line}: {column} is {value}, but must be within {min} to {max}; correct or drop the row"
    )]
    OutOfRange {
        /// Which file.
        path: PathBuf,
        /// Counted from 1, the header included.
        line: u64,
        /// Which.
        column: &'static str,
        /// What it says.
        value: f64,
        /// Least allowed.
        min: f64,
        /// Most allowed.
        max: f64,
    },
    /// A table's samples are not 0, 1, 2 and so on.
    #[error(
        "{path}, line {line}: sample {value} of {gait}, but the next of that table is {next}; sort the rows"
    )]
    Sample {
        /// Which file.
        path: PathBuf,
        /// Counted from 1, the header included.
        line: u64,
        /// Whose table.
        gait: String,
        /// What it says.
        value: f64,
        /// What it should say.
        next: usize,
    },
    /// Nothing was measured with this leg.
    #[error("{path} has no trial with legs of {leg}; it has {has}; name one of them with --leg")]
    Leg {
        /// Which file.
        path: PathBuf,
        /// What was asked for.
        leg: LegScale,
        /// What there is.
        has: String,
    },
    /// Another weight than the robot's follows from the numbers.
    #[error(
        "{path}: the trials' own weight, power / (speed x cost of transport), is {trials_n:.1} N, the robot's \
         {robot_n:.1} N: {question}"
    )]
    Weight {
        /// Which file.
        path: PathBuf,
        /// Median over the trials.
        trials_n: f64,
        /// Of the description.
        robot_n: f64,
        /// Which unit is likely.
        question: String,
    },
    /// Trials of a gait that has no table.
    #[error("there are trials of {gait}, but no table of it; there are tables of {has}")]
    NoTable {
        /// What was walked.
        gait: String,
        /// What there is.
        has: String,
    },
    /// No trial is of the method that is to be fitted.
    #[error("no trial is of method {method:?}; there are trials of {has}")]
    Method {
        /// What was asked for.
        method: String,
        /// What there is.
        has: String,
    },
    /// Too little to fit so much.
    #[error("{conditions} amplifications are too few for a fit: it needs at least {needed}")]
    TooFew {
        /// What there is.
        conditions: usize,
        /// What it takes.
        needed: usize,
    },
    /// The robot was never fitted, so nobody knows how long it holds a sample.
    #[error(
        "the robot's description has no [twin] section, so the sample time is unknown; name it with --sample-time, or fit first"
    )]
    SampleTime,
    /// The optimiser refused its settings.
    #[error(
        "the search cannot start with {parameters} parameters and a budget of {evaluations} evaluations; it needs at least 1 and {least}"
    )]
    Budget {
        /// How many are to be found.
        parameters: usize,
        /// How many sets may be tried.
        evaluations: u64,
        /// How many it takes.
        least: u64,
    },
    /// A parameter that there is not.
    #[error("{name:?} is not a parameter of a fit; the parameters are {has}")]
    Parameter {
        /// What was asked for.
        name: String,
        /// What there is.
        has: String,
    },
    /// No range of a parameter.
    #[error("{text:?} is not a parameter with a range; write NAME=MIN:MAX, such as ground.friction=0.2:0.9")]
    Range {
        /// What was asked for.
        text: String,
    },
    /// The search would not look where the robot is.
    #[error(
        "{name} is {value} in the robot's description, but the search looks from {min} to {max}; name a range with --vary {name}=MIN:MAX, along with every other parameter to fit"
    )]
    Elsewhere {
        /// Which parameter.
        name: &'static str,
        /// What the description says.
        value: f64,
        /// Least that is searched.
        min: f64,
        /// Most that is searched.
        max: f64,
    },
    /// The fitted numbers make no robot.
    #[error(transparent)]
    Robot(#[from] RobotError),
}
