//! The learner: one TD3 update after another.
//!
//! Owns the actor, the twin critics, their targets and optimisers. Refuses to
//! know where transitions come from.

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

/// Actor, critics, targets and optimisers.
#[derive(Debug)]
pub struct Agent {
    pub(super) config: Td3Config,
    pub(super) layout: Layout,
    /// Observation to action, before the hyperbolic tangent.
    pub actor: Mlp,
    /// Observation and action to value, twice.
    pub critics: [Mlp; 2],
    /// Slow copy of the actor.
    pub target_actor: Mlp,
    /// Slow copies of the critics.
    pub target_critics: [Mlp; 2],
    /// The actor's optimiser.
    pub actor_adam: Adam,
    /// The critics' optimisers.
    pub critics_adam: [Adam; 2],
    /// Updates done.
    pub updates: u64,
    memory: Memory,
}

/// What an update was like, for people to read.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Losses {
    /// Mean squared error of both critics, summed.
    pub critic: f64,
    /// Minus the mean value of the actor's own actions; nothing where only the critics moved.
    pub actor: Option<f64>,
    /// Mean value of the batch, both critics.
    pub q_mean: f64,
}

impl Losses {
    /// Whether anything went to infinity or is no number.
    pub fn is_finite(&self) -> bool {
        self.critic.is_finite() && self.actor.is_none_or(f64::is_finite) && self.q_mean.is_finite()
    }
}

/// What an update works in; nothing in it outlives the update.
#[derive(Debug, Default)]
struct Memory {
    /// Of the actors.
    actor: Activations,
    /// Of the critics.
    critic: Activations,
    /// Observations with actions of an actor, `[batch, observation + action]`.
    judged: Vec<f32>,
    /// An actor's actions, `[batch, action]`.
    actions: Vec<f32>,
    normals: Vec<f32>,
    /// What both critics should have said, `[batch]`.
    target: Vec<f32>,
    /// A loss's derivative by a network's output.
    gradient: Vec<f32>,
}

