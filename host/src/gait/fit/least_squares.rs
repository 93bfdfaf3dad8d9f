//! Least squares in the Chebyshev basis, with or without a continuous seam.
//!
//! One QR decomposition serves all joints. The seam's two conditions are solved for
//! two coefficients beforehand, so they hold to rounding and no weight has to be
//! chosen. Does not depend on units.

use super::Seam;
use nalgebra::{DMatrix, DVector};
use protocol::gait::COEFFICIENT_COUNT;

/// The basis at the rows' phases, decomposed.
pub struct Basis {
    /// Columns are the free functions, in terms of Chebyshev's.
    free: DMatrix<f64>,
    q: DMatrix<f64>,
    r: DMatrix<f64>,
}

impl Basis {
    /// For rows at `phases`, at least as many as coefficients.
    pub fn new(phases: &[f64], seam: Seam) -> Self {
        let chebyshev = DMatrix::from_fn(phases.len(), COEFFICIENT_COUNT, |row, k| {
            let x: f64 = 2.0 * phases[row] - 1.0;
            (k as f64 * x.clamp(-1.0, 1.0).acos()).cos()
        });
        let free = free_functions(seam);
        let (q, r) = (chebyshev * &free).qr().unpack();
        Self { free, q, r }
    }

    /// The Chebyshev coefficients of the best curve; `None` if there is no single one.
    pub fn fit(&self, values: &[f64]) -> Option<[f64; COEFFICIENT_COUNT]> {
        let projected = self.q.transpose() * DVector::from_column_slice(values);
        let solution = self.r.solve_upper_triangular(&projected)?;
        let coefficients = &self.free * solution;
        let coefficients: [f64; COEFFICIENT_COUNT] = coefficients.as_slice().try_into().ok()?;
        coefficients.iter().all(|c| c.is_finite()).then_some(coefficients)
    }
}

/// Functions that keep the seam's conditions, one a column.
///
/// `T_k(1) = 1`, `T_k(-1) = (-1)^k`: values agree if the odd coefficients sum
/// to zero. `T_k'(1) = k^2`, `T_k'(-1) = (-1)^(k-1) k^2`: slopes agree if the
/// even ones, times `k^2`, do. So every odd `T_k` carries `-T_1` with it, and
/// every even one `-(k^2 / 4) T_2`; both are scaled to size 1 for the QR's sake.
fn free_functions(seam: Seam) -> DMatrix<f64> {
    if seam == Seam::Free {
        return DMatrix::identity(COEFFICIENT_COUNT, COEFFICIENT_COUNT);
    }
    let orders: Vec<usize> = (0..COEFFICIENT_COUNT).filter(|k| !matches!(k, 1 | 2)).collect();
    let mut free = DMatrix::zeros(COEFFICIENT_COUNT, orders.len());
    for (column, &k) in orders.iter().enumerate() {
        let (partner, share) = match k {
            0 => (0, 1.0),
            odd if odd % 2 == 1 => (1, -1.0),
            even => (2, -((even * even) as f64) / 4.0),
        };
        let size = f64::max(1.0, share.abs());
        free[(k, column)] = 1.0 / size;
        free[(partner, column)] = share / size;
    }
    free
}
