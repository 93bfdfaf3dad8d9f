//! The learner: one TD3 update after another.
//!
//! Owns the actor, the twin critics, their targets and optimisers. Refuses to
//! know where transitions come from.

use super::adam::Adam;
use super::config::Td3Config;
use super::networks::{Activations, Mlp, Wanted};
use super::random::{Purpose, stream};
use super::replay::Layout;
use rand::Rng as _;
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use serde::{Deserialize, Serialize};
use tch::{Kind, Tensor};

/// Actor, critics, targets and optimisers.
#[derive(Debug)]
pub struct Agent {
    config: Td3Config,
    layout: Layout,
    /// Observation to action, before the hyperbolic tangent.
    pub actor: Mlp,
    /// Observation and action to value, twice.
    pub critics: Mlp,
    /// Slow copy of the actor.
    pub target_actor: Mlp,
    /// Slow copies of the critics.
    pub target_critics: Mlp,
    /// The actor's optimiser.
    pub actor_adam: Adam,
    /// The critics' optimiser.
    pub critics_adam: Adam,
    /// Updates done.
    pub updates: u64,
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

impl Agent {
    /// Random networks, targets equal to them.
    pub fn new(config: &Td3Config, layout: Layout, seed: u64) -> Self {
        Self::with_hidden(config, layout, &vec![config.hidden_width; config.hidden_layers], seed)
    }

    fn with_hidden(config: &Td3Config, layout: Layout, hidden: &[usize], seed: u64) -> Self {
        let mut rng = stream(seed, Purpose::Initialise, 0);
        let actor =
            Mlp::random(1, &[&[layout.observation_len], hidden, &[layout.action_len]].concat(), &mut rng);
        let critics = Mlp::random(2, &[&[layout.reward()], hidden, &[1]].concat(), &mut rng);
        Self {
            target_actor: actor.duplicate(),
            target_critics: critics.duplicate(),
            actor_adam: Adam::new(&actor.parameters, config.actor_learning_rate),
            critics_adam: Adam::new(&critics.parameters, config.critic_learning_rate),
            actor,
            critics,
            config: config.clone(),
            layout,
            updates: 0,
        }
    }

    /// One update on `batch` (whole rows of the layout) with the smoothing noise
    /// of `rng`. Losses are computed where `report` asks for them: they cost time.
    pub fn update(&mut self, batch: &[f32], rng: &mut ChaCha8Rng, report: bool) -> Option<Losses> {
        let count = batch.len() / self.layout.row_len() * self.layout.action_len;
        let normals: Vec<f32> = (0..count).map(|_| rng.sample(StandardNormal)).collect();
        self.update_with(batch, &normals, report)
    }

    /// One update with smoothing noise made of these standard normal numbers, one
    /// for each row and action.
    fn update_with(&mut self, batch: &[f32], normals: &[f32], report: bool) -> Option<Losses> {
        tch::no_grad(|| {
            let rows = Tensor::from_slice(batch).view([-1, self.layout.row_len() as i64]);
            self.updates += 1;
            let target = self.target(&rows, &self.smoothing_noise(normals));
            let mut losses = self.update_critics(&rows, &target, report);
            if self.updates.is_multiple_of(self.config.policy_delay) {
                let q = self.update_actor(&rows);
                if let Some(losses) = &mut losses {
                    losses.actor = Some(-q.mean(Kind::Float).double_value(&[]));
                }
                self.follow();
            }
            losses
        })
    }

    /// Clipped noise on the target policy's action, `[batch, actions]`.
    fn smoothing_noise(&self, normals: &[f32]) -> Tensor {
        let (scale, limit) = (self.config.policy_noise, self.config.policy_noise_clip);
        let noise: Vec<f32> = normals.iter().map(|n| (scale * n).clamp(-limit, limit)).collect();
        Tensor::from_slice(&noise).view([-1, self.layout.action_len as i64])
    }

    /// What both critics should have said, `[batch, 1]`: reward plus the discounted
    /// smaller value of the smoothed target action.
    ///
    /// # Source
    /// Fujimoto et al. (2018), algorithm 1.
    fn target(&self, rows: &Tensor, noise: &Tensor) -> Tensor {
        let layout = self.layout;
        let next = columns(rows, layout.next_observation(), layout.observation_len);
        let action = (act(&self.target_actor.forward(&next)).squeeze_dim(0) + noise).clamp_(-1.0, 1.0);
        let values = self.target_critics.forward(&Tensor::cat(&[next, action], 1));
        let smaller = values.output().amin([0_i64].as_slice(), false);
        let continuation = columns(rows, layout.continuation(), 1);
        columns(rows, layout.reward(), 1) + smaller * continuation * self.config.gamma
    }

    fn update_critics(&mut self, rows: &Tensor, target: &Tensor, report: bool) -> Option<Losses> {
        let activations = self.critics.forward(&columns(rows, 0, self.layout.reward()));
        let error = activations.output() - target.unsqueeze(0);
        let losses = report.then(|| Losses {
            critic: 2.0 * error.square().mean(Kind::Float).double_value(&[]),
            actor: None,
            q_mean: activations.output().mean(Kind::Float).double_value(&[]),
        });
        // d/dq of mean((q - target)²), for each critic.
        let gradient = error * (2.0 / rows.size()[0] as f64);
        self.critics.backward(&activations, gradient, Wanted::Parameters);
        self.critics_adam.step(&mut self.critics.parameters, &self.critics.gradients);
        losses
    }

    /// Climbs the first critic; answers the values of the actor's actions.
    fn update_actor(&mut self, rows: &Tensor) -> Tensor {
        let layout = self.layout;
        let observation = columns(rows, 0, layout.observation_len);
        let activations = self.actor.forward(&observation);
        let action = act(&activations);
        let judged = self.critics.forward_first(&Tensor::cat(&[observation, action.squeeze_dim(0)], 1));
        let downhill = judged.output().full_like(-1.0 / rows.size()[0] as f64);
        let input_gradient = self.critics.backward(&judged, downhill, Wanted::Input);
        if let Some(gradient) = input_gradient {
            let gradient = gradient.narrow(2, layout.action() as i64, layout.action_len as i64);
            let gradient = Tensor::tanh_backward(&gradient, &action);
            self.actor.backward(&activations, gradient, Wanted::Parameters);
            self.actor_adam.step(&mut self.actor.parameters, &self.actor.gradients);
        }
        judged.output().shallow_clone()
    }

    /// Moves the targets a share `tau` of the way.
    fn follow(&mut self) {
        let tau = self.config.tau;
        let _ = self.target_actor.parameters.lerp_(&self.actor.parameters, tau);
        let _ = self.target_critics.parameters.lerp_(&self.critics.parameters, tau);
    }
}

/// The action of an actor's output: between -1 and 1.
fn act(activations: &Activations) -> Tensor {
    activations.output().tanh()
}

fn columns(rows: &Tensor, start: usize, len: usize) -> Tensor {
    rows.narrow(1, start as i64, len as i64)
}

#[cfg(test)]
mod reference;
#[cfg(test)]
mod tests;
