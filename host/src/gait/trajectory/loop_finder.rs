//! Finds one stride in a recording of many.
//!
//! The length comes from the autocorrelation of all joints together, the place from
//! the best seam. A recording that does not repeat is an error: half a stride, fitted,
//! is not a gait. Does not depend on files.

use protocol::JOINT_COUNT;
use std::ops::Range;
use thiserror::Error;

/// Shortest loop that is looked for: fewer rows determine no degree-10 curve.
pub const MIN_LOOP_ROWS: usize = 12;
/// A recording counts as repeating from this correlation on.
pub const MIN_CORRELATION: f64 = 0.5;
/// Multiples of a stride correlate about as well; the shortest one this close to the best is the stride.
const CORRELATION_SLACK: f64 = 0.05;

/// A loop, and how well it closes.
#[derive(Debug, Clone, PartialEq)]
pub struct Loop {
    /// Rows of one stride.
    pub rows: Range<usize>,
    /// Correlation of the recording with itself, one stride later; 1 repeats exactly.
    pub correlation: f64,
    /// Difference between the rows at both ends, as a share of the movement's RMS.
    pub seam_mismatch: f64,
}

/// Why no loop was found.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
// The messages say what each field is.
#[allow(missing_docs)]
pub enum NoLoop {
    /// Two strides are the least to see one repeat.
    #[error("{rows} rows are too few to find a loop in: two strides of {MIN_LOOP_ROWS} rows are the least")]
    TooShort { rows: usize },
    /// Every joint stands still.
    #[error("no joint moves in these {rows} rows")]
    NoMovement { rows: usize },
    /// Nothing repeats well enough.
    #[error(
        "the recording does not repeat: at best, after {lag_rows} rows, it correlates {correlation:.2} with itself; \
         {MIN_CORRELATION} is the least"
    )]
    NotPeriodic {
        /// The best candidate.
        lag_rows: usize,
        /// How well it does.
        correlation: f64,
    },
}

/// Finds the stride whose ends fit best.
///
/// # Errors
/// [`NoLoop`] with the best candidate.
pub fn find_loop(actions: &[[f64; JOINT_COUNT]]) -> Result<Loop, NoLoop> {
    let count = actions.len();
    if count < 2 * MIN_LOOP_ROWS {
        return Err(NoLoop::TooShort { rows: count });
    }
    let centred = centre(actions);
    let mean_square = centred.iter().flatten().map(|a| a * a).sum::<f64>() / (count * JOINT_COUNT) as f64;
    // Sums of actions near 1 leave rounding of about 1e-16 of themselves.
    if mean_square <= 1e-24 {
        return Err(NoLoop::NoMovement { rows: count });
    }

    // One lag beyond each end of the range, so that its ends can be peaks.
    let correlations: Vec<f64> =
        (MIN_LOOP_ROWS - 1..=count / 2 + 1).map(|lag| correlation(&centred, lag)).collect();
    let peaks = correlations
        .windows(3)
        .enumerate()
        .filter(|(_, w)| w[1] >= w[0] && w[1] >= w[2])
        .map(|(i, w)| (i + MIN_LOOP_ROWS, w[1]));
    let best = peaks.clone().map(|(_, c)| c).fold(f64::NEG_INFINITY, f64::max);
    let stride = peaks.clone().find(|&(_, c)| c >= best - CORRELATION_SLACK);
    let (lag_rows, correlation) = stride.unwrap_or((MIN_LOOP_ROWS, correlations[1]));
    if correlation < MIN_CORRELATION {
        return Err(NoLoop::NotPeriodic { lag_rows, correlation });
    }

    // The true stride is not a whole number of rows: its neighbours may close better somewhere.
    let lags = (lag_rows - 1).max(MIN_LOOP_ROWS)..=(lag_rows + 1).min(count - 3);
    let seams = lags.flat_map(|lag| (1..count - lag - 1).map(move |first| (first, lag)));
    let scored = seams.map(|(first, lag)| (seam_square(&centred, first, lag), first, lag));
    let (square, first, lag) =
        scored.min_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or((f64::INFINITY, 0, lag_rows));
    Ok(Loop { rows: first..first + lag, correlation, seam_mismatch: (square / mean_square).sqrt() })
}

