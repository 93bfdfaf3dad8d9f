//! Adam over one flat tensor.
//!
//! Owns the two moments and the step count; written here because a resumed run
//! needs them back bit for bit and libtorch's optimiser in tch hides them.

use tch::Tensor;

/// Decay of the mean of the derivatives.
const BETA1: f64 = 0.9;
/// Decay of the mean of their squares.
const BETA2: f64 = 0.999;
/// Keeps the division finite.
const EPSILON: f64 = 1e-8;

/// The optimiser's state for one parameter tensor.
///
/// # Source
/// Kingma & Ba (2015), algorithm 1, with its constants.
#[derive(Debug)]
pub struct Adam {
    learning_rate: f64,
    /// Steps taken.
    pub steps: u64,
    /// First moment, as long as the parameters.
    pub mean: Tensor,
    /// Second moment, as long as the parameters.
    pub square: Tensor,
}

impl Adam {
    /// An optimiser that has seen nothing yet.
    pub fn new(parameters: &Tensor, learning_rate: f64) -> Self {
        Self { learning_rate, steps: 0, mean: parameters.zeros_like(), square: parameters.zeros_like() }
    }

    /// Moves `parameters` one step against `gradients`.
    pub fn step(&mut self, parameters: &mut Tensor, gradients: &Tensor) {
        self.steps += 1;
        let mean_correction = 1.0 - BETA1.powf(self.steps as f64);
        let square_correction = 1.0 - BETA2.powf(self.steps as f64);
        let _ = self.mean.lerp_(gradients, 1.0 - BETA1);
        let _ = self.square.lerp_(&gradients.square(), 1.0 - BETA2);
        // mean/c1 / (sqrt(square/c2) + eps), with both corrections pulled out of
        // the tensors: sqrt(c2)/c1 · mean / (sqrt(square) + eps·sqrt(c2)).
        let root = square_correction.sqrt();
        let mut denominator = self.square.sqrt();
        let _ = denominator.g_add_scalar_(EPSILON * root);
        let mut step = &self.mean / &denominator;
        let _ = step.g_mul_scalar_(-self.learning_rate * root / mean_correction);
        let _ = parameters.g_add_(&step);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_steps_follow_a_hand_worked_case() {
        let mut parameters = Tensor::from_slice(&[1.0_f32, -1.0]);
        let mut adam = Adam::new(&parameters, 0.1);

        adam.step(&mut parameters, &Tensor::from_slice(&[0.5_f32, -2.0]));

        // After one step both corrected moments are those of the derivative
        // itself: the step is the learning rate against its sign.
        let after_one = [parameters.double_value(&[0]), parameters.double_value(&[1])];
        assert!((after_one[0] - 0.9).abs() < 1e-6 && (after_one[1] + 0.9).abs() < 1e-6, "{after_one:?}");

        adam.step(&mut parameters, &Tensor::from_slice(&[-0.25_f32, 0.0]));

        // First: mean 0.9·0.05 - 0.1·0.25 = 0.02, corrected /0.19 = 0.105263;
        // square 0.999·0.00025 + 0.001·0.0625 = 0.00031225, corrected /0.001999 = 0.156203;
        // step 0.1 · 0.105263 / 0.395225 = 0.026634.
        // Second: mean 0.9·-0.2 = -0.18, /0.19 = -0.947368;
        // square 0.999·0.004 = 0.003996, /0.001999 = 1.998999; step -0.067006.
        let after_two = [parameters.double_value(&[0]), parameters.double_value(&[1])];
        assert!((after_two[0] - (0.9 - 0.026_634)).abs() < 2e-6, "{after_two:?}");
        assert!((after_two[1] - (-0.9 + 0.067_006)).abs() < 2e-6, "{after_two:?}");
    }
}
