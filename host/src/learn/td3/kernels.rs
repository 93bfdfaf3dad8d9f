//! The arithmetic that an update spends its time in, on plain memory.
//!
//! Owns the matrix product and the loops over whole layers, each compiled for
//! the widest vectors that this processor has. Refuses to know networks. This
//! is where the speed comes from: on products of 128 x 128 the crate `gemm`
//! with AVX-512 reaches more than twice the rate of libtorch (whose MKL keeps
//! to AVX2 on AMD), and no call costs more than its arithmetic.
//!
//! One processor gives one result: nothing here depends on threads, and no
//! loop's order on the width of its vectors.

use pulp::Arch;

/// A matrix in somebody's memory: element `(row, column)` stands at
/// `row * row_stride + column * column_stride`.
#[derive(Debug, Clone, Copy)]
pub struct Matrix<'a> {
    numbers: &'a [f32],
    rows: usize,
    columns: usize,
    row_stride: usize,
    column_stride: usize,
}

impl<'a> Matrix<'a> {
    /// Rows of `columns` numbers, `stride` apart, the first at `start`.
    ///
    /// # Panics
    /// If `numbers` does not hold all of it.
    pub fn rows(numbers: &'a [f32], start: usize, rows: usize, columns: usize, stride: usize) -> Self {
        let numbers = &numbers[start..];
        assert!(rows == 0 || (rows - 1) * stride + columns <= numbers.len(), "the matrix leaves its memory");
        Self { numbers, rows, columns, row_stride: stride, column_stride: 1 }
    }

    /// All of `numbers` as rows of `columns`.
    pub fn dense(numbers: &'a [f32], columns: usize) -> Self {
        Self::rows(numbers, 0, numbers.len() / columns, columns, columns)
    }

    /// The same numbers, turned.
    pub fn turned(self) -> Self {
        Self {
            rows: self.columns,
            columns: self.rows,
            row_stride: self.column_stride,
            column_stride: self.row_stride,
            ..self
        }
    }

    /// How many rows there are.
    pub fn row_count(self) -> usize {
        self.rows
    }
}

/// What a product does with what stands at its target.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Target {
    /// Forgets it.
    Replace,
    /// Adds to it.
    Add,
}

/// `product = left x right`, or `+=`; `product` holds whole rows one after another.
///
/// # Panics
/// If the shapes do not fit each other.
#[allow(unsafe_code)]
pub fn multiply(product: &mut [f32], left: Matrix<'_>, right: Matrix<'_>, target: Target) {
    assert_eq!(left.columns, right.rows, "inner dimensions");
    assert_eq!(product.len(), left.rows * right.columns, "the product's size");
    if product.is_empty() {
        return;
    }
    let add = target == Target::Add;
    // SAFETY: `Matrix` is only made where all its elements lie within its slice, turning
    // it swaps strides with dimensions, and the product's length was compared above. The
    // product is borrowed mutably and so shares no memory with either factor.
    unsafe {
        gemm::gemm(
            left.rows,
            right.columns,
            left.columns,
            product.as_mut_ptr(),
            1,
            right.columns as isize,
            add,
            left.numbers.as_ptr(),
            left.column_stride as isize,
            left.row_stride as isize,
            right.numbers.as_ptr(),
            right.column_stride as isize,
            right.row_stride as isize,
            if add { 1.0 } else { 0.0 },
            1.0,
            false,
            false,
            false,
            gemm::Parallelism::None,
        );
    }
}

/// Fills every row of `rows` with `row`.
pub fn repeat(row: &[f32], rows: &mut [f32]) {
    for to in rows.chunks_exact_mut(row.len()) {
        to.copy_from_slice(row);
    }
}

/// What is below zero becomes zero; what is no number stays so, or divergence would not show.
pub fn rectify(values: &mut [f32]) {
    Arch::new().dispatch(
        #[inline(always)]
        || {
            for value in values {
                *value = if *value < 0.0 { 0.0 } else { *value };
            }
        },
    );
}

/// Stops derivatives where the rectified value is zero.
pub fn rectify_backward(rectified: &[f32], gradient: &mut [f32]) {
    Arch::new().dispatch(
        #[inline(always)]
        || {
            for (gradient, &value) in gradient.iter_mut().zip(rectified) {
                *gradient = if value > 0.0 { *gradient } else { 0.0 };
            }
        },
    );
}

