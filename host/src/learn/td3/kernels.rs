//! The arithmetic that an update spends its time in, on plain `f32` slices.
//!
//! Holds the matrix product and the loops over whole layers. Does not depend on
//! networks or losses.
//!
//! Each loop is compiled several times, once for each set of vector instructions;
//! [`Arch::dispatch`] selects the widest that this processor has. Products go to the
//! crate `gemm`: at 128 x 128 its AVX-512 code reaches more than twice the rate of
//! libtorch, whose MKL stays with AVX2 on AMD. Nothing here allocates.
//!
//! Results do not depend on threads, nor on the width of the vectors: elementwise
//! loops have no order, and sums go row by row.

use pulp::Arch;

/// A view of a matrix in a slice: element `(row, column)` is at index
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
    /// `rows` rows of `columns` numbers each, `stride` apart, the first at `start`: some
    /// columns of a wider matrix without copying them.
    ///
    /// # Panics
    /// If an element would be outside `numbers`.
    pub fn rows(numbers: &'a [f32], start: usize, rows: usize, columns: usize, stride: usize) -> Self {
        let numbers = &numbers[start..];
        // The last element is the last column of the last row.
        assert!(rows == 0 || (rows - 1) * stride + columns <= numbers.len(), "the matrix exceeds its slice");
        Self { numbers, rows, columns, row_stride: stride, column_stride: 1 }
    }

    /// All of `numbers` as consecutive rows of `columns` numbers.
    pub fn dense(numbers: &'a [f32], columns: usize) -> Self {
        Self::rows(numbers, 0, numbers.len() / columns, columns, columns)
    }

    /// The transposed view; nothing is copied.
    pub fn transposed(self) -> Self {
        Self {
            rows: self.columns,
            columns: self.rows,
            row_stride: self.column_stride,
            column_stride: self.row_stride,
            ..self
        }
    }

    /// Rows of the view: the batch size, where it is a batch.
    pub fn row_count(self) -> usize {
        self.rows
    }
}

/// Whether a product replaces what its output holds or is added to it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Output {
    /// `output = left x right`.
    Overwrite,
    /// `output += left x right`.
    Accumulate,
}

/// `product = left x right`, or `+=`; `product` is dense, `[left rows, right columns]`.
///
/// # Panics
/// If the shapes of the three do not match.
#[allow(unsafe_code)]
pub fn multiply(product: &mut [f32], left: Matrix<'_>, right: Matrix<'_>, output: Output) {
    assert_eq!(left.columns, right.rows, "inner dimensions");
    assert_eq!(product.len(), left.rows * right.columns, "the product's size");
    if product.is_empty() {
        return;
    }
    let add = output == Output::Accumulate;
    // SAFETY: `Matrix::rows` checks that every element lies within its slice, `transposed`
    // swaps strides together with dimensions, and the product's length was compared above.
    // The product is borrowed mutably and so shares no memory with either factor.
    unsafe {
        gemm::gemm(
            // m, n, k: the product is m x n, and k is the inner dimension.
            left.rows,
            right.columns,
            left.columns,
            // Each matrix: its first element, then its column and its row stride.
            product.as_mut_ptr(),
            1,
            right.columns as isize,
            // Whether the product's old elements are read.
            add,
            left.numbers.as_ptr(),
            left.column_stride as isize,
            left.row_stride as isize,
            right.numbers.as_ptr(),
            right.column_stride as isize,
            right.row_stride as isize,
            // product = alpha * product + beta * left x right.
            if add { 1.0 } else { 0.0 },
            1.0,
            // No complex conjugates.
            false,
            false,
            false,
            // One thread: another one simulates meanwhile, and the order of sums stays the same.
            gemm::Parallelism::None,
        );
    }
}

/// Copies `row` into every row of `rows`: a layer's bias, to which the product is added.
pub fn repeat(row: &[f32], rows: &mut [f32]) {
    for to in rows.chunks_exact_mut(row.len()) {
        to.copy_from_slice(row);
    }
}

/// ReLU in place. NaN stays NaN, so that divergence is seen; `max` would make it 0.
pub fn relu(values: &mut [f32]) {
    Arch::new().dispatch(
        #[inline(always)]
        || {
            for value in values {
                *value = if *value < 0.0 { 0.0 } else { *value };
            }
        },
    );
}

