//! Random numbers by purpose and round.
//!
//! Holds the numbering of the random streams. Does not depend on what is sampled.
//! Each purpose has its own ChaCha stream in each round: no generator outlives a
//! round, a checkpoint needs no generator's state, and sampling more for one purpose
//! does not change another.

use rand::RngCore as _;
use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;

/// What random numbers are for; the value is a part of the stream's number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u64)]
pub enum Purpose {
    /// The networks' first parameters.
    Initialise = 0,
    /// Which transitions make a batch.
    Sample = 1,
    /// Target policy smoothing.
    Smooth = 2,
    /// Noise on the actions that gather experience.
    Explore = 3,
    /// Seeds of training episodes.
    TrainingEpisode = 4,
    /// Seeds of evaluation episodes.
    EvaluationEpisode = 5,
    /// Seeds of recorded trials.
    RecordedTrial = 6,
    /// Seeds of the episodes that compare the policies of several seeds.
    CompareEpisode = 7,
}

/// The generator of one purpose in one round (or of one episode, or trial).
pub fn stream(seed: u64, purpose: Purpose, round: u64) -> ChaCha8Rng {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    // No run has 2^56 rounds.
    rng.set_stream((purpose as u64) << 56 | round);
    rng
}

/// The seed that starts episode `index` of a purpose.
pub fn episode_seed(seed: u64, purpose: Purpose, index: u64) -> u64 {
    stream(seed, purpose, index).next_u64()
}
