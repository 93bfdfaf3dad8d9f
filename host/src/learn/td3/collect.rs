//! Gathers experience while the learner learns.
//!
//! Owns the training environments and their episodes. Hand-over happens at
//! fixed points: round `r` is gathered with the weights of the end of round
//! `r - 1`, however long either side takes, so that a seed has one result.
//! Within a round every environment is a piece of work of its own, with random
//! numbers of its own, so that whoever has time takes the next one: the
//! learner too, once its updates are done.
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
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use thiserror::Error;

/// Environments that a run can have: each round has as many streams of random numbers.
pub const MOST_ENVS: u64 = 1_024;

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
    /// Which: environment `i` of `n` plays `i`, `i + n`, `i + 2 n` ...
    pub number: u64,
    /// Every action since its start, one after another.
    pub actions: Vec<f32>,
}

/// What one round asks for.
#[derive(Debug)]
pub struct Order {
    /// Names the random numbers.
    pub round: u64,
    /// Control steps gathered before, over all environments together: they take turns.
    pub before: u64,
    /// Control steps, over all environments together.
    pub env_steps: u64,
    /// Who acts; nobody means uniformly random actions.
    pub policy: Option<Policy>,
    /// Standard deviation of the noise on the policy's actions.
    pub noise: f32,
    /// Share of the noise that a step hands on to the next, over an episode's end, too.
    pub correlation: f32,
}

/// A round under way: who has time takes the next environment.
#[derive(Debug)]
pub struct Round {
    order: Order,
    /// The environment that nobody has taken yet.
    next: AtomicUsize,
    /// What each environment brought, by its number.
    gathered: Mutex<Vec<Share>>,
}

/// One environment's part of a round, as replay rows.
#[derive(Debug)]
struct Share {
    slot: usize,
    rows: Result<Vec<f32>, CollectError>,
}

impl Round {
    /// A round that nobody has begun.
    pub fn new(order: Order) -> Self {
        Self { order, next: AtomicUsize::new(0), gathered: Mutex::new(Vec::new()) }
    }

    /// What was gathered, in the environments' order; whole once all of [`Collector::help`] returned.
    ///
    /// # Errors
    /// [`CollectError`] of the first environment that met one.
    pub fn rows(&self) -> Result<Vec<f32>, CollectError> {
        let mut gathered = self.gathered.lock().unwrap_or_else(PoisonError::into_inner);
        gathered.sort_by_key(|share| share.slot);
        let rows: Result<Vec<Vec<f32>>, _> = gathered.drain(..).map(|share| share.rows).collect();
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
    /// Locked by whoever plays; no two take the same in a round.
    slots: Vec<Mutex<Slot>>,
}

impl Collector {
    /// `count` environments at the start of their first episodes.
    pub fn new(make_env: MakeEnv<'_>, layout: Layout, seed: u64, count: usize) -> Self {
        let first = |number: usize| Episode { number: number as u64, actions: Vec::new() };
        Self::restore(make_env, layout, seed, (0..count).map(first).collect())
    }

    /// Environments in the states that they had, by taking every action again.
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

    /// What [`Self::restore`] needs, between two rounds.
    pub fn episodes(&self) -> Vec<Episode> {
        let episode =
            |slot: &Mutex<Slot>| slot.lock().unwrap_or_else(PoisonError::into_inner).episode.clone();
        self.slots.iter().map(episode).collect()
    }

    /// Plays environments of the round until none is left to take.
    pub fn help(&self, round: &Round) {
        let mut policy = None;
        loop {
            let taken = round.next.fetch_add(1, Ordering::Relaxed);
            let Some(slot) = self.slots.get(taken) else { return };
            let policy = policy.get_or_insert_with(|| round.order.policy.clone());
            // Poisoned only by a panic in the task, which ends the run.
            let mut slot = slot.lock().unwrap_or_else(PoisonError::into_inner);
            let rows = self.play(&mut slot, taken, &round.order, policy.as_mut());
            round.gathered.lock().unwrap_or_else(PoisonError::into_inner).push(Share { slot: taken, rows });
        }
    }

    /// One environment's share of a round, as replay rows.
    fn play(
        &self,
        slot: &mut Slot,
        number: usize,
        order: &Order,
        mut policy: Option<&mut Policy>,
    ) -> Result<Vec<f32>, CollectError> {
        let layout = self.layout;
        let envs = self.slots.len() as u64;
        // Of the steps from `before` on, those that are this environment's turn.
        let turns_until = |steps: u64| (steps + envs - 1 - number as u64) / envs;
        let steps = turns_until(order.before + order.env_steps) - turns_until(order.before);
        let mut rng = stream(self.seed, Purpose::Explore, order.round * MOST_ENVS + number as u64);
        let mut rows = Vec::with_capacity(steps as usize * layout.row_len());
        let mut action = vec![0.0; layout.action_len];
        let mut next = vec![0.0; layout.observation_len];
        // Noise starts afresh every round, so that no round depends on another's.
        let mut excitation = Excitation::new(order, layout.action_len, &mut rng);
        for _ in 0..steps {
            excitation.disturb(order, policy.as_deref_mut(), &slot.observation, &mut action, &mut rng);
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
    fn disturb(
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
