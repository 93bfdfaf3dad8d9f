//! A trained actor: observation in, action out.
//!
//! Holds the forward pass of one observation and the policy file. Does not depend on
//! the learner: gathering, recording and playing need nothing else.

use super::tensor_file::{TensorFile, TensorFileError};
use std::path::Path;

/// A layer with `weight[input][output]`, so that the inner loop runs along memory and
/// the compiler can use vector instructions.
#[derive(Debug, Clone, PartialEq)]
pub struct DenseLayer {
    /// `inputs * outputs` numbers.
    pub weight: Vec<f32>,
    /// `outputs` numbers.
    pub bias: Vec<f32>,
}

impl DenseLayer {
    fn inputs(&self) -> usize {
        self.weight.len() / self.bias.len()
    }
}

/// Hidden layers with ReLU and a hyperbolic tangent at the end.
#[derive(Debug, Clone, PartialEq)]
pub struct Policy {
    layers: Vec<DenseLayer>,
    scratch: [Vec<f32>; 2],
}

impl Policy {
    /// A policy of these layers, at least one; each has as many inputs as the one before has outputs.
    pub fn new(layers: Vec<DenseLayer>) -> Self {
        Self { layers, scratch: [Vec::new(), Vec::new()] }
    }

    /// Numbers in an observation.
    pub fn observation_len(&self) -> usize {
        self.layers.first().map_or(0, DenseLayer::inputs)
    }

    /// Numbers in an action.
    pub fn action_len(&self) -> usize {
        self.layers.last().map_or(0, |layer| layer.bias.len())
    }

    /// Whether no weight is NaN or infinite.
    pub fn is_finite(&self) -> bool {
        self.layers.iter().all(|layer| layer.weight.iter().chain(&layer.bias).all(|w| w.is_finite()))
    }

    /// The action for an observation, each between -1 and 1.
    pub fn act(&mut self, observation: &[f32], action: &mut [f32]) {
        let [input, output] = &mut self.scratch;
        input.clear();
        input.extend_from_slice(observation);
        let last = self.layers.len() - 1;
        for (depth, layer) in self.layers.iter().enumerate() {
            output.clear();
            output.extend_from_slice(&layer.bias);
            for (&x, weights) in input.iter().zip(layer.weight.chunks_exact(layer.bias.len())) {
                // The ReLU makes half of the inputs 0.
                if x != 0.0 {
                    for (sum, &weight) in output.iter_mut().zip(weights) {
                        *sum += x * weight;
                    }
                }
            }
            if depth < last {
                for value in output.iter_mut() {
                    *value = value.max(0.0);
                }
            }
            std::mem::swap(input, output);
        }
        for (action, &value) in action.iter_mut().zip(input.iter()) {
            *action = value.tanh();
        }
    }

    /// Writes the weights as `layer1.weight` (`[outputs, inputs]`, as in PyTorch),
    /// `layer1.bias` and so on.
    ///
    /// # Errors
    /// [`TensorFileError`] with the old file still in place.
    pub fn save(&self, path: &Path) -> Result<(), TensorFileError> {
        let mut file = TensorFile::new(path);
        for (number, layer) in self.layers.iter().enumerate() {
            let (inputs, outputs) = (layer.inputs(), layer.bias.len());
            let weight = transposed(&layer.weight, inputs, outputs);
            file.put(weight_name(number), &[outputs, inputs], weight);
            file.put(bias_name(number), &[outputs], layer.bias.clone());
        }
        file.save()
    }

    /// Reads what [`Self::save`] wrote.
    ///
    /// # Errors
    /// [`TensorFileError`] if there is no file, or it holds no network.
    pub fn load(path: &Path) -> Result<Self, TensorFileError> {
        let mut file = TensorFile::load(path)?;
        let mut layers: Vec<DenseLayer> = Vec::new();
        while layers.is_empty() || file.has(&weight_name(layers.len())) {
            let name = weight_name(layers.len());
            let weight = file.take(&name)?;
            let bias = file.take(&bias_name(layers.len()))?.numbers;
            let width = layers.last().map(|before| before.bias.len());
            match weight.shape[..] {
                [outputs, inputs]
                    if outputs == bias.len() && outputs * inputs > 0 && width.is_none_or(|w| w == inputs) =>
                {
                    layers.push(DenseLayer { weight: transposed(&weight.numbers, outputs, inputs), bias });
                }
                _ => return Err(file.misfit(&name)),
            }
        }
        Ok(Self::new(layers))
    }
}

fn weight_name(layer: usize) -> String {
    format!("layer{}.weight", layer + 1)
}

fn bias_name(layer: usize) -> String {
    format!("layer{}.bias", layer + 1)
}

/// `matrix`, `[rows, columns]`, as `[columns, rows]`.
fn transposed(matrix: &[f32], rows: usize, columns: usize) -> Vec<f32> {
    (0..columns).flat_map(|c| (0..rows).map(move |r| matrix[r * columns + c])).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn two_layers() -> Policy {
        let first = DenseLayer { weight: vec![1.0, -1.0, 2.0, 0.5, 0.0, 1.0], bias: vec![0.5, -0.25, 0.0] };
        let second = DenseLayer { weight: vec![0.5, -1.0, 0.25], bias: vec![0.1] };
        Policy::new(vec![first, second])
    }

    #[test]
    fn the_forward_pass_follows_a_hand_worked_case() {
        let mut action = [0.0];

        two_layers().act(&[1.0, -1.0], &mut action);

        // Hidden: 1 - 0.5 + 0.5 = 1; -1 - 0 - 0.25 < 0, so 0; 2 - 1 = 1.
        // Output: 0.1 + 0.5 + 0.25 = 0.85.
        assert!((action[0] - 0.85_f32.tanh()).abs() < 1e-6, "{action:?}");
    }

    #[test]
    fn a_saved_policy_comes_back_as_it_was() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("policy.safetensors");

        two_layers().save(&path).unwrap();

        assert_eq!(Policy::load(&path).unwrap(), two_layers());
        assert_eq!((two_layers().observation_len(), two_layers().action_len()), (2, 1));
    }

    #[test]
    fn a_cut_file_is_an_error_that_names_it() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("policy.safetensors");
        two_layers().save(&path).unwrap();
        let whole = std::fs::read(&path).unwrap();

        for len in [0, 7, 40, whole.len() - 1] {
            std::fs::write(&path, &whole[..len]).unwrap();

            let error = Policy::load(&path).unwrap_err().to_string();

            assert!(error.contains("policy.safetensors"), "{error}");
        }
    }

    #[test]
    fn layers_that_do_not_follow_one_another_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("policy.safetensors");
        let mut broken = two_layers();
        broken.layers[1].weight.push(1.0);
        broken.layers[1].weight.push(1.0);
        broken.layers[1].weight.push(1.0);

        broken.save(&path).unwrap();

        assert!(
            matches!(Policy::load(&path), Err(TensorFileError::Shape { name, .. }) if name == "layer2.weight")
        );
    }

    #[test]
    fn a_weight_that_is_nan_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("policy.safetensors");
        let mut broken = two_layers();
        broken.layers[0].bias[0] = f32::NAN;

        broken.save(&path).unwrap();

        assert!(
            matches!(Policy::load(&path), Err(TensorFileError::NotFinite { name, .. }) if name == "layer1.bias")
        );
    }
}
