//! Fully connected networks on flat parameter tensors.
//!
//! Owns the forward pass, its hand-written derivative and the layout of the
//! parameters. Refuses to know losses and optimisers. The derivative is written
//! out because a 128-wide network spends a third of an update in autograd's
//! bookkeeping; a test holds it against libtorch's own.
//!
//! Twin critics are two copies evaluated side by side: every tensor has the
//! copy as its first dimension and one batched product serves both.

use super::policy::{DenseLayer, Policy};
use rand::Rng as _;
use rand_chacha::ChaCha8Rng;
use tch::{Device, Kind, Tensor};

/// Every layer's parameters start on a cache line: 16 numbers of 4 bytes.
const ALIGNMENT: usize = 16;

/// Where one layer's numbers lie in the flat tensor.
#[derive(Debug, Clone, Copy)]
struct Span {
    start: i64,
    copies: i64,
    inputs: i64,
    outputs: i64,
}

impl Span {
    fn len(self) -> i64 {
        self.copies * self.inputs * self.outputs
    }

    fn of(self, flat: &Tensor) -> Tensor {
        flat.narrow(0, self.start, self.len()).view([self.copies, self.inputs, self.outputs])
    }
}

/// One or two networks of the same shape: rectified hidden layers, linear output.
#[derive(Debug)]
pub struct Mlp {
    spans: Vec<(Span, Span)>,
    /// All parameters, `[n]`; the layers are views of it.
    pub parameters: Tensor,
    /// All derivatives, laid out as `parameters`.
    pub gradients: Tensor,
    layers: Vec<Layer>,
}

/// Views into the flat tensors: `[copies, inputs, outputs]` and `[copies, 1, outputs]`.
#[derive(Debug)]
struct Layer {
    weight: Tensor,
    bias: Tensor,
    weight_gradient: Tensor,
    bias_gradient: Tensor,
}

/// What a forward pass leaves for the backward pass: each layer's input, then the output.
#[derive(Debug)]
pub struct Activations(Vec<Tensor>);

impl Activations {
    /// The networks' answer, `[copies, batch, outputs]`.
    pub fn output(&self) -> &Tensor {
        &self.0[self.0.len() - 1]
    }
}

/// What a backward pass computes beside the derivative it is given.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Wanted {
    /// The parameters' derivatives, into [`Mlp::gradients`].
    Parameters,
    /// The input's derivative alone; [`Mlp::gradients`] keeps what it had.
    Input,
}

impl Mlp {
    /// `copies` networks with these layer widths, input first, all zero.
    pub fn zeros(copies: usize, widths: &[usize]) -> Self {
        let mut end = 0;
        let mut span = |inputs: usize, outputs: usize| {
            let start = end as i64;
            end += (copies * inputs * outputs).next_multiple_of(ALIGNMENT);
            Span { start, copies: copies as i64, inputs: inputs as i64, outputs: outputs as i64 }
        };
        let spans: Vec<_> = widths.windows(2).map(|w| (span(w[0], w[1]), span(1, w[1]))).collect();
        let parameters = Tensor::zeros([end as i64], (Kind::Float, Device::Cpu));
        let gradients = parameters.zeros_like();
        let layers = spans
            .iter()
            .map(|(weight, bias)| Layer {
                weight: weight.of(&parameters),
                bias: bias.of(&parameters),
                weight_gradient: weight.of(&gradients),
                bias_gradient: bias.of(&gradients),
            })
            .collect();
        Self { spans, parameters, gradients, layers }
    }

    /// Random parameters, uniform in plus or minus one over the root of a layer's inputs.
    ///
    /// # Source
    /// PyTorch's default for linear layers, which the paper's code uses.
    pub fn random(copies: usize, widths: &[usize], rng: &mut ChaCha8Rng) -> Self {
        let mut network = Self::zeros(copies, widths);
        let mut flat = vec![0.0_f32; network.parameters.numel()];
        for (weight, bias) in &network.spans {
            let bound = 1.0 / (weight.inputs as f32).sqrt();
            for span in [weight, bias] {
                let start = span.start as usize;
                for value in &mut flat[start..start + span.len() as usize] {
                    *value = rng.random_range(-bound..bound);
                }
            }
        }
        network.load(&flat);
        network
    }

    /// A network of the same shape and numbers in memory of its own.
    pub fn duplicate(&self) -> Self {
        let mut widths: Vec<usize> = self.spans.iter().map(|(weight, _)| weight.inputs as usize).collect();
        widths.extend(self.spans.last().map(|(weight, _)| weight.outputs as usize));
        let mut twin = Self::zeros(self.spans[0].0.copies as usize, &widths);
        twin.parameters.copy_(&self.parameters);
        twin
    }

    /// Replaces all parameters; `flat` has as many numbers as `parameters`.
    pub fn load(&mut self, flat: &[f32]) {
        self.parameters.copy_(&Tensor::from_slice(flat));
    }

    /// The first copy in plain memory.
    pub fn policy(&self) -> Policy {
        Policy::new(dense(&self.spans, &numbers(&self.parameters), 0))
    }

    /// Evaluates every copy on `input`, `[batch, inputs]`.
    pub fn forward(&self, input: &Tensor) -> Activations {
        self.forward_copies(input, self.spans[0].0.copies)
    }

    /// Evaluates the first copy alone; `output` is `[1, batch, outputs]`.
    pub fn forward_first(&self, input: &Tensor) -> Activations {
        self.forward_copies(input, 1)
    }