/// `sums` becomes the sum of the rows of `rows`.
pub fn sum_rows(rows: &[f32], sums: &mut [f32]) {
    Arch::new().dispatch(
        #[inline(always)]
        || {
            sums.fill(0.0);
            for row in rows.chunks_exact(sums.len()) {
                for (sum, &value) in sums.iter_mut().zip(row) {
                    *sum += value;
                }
            }
        },
    );
}

/// Moves `slow` the share `tau` of the way to `fast`.
pub fn follow(slow: &mut [f32], fast: &[f32], tau: f32) {
    Arch::new().dispatch(
        #[inline(always)]
        || {
            for (slow, &fast) in slow.iter_mut().zip(fast) {
                *slow += tau * (fast - *slow);
            }
        },
    );
}

/// The numbers of one Adam step, bias corrections included.
#[derive(Debug, Clone, Copy)]
pub struct AdamStep {
    /// Share of the mean that stays.
    pub beta1: f32,
    /// Share of the mean square that stays.
    pub beta2: f32,
    /// Learning rate, times the root of the square's correction, over the mean's.
    pub size: f32,
    /// Epsilon, times the root of the square's correction.
    pub epsilon: f32,
}

/// One Adam step over all parameters, in one pass.
pub fn adam(
    step: AdamStep,
    parameters: &mut [f32],
    gradients: &[f32],
    means: &mut [f32],
    squares: &mut [f32],
) {
    Arch::new().dispatch(
        #[inline(always)]
        || {
            let moments = means.iter_mut().zip(squares);
            for ((parameter, &gradient), (mean, square)) in parameters.iter_mut().zip(gradients).zip(moments)
            {
                *mean += (1.0 - step.beta1) * (gradient - *mean);
                *square += (1.0 - step.beta2) * (gradient * gradient - *square);
                *parameter -= step.size * *mean / (square.sqrt() + step.epsilon);
            }
        },
    );
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn products_of_turned_and_spread_out_matrices_are_as_worked_out_by_hand() {
        // Two rows of two, three apart.
        let left = [9.0, 1.0, 2.0, 9.0, 3.0, 4.0];
        let left = Matrix::rows(&left, 1, 2, 2, 3);
        let right = [5.0, 6.0, 7.0, 8.0];
        let right = Matrix::dense(&right, 2);
        let mut product = [100.0; 4];

        multiply(&mut product, left, right, Target::Replace);
        assert_eq!(product, [19.0, 22.0, 43.0, 50.0]);

        multiply(&mut product, left.turned(), right, Target::Add);
        assert_eq!(product, [19.0 + 26.0, 22.0 + 30.0, 43.0 + 38.0, 50.0 + 44.0]);

        multiply(&mut product, left, right.turned(), Target::Replace);
        assert_eq!(product, [17.0, 23.0, 39.0, 53.0]);
    }

    #[test]
    #[should_panic(expected = "leaves its memory")]
    fn a_matrix_beyond_its_memory_is_refused() {
        let _ = Matrix::rows(&[0.0; 5], 0, 2, 2, 4);
    }

    #[test]
    #[should_panic(expected = "inner dimensions")]
    fn factors_that_do_not_fit_are_refused() {
        let numbers = [0.0; 6];
        multiply(&mut [0.0; 4], Matrix::dense(&numbers, 3), Matrix::dense(&numbers, 3), Target::Replace);
    }

    #[test]
    fn loops_reach_the_last_number_of_an_odd_length() {
        let mut values: Vec<f32> = (0..67).map(|i| i as f32 - 33.0).collect();
        let rectified: Vec<f32> = values.iter().map(|v| v.max(0.0)).collect();
        let mut gradient = vec![1.0; 67];

        rectify(&mut values);
        let mut no_number = [f32::NAN];
        rectify(&mut no_number);
        rectify_backward(&rectified, &mut gradient);

        assert_eq!(values, rectified);
        assert!(no_number[0].is_nan());
        assert_eq!(gradient.iter().sum::<f32>(), 33.0);
        let mut sums = [7.0; 3];
        sum_rows(&[1.0, 2.0, 3.0, 10.0, 20.0, 30.0], &mut sums);
        assert_eq!(sums, [11.0, 22.0, 33.0]);
    }
}
