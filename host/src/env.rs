//! The interface between a learner and a task.
//!
//! Holds the trait alone, so that `td3` does not depend on rapier, nor `sim` on tch.

/// One control step's outcome.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Step {
    /// Dimensionless, as the task defines it.
    pub reward: f32,
    /// The task ended by itself: its value is zero from here on.
    pub terminated: bool,
    /// The time limit cut the episode: its value goes on from here.
    pub truncated: bool,
    /// Speed towards the goal, for people to read; no part of the learning.
    pub forward_speed_m_s: f32,
}

/// A task in discrete control steps, actions in [-1, 1].
pub trait Env: Send {
    /// Numbers in an observation.
    fn observation_len(&self) -> usize;

    /// Numbers in an action.
    fn action_len(&self) -> usize;

    /// Starts an episode; the same seed starts the same episode.
    fn reset(&mut self, seed: u64, observation: &mut [f32]);

    /// Advances one control step. An action outside [-1, 1] is clipped.
    fn step(&mut self, action: &[f32], observation: &mut [f32]) -> Step;
}