    fn forward_copies(&self, input: &Tensor, copies: i64) -> Activations {
        let batch = input.size()[0];
        let mut tensors = Vec::with_capacity(self.layers.len() + 1);
        tensors.push(input.unsqueeze(0).expand([copies, batch, input.size()[1]], false));
        for (depth, layer) in self.layers.iter().enumerate() {
            let (weight, bias) = (layer.weight.narrow(0, 0, copies), layer.bias.narrow(0, 0, copies));
            let mut sum = bias.baddbmm(&tensors[depth], &weight, 1.0, 1.0);
            if depth + 1 < self.layers.len() {
                sum = sum.relu_();
            }
            tensors.push(sum);
        }
        Activations(tensors)
    }

    /// Carries `output_gradient` (`[copies, batch, outputs]`) back; answers the
    /// input's derivative (`[copies, batch, inputs]`) where that is wanted.
    pub fn backward(
        &mut self,
        activations: &Activations,
        output_gradient: Tensor,
        wanted: Wanted,
    ) -> Option<Tensor> {
        let copies = output_gradient.size()[0];
        let mut gradient = output_gradient;
        for (depth, layer) in self.layers.iter().enumerate().rev() {
            if depth + 1 < self.layers.len() {
                gradient = activations.0[depth + 1].threshold_backward(&gradient, 0.0);
            }
            if wanted == Wanted::Parameters {
                let input = activations.0[depth].transpose(1, 2);
                let _ = input.bmm_out(&layer.weight_gradient, &gradient);
                let _ = gradient.sum_intlist_out(&layer.bias_gradient, [1_i64].as_slice(), true, None);
                if depth == 0 {
                    return None;
                }
            }
            gradient = gradient.bmm(&layer.weight.narrow(0, 0, copies).transpose(1, 2));
        }
        Some(gradient)
    }
}

/// One copy's layers out of flat numbers laid out as these spans.
fn dense(spans: &[(Span, Span)], flat: &[f32], copy: usize) -> Vec<DenseLayer> {
    let part = |span: &Span| {
        let len = (span.inputs * span.outputs) as usize;
        flat[span.start as usize + copy * len..][..len].to_vec()
    };
    spans.iter().map(|(w, b)| DenseLayer { weight: part(w), bias: part(b) }).collect()
}

/// A tensor's numbers, last dimension fastest.
pub fn numbers(tensor: &Tensor) -> Vec<f32> {
    let mut numbers = vec![0.0; tensor.numel()];
    let len = numbers.len();
    tensor.copy_data(&mut numbers, len);
    numbers
}

/// What only tests ask for.
#[cfg(test)]
impl Mlp {
    /// A copy's layers, as `parameters` or `gradients` (laid out alike) have them.
    pub fn layers_of(&self, flat: &Tensor, copy: usize) -> Vec<DenseLayer> {
        dense(&self.spans, &numbers(flat), copy)
    }

    /// Replaces a copy's layers.
    pub fn set_layers(&mut self, copy: usize, layers: &[DenseLayer]) {
        let mut flat = numbers(&self.parameters);
        for ((weight, bias), layer) in self.spans.iter().zip(layers) {
            for (span, values) in [(weight, &layer.weight), (bias, &layer.bias)] {
                flat[span.start as usize + copy * values.len()..][..values.len()].copy_from_slice(values);
            }
        }
        self.load(&flat);
    }
}

#[cfg(test)]
mod tests {
    use super::super::random::{Purpose, stream};
    use super::*;

    fn network() -> Mlp {
        Mlp::random(2, &[3, 5, 4, 2], &mut stream(3, Purpose::Initialise, 0))
    }

    fn input() -> Tensor {
        Tensor::from_slice(&[0.1_f32, -0.4, 0.9, 1.0, 0.3, -0.2, -0.7, 0.6, 0.5, 0.0, 0.2, -1.0]).view([4, 3])
    }

    fn assert_close(got: &Tensor, want: &Tensor) {
        assert_eq!(got.size(), want.size());
        assert!(want.abs().max().double_value(&[]) > 1e-3, "nothing to compare");
        let difference = (got - want).abs().max().double_value(&[]);
        assert!(difference < 1e-5, "{difference}");
    }

    /// The derivatives written out by hand, against libtorch's own.
    #[test]
    fn derivatives_agree_with_autograd() {
        let mut network = network();
        let leaf = network.parameters.copy().set_requires_grad(true);
        let input_leaf = input().unsqueeze(0).repeat([2, 1, 1]).set_requires_grad(true);
        let mut value = input_leaf.shallow_clone();
        for (depth, (weight, bias)) in network.spans.iter().enumerate() {
            value = value.matmul(&weight.of(&leaf)) + bias.of(&leaf);
            value = if depth + 1 < network.spans.len() { value.relu() } else { value };
        }
        let pull = value.detach().sin();
        let loss = (&value * &pull).sum(Kind::Float);
        let wanted = Tensor::run_backward(&[&loss], &[&leaf, &input_leaf], false, false);

        let activations = network.forward(&input());
        network.backward(&activations, pull.shallow_clone(), Wanted::Parameters);
        let by_input = network.backward(&activations, pull, Wanted::Input).unwrap();

        assert_close(activations.output(), &value.detach());
        assert_close(&network.gradients, &wanted[0]);
        assert_close(&by_input, &wanted[1]);
    }

    #[test]
    fn the_plain_policy_says_what_the_first_copy_says() {
        let network = network();
        let mut policy = network.policy();
        let wanted = network.forward_first(&input()).output().tanh();

        let mut got = Vec::new();
        for row in numbers(&input()).chunks(3) {
            let mut action = [0.0; 2];
            policy.act(row, &mut action);
            got.extend(action);
        }

        assert_close(&Tensor::from_slice(&got).view([1, 4, 2]), &wanted);
    }

    #[test]
    fn both_copies_start_apart() {
        let output = network().forward(&input()).output().shallow_clone();

        assert!((output.get(0) - output.get(1)).abs().max().double_value(&[]) > 1e-3);
    }
}
