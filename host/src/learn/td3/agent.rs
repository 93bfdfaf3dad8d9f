//! The TD3 update.
//!
//! Holds the actor, the twin critics, their target networks and optimisers. Does not
//! depend on where transitions come from.

use super::adam::Adam;
use super::config::Td3Config;
use super::kernels::{self, Matrix};
use super::networks::{Activations, Mlp};
use super::random::{Purpose, stream};
use super::replay::Layout;
use rand::Rng as _;
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use serde::{Deserialize, Serialize};

/// Actor, critics, target networks and optimisers.
#[derive(Debug)]
pub struct Agent {
    pub(super) config: Td3Config,
    pub(super) layout: Layout,
    /// From observation to action, before the hyperbolic tangent.
    pub actor: Mlp,
    /// From observation and action to value; two, of which targets take the smaller.
    pub critics: [Mlp; 2],
    /// Follows the actor by soft updates.
    pub target_actor: Mlp,
    /// Follow the critics by soft updates.
    pub target_critics: [Mlp; 2],
    /// The actor's optimiser.
    pub actor_adam: Adam,
    /// The critics' optimisers.
    pub critics_adam: [Adam; 2],
    /// Updates done.
    pub updates: u64,
    scratch: Scratch,
}

/// Losses of one update, for the learning curve.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Losses {
    /// Mean squared error of both critics, summed.
    pub critic: f64,
    /// Minus the mean value of the actor's own actions; `None` where only the critics were updated.
    pub actor: Option<f64>,
    /// Mean value of the batch over both critics.
    pub q_mean: f64,
}

impl Losses {
    /// Whether no loss is NaN or infinite.
    pub fn is_finite(&self) -> bool {
        self.critic.is_finite() && self.actor.is_none_or(f64::is_finite) && self.q_mean.is_finite()
    }
}

/// Working memory of an update, kept so that no update allocates.
#[derive(Debug, Default)]
struct Scratch {
    /// Of the actor or its target.
    actor: Activations,
    /// Of the critic or target evaluated last.
    critic: Activations,
    /// Observations and an actor's actions side by side, `[batch, observation + action]`.
    critic_input: Vec<f32>,
    /// An actor's actions, `[batch, action]`.
    actions: Vec<f32>,
    normals: Vec<f32>,
    /// Target values of both critics, `[batch]`.
    target: Vec<f32>,
    /// Derivative of a loss by a network's output, `[batch, outputs]`.
    gradient: Vec<f32>,
}

impl Agent {
    /// Random networks; target networks start equal to them.
    pub fn new(config: &Td3Config, layout: Layout, seed: u64) -> Self {
        Self::with_hidden(config, layout, &vec![config.hidden_width; config.hidden_layers], seed)
    }

    fn with_hidden(config: &Td3Config, layout: Layout, hidden: &[usize], seed: u64) -> Self {
        let mut rng = stream(seed, Purpose::Initialise, 0);
        let actor =
            Mlp::random(&[&[layout.observation_len], hidden, &[layout.action_len]].concat(), &mut rng);
        let widths = [&[layout.reward()], hidden, &[1]].concat();
        let critics = [Mlp::random(&widths, &mut rng), Mlp::random(&widths, &mut rng)];
        let critics_adam = Adam::new(critics[0].parameters.len(), config.critic_learning_rate);
        Self {
            actor_adam: Adam::new(actor.parameters.len(), config.actor_learning_rate),
            critics_adam: [critics_adam.clone(), critics_adam],
            target_actor: actor.clone(),
            target_critics: critics.clone(),
            actor,
            critics,
            config: config.clone(),
            layout,
            updates: 0,
            scratch: Scratch::default(),
        }
    }

