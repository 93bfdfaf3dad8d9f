//! The same losses written straight in tch: what the learner's speed is held to.
//!
//! Owns a TD3 as the library's own examples would have it: layers, autograd and
//! Adam are libtorch's. Refuses to train anything: it is only timed, and held to
//! the learner's losses by a test.

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

    /// Moves this one the share `tau` of the way to `fast`.
    fn follow(&self, fast: &Self, tau: f64) {
        for (mut slow, fast) in
            self.store.trainable_variables().into_iter().zip(fast.store.trainable_variables())
        {
            let _ = slow.lerp_(&fast, tau);
        }
    }
}

/// Actor, critics, targets, optimisers.
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
    /// Random networks, targets equal to them.
    pub fn new(config: &Td3Config, layout: Layout) -> Result<Self, tch::TchError> {
        let hidden = vec![config.hidden_width; config.hidden_layers];
        let actor_widths = [&[layout.observation_len], &hidden[..], &[layout.action_len]].concat();
        let critic_widths = [&[layout.reward()], &hidden[..], &[1]].concat();
        let actor = Network::new(&actor_widths);
        let critics = [Network::new(&critic_widths), Network::new(&critic_widths)];
        let target_actor = Network::new(&actor_widths);
        let target_critics = [Network::new(&critic_widths), Network::new(&critic_widths)];
        tch::no_grad(|| {
            target_actor.follow(&actor, 1.0);
            for (slow, fast) in target_critics.iter().zip(&critics) {
                slow.follow(fast, 1.0);
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

    /// One update on `batch`, whole rows of the layout.
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
            let judged = Tensor::cat(&[&next, &next_action], 1);
            let smaller = self.target_critics[0]
                .layers
                .forward(&judged)
                .min_other(&self.target_critics[1].layers.forward(&judged));
            columns(layout.reward(), 1) + self.config.gamma * columns(layout.continuation(), 1) * smaller
        });
        let judged = Tensor::cat(&[&observation, &action], 1);
        for (critic, adam) in self.critics.iter().zip(&mut self.critic_adams) {
            let loss = critic.layers.forward(&judged).mse_loss(&target, tch::Reduction::Mean);
            adam.backward_step(&loss);
        }
        if self.updates.is_multiple_of(self.config.policy_delay) {
            let action = self.actor.layers.forward(&observation).tanh();
            let judged = Tensor::cat(&[&observation, &action], 1);
            let loss = -self.critics[0].layers.forward(&judged).mean(Kind::Float);
            self.actor_adam.backward_step(&loss);
            tch::no_grad(|| {
                self.target_actor.follow(&self.actor, self.config.tau);
                for (slow, fast) in self.target_critics.iter().zip(&self.critics) {
                    slow.follow(fast, self.config.tau);
                }
            });
        }
    }

    /// The first critic's value of one observation and action.
    #[cfg(test)]
    fn value(&self, judged: &[f32]) -> f64 {
        let judged = Tensor::from_slice(judged).unsqueeze(0);
        tch::no_grad(|| self.critics[0].layers.forward(&judged).double_value(&[0, 0]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What is timed must be learning: a reward of 1 and no future is worth 1.
    #[test]
    fn the_yardstick_learns_what_it_is_told() {
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
