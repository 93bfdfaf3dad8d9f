//! The same gait from many starts, over all cores.
//!
//! Holds the seeds of the starts: each has its own random stream, so that a start
//! does not depend on how many there are or on the core that plays it. A walk that
//! diverged is an error, so that no NaN enters a mean.

use super::{Trial, Walk, play};
use crate::robot::Robot;
use crate::sim::start::{Perturbation, Start};
use protocol::JOINT_COUNT;
use rand::{RngCore as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use std::panic::{AssertUnwindSafe, catch_unwind};
use thiserror::Error;

/// A number of starts that differ.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Starts {
    /// How much they differ.
    pub perturbation: Perturbation,
    /// Random seed.
    pub seed: u64,
    /// Number of starts.
    pub count: u32,
}

impl Starts {
    /// The start of that number, from 0.
    #[must_use]
    pub fn start(&self, number: u32) -> Start {
        let mut random = ChaCha8Rng::seed_from_u64(self.seed);
        random.set_stream(number.into());
        Start::sampled(&self.perturbation, random.next_u64())
    }
}

/// The simulation diverged.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[error("the simulation of start {start} diverged: speeds or angles became impossible or NaN")]
pub struct Diverged {
    /// Counted from 0.
    pub start: u32,
}

/// Plays `gait` once; `None` if the simulation diverged.
pub fn play_sound(robot: &Robot, trial: &Trial, gait: impl FnMut(f64) -> [f64; JOINT_COUNT]) -> Option<Walk> {
    // A diverged world violates the engine's own assertions, which panic.
    let walk = catch_unwind(AssertUnwindSafe(|| play(robot, trial, gait)));
    walk.ok().filter(Walk::is_sound)
}

/// Plays `gait` from each start, over all cores; walks are in the order of the
/// starts. `trial.start` is ignored.
///
/// # Errors
/// [`Diverged`] for the first start whose simulation diverged.
pub fn play_starts(
    robot: &Robot,
    trial: &Trial,
    starts: &Starts,
    gait: impl Fn(f64) -> [f64; JOINT_COUNT] + Sync,
) -> Result<Vec<Walk>, Diverged> {
    let one = |start: u32| {
        let trial = Trial { start: starts.start(start), ..*trial };
        play_sound(robot, &trial, &gait).ok_or(Diverged { start })
    };
    let walks: Vec<_> = (0..starts.count).into_par_iter().map(one).collect();
    walks.into_iter().collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::LegScale;
    use protocol::LEG_COUNT;
    use std::f64::consts::{PI, TAU};

    const STARTS: Starts =
        Starts { perturbation: Perturbation { friction_share: 0.0, ..USUAL }, seed: 3, count: 5 };
    const USUAL: Perturbation =
        Perturbation { yaw_rad: 0.05, height_m: 0.005, joint_rad: 0.05, friction_share: 0.05 };

    fn trot(t: f64) -> [f64; JOINT_COUNT] {
        let leg = |leg: usize| TAU * t + PI * (leg % 2) as f64;
        std::array::from_fn(
            |j| if j < LEG_COUNT { 0.3 * leg(j).sin() } else { 0.3 * leg(j % LEG_COUNT).cos() },
        )
    }

    fn walks(threads: usize, starts: &Starts) -> Vec<Walk> {
        let robot = Robot::ant(LegScale::LONG).unwrap();
        let trial = Trial { duration_s: 2.0, ..Trial::default() };
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| play_starts(&robot, &trial, starts, trot)).unwrap()
    }

    #[test]
    fn one_core_and_two_walk_the_same_walks_in_the_same_order() {
        let one = walks(1, &STARTS);

        assert_eq!(one, walks(2, &STARTS));
        assert!(one.windows(2).all(|pair| pair[0] != pair[1]), "starts are alike: {one:?}");
    }

    #[test]
    fn a_start_is_the_same_whatever_starts_beside_it() {
        let many = walks(2, &STARTS);

        assert_eq!(many[..2], walks(2, &Starts { count: 2, ..STARTS })[..]);
        assert_ne!(many[1].distance_m, walks(2, &Starts { seed: 4, count: 2, ..STARTS })[0].distance_m);
    }

    #[test]
    fn starts_without_perturbation_are_one_start() {
        let alike = walks(2, &Starts { perturbation: Perturbation::NONE, ..STARTS });

        assert!(alike.windows(2).all(|pair| pair[0] == pair[1]), "{alike:?}");
    }
}
