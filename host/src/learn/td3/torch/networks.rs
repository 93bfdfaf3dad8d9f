//! Fully connected networks in libtorch's tensors.
//!
//! Holds the forward pass and its hand-written derivative: with networks this narrow,
//! autograd's overhead is a third of an update. Does not depend on losses. The layout
//! of the parameters is [`Mlp`]'s, so that they are copied without conversion.
//!
//! Twin critics are two copies: every tensor has the copy as its first dimension, and
//! one batched product serves both.

use crate::learn::td3::networks::{Mlp, Span};
use tch::{Device, TchError, Tensor};

/// One or two networks of the same shape: hidden layers with ReLU, linear output.
#[derive(Debug)]
pub struct Networks {
    /// All parameters, `[copies, numbers]`; the layers are views of it.
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

impl Layer {
    fn new(span: &Span, parameters: &Tensor, gradients: &Tensor) -> Result<Self, TchError> {
        let copies = parameters.size()[0];
        let part = |flat: &Tensor, start: usize, rows: usize| {
            let shape = [copies, rows as i64, span.outputs as i64];
            flat.f_narrow(1, start as i64, (rows * span.outputs) as i64)?.f_view(shape)
        };
        Ok(Self {
            weight: part(parameters, span.weight, span.inputs)?,
            bias: part(parameters, span.bias, 1)?,
            weight_gradient: part(gradients, span.weight, span.inputs)?,
            bias_gradient: part(gradients, span.bias, 1)?,
        })
    }
}

/// What the backward pass needs of a forward pass: each layer's input, then the output.
#[derive(Debug)]
pub struct Activations(Vec<Tensor>);

impl Activations {
    /// The networks' output, `[copies, batch, outputs]`.
    pub fn output(&self) -> &Tensor {
        // Never empty: it holds at least the input.
        &self.0[self.0.len() - 1]
    }
}

/// Which derivatives a backward pass computes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Wanted {
    /// The parameters' derivatives, into [`Networks::gradients`].
    Parameters,
    /// The input's derivative only; [`Networks::gradients`] stays unchanged.
    Input,
}

impl Networks {
    /// Copies of these networks, at least one, all of the same shape.
    pub fn of(networks: &[&Mlp], device: Device) -> Result<Self, TchError> {
        let flats: Vec<&[f32]> = networks.iter().map(|network| &network.parameters[..]).collect();
        let parameters = tensor(&flats, device)?;
        let gradients = parameters.f_zeros_like()?;
        let spans = networks.first().map_or(&[][..], |network| network.spans());
        let layers = spans.iter().map(|span| Layer::new(span, &parameters, &gradients));
        Ok(Self { layers: layers.collect::<Result<_, _>>()?, parameters, gradients })
    }

    /// Evaluates every copy on `input`, `[batch, inputs]`.
    pub fn forward(&self, input: &Tensor) -> Result<Activations, TchError> {
        self.forward_copies(input, self.parameters.size()[0])
    }

    /// Evaluates the first copy alone; `output` is `[1, batch, outputs]`.
    pub fn forward_first(&self, input: &Tensor) -> Result<Activations, TchError> {
        self.forward_copies(input, 1)
    }

    fn forward_copies(&self, input: &Tensor, copies: i64) -> Result<Activations, TchError> {
        let mut tensors = Vec::with_capacity(self.layers.len() + 1);
        tensors.push(input.f_unsqueeze(0)?.f_expand([copies, -1, -1], false)?);
        for (depth, layer) in self.layers.iter().enumerate() {
            let (weight, bias) = (layer.weight.f_narrow(0, 0, copies)?, layer.bias.f_narrow(0, 0, copies)?);
            let mut sum = bias.f_baddbmm(&tensors[depth], &weight, 1.0, 1.0)?;
            if depth + 1 < self.layers.len() {
                sum = sum.f_relu_()?;
            }
            tensors.push(sum);
        }
        Ok(Activations(tensors))
    }

    /// Backpropagates `output_gradient`, `[copies, batch, outputs]`; returns the input's
    /// derivative, `[copies, batch, inputs]`, where it is wanted.
    pub fn backward(
        &mut self,
        activations: &Activations,
        output_gradient: Tensor,
        wanted: Wanted,
    ) -> Result<Option<Tensor>, TchError> {
        let copies = output_gradient.size()[0];
        let mut gradient = output_gradient;
        for (depth, layer) in self.layers.iter().enumerate().rev() {
            if depth + 1 < self.layers.len() {
                gradient = activations.0[depth + 1].f_threshold_backward(&gradient, 0.0)?;
            }
            if wanted == Wanted::Parameters {
                let input = activations.0[depth].f_transpose(1, 2)?;
                let _ = input.f_bmm_out(&layer.weight_gradient, &gradient)?;
                let _ = gradient.f_sum_intlist_out(&layer.bias_gradient, [1_i64].as_slice(), true, None)?;
                if depth == 0 {
                    return Ok(None);
                }
            }
            gradient = gradient.f_bmm(&layer.weight.f_narrow(0, 0, copies)?.f_transpose(1, 2)?)?;
        }
        Ok(Some(gradient))
    }
}

/// A tensor `[rows.len(), numbers]` of rows of equal length.
pub fn tensor(rows: &[&[f32]], device: Device) -> Result<Tensor, TchError> {
    Tensor::f_from_slice(&rows.concat())?.f_view([rows.len() as i64, -1])?.f_to(device)
}

/// Copies row `row` into `numbers`, which has the same length.
pub fn read_row(tensor: &Tensor, row: usize, numbers: &mut [f32]) -> Result<(), TchError> {
    let row = tensor.f_select(0, row as i64)?.f_to(Device::Cpu)?;
    let len = numbers.len();
    row.f_copy_data(numbers, len)
}
