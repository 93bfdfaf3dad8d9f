//! Gathers experience while the learner learns.
//!
//! Holds the training environments and their episodes. Does not depend on the
//! learner. Round `r` is gathered with the weights of the end of round `r - 1`,
//! however long gathering and learning take, so that a seed has one result. Within a
//! round each environment is a separate piece of work with its own random numbers,
//! so that any thread can take the next one: the learner too, after its updates.
//!
//! An environment cannot be saved. A checkpoint holds the episode's number and its
//! actions instead; replaying them leads to the same state.

use super::MakeEnv;
use super::policy::Policy;
use super::random::{Purpose, episode_seed, stream};
use super::replay::Layout;
use crate::env::Env;
use rand::Rng as _;
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use thiserror::Error;

/// Maximum number of environments: each round has as many random streams.
pub const MAX_ENVS: u64 = 1_024;

/// Why gathering stopped.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum CollectError {
    /// The simulation diverged.
    #[error("the task returned NaN or infinity {steps} steps into the episode of seed {seed}")]
    NotFinite {
        /// The episode's seed.
        seed: u64,
        /// Steps since its start.
        steps: usize,
    },
}

/// An unfinished episode, as a checkpoint holds it.
#[derive(Debug, Clone, PartialEq)]
pub struct Episode {
    /// Number of the episode: environment `i` of `n` plays `i`, `i + n`, `i + 2 n` ...
    pub number: u64,
    /// Every action since its start, `[steps, action]`.
    pub actions: Vec<f32>,
}

/// How one round is to be gathered.
#[derive(Debug)]
pub struct Order {
    /// Number of the round; selects the random streams.
    pub round: u64,
    /// Control steps gathered before, over all environments, which step alternately.
    pub before: u64,
    /// Control steps to gather, over all environments.
    pub env_steps: u64,
    /// The policy that acts; without one, actions are uniformly random.
    pub policy: Option<Policy>,
    /// Standard deviation of the noise on the policy's actions.
    pub noise: f32,
    /// Correlation of the noise of two consecutive steps, also across the end of an episode.
    pub correlation: f32,
}

/// A round in progress, from which each thread takes the next environment.
#[derive(Debug)]
pub struct Round {
    order: Order,
    /// The next environment to take.
    next: AtomicUsize,
    /// Transitions of each environment.
    gathered: Mutex<Vec<Gathered>>,
}

/// One environment's part of a round, as replay rows.
#[derive(Debug)]
struct Gathered {
    slot: usize,
    rows: Result<Vec<f32>, CollectError>,
}

impl Round {
    /// A round from which no environment was taken yet.
    pub fn new(order: Order) -> Self {
        Self { order, next: AtomicUsize::new(0), gathered: Mutex::new(Vec::new()) }
    }

    /// All transitions, in the order of the environments; complete when every
    /// [`Collector::help`] has returned.
    ///
    /// # Errors
    /// [`CollectError`] of the first environment that has one.
    pub fn rows(&self) -> Result<Vec<f32>, CollectError> {
        let mut gathered = self.gathered.lock().unwrap_or_else(PoisonError::into_inner);
        gathered.sort_by_key(|gathered| gathered.slot);
        let rows: Result<Vec<Vec<f32>>, _> = gathered.drain(..).map(|gathered| gathered.rows).collect();
        Ok(rows?.concat())
    }
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
    /// In a round each is taken, and locked, once.
    slots: Vec<Mutex<Slot>>,
}

impl Collector {
    /// `count` environments at the start of their first episodes.
    pub fn new(make_env: MakeEnv<'_>, layout: Layout, seed: u64, count: usize) -> Self {
        let first = |number: usize| Episode { number: number as u64, actions: Vec::new() };
        Self::restore(make_env, layout, seed, (0..count).map(first).collect())
    }

    /// Environments in their earlier states, by replaying every action.
    pub fn restore(make_env: MakeEnv<'_>, layout: Layout, seed: u64, episodes: Vec<Episode>) -> Self {
        let slots = episodes.into_iter().map(|episode| {
            let mut env = make_env();
            let mut observation = vec![0.0; layout.observation_len];
            env.reset(episode_seed(seed, Purpose::TrainingEpisode, episode.number), &mut observation);
            for action in episode.actions.chunks_exact(layout.action_len) {
                env.step(action, &mut observation);
            }
            Mutex::new(Slot { env, observation, episode })
        });
        Self { layout, seed, slots: slots.collect() }
    }

