//! A fully connected network on one flat slice of parameters.
//!
//! Holds the forward pass, its hand-written derivative and the layout of the
//! parameters. Does not depend on losses or optimisers.

use super::kernels::{self, Matrix, Output, multiply};
use super::policy::{DenseLayer, Policy};
use rand::Rng as _;
use rand_chacha::ChaCha8Rng;

/// Each layer's parameters start on a multiple of a cache line: 16 numbers of 4 bytes.
const ALIGNMENT: usize = 16;

/// Place of one layer in the flat slice: `weight[input][output]` and `bias[output]`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Span {
    /// Index of the first weight.
    pub weight: usize,
    /// Index of the first bias.
    pub bias: usize,
    /// Inputs of the layer.
    pub inputs: usize,
    /// Outputs of the layer.
    pub outputs: usize,
}

impl Span {
    fn weight(self, flat: &[f32]) -> &[f32] {
        &flat[self.weight..][..self.inputs * self.outputs]
    }

    fn bias(self, flat: &[f32]) -> &[f32] {
        &flat[self.bias..][..self.outputs]
    }
}

/// Hidden layers with ReLU, linear output.
#[derive(Debug, Clone, PartialEq)]
pub struct Mlp {
    spans: Vec<Span>,
    /// All parameters.
    pub parameters: Vec<f32>,
    /// All derivatives, laid out as `parameters`.
    pub gradients: Vec<f32>,
}

/// What the backward pass needs of a forward pass, and its working memory; the caller
/// keeps it, so that no pass allocates.
#[derive(Debug, Default)]
pub struct Activations {
    /// Each layer's output, `[batch, outputs]`, of hidden layers after the ReLU.
    outputs: Vec<Vec<f32>>,
    /// Derivatives by the output of a layer and of the layer below.
    gradients: [Vec<f32>; 2],
}

impl Activations {
    /// The network's output, `[batch, outputs]`.
    pub fn output(&self) -> &[f32] {
        self.outputs.last().map_or(&[], Vec::as_slice)
    }
}

impl Mlp {
    /// A network with these layer widths, input first, all zero.
    pub fn zeros(widths: &[usize]) -> Self {
        let mut end = 0;
        let mut place = |len: usize| {
            let start = end;
            end += len.next_multiple_of(ALIGNMENT);
            start
        };
        let spans = widths
            .windows(2)
            .map(|w| Span { weight: place(w[0] * w[1]), bias: place(w[1]), inputs: w[0], outputs: w[1] })
            .collect();
        Self { spans, parameters: vec![0.0; end], gradients: vec![0.0; end] }
    }

    /// Random parameters, uniform in plus or minus one over the root of a layer's inputs.
    ///
    /// # Source
    /// PyTorch's default for linear layers, which the paper's code uses.
    pub fn random(widths: &[usize], rng: &mut ChaCha8Rng) -> Self {
        let mut network = Self::zeros(widths);
        for span in &network.spans {
            let bound = 1.0 / (span.inputs as f32).sqrt();
            for (start, len) in [(span.weight, span.inputs * span.outputs), (span.bias, span.outputs)] {
                for value in &mut network.parameters[start..][..len] {
                    *value = rng.random_range(-bound..bound);
                }
            }
        }
        network
    }

    /// The network in the form that evaluates one observation at a time.
    pub fn policy(&self) -> Policy {
        Policy::new(self.layers_of(&self.parameters))
    }

    /// The layers in `flat`, which has the layout of `parameters`.
    pub fn layers_of(&self, flat: &[f32]) -> Vec<DenseLayer> {
        let layer =
            |span: &Span| DenseLayer { weight: span.weight(flat).to_vec(), bias: span.bias(flat).to_vec() };
        self.spans.iter().map(layer).collect()
    }

    /// Places of the layers in `parameters`, first layer first.
    pub fn spans(&self) -> &[Span] {
        &self.spans
    }

    /// Multiplications of a forward pass for one row; there are as many additions.
    pub fn multiplications(&self) -> usize {
        self.spans.iter().map(|span| span.inputs * span.outputs).sum()
    }

