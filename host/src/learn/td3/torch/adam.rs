//! Adam over one tensor of parameters.
//!
//! Holds the two moments and the step count. Written here, because a resumed run needs
//! them bit for bit and tch gives no access to those of libtorch's optimiser. Does not
//! depend on networks.

use super::networks::{read_row, tensor};
use crate::learn::td3::adam::{Adam, BETA1, BETA2, EPSILON};
use tch::{Device, TchError, Tensor};

/// The optimiser's state for all copies of a network.
///
/// # Source
/// Kingma & Ba (2015), algorithm 1, with its constants.
#[derive(Debug)]
pub struct TorchAdam {
    learning_rate: f64,
    steps: u64,
    /// First moment, shaped as the parameters.
    mean: Tensor,
    /// Second moment, shaped as the parameters.
    square: Tensor,
}

impl TorchAdam {
    /// Copies these states, one for each copy of the network, all after the same number of steps.
    pub fn of(adams: &[&Adam], device: Device) -> Result<Self, TchError> {
        let rows = |of: fn(&Adam) -> &[f32]| -> Vec<&[f32]> { adams.iter().map(|adam| of(adam)).collect() };
        Ok(Self {
            learning_rate: adams.first().map_or(0.0, |adam| adam.learning_rate),
            steps: adams.first().map_or(0, |adam| adam.steps),
            mean: tensor(&rows(|adam| &adam.mean), device)?,
            square: tensor(&rows(|adam| &adam.square), device)?,
        })
    }

    /// Copies the state of copy `copy` to `adam`.
    pub fn store(&self, copy: usize, adam: &mut Adam) -> Result<(), TchError> {
        adam.steps = self.steps;
        read_row(&self.mean, copy, &mut adam.mean)?;
        read_row(&self.square, copy, &mut adam.square)
    }

    /// Moves `parameters` one step against `gradients`.
    pub fn step(&mut self, parameters: &mut Tensor, gradients: &Tensor) -> Result<(), TchError> {
        self.steps += 1;
        let mean_correction = 1.0 - BETA1.powf(self.steps as f64);
        let root = (1.0 - BETA2.powf(self.steps as f64)).sqrt();
        let _ = self.mean.f_lerp_(gradients, 1.0 - BETA1)?;
        let _ = self.square.f_lerp_(&gradients.f_square()?, 1.0 - BETA2)?;
        // Both bias corrections are folded into scalars, as in the plain `Adam`.
        let mut denominator = self.square.f_sqrt()?;
        let _ = denominator.f_add_scalar_(EPSILON * root)?;
        let mut step = self.mean.f_div(&denominator)?;
        let _ = step.f_mul_scalar_(-self.learning_rate * root / mean_correction)?;
        let _ = parameters.f_add_(&step)?;
        Ok(())
    }
}