    /// One update on `batch`, `[batch, row]`; `rng` gives the smoothing noise.
    pub fn update(&mut self, batch: &[f32], rng: &mut ChaCha8Rng) -> Losses {
        let mut normals = std::mem::take(&mut self.scratch.normals);
        self.sample_normals(batch, rng, &mut normals);
        let losses = self.update_with(batch, &normals);
        self.scratch.normals = normals;
        losses
    }

    /// Samples the standard normal numbers of an update, `[batch, action]`: the same on every device.
    pub(super) fn sample_normals(&self, batch: &[f32], rng: &mut ChaCha8Rng, normals: &mut Vec<f32>) {
        let count = self.rows_in(batch) * self.layout.action_len;
        normals.clear();
        normals.extend((0..count).map(|_| rng.sample::<f32, _>(StandardNormal)));
    }

    /// Multiplications and additions in the matrix products of an update with `rows` rows, on
    /// average over updates with and without the actor.
    pub fn arithmetic_of_an_update(&self, rows: usize) -> f64 {
        let (actor, critic) = (self.actor.multiplications(), self.critics[0].multiplications());
        let into_actor = self.actor.first_multiplications();
        let into_critic = self.critics[0].first_multiplications();
        // Targets: a forward pass of each target network. Critics: a forward pass, the derivatives
        // by all weights, and those by the inputs of all layers but the first.
        let every = actor + 2 * critic + 2 * (3 * critic - into_critic);
        // Forward passes of actor and first critic; backward through the critic to its input, then
        // through the actor.
        let delayed = actor + 2 * critic + 2 * actor - into_actor;
        2.0 * rows as f64 * (every as f64 + delayed as f64 / self.config.policy_delay as f64)
    }

    /// One update; `normals`, `[batch, action]`, become the smoothing noise.
    fn update_with(&mut self, batch: &[f32], normals: &[f32]) -> Losses {
        self.updates += 1;
        self.compute_targets(batch, normals);
        let mut losses = self.update_critics(batch);
        if self.updates.is_multiple_of(self.config.policy_delay) {
            losses.actor = Some(self.update_actor(batch));
            self.soft_update();
        }
        losses
    }

    fn rows_in(&self, batch: &[f32]) -> usize {
        batch.len() / self.layout.row_len()
    }

