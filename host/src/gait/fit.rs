//! Fits a degree-10 curve per joint, in degrees, to one stride of actions.
//!
//! Holds the seam between strides, and the split into centre and deviation. Does not
//! depend on files: [`crate::gait::trajectory`] reads, [`crate::gait::gait_file`]
//! writes. Too few rows to leave a residual are an error.
//!
//! Deviations from the paper: strides are joined ([`Seam::Continuous`]) unless
//! [`Seam::Free`] is chosen, which is the paper's; the basis is Chebyshev's on the
//! normalised phase, not monomials in time (the same curves, well conditioned), and
//! the pivot of the amplitude is the exact mean of the curve over the stride, not of
//! its samples.

mod least_squares;
pub mod speeds;

use crate::gait::gait_file::JointSeries;
use protocol::gait::{COEFFICIENT_COUNT, DEGREE};
use protocol::{JOINT_COUNT, Joint};
use std::str::FromStr;
use thiserror::Error;

/// Fewest rows of a stride: one more than a curve has coefficients, so that something is left over.
pub const MIN_ROWS: usize = COEFFICIENT_COUNT + 1;
/// Below this R2 a curve no longer shows what the policy does.
pub const R2_WARNING: f64 = 0.8;
/// Below this many rows the curve may swing between them.
pub const FEW_ROWS: usize = 2 * COEFFICIENT_COUNT;

/// One curve of degree 10 follows a stride, hardly more than one and a half.
pub const MOST_STRIDES: f64 = 1.5;

/// How the end of a stride meets its beginning.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Seam {
    /// Least squares and nothing else, as in the paper. The first row is phase
    /// 0 and the last is phase 1: between its rows a degree-10 curve is tame,
    /// but beyond the last one, where a row after it would have been, it swings
    /// (the authors' loop: by 30 degrees at amplitude 1.0). The step from the
    /// last row to the first happens at the seam, as in a table played in a loop.
    Free,
    /// Row `i` of `n` is phase `i / n`, and value and slope are the same at
    /// both ends of the stride: nothing jumps, for two degrees of freedom less.
    Continuous,
}

impl Seam {
    /// As in files and flags.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Free => "free",
            Self::Continuous => "continuous",
        }
    }

    /// The default: a stride closes on itself, a window of
    /// fixed length does not.
    #[must_use]
    pub const fn usual(is_window: bool) -> Self {
        if is_window { Self::Free } else { Self::Continuous }
    }

    fn phase(self, row: usize, count: usize) -> f64 {
        let intervals = match self {
            Self::Free => count - 1,
            Self::Continuous => count,
        };
        row as f64 / intervals as f64
    }
}

impl FromStr for Seam {
    type Err = UnknownSeam;

    fn from_str(text: &str) -> Result<Self, UnknownSeam> {
        [Self::Free, Self::Continuous]
            .into_iter()
            .find(|seam| seam.name() == text)
            .ok_or_else(|| UnknownSeam { text: text.into() })
    }
}

/// A seam that does not exist.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("{text:?} is not a seam; it must be free or continuous")]
pub struct UnknownSeam {
    /// What was asked for.
    pub text: String,
}

/// From actions to degrees.
#[derive(Debug, Clone, PartialEq)]
pub struct Scale {
    /// -1 where the robot's joint turns the other way than the recorded one.
    pub signs: [f64; JOINT_COUNT],
    /// Degrees per unit of action about the centre, at amplitude 1.0.
    pub unit_deg: f64,
    /// Degrees per unit of the mean action: where the centre lies.
    pub centre_unit_deg: f64,
    /// Degrees between action 0 and neutral.
    pub centre_offset_deg: f64,
    /// Joint limit, either way from neutral.
    pub limit_deg: f64,
}

/// One joint's curve, and what it leaves over.
#[derive(Debug, Clone, PartialEq)]
pub struct JointFit {
    /// The curve; its residual and R2 are filled in. R2 is the share of the
    /// trajectory's variance that the curve keeps.
    pub series: JointSeries,
    /// Highest minus lowest angle at amplitude 1.0.
    pub stroke_deg: f64,
    /// First minus last angle of the stride at amplitude 1.0.
    pub seam_jump_deg: f64,
}

