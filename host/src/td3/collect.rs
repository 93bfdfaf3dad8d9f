//! Gathers experience while the learner learns.
//!
//! Owns the training environments and their episodes. Hand-over happens at
//! fixed points: round `r` is gathered with the weights of the end of round
//! `r - 1`, however long either side takes, so that a seed has one result.
//!
//! An environment cannot be saved. A checkpoint keeps the episode's number and
//! the actions since its start instead; taking them again leads to the same state.

use super::MakeEnv;
use super::policy::Policy;
use super::random::{Purpose, episode_seed, stream};
use super::replay::Layout;
use crate::env::Env;
use rand::Rng as _;
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use thiserror::Error;

/// Why gathering stopped.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum CollectError {
    /// The simulation blew up.
    #[error(
        "the task answered with a number that is not finite, {steps} steps into the episode of seed {seed}"
    )]
    NotFinite {
        /// The episode's seed.
        seed: u64,
        /// Steps since its start.
        steps: usize,
    },
}

/// An episode under way, as a checkpoint keeps it.
#[derive(Debug, Clone, PartialEq)]
pub struct Episode {
    /// Which, counted over all environments.
    pub number: u64,
    /// Every action since its start, one after another.
    pub actions: Vec<f32>,
}

/// What one round asks for.
#[derive(Debug)]
pub struct Order {
    /// Names the random numbers.
    pub round: u64,
    /// Control steps, over all environments together.
    pub env_steps: u64,
    /// Who acts; nobody means uniformly random actions.
    pub policy: Option<Policy>,
    /// Standard deviation of the noise on the policy's actions.
    pub noise: f32,
    /// Share of the noise that a step hands on to the next of the same episode.
    pub correlation: f32,
}

/// One environment and its episode.
struct Slot {
    env: Box<dyn Env>,
    observation: Vec<f32>,
    episode: Episode,
}

/// The training environments.
pub struct Collector {
    layout: Layout,
    seed: u64,
    slots: Vec<Slot>,
    /// Number of the next episode to start.
    next_episode: u64,
    /// Whose turn it is.
    turn: usize,
}

/// Where the collector stands between two rounds.
#[derive(Debug, Clone, PartialEq)]
pub struct CollectorState {
    /// One an environment.
    pub episodes: Vec<Episode>,
    /// Number of the next episode to start.
    pub next_episode: u64,
    /// Whose turn it is.
    pub turn: usize,
}

impl Collector {
    /// `count` environments at the start of their first episodes.
    pub fn new(make_env: MakeEnv<'_>, layout: Layout, seed: u64, count: usize) -> Self {
        let mut collector = Self { layout, seed, slots: Vec::new(), next_episode: 0, turn: 0 };
        for _ in 0..count {
            let observation = vec![0.0; layout.observation_len];
            let episode = Episode { number: 0, actions: Vec::new() };
            collector.slots.push(Slot { env: make_env(), observation, episode });
            collector.start_episode(collector.slots.len() - 1);
        }
        collector
    }

    /// Environments in the states that they had, by taking every action again.
    pub fn restore(make_env: MakeEnv<'_>, layout: Layout, seed: u64, state: CollectorState) -> Self {
        let CollectorState { episodes, next_episode, turn } = state;
        let slots = episodes.into_iter().map(|episode| {
            let mut env = make_env();
            let mut observation = vec![0.0; layout.observation_len];
            env.reset(episode_seed(seed, Purpose::TrainingEpisode, episode.number), &mut observation);
            for action in episode.actions.chunks_exact(layout.action_len) {
                env.step(action, &mut observation);
            }
            Slot { env, observation, episode }
        });
        Self { layout, seed, slots: slots.collect(), next_episode, turn }
    }

    /// What [`Self::restore`] needs.
    pub fn state(&self) -> CollectorState {
        CollectorState {
            episodes: self.slots.iter().map(|slot| slot.episode.clone()).collect(),
            next_episode: self.next_episode,
            turn: self.turn,
        }
    }

