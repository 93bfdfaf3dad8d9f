//! The TD3 update on libtorch, on the CPU or on a GPU.
//!
//! Holds the agent's numbers as tensors while it learns. Does not initialise or save
//! any: it copies them from an [`Agent`] and back. Networks, losses, optimiser and
//! noise are the agent's; the order of summation differs, so that both agree to
//! rounding and not bit for bit.

mod adam;
mod networks;

use super::agent::{Agent, Losses};
use super::config::Td3Config;
use super::networks::Mlp;
use super::replay::Layout;
use adam::TorchAdam;
use networks::{Activations, Networks, Wanted, read_row};
use tch::{Device, Kind, TchError, Tensor};

/// Actor, critics, target networks and optimisers on one device.
#[derive(Debug)]
pub struct TorchAgent {
    config: Td3Config,
    layout: Layout,
    device: Device,
    actor: Networks,
    critics: Networks,
    target_actor: Networks,
    target_critics: Networks,
    actor_adam: TorchAdam,
    critics_adam: TorchAdam,
    updates: u64,
    latest: Latest,
}

/// Tensors that the losses are computed from on request; fetching after every update would cost time.
#[derive(Debug, Default)]
struct Latest {
    /// Target values of both critics, `[batch, 1]`.
    target: Option<Tensor>,
    /// Values of both critics, `[2, batch, 1]`.
    values: Option<Tensor>,
    /// The first critic's values of the actor's actions, `[1, batch, 1]`.
    actor_values: Option<Tensor>,
}

impl TorchAgent {
    /// Copies `agent` to `device`.
    ///
    /// libtorch is limited to one thread: these products are too small to share,
    /// the other core simulates, and the order of summation stays the same.
    ///
    /// # Errors
    /// libtorch's, if the device is out of memory.
    pub fn new(agent: &Agent, device: Device) -> Result<Self, TchError> {
        tch::set_num_threads(1);
        let [critic1, critic2] = &agent.critics;
        let [target1, target2] = &agent.target_critics;
        let [adam1, adam2] = &agent.critics_adam;
        Ok(Self {
            config: agent.config.clone(),
            layout: agent.layout,
            device,
            actor: Networks::of(&[&agent.actor], device)?,
            critics: Networks::of(&[critic1, critic2], device)?,
            target_actor: Networks::of(&[&agent.target_actor], device)?,
            target_critics: Networks::of(&[target1, target2], device)?,
            actor_adam: TorchAdam::of(&[&agent.actor_adam], device)?,
            critics_adam: TorchAdam::of(&[adam1, adam2], device)?,
            updates: agent.updates,
            latest: Latest::default(),
        })
    }

    /// Copies the actor's parameters back.
    ///
    /// # Errors
    /// libtorch's.
    pub fn store_actor(&self, agent: &mut Agent) -> Result<(), TchError> {
        read_row(&self.actor.parameters, 0, &mut agent.actor.parameters)
    }

    /// Copies everything back that a checkpoint holds.
    ///
    /// # Errors
    /// libtorch's.
    pub fn store(&self, agent: &mut Agent) -> Result<(), TchError> {
        agent.updates = self.updates;
        self.store_actor(agent)?;
        read_row(&self.target_actor.parameters, 0, &mut agent.target_actor.parameters)?;
        self.actor_adam.store(0, &mut agent.actor_adam)?;
        let store_copies = |from: &Networks, to: &mut [Mlp; 2]| {
            (0..).zip(to).try_for_each(|(copy, to)| read_row(&from.parameters, copy, &mut to.parameters))
        };
        store_copies(&self.critics, &mut agent.critics)?;
        store_copies(&self.target_critics, &mut agent.target_critics)?;
        (0..).zip(&mut agent.critics_adam).try_for_each(|(copy, adam)| self.critics_adam.store(copy, adam))
    }

    /// One update; `normals`, `[batch, action]`, become the smoothing noise.
    ///
    /// # Errors
    /// libtorch's; the numbers are then unusable.
    pub fn update_with(&mut self, batch: &[f32], normals: &[f32]) -> Result<(), TchError> {
        tch::no_grad(|| {
            let rows = [-1, self.layout.row_len() as i64];
            let rows = Tensor::f_from_slice(batch)?.f_view(rows)?.f_to(self.device)?;
            self.updates += 1;
            let target = self.compute_targets(&rows, &self.smoothing_noise(normals)?)?;
            self.update_critics(&rows, target)?;
            if self.updates.is_multiple_of(self.config.policy_delay) {
                self.update_actor(&rows)?;
                self.soft_update()?;
            }
            Ok(())
        })
    }

    /// Losses of the latest update; the actor's of the latest that updated it.
    ///
    /// # Errors
    /// libtorch's.
    pub fn losses(&self) -> Result<Losses, TchError> {
        let mean = |tensor: &Tensor| tensor.f_mean(Kind::Double)?.f_double_value(&[]);
        let (Some(values), Some(target)) = (&self.latest.values, &self.latest.target) else {
            return Ok(Losses::default());
        };
        Ok(Losses {
            // The mean is over both critics, the loss their sum.
            critic: 2.0 * mean(&values.f_sub(target)?.f_square()?)?,
            actor: self.latest.actor_values.as_ref().map(|values| mean(values).map(|q| -q)).transpose()?,
            q_mean: mean(values)?,
        })
    }

