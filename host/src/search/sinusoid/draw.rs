//! Random numbers of a search: its design, its starts, and the surrogate's seeds.
//!
//! Holds the streams of its seed, one for each purpose, so that more numbers of
//! one kind change no other. Does not depend on what they are used for.

use rand::seq::SliceRandom as _;
use rand::{Rng as _, RngCore as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;

/// Streams of the seed.
#[derive(Clone, Copy)]
#[repr(u64)]
pub(super) enum Stream {
    /// The hypercube.
    Design,
    /// Starts of the search's episodes.
    Starts,
    /// Starts of the last comparison's episodes.
    FinalStarts,
    /// Seeds of the surrogate.
    Surrogate,
    /// Seeds of the rounds after the first.
    Rounds,
}

/// A generator of its own for each stream.
pub(super) fn stream(seed: u64, stream: Stream) -> ChaCha8Rng {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    random.set_stream(stream as u64);
    random
}

/// Seeds of episodes, or of rounds.
pub(super) fn seeds(seed: u64, which: Stream, count: usize) -> Vec<u64> {
    let mut random = stream(seed, which);
    (0..count).map(|_| random.next_u64()).collect()
}

/// A Latin hypercube in the unit cube: each number has one value in each of `count` equal parts.
pub(super) fn hypercube(count: usize, dimension: usize, seed: u64) -> Vec<Vec<f64>> {
    let mut random = stream(seed, Stream::Design);
    let mut points = vec![vec![0.0; dimension]; count];
    for number in 0..dimension {
        let mut parts: Vec<usize> = (0..count).collect();
        parts.shuffle(&mut random);
        for (point, part) in points.iter_mut().zip(parts) {
            point[number] = (part as f64 + random.random::<f64>()) / count as f64;
        }
    }
    points
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_hypercube_has_every_part_of_every_number_once_and_another_seed_another() {
        let points = hypercube(20, 3, 7);

        for number in 0..3 {
            let mut parts: Vec<usize> = points.iter().map(|point| (20.0 * point[number]) as usize).collect();
            parts.sort_unstable();
            assert!(parts.into_iter().eq(0..20), "number {number}");
        }
        assert_eq!(points, hypercube(20, 3, 7));
        assert_ne!(points, hypercube(20, 3, 8));
    }
}