    /// Columns of the batch's rows.
    fn columns<'a>(&self, batch: &'a [f32], start: usize, len: usize) -> Matrix<'a> {
        Matrix::rows(batch, start, self.rows_in(batch), len, self.layout.row_len())
    }

    /// Computes the target values of both critics into `scratch.target`: reward plus the
    /// discounted smaller value of the smoothed target action.
    ///
    /// # Source
    /// Fujimoto et al. (2018), algorithm 1.
    fn compute_targets(&mut self, batch: &[f32], normals: &[f32]) {
        let layout = self.layout;
        let mut scratch = std::mem::take(&mut self.scratch);
        // The target actor's actions for the next observations, plus clipped noise.
        let next = self.columns(batch, layout.next_observation(), layout.observation_len);
        self.target_actor.forward(next, &mut scratch.actor);
        scratch.actions.clear();
        let smoothed = scratch.actor.output().iter().zip(normals);
        scratch
            .actions
            .extend(smoothed.map(|(a, &n)| (a.tanh() + self.config.smoothing_noise(n)).clamp(-1.0, 1.0)));
        join(batch, layout, layout.next_observation(), &scratch.actions, &mut scratch.critic_input);
        // Both target critics' values of those actions.
        let critic_input = Matrix::dense(&scratch.critic_input, layout.reward());
        self.target_critics[0].forward(critic_input, &mut scratch.critic);
        scratch.target.clear();
        scratch.target.extend_from_slice(scratch.critic.output());
        self.target_critics[1].forward(critic_input, &mut scratch.critic);
        let gamma = self.config.gamma as f32;
        let rows = batch.chunks_exact(layout.row_len());
        for ((target, &second), row) in scratch.target.iter_mut().zip(scratch.critic.output()).zip(rows) {
            // Not `min`, which would drop a NaN: divergence must be seen.
            let smaller = if second < *target || second.is_nan() { second } else { *target };
            *target = row[layout.reward()] + gamma * row[layout.not_terminal()] * smaller;
        }
        self.scratch = scratch;
    }

    /// One gradient step of both critics on their squared error to `scratch.target`.
    fn update_critics(&mut self, batch: &[f32]) -> Losses {
        let mut scratch = std::mem::take(&mut self.scratch);
        let input = self.columns(batch, 0, self.layout.reward());
        let count = self.rows_in(batch) as f64;
        let mut losses = Losses::default();
        for (critic, adam) in self.critics.iter_mut().zip(&mut self.critics_adam) {
            critic.forward(input, &mut scratch.critic);
            scratch.gradient.clear();
            for (&value, &target) in scratch.critic.output().iter().zip(&scratch.target) {
                let error = value - target;
                losses.critic += f64::from(error) * f64::from(error) / count;
                losses.q_mean += f64::from(value) / (2.0 * count);
                // d/dq of mean((q - target)²).
                scratch.gradient.push(error * (2.0 / count as f32));
            }
            critic.backward(input, &mut scratch.critic, &scratch.gradient);
            adam.step(&mut critic.parameters, &critic.gradients);
        }
        self.scratch = scratch;
        losses
    }

    /// One gradient step of the actor up the first critic's value; returns the actor's loss.
    fn update_actor(&mut self, batch: &[f32]) -> f64 {
        let layout = self.layout;
        let mut scratch = std::mem::take(&mut self.scratch);
        // The first critic's values of the actor's actions.
        let observation = self.columns(batch, 0, layout.observation_len);
        self.actor.forward(observation, &mut scratch.actor);
        scratch.actions.clear();
        scratch.actions.extend(scratch.actor.output().iter().map(|output| output.tanh()));
        join(batch, layout, 0, &scratch.actions, &mut scratch.critic_input);
        let critic_input = Matrix::dense(&scratch.critic_input, layout.reward());
        self.critics[0].forward(critic_input, &mut scratch.critic);
        let count = self.rows_in(batch);
        let loss = -scratch.critic.output().iter().map(|&q| f64::from(q)).sum::<f64>() / count as f64;
        // d/dq of -mean(q), back through the critic to the action, then through the tanh.
        scratch.gradient.clear();
        scratch.gradient.resize(count, -1.0 / count as f32);
        let by_action =
            self.critics[0].backward_to_input(layout.action(), &mut scratch.critic, &scratch.gradient);
        scratch.gradient.clear();
        scratch.gradient.extend(by_action.iter().zip(&scratch.actions).map(|(g, a)| g * (1.0 - a * a)));
        self.actor.backward(observation, &mut scratch.actor, &scratch.gradient);
        self.actor_adam.step(&mut self.actor.parameters, &self.actor.gradients);
        self.scratch = scratch;
        loss
    }

    /// Moves all target networks towards their sources by the share `tau`.
    fn soft_update(&mut self) {
        let tau = self.config.tau as f32;
        kernels::soft_update(&mut self.target_actor.parameters, &self.actor.parameters, tau);
        for (target, source) in self.target_critics.iter_mut().zip(&self.critics) {
            kernels::soft_update(&mut target.parameters, &source.parameters, tau);
        }
    }
}

/// Writes the observation at column `start` of each row and its action side by side into `critic_input`.
fn join(batch: &[f32], layout: Layout, start: usize, actions: &[f32], critic_input: &mut Vec<f32>) {
    critic_input.clear();
    for (row, action) in batch.chunks_exact(layout.row_len()).zip(actions.chunks_exact(layout.action_len)) {
        critic_input.extend_from_slice(&row[start..][..layout.observation_len]);
        critic_input.extend_from_slice(action);
    }
}

#[cfg(test)]
mod reference;
#[cfg(test)]
mod tests;