/// Derivative of the ReLU: sets `gradient` to 0 where its output `activated` is 0.
pub fn relu_backward(activated: &[f32], gradient: &mut [f32]) {
    Arch::new().dispatch(
        #[inline(always)]
        || {
            for (gradient, &value) in gradient.iter_mut().zip(activated) {
                *gradient = if value > 0.0 { *gradient } else { 0.0 };
            }
        },
    );
}

/// Sums `rows` over the batch into `sums`, first row first: the derivative of a bias.
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

/// Soft (Polyak) update of target parameters: `target += tau * (source - target)`.
///
/// # Source
/// Lillicrap et al. (2015), algorithm 1: `tau * source + (1 - tau) * target`.
pub fn soft_update(target: &mut [f32], source: &[f32], tau: f32) {
    Arch::new().dispatch(
        #[inline(always)]
        || {
            for (target, &source) in target.iter_mut().zip(source) {
                *target += tau * (source - *target);
            }
        },
    );
}

/// The constants of one Adam step. Both bias corrections are folded into `size` and
/// `epsilon`, so that the loop needs no power and no second division.
#[derive(Debug, Clone, Copy)]
pub struct AdamStep {
    /// Decay of the first moment, the mean of the gradients.
    pub beta1: f32,
    /// Decay of the second moment, the mean of the squared gradients.
    pub beta2: f32,
    /// `learning rate * sqrt(1 - beta2^t) / (1 - beta1^t)` at step `t`.
    pub size: f32,
    /// `epsilon * sqrt(1 - beta2^t)`.
    pub epsilon: f32,
}

/// One Adam step over all parameters, in one pass over memory.
///
/// # Source
/// Kingma & Ba (2015), algorithm 1.
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
                // Both moments as exponential moving averages: m += (1 - beta) (g - m).
                *mean += (1.0 - step.beta1) * (gradient - *mean);
                *square += (1.0 - step.beta2) * (gradient * gradient - *square);
                // Against the gradient, corrected by `size` and `epsilon`.
                *parameter -= step.size * *mean / (square.sqrt() + step.epsilon);
            }
        },
    );
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn products_of_transposed_and_strided_matrices_match_a_hand_worked_case() {
        // Two rows of two, three apart.
        let left = [9.0, 1.0, 2.0, 9.0, 3.0, 4.0];
        let left = Matrix::rows(&left, 1, 2, 2, 3);
        let right = [5.0, 6.0, 7.0, 8.0];
        let right = Matrix::dense(&right, 2);
        let mut product = [100.0; 4];

        multiply(&mut product, left, right, Output::Overwrite);
        assert_eq!(product, [19.0, 22.0, 43.0, 50.0]);

        multiply(&mut product, left.transposed(), right, Output::Accumulate);
        assert_eq!(product, [19.0 + 26.0, 22.0 + 30.0, 43.0 + 38.0, 50.0 + 44.0]);

        multiply(&mut product, left, right.transposed(), Output::Overwrite);
        assert_eq!(product, [17.0, 23.0, 39.0, 53.0]);
    }

    #[test]
    #[should_panic(expected = "exceeds its slice")]
    fn a_matrix_beyond_its_slice_is_refused() {
        let _ = Matrix::rows(&[0.0; 5], 0, 2, 2, 4);
    }

    #[test]
    #[should_panic(expected = "inner dimensions")]
    fn factors_that_do_not_fit_are_refused() {
        let numbers = [0.0; 6];
        multiply(&mut [0.0; 4], Matrix::dense(&numbers, 3), Matrix::dense(&numbers, 3), Output::Overwrite);
    }

    #[test]
    fn loops_reach_the_last_number_of_an_odd_length() {
        let mut values: Vec<f32> = (0..67).map(|i| i as f32 - 33.0).collect();
        let activated: Vec<f32> = values.iter().map(|v| v.max(0.0)).collect();
        let mut gradient = vec![1.0; 67];

        relu(&mut values);
        let mut not_a_number = [f32::NAN];
        relu(&mut not_a_number);
        relu_backward(&activated, &mut gradient);

        assert_eq!(values, activated);
        assert!(not_a_number[0].is_nan());
        assert_eq!(gradient.iter().sum::<f32>(), 33.0);
        let mut sums = [7.0; 3];
        sum_rows(&[1.0, 2.0, 3.0, 10.0, 20.0, 30.0], &mut sums);
        assert_eq!(sums, [11.0, 22.0, 33.0]);
    }
}
