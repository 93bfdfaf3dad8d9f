//! The next points to try, by a Gaussian process over those that were tried.
//!
//! Holds the use of crate `egobox-ego`. Does not depend on what the points mean.
//! Every suggestion is a function of the known points and the seed, whatever the
//! number of cores.

use egobox_ego::{CorrelationSpec, EgorServiceBuilder, InfillStrategy};
use ndarray::Array2;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// Starts of the likelihood's search, and its evaluations each: with 300 points of 12 numbers a
/// batch of four takes 3 s of one core.
const LIKELIHOOD_STARTS: usize = 3;
const LIKELIHOOD_EVALUATIONS: usize = 25;
/// Starts of the search for the largest expected improvement.
const IMPROVEMENT_STARTS: usize = 20;

/// Points that were tried, in numbers from 0 to 1.
#[derive(Debug)]
pub struct Known<'a> {
    /// Points, all of one length.
    pub points: &'a [Vec<f64>],
    /// One for each point; lower is better.
    pub costs: &'a [f64],
}

/// Points of most expected improvement within `limits`, one after the other as if
/// those before had come out as expected; `None` if the process cannot be fitted.
#[must_use]
pub fn suggest(known: &Known<'_>, limits: &[[f64; 2]], count: usize, seed: u64) -> Option<Vec<Vec<f64>>> {
    // The crate panics on matrices that are not positive definite.
    let found = catch_unwind(AssertUnwindSafe(|| ask(known, limits, count, seed)));
    let points: Vec<Vec<f64>> = found.ok()??.rows().into_iter().map(|row| row.to_vec()).collect();
    let is_whole = points.iter().flatten().all(|number| number.is_finite());
    (is_whole && !points.is_empty()).then_some(points)
}

fn ask(known: &Known<'_>, limits: &[[f64; 2]], count: usize, seed: u64) -> Option<Array2<f64>> {
    let size = limits.len();
    let box_of_points = Array2::from_shape_fn((size, 2), |(number, end)| limits[number][end]);
    let points = Array2::from_shape_fn((known.points.len(), size), |(row, number)| known.points[row][number]);
    let costs = Array2::from_shape_fn((known.costs.len(), 1), |(row, _)| known.costs[row]);
    let service = EgorServiceBuilder::optimize()
        .configure(|config| {
            config
                .configure_gp(|process| {
                    process
                        .correlation_spec(CorrelationSpec::MATERN52)
                        .n_start(LIKELIHOOD_STARTS)
                        .max_eval(LIKELIHOOD_EVALUATIONS)
                })
                // One fit of the likelihood for all points of a batch.
                .configure_qei(|batch| batch.batch(count).optmod(count))
                .infill_strategy(InfillStrategy::LogEI)
                .n_start(IMPROVEMENT_STARTS)
                .seed(seed)
        })
        .min_within(&box_of_points)
        .ok()?;
    // The crate logs to standard output, where results go.
    log::set_max_level(log::LevelFilter::Off);
    Some(service.suggest(&points, &costs))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bowl(point: &[f64]) -> f64 {
        point.iter().map(|x| (x - 0.3).powi(2)).sum()
    }

    fn searched(threads: usize) -> Vec<Vec<f64>> {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| {
            let mut points: Vec<Vec<f64>> = (0..12)
                .map(|i| (0..3).map(|j| (f64::from(i) * (0.618 + 0.2 * f64::from(j))).fract()).collect())
                .collect();
            for round in 0..6 {
                let costs: Vec<f64> = points.iter().map(|point| bowl(point)).collect();
                let known = Known { points: &points, costs: &costs };
                let found = suggest(&known, &[[0.0, 1.0]; 3], 2, round).expect("a bowl can be fitted");
                points.extend(found);
            }
            points
        })
    }

    #[test]
    fn the_bottom_of_a_bowl_is_found_the_same_on_one_core_and_two() {
        let points = searched(1);

        let least = points.iter().map(|point| bowl(point)).fold(f64::INFINITY, f64::min);
        assert!(least < 1e-3, "{least}");
        assert_eq!(points, searched(2));
    }

    #[test]
    fn what_cannot_be_fitted_is_no_answer_and_no_panic() {
        let points = vec![vec![f64::NAN; 3]; 4];
        let known = Known { points: &points, costs: &[f64::NAN; 4] };

        assert_eq!(suggest(&known, &[[0.0, 1.0]; 3], 2, 0), None);
    }
}
