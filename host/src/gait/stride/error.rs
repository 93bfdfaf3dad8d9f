//! Why motion makes no stride, with what was found instead.

use super::{MAX_PERIOD_S, MIN_CORRELATION, MIN_PERIOD_S, MIN_WINDOW_S, STILL_RMS};
use thiserror::Error;

/// Why no stride was found.
#[derive(Debug, Clone, PartialEq, Error)]
// The messages say what each field is.
#[allow(missing_docs)]
pub enum StrideError {
    /// Nothing moves.
    #[error("the joints hardly move: {rms:.4} in action units (rms), at least {STILL_RMS} is needed")]
    Still {
        /// Root mean square over all joints.
        rms: f64,
    },
    /// Nothing repeats.
    #[error(
        "the motion does not repeat: the best correlation between {MIN_PERIOD_S} and {MAX_PERIOD_S} s is \
         {correlation:.2} at {period_s:.2} s, at least {MIN_CORRELATION} is needed"
    )]
    NotPeriodic {
        /// Best normalised correlation found.
        correlation: f64,
        period_s: f64,
    },
    /// It repeats, but strides differ.
    #[error("only {kept} of {found} strides of {period_s:.2} s are alike, more than half must be")]
    Unlike {
        /// Strides like the average.
        kept: usize,
        found: usize,
        /// The common period.
        period_s: f64,
    },
    /// Every trial moves, but not as the others do.
    #[error(
        "only {kept} of {found} trials have {window_s:.2} s like those of the others, more than half must"
    )]
    WindowsUnlike {
        /// Trials with a window like the average.
        kept: usize,
        found: usize,
        /// Of the window.
        window_s: f64,
    },
    /// No room to move the window in.
    #[error(
        "a window of {window_s} s cannot be laid over trials of {duration_s:.2} s: it lasts {} to {most_s:.2} s",
        MIN_WINDOW_S
    )]
    Window {
        /// Asked for.
        window_s: f64,
        /// Of the longest trial.
        duration_s: f64,
        /// The longest window that leaves a stride to move it in.
        most_s: f64,
    },
    /// Too short for three strides.
    #[error("the longest trial lasts {duration_s:.2} s; three strides need more")]
    TooShort {
        /// Of the longest trial.
        duration_s: f64,
    },
}