impl Agent {
    /// Random networks, targets equal to them.
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
            memory: Memory::default(),
        }
    }

    /// One update on `batch` (whole rows of the layout) with the smoothing noise of `rng`.
    pub fn update(&mut self, batch: &[f32], rng: &mut ChaCha8Rng) -> Losses {
        let mut normals = std::mem::take(&mut self.memory.normals);
        self.draw_normals(batch, rng, &mut normals);
        let losses = self.update_with(batch, &normals);
        self.memory.normals = normals;
        losses
    }

    /// The standard normal numbers of an update on `batch`, into `normals`: the same on every device.
    pub(super) fn draw_normals(&self, batch: &[f32], rng: &mut ChaCha8Rng, normals: &mut Vec<f32>) {
        let count = self.rows_in(batch) * self.layout.action_len;
        normals.clear();
        normals.extend((0..count).map(|_| rng.sample::<f32, _>(StandardNormal)));
    }

    /// Multiplications and additions in the products of the mean update with `rows` rows.
    pub fn arithmetic_of_an_update(&self, rows: usize) -> f64 {
        let (actor, critic) = (self.actor.multiplications(), self.critics[0].multiplications());
        let into_actor = self.actor.first_multiplications();
        let into_critic = self.critics[0].first_multiplications();
        // Target: each target network forwards. Critics: forwards, derivatives by weights, and
        // by all inputs but the first layer's.
        let every = actor + 2 * critic + 2 * (3 * critic - into_critic);
        // Actor and first critic forwards; back through the critic to its input, and through the actor.
        let delayed = actor + 2 * critic + 2 * actor - into_actor;
        2.0 * rows as f64 * (every as f64 + delayed as f64 / self.config.policy_delay as f64)
    }

    /// One update with smoothing noise made of these standard normal numbers, one
    /// for each row and action.
    fn update_with(&mut self, batch: &[f32], normals: &[f32]) -> Losses {
        self.updates += 1;
        self.aim(batch, normals);
        let mut losses = self.update_critics(batch);
        if self.updates.is_multiple_of(self.config.policy_delay) {
            losses.actor = Some(self.update_actor(batch));
            self.follow();
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

    /// What both critics should have said, into `memory.target`: reward plus the
    /// discounted smaller value of the smoothed target action.
    ///
    /// # Source
    /// Fujimoto et al. (2018), algorithm 1.
    fn aim(&mut self, batch: &[f32], normals: &[f32]) {
        let layout = self.layout;
        let mut memory = std::mem::take(&mut self.memory);
        let next = self.columns(batch, layout.next_observation(), layout.observation_len);
        self.target_actor.forward(next, &mut memory.actor);
        memory.actions.clear();
        let smoothed = memory.actor.output().iter().zip(normals);
        memory
            .actions
            .extend(smoothed.map(|(a, &n)| (a.tanh() + self.config.smoothing_noise(n)).clamp(-1.0, 1.0)));
        join(batch, layout, layout.next_observation(), &memory.actions, &mut memory.judged);
        let judged = Matrix::dense(&memory.judged, layout.reward());
        self.target_critics[0].forward(judged, &mut memory.critic);
        memory.target.clear();
        memory.target.extend_from_slice(memory.critic.output());
        self.target_critics[1].forward(judged, &mut memory.critic);
        let gamma = self.config.gamma as f32;
        let rows = batch.chunks_exact(layout.row_len());
        for ((target, &second), row) in memory.target.iter_mut().zip(memory.critic.output()).zip(rows) {
            // Not `min`, which would drop a value that is no number: divergence must show.
            let smaller = if second < *target || second.is_nan() { second } else { *target };
            *target = row[layout.reward()] + gamma * row[layout.continuation()] * smaller;
        }
        self.memory = memory;
    }

    /// Moves both critics towards `memory.target`.
    fn update_critics(&mut self, batch: &[f32]) -> Losses {
        let mut memory = std::mem::take(&mut self.memory);
        let input = self.columns(batch, 0, self.layout.reward());
        let count = self.rows_in(batch) as f64;
        let mut losses = Losses::default();
        for (critic, adam) in self.critics.iter_mut().zip(&mut self.critics_adam) {
            critic.forward(input, &mut memory.critic);
            memory.gradient.clear();
            for (&value, &target) in memory.critic.output().iter().zip(&memory.target) {
                let error = value - target;
                losses.critic += f64::from(error) * f64::from(error) / count;
                losses.q_mean += f64::from(value) / (2.0 * count);
                // d/dq of mean((q - target)²).
                memory.gradient.push(error * (2.0 / count as f32));
            }
            critic.backward(input, &mut memory.critic, &memory.gradient);
            adam.step(&mut critic.parameters, &critic.gradients);
        }
        self.memory = memory;
        losses
    }

    /// Climbs the first critic; answers minus the mean value of the actor's actions.
    fn update_actor(&mut self, batch: &[f32]) -> f64 {
        let layout = self.layout;
        let mut memory = std::mem::take(&mut self.memory);
        let observation = self.columns(batch, 0, layout.observation_len);
        self.actor.forward(observation, &mut memory.actor);
        memory.actions.clear();
        memory.actions.extend(memory.actor.output().iter().map(|output| output.tanh()));
        join(batch, layout, 0, &memory.actions, &mut memory.judged);
        let judged = Matrix::dense(&memory.judged, layout.reward());
        self.critics[0].forward(judged, &mut memory.critic);
        let count = self.rows_in(batch);
        let loss = -memory.critic.output().iter().map(|&q| f64::from(q)).sum::<f64>() / count as f64;
        memory.gradient.clear();
        memory.gradient.resize(count, -1.0 / count as f32);
        let by_action =
            self.critics[0].backward_to_input(layout.action(), &mut memory.critic, &memory.gradient);
        memory.gradient.clear();
        memory.gradient.extend(by_action.iter().zip(&memory.actions).map(|(g, a)| g * (1.0 - a * a)));
        self.actor.backward(observation, &mut memory.actor, &memory.gradient);
        self.actor_adam.step(&mut self.actor.parameters, &self.actor.gradients);
        self.memory = memory;
        loss
    }

    /// Moves the targets a share `tau` of the way.
    fn follow(&mut self) {
        let tau = self.config.tau as f32;
        kernels::follow(&mut self.target_actor.parameters, &self.actor.parameters, tau);
        for (slow, fast) in self.target_critics.iter_mut().zip(&self.critics) {
            kernels::follow(&mut slow.parameters, &fast.parameters, tau);
        }
    }
}

/// The observation that starts at `start` of each row, and its action, side by side.
fn join(batch: &[f32], layout: Layout, start: usize, actions: &[f32], judged: &mut Vec<f32>) {
    judged.clear();
    for (row, action) in batch.chunks_exact(layout.row_len()).zip(actions.chunks_exact(layout.action_len)) {
        judged.extend_from_slice(&row[start..][..layout.observation_len]);
        judged.extend_from_slice(action);
    }
}

#[cfg(test)]
mod reference;
#[cfg(test)]
mod tests;
