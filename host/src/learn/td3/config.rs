//! What a training run is told: Table 1, and what the table leaves open.
//!
//! Owns the defaults, which are the paper's, and the limits; refuses to know the
//! task, whose numbers `run_config` adds.

use super::collect::MOST_ENVS;
use serde::{Deserialize, Serialize};
use thiserror::Error;

/// A value that no run can work with.
#[derive(Debug, Clone, PartialEq, Error)]
#[error("{name} is {value}, it must be {limit}")]
pub struct BadValue {
    /// Section and name, as in the file.
    pub name: &'static str,
    /// What stands there.
    pub value: String,
    /// What may stand there.
    pub limit: &'static str,
}

/// The algorithm's numbers.
///
/// # Source
/// Table 1; `policy_noise_clip` from Fujimoto et al. (2018).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Td3Config {
    /// Transitions kept.
    pub buffer_size: usize,
    /// Adam's step for the actor.
    pub actor_learning_rate: f64,
    /// Adam's step for the critics.
    pub critic_learning_rate: f64,
    /// Discount a control step.
    pub gamma: f64,
    /// Share that the targets move an actor update.
    pub tau: f64,
    /// Critic updates an actor update.
    pub policy_delay: u64,
    /// Standard deviation of the noise on the target action.
    pub policy_noise: f32,
    /// Largest noise on the target action.
    pub policy_noise_clip: f32,
    /// Standard deviation of the noise on the actions that gather experience.
    pub exploration_noise: f32,
    /// Share of that noise that a control step hands on to the next; 0 is the
    /// paper's white noise, which a servo of 3 rad/s hardly follows.
    pub exploration_correlation: f32,
    /// Transitions an update.
    pub batch_size: usize,
    /// Hidden layers of every network.
    pub hidden_layers: usize,
    /// Neurons of a hidden layer, rectified.
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

/// How long a run goes on and how often it is judged.
///
/// # Source
/// Table 1 and section 2.4, except `warm_up_env_steps` and `round_updates`: ours.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Schedule {
    /// Epochs; each ends with an evaluation and a checkpoint.
    pub epochs: u64,
    /// Updates an epoch.
    pub updates_per_epoch: u64,
    /// Control steps gathered an update.
    pub env_steps_per_update: u64,
    /// Updates between two hand-overs of weights and transitions; an epoch's is a multiple.
    pub round_updates: u64,
    /// Control steps with uniformly random actions before the first update; with none,
    /// the untrained policy gathers the first round.
    pub warm_up_env_steps: u64,
    /// Environments that experience is gathered from in turn ("training number").
    pub training_envs: usize,
    /// Noise-free episodes an evaluation ("test number").
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

    /// Control steps between two hand-overs.
    pub fn round_env_steps(&self) -> u64 {
        self.round_updates * self.env_steps_per_update
    }
}

/// Learning, apart from the task.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Learning {
    /// The algorithm.
    pub td3: Td3Config,
    /// The run.
    pub schedule: Schedule,
}

impl Learning {
    /// Whether a run can work with this.
    ///
    /// # Errors
    /// [`BadValue`] for the first number outside its limit.
    pub fn check(&self) -> Result<(), BadValue> {
        let (t, s) = (&self.td3, &self.schedule);
        at_most("td3.buffer_size", t.buffer_size as u64, 10_000_000, "1 to 10,000,000")?;
        at_most("td3.batch_size", t.batch_size as u64, 65_536, "1 to 65,536")?;
        // 29 MB a network at most, of which there are fifteen, moments and derivatives included:
        // a program without memory is ended on the spot.
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
        at_most("schedule.training_envs", s.training_envs as u64, MOST_ENVS, "1 to 1,024")?;
        at_most("schedule.evaluation_episodes", s.evaluation_episodes as u64, 10_000, "1 to 10,000")?;
        if s.warm_up_env_steps > 0 {
            at_most("schedule.warm_up_env_steps", s.warm_up_env_steps, 10_000_000, "0 to 10,000,000")?;
        }
        // A round's transitions are handed over in one piece, 256 bytes each.
        at_most(
            "schedule.round_updates times schedule.env_steps_per_update",
            s.round_env_steps(),
            1_000_000,
            "1 to 1,000,000",
        )?;
        if s.updates_per_epoch % s.round_updates != 0 {
            return Err(BadValue {
                name: "schedule.updates_per_epoch",
                value: s.updates_per_epoch.to_string(),
                limit: "a multiple of schedule.round_updates",
            });
        }
        Ok(())
    }
}

fn at_most(name: &'static str, value: u64, most: u64, limit: &'static str) -> Result<(), BadValue> {
    if (1..=most).contains(&value) { Ok(()) } else { Err(BadValue { name, value: value.to_string(), limit }) }
}

fn within(
    name: &'static str,
    value: f64,
    least: f64,
    most: f64,
    limit: &'static str,
) -> Result<(), BadValue> {
    if (least..=most).contains(&value) {
        Ok(())
    } else {
        Err(BadValue { name, value: value.to_string(), limit })
    }
}
