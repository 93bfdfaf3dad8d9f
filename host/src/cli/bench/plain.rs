//! TD3 in plain tch, the baseline of the learner's speed.
//!
//! Holds the same losses in the style of tch's examples: layers, autograd and Adam are
//! libtorch's. Does not depend on the learner. It is only timed; a test checks that it
//! learns.

use crate::learn::td3::config::Td3Config;
use crate::learn::td3::replay::Layout;
use tch::nn::{self, Module as _, OptimizerConfig as _};
use tch::{Device, Kind, Tensor};

/// One network with parameters of its own.
struct Network {
    store: nn::VarStore,
    layers: nn::Sequential,
}

impl Network {
    fn new(widths: &[usize]) -> Self {
        let store = nn::VarStore::new(Device::Cpu);
        let mut layers = nn::seq();
        for (depth, w) in widths.windows(2).enumerate() {
            if depth > 0 {
                layers = layers.add_fn(Tensor::relu);
            }
            let path = store.root() / format!("layer{depth}");
            layers = layers.add(nn::linear(path, w[0] as i64, w[1] as i64, nn::LinearConfig::default()));
        }
        Self { store, layers }
    }

    fn adam(&self, learning_rate: f64) -> Result<nn::Optimizer, tch::TchError> {
        nn::Adam::default().build(&self.store, learning_rate)
    }

    /// Moves this target network towards `source` by the share `tau`.
    fn soft_update(&self, source: &Self, tau: f64) {
        for (mut target, source) in
            self.store.trainable_variables().into_iter().zip(source.store.trainable_variables())
        {
            let _ = target.lerp_(&source, tau);
        }
    }
}

/// Actor, critics, target networks and optimisers.
pub struct PlainTd3 {
    config: Td3Config,
    layout: Layout,
    actor: Network,
    critics: [Network; 2],
    target_actor: Network,
    target_critics: [Network; 2],
    actor_adam: nn::Optimizer,
    critic_adams: [nn::Optimizer; 2],
    updates: u64,
}

impl PlainTd3 {
    /// Random networks; target networks start equal to them.
    pub fn new(config: &Td3Config, layout: Layout) -> Result<Self, tch::TchError> {
        let hidden = vec![config.hidden_width; config.hidden_layers];
        let actor_widths = [&[layout.observation_len], &hidden[..], &[layout.action_len]].concat();
        let critic_widths = [&[layout.reward()], &hidden[..], &[1]].concat();
        let actor = Network::new(&actor_widths);
        let critics = [Network::new(&critic_widths), Network::new(&critic_widths)];
        let target_actor = Network::new(&actor_widths);
        let target_critics = [Network::new(&critic_widths), Network::new(&critic_widths)];
        tch::no_grad(|| {
            target_actor.soft_update(&actor, 1.0);
            for (slow, fast) in target_critics.iter().zip(&critics) {
                slow.soft_update(fast, 1.0);
            }
        });
        let critic_adams =
            [critics[0].adam(config.critic_learning_rate)?, critics[1].adam(config.critic_learning_rate)?];
        Ok(Self {
            actor_adam: actor.adam(config.actor_learning_rate)?,
            config: config.clone(),
            layout,
            actor,
            critics,
            target_actor,
            target_critics,
            critic_adams,
            updates: 0,
        })
    }

    /// One update on `batch`, `[batch, row]`.
    pub fn update(&mut self, batch: &[f32]) {
        self.updates += 1;
        let layout = self.layout;
        let rows = Tensor::from_slice(batch).view([-1, layout.row_len() as i64]);
        let columns = |start: usize, len: usize| rows.narrow(1, start as i64, len as i64);
        let (observation, action) =
            (columns(0, layout.observation_len), columns(layout.action(), layout.action_len));
        let next = columns(layout.next_observation(), layout.observation_len);
        let target = tch::no_grad(|| {
            let limit = f64::from(self.config.policy_noise_clip);
            let noise = (action.randn_like() * f64::from(self.config.policy_noise)).clamp(-limit, limit);
            let next_action = (self.target_actor.layers.forward(&next).tanh() + noise).clamp(-1.0, 1.0);
            let target_input = Tensor::cat(&[&next, &next_action], 1);
            let smaller = self.target_critics[0]
                .layers
                .forward(&target_input)
                .min_other(&self.target_critics[1].layers.forward(&target_input));
            columns(layout.reward(), 1) + self.config.gamma * columns(layout.not_terminal(), 1) * smaller
        });
        let critic_input = Tensor::cat(&[&observation, &action], 1);
        for (critic, adam) in self.critics.iter().zip(&mut self.critic_adams) {
            let loss = critic.layers.forward(&critic_input).mse_loss(&target, tch::Reduction::Mean);
            adam.backward_step(&loss);
        }
        if self.updates.is_multiple_of(self.config.policy_delay) {
            let action = self.actor.layers.forward(&observation).tanh();
            let critic_input = Tensor::cat(&[&observation, &action], 1);
            let loss = -self.critics[0].layers.forward(&critic_input).mean(Kind::Float);
            self.actor_adam.backward_step(&loss);
            tch::no_grad(|| {
                self.target_actor.soft_update(&self.actor, self.config.tau);
                for (slow, fast) in self.target_critics.iter().zip(&self.critics) {
                    slow.soft_update(fast, self.config.tau);
                }
            });
        }
    }

    /// The first critic's value of one observation and action.
    #[cfg(test)]
    fn value(&self, critic_input: &[f32]) -> f64 {
        let critic_input = Tensor::from_slice(critic_input).unsqueeze(0);
        tch::no_grad(|| self.critics[0].layers.forward(&critic_input).double_value(&[0, 0]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What is timed must learn: a reward of 1 in a terminal step has the value 1.
    #[test]
    fn the_baseline_learns_the_value_of_a_terminal_step() {
        let layout = Layout { observation_len: 2, action_len: 1 };
        let config = Td3Config { hidden_layers: 2, hidden_width: 16, ..Td3Config::default() };
        let mut plain = PlainTd3::new(&config, layout).unwrap();
        let row = [0.5, -0.5, 0.25, 1.0, 0.0, 0.5, -0.5];
        let batch = row.repeat(8);

        for _ in 0..400 {
            plain.update(&batch);
        }

        let value = plain.value(&row[..3]);
        assert!((value - 1.0).abs() < 0.05, "{value}");
    }
}
