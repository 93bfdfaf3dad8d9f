//! Smooth closed curves, the wave-like ones first.
//!
//! Holds the coordinates that gaits are searched in: eight degree-10 curves whose
//! value and slope are continuous over the seam, with mean zero and a root mean
//! square of 1. They span every such curve. In order of roughness they resemble
//! the cosines and sines of one to four waves per stride, so that the first two
//! are searched first and the last two can be left at zero. Does not depend on
//! robots.

use nalgebra::{DMatrix, DVector};
use protocol::gait::COEFFICIENT_COUNT;

/// Waves a stride of the fastest pair.
pub const WAVES: usize = 4;

/// A curve's Chebyshev coefficients in `x = 2 phase - 1`, order 0 first.
pub type Curve = [f64; COEFFICIENT_COUNT];

/// The curves.
#[derive(Debug, Clone, PartialEq)]
pub struct Basis {
    /// One wave to four a stride, each as a cosine and a sine.
    pub curves: [[Curve; 2]; WAVES],
}

impl Basis {
    /// The same each time; `None` only if the linear algebra failed.
    #[must_use]
    pub fn new() -> Option<Self> {
        // Even and odd curves never mix: the integrals of their products are zero.
        let (even, odd) = (by_roughness(&closed_even())?, by_roughness(&closed_odd())?);
        let mut curves = [[[0.0; COEFFICIENT_COUNT]; 2]; WAVES];
        for (wave, pair) in curves.iter_mut().enumerate() {
            // A cosine begins at its top, a sine upwards.
            *pair =
                [turned(even.column(wave).as_slice(), start)?, turned(odd.column(wave).as_slice(), rise)?];
        }
        Some(Self { curves })
    }

    /// What of a curve these can make: its share of each, constants left out.
    #[must_use]
    pub fn shares(&self, curve: &Curve) -> [[f64; 2]; WAVES] {
        self.curves.map(|pair| pair.map(|own| mean_product(&own, curve)))
    }
}

/// Even curves with mean zero whose slope closes, one a column: `T_4`, `T_6`,
/// `T_8` and `T_10`, each with as much `T_2` as closes the slope and as much
/// `T_0` as takes out the mean.
fn closed_even() -> DMatrix<f64> {
    let mut curves = DMatrix::zeros(COEFFICIENT_COUNT, WAVES);
    for column in 0..WAVES {
        let k = 4 + 2 * column;
        let second = -((k * k) as f64) / 4.0;
        curves[(k, column)] = 1.0;
        curves[(2, column)] = second;
        curves[(0, column)] = -(mean(k) + second * mean(2));
    }
    curves
}

/// Odd curves that end where they begin, one a column.
fn closed_odd() -> DMatrix<f64> {
    let mut curves = DMatrix::zeros(COEFFICIENT_COUNT, WAVES);
    for column in 0..WAVES {
        curves[(3 + 2 * column, column)] = 1.0;
        curves[(1, column)] = -1.0;
    }
    curves
}

/// The same space, orthonormal over the stride, slowly turning curves first.
fn by_roughness(curves: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let size = DMatrix::from_fn(COEFFICIENT_COUNT, COEFFICIENT_COUNT, product);
    let slope = slopes();
    let sizes = curves.transpose() * &size * curves;
    let roughness = curves.transpose() * slope.transpose() * &size * slope * curves;
    // With sizes = L L': the eigenvectors of L^-1 roughness L^-T.
    let lower = sizes.cholesky()?.l();
    let half = lower.solve_lower_triangular(&roughness)?;
    let whole = lower.solve_lower_triangular(&half.transpose())?;
    let eigen = whole.symmetric_eigen();
    let mut order: Vec<usize> = (0..WAVES).collect();
    order.sort_by(|&a, &b| eigen.eigenvalues[a].total_cmp(&eigen.eigenvalues[b]));
    let sorted = DMatrix::from_fn(WAVES, WAVES, |row, column| eigen.eigenvectors[(row, order[column])]);
    Some(curves * lower.transpose().solve_upper_triangular(&sorted)?)
}

/// From coefficients to those of the derivative by phase.
fn slopes() -> DMatrix<f64> {
    let mut slopes = DMatrix::zeros(COEFFICIENT_COUNT, COEFFICIENT_COUNT);
    for k in 1..COEFFICIENT_COUNT {
        // T_k' = 2 k (T_(k-1) + T_(k-3) + ...), the constant halved; x moves twice as fast as phase.
        for below in (0..k).rev().step_by(2) {
            slopes[(below, k)] = 2.0 * 2.0 * k as f64 * if below == 0 { 0.5 } else { 1.0 };
        }
    }
    slopes
}

