//! The replay buffer: the latest transitions, and random batches of them.
//!
//! Holds a ring buffer of rows in plain memory. Does not depend on time limits: a row
//! says whether its next state is terminal, and that of a truncated episode is
//! bootstrapped (not terminal).

use rand::Rng as _;
use rand_chacha::ChaCha8Rng;

/// Lengths of a transition's parts; a row is observation, action, reward, whether
/// the next state is not terminal, next observation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Layout {
    /// Numbers in an observation.
    pub observation_len: usize,
    /// Numbers in an action.
    pub action_len: usize,
}

impl Layout {
    /// First column of the action.
    pub const fn action(self) -> usize {
        self.observation_len
    }

    /// Column of the reward.
    pub const fn reward(self) -> usize {
        self.observation_len + self.action_len
    }

    /// Column that is 0 if the next state is terminal, otherwise 1: the factor of its value.
    pub const fn not_terminal(self) -> usize {
        self.reward() + 1
    }

    /// First column of the next observation.
    pub const fn next_observation(self) -> usize {
        self.not_terminal() + 1
    }

    /// Numbers in a row.
    pub const fn row_len(self) -> usize {
        self.next_observation() + self.observation_len
    }

    /// Appends one transition to `rows`.
    pub fn push_row(
        self,
        rows: &mut Vec<f32>,
        from: &[f32],
        action: &[f32],
        outcome: &crate::env::Step,
        to: &[f32],
    ) {
        rows.extend_from_slice(from);
        rows.extend_from_slice(action);
        rows.push(outcome.reward);
        // A time limit is not terminal: the task would have gone on beyond it.
        rows.push(if outcome.terminated { 0.0 } else { 1.0 });
        rows.extend_from_slice(to);
    }
}

/// A ring buffer of transitions.
#[derive(Debug, Clone, PartialEq)]
pub struct ReplayBuffer {
    layout: Layout,
    capacity: usize,
    /// Index of the next row once the buffer is full.
    next: usize,
    rows: Vec<f32>,
}

impl ReplayBuffer {
    /// An empty buffer for `capacity` transitions.
    pub fn new(layout: Layout, capacity: usize) -> Self {
        Self { layout, capacity, next: 0, rows: Vec::new() }
    }

    /// A buffer from [`Self::rows`] and [`Self::next`]; `None` if they contradict each other.
    pub fn restore(layout: Layout, capacity: usize, rows: Vec<f32>, next: usize) -> Option<Self> {
        let len = rows.len() / layout.row_len();
        let whole = rows.len().is_multiple_of(layout.row_len());
        let placed = if len == capacity { next < capacity } else { next == 0 };
        (whole && len <= capacity && placed).then_some(Self { layout, capacity, next, rows })
    }

    /// The layout of a row.
    pub fn layout(&self) -> Layout {
        self.layout
    }

    /// Number of transitions.
    pub fn len(&self) -> usize {
        self.rows.len() / self.layout.row_len()
    }

    /// Whether there is no transition yet.
    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// All rows; the oldest is first only until the buffer has wrapped.
    pub fn rows(&self) -> &[f32] {
        &self.rows
    }

    /// Index of the row that the next transition replaces once the buffer is full.
    pub fn next(&self) -> usize {
        self.next
    }

    /// Adds whole rows, in place of the oldest once the buffer is full.
    pub fn extend(&mut self, rows: &[f32]) {
        let width = self.layout.row_len();
        for row in rows.chunks_exact(width) {
            if self.len() < self.capacity {
                self.rows.extend_from_slice(row);
            } else {
                self.rows[self.next * width..][..width].copy_from_slice(row);
                self.next = (self.next + 1) % self.capacity;
            }
        }
    }

    /// Fills `batch` with `count` rows sampled with replacement; the buffer must not be empty.
    pub fn sample(&self, count: usize, rng: &mut ChaCha8Rng, batch: &mut Vec<f32>) {
        let width = self.layout.row_len();
        batch.clear();
        for _ in 0..count {
            let index = rng.random_range(0..self.len());
            batch.extend_from_slice(&self.rows[index * width..][..width]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::random::{Purpose, stream};
    use super::*;
    use crate::env::Step;

    const LAYOUT: Layout = Layout { observation_len: 1, action_len: 1 };

    fn row(number: f32) -> Vec<f32> {
        let mut row = Vec::new();
        let step = Step { reward: number, terminated: false, truncated: false, forward_speed_m_s: 0.0 };
        LAYOUT.push_row(&mut row, &[number], &[number], &step, &[number]);
        row
    }

    fn rewards(replay: &ReplayBuffer) -> Vec<f32> {
        replay.rows().chunks(LAYOUT.row_len()).map(|row| row[LAYOUT.reward()]).collect()
    }

    #[test]
    fn a_full_buffer_replaces_the_oldest_first() {
        let mut replay = ReplayBuffer::new(LAYOUT, 3);

        for number in 0..5 {
            replay.extend(&row(number as f32));
        }

        assert_eq!(rewards(&replay), [3.0, 4.0, 2.0]);
        assert_eq!(replay.next(), 2);
    }

    #[test]
    fn a_time_limit_is_bootstrapped_and_a_fall_is_terminal() {
        let step =
            |terminated, truncated| Step { reward: 1.0, terminated, truncated, forward_speed_m_s: 0.0 };
        let not_terminal = |outcome| {
            let mut row = Vec::new();
            LAYOUT.push_row(&mut row, &[0.0], &[0.0], &outcome, &[0.0]);
            row[LAYOUT.not_terminal()]
        };

        assert_eq!(not_terminal(step(false, true)), 1.0);
        assert_eq!(not_terminal(step(true, false)), 0.0);
        assert_eq!(not_terminal(step(true, true)), 0.0);
    }

    #[test]
    fn batches_reach_every_transition_and_none_that_left() {
        let mut replay = ReplayBuffer::new(LAYOUT, 4);
        for number in 0..6 {
            replay.extend(&row(number as f32));
        }
        let mut batch = Vec::new();

        replay.sample(200, &mut stream(0, Purpose::Sample, 0), &mut batch);

        let mut seen: Vec<u32> = batch.chunks(LAYOUT.row_len()).map(|row| row[0] as u32).collect();
        seen.sort_unstable();
        seen.dedup();
        assert_eq!(seen, [2, 3, 4, 5]);
    }

    #[test]
    fn a_buffer_that_contradicts_itself_is_not_restored() {
        let full: Vec<f32> = [row(0.0), row(1.0)].concat();

        assert!(ReplayBuffer::restore(LAYOUT, 2, full.clone(), 1).is_some());
        assert!(ReplayBuffer::restore(LAYOUT, 2, full.clone(), 2).is_none());
        assert!(ReplayBuffer::restore(LAYOUT, 1, full.clone(), 0).is_none());
        assert!(ReplayBuffer::restore(LAYOUT, 3, full[1..].to_vec(), 0).is_none());
    }
}