/// Why a stride was not fitted.
#[derive(Debug, Clone, PartialEq, Error)]
// The messages say what each field is.
#[allow(missing_docs)]
pub enum FitError {
    /// Too few samples.
    #[error("the stride has {rows} rows; a degree-{DEGREE} curve and its residual need {MIN_ROWS}")]
    TooFewRows { rows: usize },
    /// The rows do not determine the curve.
    #[error("{joint}: the rows do not determine a degree-{DEGREE} curve")]
    Undetermined { joint: &'static str },
}

/// Fits every joint over one stride of equally spaced rows.
///
/// The stride lasts as long as its rows, each counted with the interval after
/// it: `n` rows last `n` intervals.
///
/// # Errors
/// [`FitError::TooFewRows`]; [`FitError::Undetermined`] if a number overflows.
pub fn fit(
    rows: &[[f64; JOINT_COUNT]],
    scale: &Scale,
    seam: Seam,
) -> Result<[JointFit; JOINT_COUNT], FitError> {
    if rows.len() < MIN_ROWS {
        return Err(FitError::TooFewRows { rows: rows.len() });
    }
    let phases: Vec<f64> = (0..rows.len()).map(|row| seam.phase(row, rows.len())).collect();
    let basis = least_squares::Basis::new(&phases, seam);
    let mut fits = Vec::with_capacity(JOINT_COUNT);
    for joint in Joint::ALL {
        let sign = scale.signs[joint.index()];
        let actions: Vec<f64> = rows.iter().map(|row| sign * row[joint.index()]).collect();
        let coefficients = basis.fit(&actions).ok_or(FitError::Undetermined { joint: joint.name() })?;
        fits.push(in_degrees(coefficients, &phases, &actions, scale));
    }
    fits.try_into().map_err(|_| FitError::TooFewRows { rows: rows.len() })
}

fn in_degrees(
    mut curve: [f64; COEFFICIENT_COUNT],
    phases: &[f64],
    actions: &[f64],
    scale: &Scale,
) -> JointFit {
    let residual_square = phases
        .iter()
        .zip(actions)
        .map(|(&phase, action)| {
            (crate::gait::gait_file::chebyshev(&curve, 2.0 * phase - 1.0) - action).powi(2)
        })
        .sum::<f64>();
    let mean_action = actions.iter().sum::<f64>() / actions.len() as f64;
    let variation = actions.iter().map(|action| (action - mean_action).powi(2)).sum::<f64>();
    // A joint that stands still has nothing to explain.
    let moves = variation > 1e-12 * actions.len() as f64;

    let mean = mean_over_stride(&curve);
    curve[0] -= mean;
    let series = JointSeries {
        centre_deg: scale.centre_unit_deg * mean + scale.centre_offset_deg,
        min_deg: -scale.limit_deg,
        max_deg: scale.limit_deg,
        coefficients_deg: curve.map(|c| c * scale.unit_deg),
        residual_rms_deg: Some(scale.unit_deg * (residual_square / actions.len() as f64).sqrt()),
        r2: moves.then(|| 1.0 - residual_square / variation),
    };
    let (low, high) = series.deviation_range_deg();
    let seam_jump_deg = series.deviation_deg(0.0) - series.deviation_deg(1.0);
    JointFit { series, stroke_deg: high - low, seam_jump_deg }
}

/// Mean of a Chebyshev series over its whole range.
///
/// # Source
/// The integral of `T_k` over [-1, 1] is `2 / (1 - k^2)` for even `k`, 0 for odd.
pub(crate) fn mean_over_stride(coefficients: &[f64; COEFFICIENT_COUNT]) -> f64 {
    coefficients.iter().enumerate().step_by(2).map(|(k, c)| c / (1.0 - (k * k) as f64)).sum()
}

#[cfg(test)]
mod reference;
#[cfg(test)]
mod tests;
