//! Algorithm and schedule of a training run: Table 1, and what the table leaves open.
//!
//! Holds the defaults, which are the paper's, and the limits. Does not depend on the
//! task, whose numbers `learn::run_config` adds.

use super::collect::MAX_ENVS;
use serde::{Deserialize, Serialize};
use thiserror::Error;

/// A value that is out of its range.
#[derive(Debug, Clone, PartialEq, Error)]
#[error("{name} is {value}, it must be {limit}")]
pub struct BadValue {
    /// Section and name, as in the file.
    pub name: String,
    /// The value, as text.
    pub value: String,
    /// The range.
    pub limit: &'static str,
}

/// `[td3]`: the hyperparameters of the algorithm.
///
/// # Source
/// Table 1; `policy_noise_clip` from Fujimoto et al. (2018).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Td3Config {
    /// Capacity of the replay buffer, in transitions.
    pub buffer_size: usize,
    /// Adam's learning rate of the actor.
    pub actor_learning_rate: f64,
    /// Adam's learning rate of the critics.
    pub critic_learning_rate: f64,
    /// Discount factor of a control step.
    pub gamma: f64,
    /// Share of a soft update of the target networks.
    pub tau: f64,
    /// Critic updates for each update of actor and targets.
    pub policy_delay: u64,
    /// Standard deviation of the noise on the target action.
    pub policy_noise: f32,
    /// Largest noise on the target action.
    pub policy_noise_clip: f32,
    /// Standard deviation of the noise on the actions that gather experience.
    pub exploration_noise: f32,
    /// Correlation of that noise between consecutive control steps; 0 is the paper's
    /// white noise, which a servo of 3 rad/s hardly follows.
    pub exploration_correlation: f32,
    /// Transitions in the batch of an update.
    pub batch_size: usize,
    /// Hidden layers of each network.
    pub hidden_layers: usize,
    /// Neurons of a hidden layer, with ReLU.
    pub hidden_width: usize,
}

impl Default for Td3Config {
    fn default() -> Self {
        Self {
            buffer_size: 20_000,
            actor_learning_rate: 3e-4,
            critic_learning_rate: 1e-3,
            gamma: 0.99,
            tau: 0.005,
            policy_delay: 2,
            policy_noise: 0.2,
            policy_noise_clip: 0.5,
            exploration_noise: 0.1,
            exploration_correlation: 0.0,
            batch_size: 128,
            hidden_layers: 3,
            hidden_width: 128,
        }
    }
}

impl Td3Config {
    /// Clipped noise on the target policy's action, from a standard normal number.
    pub fn smoothing_noise(&self, normal: f32) -> f32 {
        let limit = self.policy_noise_clip;
        (self.policy_noise * normal).clamp(-limit, limit)
    }
}

/// `[schedule]`: length of a run, and how often it is evaluated.
///
/// # Source
/// Table 1 and section 2.4, except `warm_up_env_steps` and `round_updates`: ours.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Schedule {
    /// Number of epochs; each ends with an evaluation and a checkpoint.
    pub epochs: u64,
    /// Updates in an epoch.
    pub updates_per_epoch: u64,
    /// Control steps gathered for each update, over all environments.
    pub env_steps_per_update: u64,
    /// Updates in a round, between two exchanges of weights and transitions; an epoch is a
    /// multiple of it.
    pub round_updates: u64,
    /// Control steps with uniformly random actions before the first update; with 0, the
    /// untrained policy gathers the first round.
    pub warm_up_env_steps: u64,
    /// Environments that gather experience ("training number").
    pub training_envs: usize,
    /// Episodes without noise in an evaluation ("test number").
    pub evaluation_episodes: usize,
}

impl Default for Schedule {
    fn default() -> Self {
        Self {
            epochs: 100,
            updates_per_epoch: 2_500,
            env_steps_per_update: 10,
            round_updates: 1,
            warm_up_env_steps: 0,
            training_envs: 8,
            evaluation_episodes: 50,
        }
    }
}

impl Schedule {
    /// Updates of the whole run.
    pub fn total_updates(&self) -> u64 {
        self.epochs * self.updates_per_epoch
    }