    /// The input of [`Self::restore`]; to be read between two rounds.
    pub fn episodes(&self) -> Vec<Episode> {
        let episode =
            |slot: &Mutex<Slot>| slot.lock().unwrap_or_else(PoisonError::into_inner).episode.clone();
        self.slots.iter().map(episode).collect()
    }

    /// Takes and plays environments of the round until none is left.
    pub fn help(&self, round: &Round) {
        let mut policy = None;
        loop {
            let taken = round.next.fetch_add(1, Ordering::Relaxed);
            let Some(slot) = self.slots.get(taken) else { return };
            let policy = policy.get_or_insert_with(|| round.order.policy.clone());
            // Poisoned only by a panic in the task, which ends the run anyway.
            let mut slot = slot.lock().unwrap_or_else(PoisonError::into_inner);
            let rows = self.play(&mut slot, taken, &round.order, policy.as_mut());
            round
                .gathered
                .lock()
                .unwrap_or_else(PoisonError::into_inner)
                .push(Gathered { slot: taken, rows });
        }
    }

    /// Plays one environment's part of a round; returns it as rows of the replay buffer.
    fn play(
        &self,
        slot: &mut Slot,
        number: usize,
        order: &Order,
        mut policy: Option<&mut Policy>,
    ) -> Result<Vec<f32>, CollectError> {
        let layout = self.layout;
        let envs = self.slots.len() as u64;
        // The environments step alternately: this one's steps between `before` and the round's end.
        let turns_until = |steps: u64| (steps + envs - 1 - number as u64) / envs;
        let steps = turns_until(order.before + order.env_steps) - turns_until(order.before);
        let mut rng = stream(self.seed, Purpose::Explore, order.round * MAX_ENVS + number as u64);
        let mut rows = Vec::with_capacity(steps as usize * layout.row_len());
        let mut action = vec![0.0; layout.action_len];
        let mut next = vec![0.0; layout.observation_len];
        // Noise is sampled anew every round, so that a round does not depend on earlier ones.
        let mut exploration = Exploration::new(order, layout.action_len, &mut rng);
        for _ in 0..steps {
            exploration.act(order, policy.as_deref_mut(), &slot.observation, &mut action, &mut rng);
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
                slot.episode.number += envs;
                slot.episode.actions.clear();
                let seed = episode_seed(self.seed, Purpose::TrainingEpisode, slot.episode.number);
                slot.env.reset(seed, &mut slot.observation);
            } else {
                slot.observation.copy_from_slice(&next);
            }
        }
        Ok(rows)
    }
}

/// Exploration in one environment: correlated noise, or random actions.
#[derive(Debug, Clone)]
struct Exploration {
    /// Noise on the policy's action; without a policy, the random action itself.
    values: Vec<f32>,
}

impl Exploration {
    fn new(order: &Order, action_len: usize, rng: &mut ChaCha8Rng) -> Self {
        let mut values = vec![0.0; action_len];
        for value in &mut values {
            *value = fresh(order, rng);
        }
        Self { values }
    }

    /// Writes the noisy action for `observation`, and samples the noise of the next step.
    fn act(
        &mut self,
        order: &Order,
        policy: Option<&mut Policy>,
        observation: &[f32],
        action: &mut [f32],
        rng: &mut ChaCha8Rng,
    ) {
        let kept = order.correlation;
        match policy {
            Some(policy) => {
                policy.act(observation, action);
                for (action, &noise) in action.iter_mut().zip(&self.values) {
                    *action = (*action + noise).clamp(-1.0, 1.0);
                }
                // A first-order autoregressive process of constant variance.
                let new = (1.0 - kept * kept).sqrt();
                for value in &mut self.values {
                    *value = kept * *value + new * fresh(order, rng);
                }
            }
            None => {
                action.copy_from_slice(&self.values);
                // Held for as many steps, on average, as the noise would be correlated.
                if rng.random::<f32>() >= kept {
                    for value in &mut self.values {
                        *value = fresh(order, rng);
                    }
                }
            }
        }
    }
}

/// Uncorrelated noise, or a random action where there is no policy.
fn fresh(order: &Order, rng: &mut ChaCha8Rng) -> f32 {
    match order.policy {
        Some(_) => order.noise * rng.sample::<f32, _>(StandardNormal),
        None => rng.random_range(-1.0..=1.0),
    }
}

#[cfg(test)]
mod tests;
