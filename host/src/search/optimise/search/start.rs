//! The gaits that a search is initialised with.
//!
//! Holds how they are sampled. Does not depend on the stages of a search.

use crate::search::optimise::space::{Motion, Space};
use protocol::{JOINT_COUNT, LEG_COUNT};
use rand::Rng;
use rand_chacha::ChaCha8Rng;

/// A known gait is more than a sine.
const WAVES_OF_A_GAIT: usize = 2;

/// Where a search starts.
#[derive(Debug, Clone, PartialEq)]
pub enum Start {
    /// Random gaits.
    Nothing,
    /// Diagonal legs together, or each by itself, swung by sines.
    Sinusoid,
    /// A known gait, at the stroke that it was learned at.
    Gait(Box<Motion>),
}

impl Start {
    /// Waves per stride of the first curves.
    pub(super) fn waves(&self) -> usize {
        match self {
            Self::Nothing | Self::Sinusoid => 1,
            Self::Gait(_) => WAVES_OF_A_GAIT,
        }
    }

    /// A point to start from; of a gait, number 0 is the gait itself.
    pub(super) fn point(&self, space: &Space, number: usize, random: &mut ChaCha8Rng) -> Vec<f64> {
        match self {
            Self::Nothing => random_point(space, random),
            Self::Sinusoid => space.point(&sinusoid(space, random)),
            Self::Gait(motion) => varied(space, motion, number, random),
        }
    }
}

/// Joints that swing independently.
fn random_point(space: &Space, random: &mut ChaCha8Rng) -> Vec<f64> {
    (0..space.dimension()).map(|_| 1.5 * random.random_range(-1.0..=1.0)).collect()
}

/// Legs that swing forwards while their shins are lifted, in the order of a trot or of any other gait.
fn sinusoid(space: &Space, random: &mut ChaCha8Rng) -> Motion {
    use core::f64::consts::{FRAC_PI_2, PI, TAU};
    let mut within = |low: f64, high: f64| random.random_range(low..=high);
    let (swing_deg, lift_deg) = (within(5.0, 25.0), within(2.0, 20.0));
    let period_s = within(0.4, 1.6);
    let trot = within(0.0, 1.0) < 0.5;
    let phases = [0.0, PI, 0.0, PI].map(|phase| if trot { phase } else { within(0.0, TAU) });
    let lead = FRAC_PI_2 + within(-0.7, 0.7);
    let (hip_deg, knee_deg) = (within(-5.0, 5.0), within(-10.0, 10.0));
    // Seen from above hips turn counter-clockwise: forwards for two legs, backwards for the others.
    let forwards = [-1.0, -1.0, 1.0, 1.0];
    let mut centres_deg = [0.0; JOINT_COUNT];
    let mut waves = [[0.0; 2]; JOINT_COUNT];
    for leg in 0..LEG_COUNT {
        centres_deg[leg] = hip_deg;
        centres_deg[LEG_COUNT + leg] = knee_deg;
        let swing = forwards[leg] * swing_deg;
        waves[leg] = [swing * phases[leg].cos(), -swing * phases[leg].sin()];
        let lifted = phases[leg] + lead;
        waves[LEG_COUNT + leg] = [lift_deg * lifted.cos(), -lift_deg * lifted.sin()];
    }
    space.swinging(period_s, centres_deg, &waves)
}

/// A known gait: first as it is, then faster, slower, wider or narrower, with some noise.
fn varied(space: &Space, motion: &Motion, number: usize, random: &mut ChaCha8Rng) -> Vec<f64> {
    let mut point = space.point(motion);
    if number > 0 {
        let centres = 1 + JOINT_COUNT;
        let stroke = random.random_range(0.6..=1.4);
        point[0] += random.random_range(-3.0..=1.0);
        point.iter_mut().skip(centres).for_each(|n| *n *= stroke);
        point.iter_mut().skip(1).for_each(|n| *n += 0.2 * random.random_range(-1.0..=1.0));
    }
    point
}