    /// Clipped noise on the target policy's actions, `[batch, actions]`.
    fn smoothing_noise(&self, normals: &[f32]) -> Result<Tensor, TchError> {
        let noise: Vec<f32> = normals.iter().map(|&normal| self.config.smoothing_noise(normal)).collect();
        Tensor::f_from_slice(&noise)?.f_view([-1, self.layout.action_len as i64])?.f_to(self.device)
    }

    /// Target values of both critics, `[batch, 1]`: reward plus the discounted smaller
    /// value of the smoothed target action.
    ///
    /// # Source
    /// Fujimoto et al. (2018), algorithm 1.
    fn compute_targets(&self, rows: &Tensor, noise: &Tensor) -> Result<Tensor, TchError> {
        let layout = self.layout;
        let next = columns(rows, layout.next_observation(), layout.observation_len)?;
        let mut action = act(&self.target_actor.forward(&next)?)?.f_add(noise)?;
        let _ = action.f_clamp_(-1.0, 1.0)?;
        let values = self.target_critics.forward(&Tensor::f_cat(&[next, action], 1)?)?;
        // `amin` propagates NaN: divergence must be seen.
        let smaller = values.output().f_amin([0_i64].as_slice(), false)?;
        let not_terminal = columns(rows, layout.not_terminal(), 1)?;
        let future = smaller.f_mul(&not_terminal)?.f_mul_scalar(self.config.gamma)?;
        columns(rows, layout.reward(), 1)?.f_add(&future)
    }

    /// One gradient step of both critics on their squared error to `target`.
    fn update_critics(&mut self, rows: &Tensor, target: Tensor) -> Result<(), TchError> {
        let activations = self.critics.forward(&columns(rows, 0, self.layout.reward())?)?;
        let error = activations.output().f_sub(&target)?;
        // d/dq of mean((q - target)²), for each critic.
        let gradient = error.f_mul_scalar(2.0 / rows.size()[0] as f64)?;
        self.critics.backward(&activations, gradient, Wanted::Parameters)?;
        self.critics_adam.step(&mut self.critics.parameters, &self.critics.gradients)?;
        self.latest.values = Some(activations.output().shallow_clone());
        self.latest.target = Some(target);
        Ok(())
    }

    /// One gradient step of the actor up the first critic's value.
    fn update_actor(&mut self, rows: &Tensor) -> Result<(), TchError> {
        let layout = self.layout;
        let observation = columns(rows, 0, layout.observation_len)?;
        let activations = self.actor.forward(&observation)?;
        let action = act(&activations)?;
        let input = Tensor::f_cat(&[&observation, &action], 1)?;
        let values = self.critics.forward_first(&input)?;
        let gradient = values.output().f_full_like(-1.0 / rows.size()[0] as f64)?;
        if let Some(gradient) = self.critics.backward(&values, gradient, Wanted::Input)? {
            let gradient = gradient.f_narrow(2, layout.action() as i64, layout.action_len as i64)?;
            let gradient = Tensor::f_tanh_backward(&gradient, &action.f_unsqueeze(0)?)?;
            self.actor.backward(&activations, gradient, Wanted::Parameters)?;
            self.actor_adam.step(&mut self.actor.parameters, &self.actor.gradients)?;
        }
        self.latest.actor_values = Some(values.output().shallow_clone());
        Ok(())
    }

    /// Moves all target networks towards their sources by the share `tau`.
    fn soft_update(&mut self) -> Result<(), TchError> {
        let tau = self.config.tau;
        let _ = self.target_actor.parameters.f_lerp_(&self.actor.parameters, tau)?;
        let _ = self.target_critics.parameters.f_lerp_(&self.critics.parameters, tau)?;
        Ok(())
    }
}

/// For tests.
#[cfg(test)]
impl TorchAgent {
    /// Copies the latest update's derivatives to `agent`.
    pub fn store_gradients(&self, agent: &mut Agent) -> Result<(), TchError> {
        read_row(&self.actor.gradients, 0, &mut agent.actor.gradients)?;
        let critics = (0..).zip(&mut agent.critics);
        critics
            .into_iter()
            .try_for_each(|(copy, to)| read_row(&self.critics.gradients, copy, &mut to.gradients))
    }

    /// Target values of the latest update.
    pub fn latest_target(&self) -> Result<Vec<f32>, TchError> {
        let Some(target) = &self.latest.target else { return Ok(Vec::new()) };
        let mut numbers = vec![0.0; target.numel()];
        read_row(&target.f_unsqueeze(0)?, 0, &mut numbers)?;
        Ok(numbers)
    }
}

/// The actions of an actor's output, `[batch, actions]`, between -1 and 1.
fn act(activations: &Activations) -> Result<Tensor, TchError> {
    activations.output().f_squeeze_dim(0)?.f_tanh()
}

fn columns(rows: &Tensor, start: usize, len: usize) -> Result<Tensor, TchError> {
    rows.f_narrow(1, start as i64, len as i64)
}

#[cfg(test)]
mod tests;