/// Mean of `T_k` over the stride.
///
/// # Source
/// The integral of `T_k` over [-1, 1] is `2 / (1 - k^2)` for even `k`, 0 for odd.
fn mean(k: usize) -> f64 {
    if k % 2 == 1 { 0.0 } else { 1.0 / (1.0 - (k * k) as f64) }
}

/// Mean of `T_i T_j` over the stride: `T_i T_j = (T_(i+j) + T_|i-j|) / 2`.
fn product(i: usize, j: usize) -> f64 {
    0.5 * (mean(i + j) + mean(i.abs_diff(j)))
}

/// Mean of the product of two curves over the stride.
fn mean_product(a: &Curve, b: &Curve) -> f64 {
    let terms =
        a.iter().enumerate().flat_map(|(i, a)| b.iter().enumerate().map(move |(j, b)| a * b * product(i, j)));
    terms.sum()
}

fn start(curve: &Curve) -> f64 {
    crate::gait::gait_file::chebyshev(curve, -1.0)
}

fn rise(curve: &Curve) -> f64 {
    let slope = slopes() * DVector::from_column_slice(curve);
    crate::gait::gait_file::chebyshev(slope.as_slice(), -1.0)
}

/// An eigenvector's sign is arbitrary: chosen so that `measure` is positive.
fn turned(curve: &[f64], measure: fn(&Curve) -> f64) -> Option<Curve> {
    let curve: Curve = curve.try_into().ok()?;
    let sign = if measure(&curve) < 0.0 { -1.0 } else { 1.0 };
    Some(curve.map(|c| sign * c))
}

/// Fastest change of a curve, by phase: at 512 phases, which a degree-10 curve never hides between.
#[must_use]
pub fn steepest(curve: &Curve) -> f64 {
    const PHASES: usize = 512;
    let slope = slopes() * DVector::from_column_slice(curve);
    let at = |i: usize| {
        crate::gait::gait_file::chebyshev(slope.as_slice(), 2.0 * i as f64 / PHASES as f64 - 1.0).abs()
    };
    (0..=PHASES).map(at).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gait::gait_file::chebyshev;
    use core::f64::consts::TAU;

    fn basis() -> Basis {
        Basis::new().expect("the algebra holds")
    }

    fn all() -> Vec<Curve> {
        basis().curves.into_iter().flatten().collect()
    }

    #[test]
    fn every_curve_closes_in_value_and_slope_and_has_mean_zero() {
        for curve in all() {
            let slope = slopes() * DVector::from_column_slice(&curve);
            let jump = chebyshev(&curve, 1.0) - chebyshev(&curve, -1.0);
            let kink = chebyshev(slope.as_slice(), 1.0) - chebyshev(slope.as_slice(), -1.0);
            let mean: f64 = curve.iter().enumerate().map(|(k, c)| c * mean(k)).sum();

            assert!(jump.abs() < 1e-9 && kink.abs() < 1e-7 && mean.abs() < 1e-9, "{jump} {kink} {mean}");
        }
    }

    #[test]
    fn the_curves_are_orthonormal_over_the_stride() {
        for (i, a) in all().iter().enumerate() {
            for (j, b) in all().iter().enumerate() {
                let expected = if i == j { 1.0 } else { 0.0 };
                assert!((mean_product(a, b) - expected).abs() < 1e-9, "{i} {j}");
            }
        }
    }

    #[test]
    fn the_first_pair_is_a_cosine_and_a_sine() {
        let [[cosine, sine], ..] = basis().curves;
        for i in 0..=100 {
            let phase = f64::from(i) / 100.0;
            let wave = [(TAU * phase).cos(), (TAU * phase).sin()].map(|w| w * core::f64::consts::SQRT_2);

            assert!((chebyshev(&cosine, 2.0 * phase - 1.0) - wave[0]).abs() < 0.01, "cosine at {phase}");
            assert!((chebyshev(&sine, 2.0 * phase - 1.0) - wave[1]).abs() < 0.01, "sine at {phase}");
        }
        assert!((steepest(&sine) / (TAU * core::f64::consts::SQRT_2) - 1.0).abs() < 0.01);
    }

    #[test]
    fn shares_find_a_curve_again() {
        let basis = basis();
        let curve: Curve =
            core::array::from_fn(|k| 3.0 * basis.curves[0][1][k] - 2.0 * basis.curves[2][0][k]);

        let shares = basis.shares(&curve);

        assert!((shares[0][1] - 3.0).abs() < 1e-9 && (shares[2][0] + 2.0).abs() < 1e-9, "{shares:?}");
        assert!(shares[1][0].abs() < 1e-9 && shares[3][1].abs() < 1e-9, "{shares:?}");
    }
}