    /// The first layer's share of [`Self::multiplications`].
    pub fn first_multiplications(&self) -> usize {
        self.spans.first().map_or(0, |span| span.inputs * span.outputs)
    }

    /// Evaluates `input`, `[batch, inputs]`.
    pub fn forward(&self, input: Matrix<'_>, activations: &mut Activations) {
        activations.outputs.resize_with(self.spans.len(), Vec::new);
        for (depth, &span) in self.spans.iter().enumerate() {
            let (below, above) = activations.outputs.split_at_mut(depth);
            let output = &mut above[0];
            output.resize(input.row_count() * span.outputs, 0.0);
            let input = below.last().map_or(input, |below| Matrix::dense(below, span.inputs));
            // output = bias + input x weight, then the ReLU on hidden layers.
            kernels::repeat(span.bias(&self.parameters), output);
            let weight = Matrix::dense(span.weight(&self.parameters), span.outputs);
            multiply(output, input, weight, Output::Accumulate);
            if depth + 1 < self.spans.len() {
                kernels::relu(output);
            }
        }
    }

    /// Backpropagates the output's derivative, `[batch, outputs]`, into [`Self::gradients`].
    pub fn backward(&mut self, input: Matrix<'_>, activations: &mut Activations, output_gradient: &[f32]) {
        let Activations { outputs, gradients: [gradient, below] } = activations;
        gradient.clear();
        gradient.extend_from_slice(output_gradient);
        for (depth, &span) in self.spans.iter().enumerate().rev() {
            if depth + 1 < self.spans.len() {
                kernels::relu_backward(&outputs[depth], gradient);
            }
            let input = if depth == 0 { input } else { Matrix::dense(&outputs[depth - 1], span.inputs) };
            // d/dweight = input^T x d/doutput, d/dbias = sum of d/doutput over the batch.
            let by_output = Matrix::dense(gradient, span.outputs);
            let weight_gradient = &mut self.gradients[span.weight..][..span.inputs * span.outputs];
            multiply(weight_gradient, input.transposed(), by_output, Output::Overwrite);
            kernels::sum_rows(gradient, &mut self.gradients[span.bias..][..span.outputs]);
            // d/dinput = d/doutput x weight^T; the first layer's input is not learned.
            if depth > 0 {
                let weight = Matrix::dense(span.weight(&self.parameters), span.outputs);
                below.resize(input.row_count() * span.inputs, 0.0);
                multiply(below, by_output, weight.transposed(), Output::Overwrite);
                std::mem::swap(gradient, below);
            }
        }
    }

    /// Backpropagates the output's derivative to the inputs from `first` on and returns
    /// that, `[batch, inputs - first]`; [`Self::gradients`] stays unchanged.
    pub fn backward_to_input<'a>(
        &self,
        first: usize,
        activations: &'a mut Activations,
        output_gradient: &[f32],
    ) -> &'a [f32] {
        let Activations { outputs, gradients: [gradient, below] } = activations;
        gradient.clear();
        gradient.extend_from_slice(output_gradient);
        for (depth, &span) in self.spans.iter().enumerate().rev() {
            if depth + 1 < self.spans.len() {
                kernels::relu_backward(&outputs[depth], gradient);
            }
            let skipped = if depth == 0 { first } else { 0 };
            let wanted = span.inputs - skipped;
            let weight = span.weight(&self.parameters);
            let weight = Matrix::rows(weight, skipped * span.outputs, wanted, span.outputs, span.outputs);
            // d/dinput = d/doutput x weight^T.
            let by_output = Matrix::dense(gradient, span.outputs);
            below.resize(by_output.row_count() * wanted, 0.0);
            multiply(below, by_output, weight.transposed(), Output::Overwrite);
            std::mem::swap(gradient, below);
        }
        gradient
    }
}

