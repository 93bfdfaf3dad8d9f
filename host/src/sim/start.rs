//! The start of an episode or trial: exact, or perturbed by a seed.
//!
//! Holds the random numbers of a start. Does not depend on the world.

use protocol::JOINT_COUNT;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

/// Ranges of the random differences between starts; all uniform.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Perturbation {
    /// Heading, either way.
    pub yaw_rad: f64,
    /// Dropped from up to this height above standing.
    pub height_m: f64,
    /// Each joint's angle, either way.
    pub joint_rad: f64,
    /// Ground friction, either way, as a share of itself.
    pub friction_share: f64,
}

impl Default for Perturbation {
    /// # Source
    /// Ours: enough that 20 trials differ, too little to start a fall.
    fn default() -> Self {
        Self { yaw_rad: 0.05, height_m: 0.005, joint_rad: 0.05, friction_share: 0.05 }
    }
}

impl Perturbation {
    /// Every start is the same.
    pub const NONE: Self = Self { yaw_rad: 0.0, height_m: 0.0, joint_rad: 0.0, friction_share: 0.0 };
}

/// One start: what differs from standing at neutral.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Start {
    /// Heading.
    pub yaw_rad: f64,
    /// Above standing.
    pub drop_m: f64,
    /// Added to each joint angle.
    pub joint_offsets_rad: [f64; JOINT_COUNT],
    /// Added to 1, times the robot's ground friction.
    pub friction_share: f64,
}

impl Start {
    /// Samples a start; the same seed gives the same start.
    #[must_use]
    pub fn sampled(perturbation: &Perturbation, seed: u64) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut either_way = |range: f64| range * random.random_range(-1.0..=1.0);
        Self {
            yaw_rad: either_way(perturbation.yaw_rad),
            drop_m: either_way(perturbation.height_m).abs(),
            joint_offsets_rad: core::array::from_fn(|_| either_way(perturbation.joint_rad)),
            friction_share: either_way(perturbation.friction_share),
        }
    }
}