fn centre(actions: &[[f64; JOINT_COUNT]]) -> Vec<[f64; JOINT_COUNT]> {
    let mut means = [0.0; JOINT_COUNT];
    for row in actions {
        for (mean, action) in means.iter_mut().zip(row) {
            *mean += action / actions.len() as f64;
        }
    }
    actions.iter().map(|row| std::array::from_fn(|joint| row[joint] - means[joint])).collect()
}

fn correlation(rows: &[[f64; JOINT_COUNT]], lag: usize) -> f64 {
    let (mut product, mut early, mut late) = (0.0, 0.0, 0.0);
    for (a, b) in rows.iter().zip(&rows[lag.min(rows.len())..]) {
        for (x, y) in a.iter().zip(b) {
            product += x * y;
            early += x * x;
            late += y * y;
        }
    }
    if early > 0.0 && late > 0.0 { product / (early * late).sqrt() } else { 0.0 }
}

/// Mean square difference of three rows about both ends: position and speed.
fn seam_square(rows: &[[f64; JOINT_COUNT]], first: usize, lag: usize) -> f64 {
    let ends = rows[first - 1..=first + 1].iter().zip(&rows[first + lag - 1..=first + lag + 1]);
    let squares = ends.flat_map(|(a, b)| a.iter().zip(b)).map(|(x, y)| (x - y) * (x - y));
    squares.sum::<f64>() / (3 * JOINT_COUNT) as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{Rng as _, SeedableRng as _};
    use rand_chacha::ChaCha8Rng;
    use std::f64::consts::TAU;

    /// Eight joints with harmonics and phases of their own; `period_rows` need be no integer.
    fn walking(count: usize, period_rows: f64, noise: f64) -> Vec<[f64; JOINT_COUNT]> {
        let mut random = ChaCha8Rng::seed_from_u64(5);
        let angle = |row: usize, joint: usize| TAU * (row as f64 / period_rows + joint as f64 / 8.0);
        (0..count)
            .map(|row| {
                std::array::from_fn(|joint| {
                    let a = angle(row, joint);
                    0.4 * a.sin() + 0.2 * (2.0 * a + 1.0).cos() + noise * (random.random::<f64>() - 0.5)
                })
            })
            .collect()
    }

    #[test]
    fn one_stride_is_found_and_not_two() {
        let found = find_loop(&walking(300, 31.0, 0.0)).unwrap();

        assert_eq!(found.rows.len(), 31);
        assert!(found.correlation > 0.999 && found.seam_mismatch < 1e-9, "{found:?}");
    }

    #[test]
    fn noise_and_a_broken_period_are_tolerated() {
        let found = find_loop(&walking(300, 27.4, 0.2)).unwrap();

        assert!((26..=29).contains(&found.rows.len()), "{found:?}");
    }

    #[test]
    fn noise_alone_is_no_loop() {
        let mut random = ChaCha8Rng::seed_from_u64(3);
        let noise: Vec<[f64; JOINT_COUNT]> =
            (0..200).map(|_| std::array::from_fn(|_| random.random())).collect();

        assert!(matches!(find_loop(&noise), Err(NoLoop::NotPeriodic { .. })));
    }

    #[test]
    fn too_few_rows_and_stillness_are_refused() {
        assert_eq!(find_loop(&walking(23, 12.0, 0.0)), Err(NoLoop::TooShort { rows: 23 }));
        assert_eq!(find_loop(&[[0.3; JOINT_COUNT]; 50]), Err(NoLoop::NoMovement { rows: 50 }));
    }
}
