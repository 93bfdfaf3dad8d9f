//! Adam over one flat slice of parameters.
//!
//! Holds the two moments and the step count, which a resumed run needs bit for bit.
//! Does not depend on networks.

use super::kernels::{self, AdamStep};

/// Decay of the first moment.
pub(super) const BETA1: f64 = 0.9;
/// Decay of the second moment.
pub(super) const BETA2: f64 = 0.999;
/// Avoids a division by zero.
pub(super) const EPSILON: f64 = 1e-8;

/// The optimiser's state for one network.
///
/// # Source
/// Kingma & Ba (2015), algorithm 1, with its constants.
#[derive(Debug, Clone, PartialEq)]
pub struct Adam {
    pub(super) learning_rate: f64,
    /// Steps taken.
    pub steps: u64,
    /// First moment, one number a parameter.
    pub mean: Vec<f32>,
    /// Second moment, one number a parameter.
    pub square: Vec<f32>,
}

impl Adam {
    /// An optimiser of so many parameters before its first step.
    pub fn new(parameters: usize, learning_rate: f64) -> Self {
        Self { learning_rate, steps: 0, mean: vec![0.0; parameters], square: vec![0.0; parameters] }
    }

    /// Moves `parameters` one step against `gradients`.
    pub fn step(&mut self, parameters: &mut [f32], gradients: &[f32]) {
        self.steps += 1;
        let mean_correction = 1.0 - BETA1.powf(self.steps as f64);
        let root = (1.0 - BETA2.powf(self.steps as f64)).sqrt();
        // mean/c1 / (sqrt(square/c2) + eps), with both corrections pulled out of
        // the loop: sqrt(c2)/c1 · mean / (sqrt(square) + eps·sqrt(c2)).
        let step = AdamStep {
            beta1: BETA1 as f32,
            beta2: BETA2 as f32,
            size: (self.learning_rate * root / mean_correction) as f32,
            epsilon: (EPSILON * root) as f32,
        };
        kernels::adam(step, parameters, gradients, &mut self.mean, &mut self.square);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_steps_follow_a_hand_worked_case() {
        let mut parameters = [1.0_f32, -1.0];
        let mut adam = Adam::new(2, 0.1);

        adam.step(&mut parameters, &[0.5, -2.0]);

        // After one step both corrected moments are those of the derivative
        // itself: the step is the learning rate against its sign.
        assert!((parameters[0] - 0.9).abs() < 1e-6 && (parameters[1] + 0.9).abs() < 1e-6, "{parameters:?}");

        adam.step(&mut parameters, &[-0.25, 0.0]);

        // First: mean 0.9·0.05 - 0.1·0.25 = 0.02, corrected /0.19 = 0.105263;
        // square 0.999·0.00025 + 0.001·0.0625 = 0.00031225, corrected /0.001999 = 0.156203;
        // step 0.1 · 0.105263 / 0.395225 = 0.026634.
        // Second: mean 0.9·-0.2 = -0.18, /0.19 = -0.947368;
        // square 0.999·0.004 = 0.003996, /0.001999 = 1.998999; step -0.067006.
        assert!((parameters[0] - (0.9 - 0.026_634)).abs() < 2e-6, "{parameters:?}");
        assert!((parameters[1] - (-0.9 + 0.067_006)).abs() < 2e-6, "{parameters:?}");
    }
}