/// For tests.
#[cfg(test)]
impl Mlp {
    /// Replaces the layers.
    pub fn set_layers(&mut self, layers: &[DenseLayer]) {
        for (span, layer) in self.spans.iter().zip(layers) {
            self.parameters[span.weight..][..layer.weight.len()].copy_from_slice(&layer.weight);
            self.parameters[span.bias..][..layer.bias.len()].copy_from_slice(&layer.bias);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::random::{Purpose, stream};
    use super::*;

    const INPUT: [f32; 12] = [0.1, -0.4, 0.9, 1.0, 0.3, -0.2, -0.7, 0.6, 0.5, 0.0, 0.2, -1.0];
    /// The loss's derivative by each output.
    const PULL: [f32; 8] = [0.3, -0.2, 1.0, 0.5, -0.7, 0.1, 0.4, -0.9];

    fn network() -> Mlp {
        Mlp::random(&[3, 5, 4, 2], &mut stream(5, Purpose::Initialise, 0))
    }

    fn loss(network: &Mlp, input: &[f32]) -> f64 {
        let mut activations = Activations::default();
        network.forward(Matrix::dense(input, 3), &mut activations);
        activations.output().iter().zip(PULL).map(|(o, p)| f64::from(*o) * f64::from(p)).sum()
    }

    /// Central difference.
    fn slope(mut loss_at: impl FnMut(f32) -> f64) -> f32 {
        const WAY: f32 = 1.0 / 1024.0;
        ((loss_at(WAY) - loss_at(-WAY)) / f64::from(2.0 * WAY)) as f32
    }

    #[test]
    fn derivatives_by_every_parameter_and_input_match_central_differences() {
        let mut network = network();
        let mut activations = Activations::default();
        network.forward(Matrix::dense(&INPUT, 3), &mut activations);

        network.backward(Matrix::dense(&INPUT, 3), &mut activations, &PULL);
        let by_input = network.backward_to_input(1, &mut activations, &PULL).to_vec();

        let mut moved = network.clone();
        for index in 0..network.parameters.len() {
            let slope = slope(|way| {
                moved.parameters[index] = network.parameters[index] + way;
                loss(&moved, &INPUT)
            });
            moved.parameters[index] = network.parameters[index];
            let got = network.gradients[index];
            assert!((got - slope).abs() < 1e-3, "parameter {index}: {got} {slope}");
        }
        assert!(network.gradients.iter().filter(|g| g.abs() > 1e-2).count() > 20, "nothing to compare");
        for row in 0..4 {
            for column in 1..3 {
                let mut moved = INPUT;
                let slope = slope(|way| {
                    moved[row * 3 + column] = INPUT[row * 3 + column] + way;
                    loss(&network, &moved)
                });
                let got = by_input[row * 2 + column - 1];
                assert!((got - slope).abs() < 1e-3, "input {row} {column}: {got} {slope}");
            }
        }
    }

    #[test]
    fn the_policys_action_is_the_tanh_of_the_networks_output() {
        let network = network();
        let mut policy = network.policy();
        let mut activations = Activations::default();

        network.forward(Matrix::dense(&INPUT, 3), &mut activations);

        for (row, wanted) in INPUT.chunks(3).zip(activations.output().chunks(2)) {
            let mut action = [0.0; 2];
            policy.act(row, &mut action);
            for (got, wanted) in action.iter().zip(wanted) {
                assert!((got - wanted.tanh()).abs() < 1e-6, "{action:?}");
            }
        }
    }

    /// A smaller batch after a larger one must not read what the larger one left.
    #[test]
    fn activations_can_be_used_again_for_another_batch_and_network() {
        let network = network();
        let mut used = Activations::default();
        let other = Mlp::random(&[3, 7, 1], &mut stream(4, Purpose::Initialise, 0));
        network.forward(Matrix::dense(&INPUT, 3), &mut used);
        other.forward(Matrix::dense(&INPUT, 3), &mut used);
        network.forward(Matrix::dense(&INPUT[..6], 3), &mut used);
        let mut fresh = Activations::default();

        network.forward(Matrix::dense(&INPUT[..6], 3), &mut fresh);

        assert_eq!(used.output(), fresh.output());
    }
}