    fn start_episode(&mut self, slot: usize) {
        let slot = &mut self.slots[slot];
        slot.episode.number = self.next_episode;
        slot.episode.actions.clear();
        self.next_episode += 1;
        let seed = episode_seed(self.seed, Purpose::TrainingEpisode, slot.episode.number);
        slot.env.reset(seed, &mut slot.observation);
    }

    /// One round's transitions, as replay rows.
    ///
    /// # Errors
    /// [`CollectError::NotFinite`] if the task's numbers blow up.
    pub fn gather(&mut self, mut order: Order) -> Result<Vec<f32>, CollectError> {
        let layout = self.layout;
        let mut rng = stream(self.seed, Purpose::Explore, order.round);
        let mut rows = Vec::with_capacity(order.env_steps as usize * layout.row_len());
        let mut action = vec![0.0; layout.action_len];
        // Noise starts afresh every round, so that no round depends on another's.
        // One for each environment: sharing them would gather the same swing eight times.
        let mut excitations: Vec<_> =
            self.slots.iter().map(|_| Excitation::new(&order, layout.action_len, &mut rng)).collect();
        let mut next = vec![0.0; layout.observation_len];
        for _ in 0..order.env_steps {
            let slot = &mut self.slots[self.turn];
            excitations[self.turn].disturb(&mut order, &slot.observation, &mut action, &mut rng);
            let outcome = slot.env.step(&action, &mut next);
            slot.episode.actions.extend_from_slice(&action);
            if !outcome.reward.is_finite() || !next.iter().all(|number| number.is_finite()) {
                let seed = episode_seed(self.seed, Purpose::TrainingEpisode, slot.episode.number);
                return Err(CollectError::NotFinite {
                    seed,
                    steps: slot.episode.actions.len() / layout.action_len,
                });
            }
            layout.push_row(&mut rows, &slot.observation, &action, &outcome, &next);
            if outcome.terminated || outcome.truncated {
                self.start_episode(self.turn);
            } else {
                slot.observation.copy_from_slice(&next);
            }
            self.turn = (self.turn + 1) % self.slots.len();
        }
        Ok(rows)
    }
}

/// What keeps one environment's actions from being the policy's own.
#[derive(Debug, Clone)]
struct Excitation {
    /// Noise with a policy; without one, the random action itself.
    values: Vec<f32>,
}

impl Excitation {
    fn new(order: &Order, action_len: usize, rng: &mut ChaCha8Rng) -> Self {
        let mut values = vec![0.0; action_len];
        for value in &mut values {
            *value = fresh(order, rng);
        }
        Self { values }
    }

    /// The action for `observation`, and the noise of the step after.
    fn disturb(&mut self, order: &mut Order, observation: &[f32], action: &mut [f32], rng: &mut ChaCha8Rng) {
        let kept = order.correlation;
        match &mut order.policy {
            Some(policy) => {
                policy.act(observation, action);
                for (action, &noise) in action.iter_mut().zip(&self.values) {
                    *action = (*action + noise).clamp(-1.0, 1.0);
                }
                // A first-order process of unchanging variance.
                let new = (1.0 - kept * kept).sqrt();
                for value in &mut self.values {
                    *value = kept * *value + new * fresh(order, rng);
                }
            }
            None => {
                action.copy_from_slice(&self.values);
                // As many steps on average as the noise would last.
                if rng.random::<f32>() >= kept {
                    for value in &mut self.values {
                        *value = fresh(order, rng);
                    }
                }
            }
        }
    }
}

/// Noise of one step alone, or a random action where nobody acts.
fn fresh(order: &Order, rng: &mut ChaCha8Rng) -> f32 {
    match order.policy {
        Some(_) => order.noise * rng.sample::<f32, _>(StandardNormal),
        None => rng.random_range(-1.0..=1.0),
    }
}

#[cfg(test)]
mod tests;