    /// Control steps in a round.
    pub fn round_env_steps(&self) -> u64 {
        self.round_updates * self.env_steps_per_update
    }
}

/// Algorithm and schedule, without the task.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Learning {
    /// The algorithm.
    pub td3: Td3Config,
    /// The run.
    pub schedule: Schedule,
}

impl Learning {
    /// Checks that every number is within its range.
    ///
    /// # Errors
    /// [`BadValue`] for the first number outside its limit.
    pub fn check(&self) -> Result<(), BadValue> {
        let (t, s) = (&self.td3, &self.schedule);
        at_most("td3.buffer_size", t.buffer_size as u64, 10_000_000, "1 to 10,000,000")?;
        at_most("td3.batch_size", t.batch_size as u64, 65_536, "1 to 65,536")?;
        // At most 29 MB for each of fifteen copies of a network, moments and derivatives included:
        // a program that is out of memory is killed without a message.
        at_most("td3.hidden_layers", t.hidden_layers as u64, 8, "1 to 8")?;
        at_most("td3.hidden_width", t.hidden_width as u64, 1_024, "1 to 1,024")?;
        at_most("td3.policy_delay", t.policy_delay, 1_000, "1 to 1,000")?;
        within(
            "td3.actor_learning_rate",
            t.actor_learning_rate,
            f64::MIN_POSITIVE,
            1.0,
            "above 0, at most 1",
        )?;
        within(
            "td3.critic_learning_rate",
            t.critic_learning_rate,
            f64::MIN_POSITIVE,
            1.0,
            "above 0, at most 1",
        )?;
        within("td3.gamma", t.gamma, 0.0, 0.9999, "0 to 0.9999")?;
        within("td3.tau", t.tau, f64::MIN_POSITIVE, 1.0, "above 0, at most 1")?;
        within("td3.policy_noise", t.policy_noise.into(), 0.0, 2.0, "0 to 2")?;
        within("td3.policy_noise_clip", t.policy_noise_clip.into(), 0.0, 2.0, "0 to 2")?;
        within("td3.exploration_noise", t.exploration_noise.into(), 0.0, 2.0, "0 to 2")?;
        within("td3.exploration_correlation", t.exploration_correlation.into(), 0.0, 0.999, "0 to 0.999")?;
        at_most("schedule.epochs", s.epochs, 1_000_000, "1 to 1,000,000")?;
        at_most("schedule.updates_per_epoch", s.updates_per_epoch, 1_000_000, "1 to 1,000,000")?;
        at_most("schedule.env_steps_per_update", s.env_steps_per_update, 10_000, "1 to 10,000")?;
        at_most("schedule.round_updates", s.round_updates, 100_000, "1 to 100,000")?;
        at_most("schedule.training_envs", s.training_envs as u64, MAX_ENVS, "1 to 1,024")?;
        at_most("schedule.evaluation_episodes", s.evaluation_episodes as u64, 10_000, "1 to 10,000")?;
        if s.warm_up_env_steps > 0 {
            at_most("schedule.warm_up_env_steps", s.warm_up_env_steps, 10_000_000, "0 to 10,000,000")?;
        }
        // A round's transitions are in memory at once, 256 bytes each.
        at_most(
            "schedule.round_updates times schedule.env_steps_per_update",
            s.round_env_steps(),
            1_000_000,
            "1 to 1,000,000",
        )?;
        if s.updates_per_epoch % s.round_updates != 0 {
            return Err(BadValue {
                name: "schedule.updates_per_epoch".to_owned(),
                value: s.updates_per_epoch.to_string(),
                limit: "a multiple of schedule.round_updates",
            });
        }
        Ok(())
    }
}

fn at_most(name: &str, value: u64, most: u64, limit: &'static str) -> Result<(), BadValue> {
    if (1..=most).contains(&value) {
        Ok(())
    } else {
        Err(BadValue { name: name.to_owned(), value: value.to_string(), limit })
    }
}

fn within(name: &str, value: f64, least: f64, most: f64, limit: &'static str) -> Result<(), BadValue> {
    // NaN lies within nothing.
    if (least..=most).contains(&value) {
        Ok(())
    } else {
        Err(BadValue { name: name.to_owned(), value: value.to_string(), limit })
    }
}
