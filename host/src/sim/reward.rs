//! The reward of a control step: its terms, their weights and their sum.
//!
//! Holds one table, [`TERMS`], with a row for each term: the paper's, and some of
//! ours. Does not depend on the world: it sees a step as [`Observed`] numbers, so
//! that each term can be checked by hand. The default weights are pybullet-gym's,
//! which the paper builds on; our terms are off there.
//!
//! A term is complete when it has a weight in [`RewardConfig`] and a row in
//! [`TERMS`], in `configs/paper.toml` and in the table of `docs/learning.md`. The
//! tests of this module and of `learn::run_config` name a term that lacks one of them.

use protocol::JOINT_COUNT;
use serde::{Deserialize, Serialize};

/// A joint beyond this share of its range counts as stuck at its limit.
///
/// # Source
/// pybullet-gym, `robot_locomotors.py`.
pub const AT_LIMIT_SHARE: f64 = 0.99;
/// Scale of the joint speeds in rad/s, in observation and cost alike.
///
/// # Source
/// pybullet-gym.
pub const JOINT_SPEED_SCALE: f64 = 0.1;

/// How the electricity term measures effort.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Electricity {
    /// pybullet-gym's `mean |action * 0.1 joint speed|`. It means power where an
    /// action is a torque; for position targets it is only a cost on moving far out.
    ActionTimesSpeed,
    /// Electrical power of the servos, in watts.
    ServoPower,
}

/// Weights of the terms, and the two settings that terms need; costs are negative.
///
/// This is `[env.reward]` of a configuration. A weight has the name of its row in [`TERMS`].
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RewardConfig {
    /// Added in each step with the torso above `alive_height_m`, subtracted in each other.
    pub alive: f64,
    /// Height of the torso's middle that separates lying from standing. No weight.
    pub alive_height_m: f64,
    /// For each m/s along the world's x.
    pub forward: f64,
    /// How effort is measured. No weight.
    pub electricity_form: Electricity,
    /// For each unit of effort.
    pub electricity: f64,
    /// For each unit of mean squared action: holding a joint far out costs as well.
    pub stall: f64,
    /// For each joint at its limit.
    pub joint_at_limit: f64,
    /// For each pair of legs that touch.
    pub feet_collision: f64,
    /// Once, in the step whose fall ends an episode. Ours.
    pub fall: f64,
    /// For each m/s across, either way. Ours.
    pub drift: f64,
    /// For each radian away from the x axis, either way. Ours.
    pub heading: f64,
}

impl Default for RewardConfig {
    /// # Source
    /// Paper, section 2.2, for the terms; pybullet-gym for the weights, which
    /// the paper does not give. pybullet-gym has the feet's term commented out.
    fn default() -> Self {
        Self {
            alive: 1.0,
            alive_height_m: 0.05,
            forward: 1.0,
            electricity_form: Electricity::ActionTimesSpeed,
            electricity: -2.0,
            stall: -0.1,
            joint_at_limit: -0.1,
            feet_collision: -1.0,
            fall: 0.0,
            drift: 0.0,
            heading: 0.0,
        }
    }
}

/// One control step, as the terms see it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Observed {
    /// Torso's middle above the ground.
    pub torso_height_m: f64,
    /// Displacement over the step, per second, along x and y.
    pub velocity_m_s: [f64; 2],
    /// Heading, counter-clockwise from x.
    pub yaw_rad: f64,
    /// As the policy gave it, clipped.
    pub action: [f64; JOINT_COUNT],
    /// 1 is the end of the policy's range.
    pub joint_positions: [f64; JOINT_COUNT],
    /// At the end of the step.
    pub joint_speeds_rad_s: [f64; JOINT_COUNT],
    /// Mean over the step.
    pub servo_power_w: f64,
    /// Pairs of legs that touch.
    pub touching_legs: usize,
    /// Whether the step ended the episode by a fall.
    pub fell: bool,
}

/// The parts of the reward, in the order in which they are added.
///
/// A part's terms are added first. Floating-point sums depend on the order, and
/// with it every trained policy: add new parts at the end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Part {
    /// Standing up.
    Alive,
    /// Getting on.
    Forward,
    /// Effort.
    Electricity,
    /// Joints stuck at their limits.
    Limit,
    /// Legs touching each other.
    Collision,
    /// Going and facing sideways. Ours.
    Straightness,
}

impl Part {
    /// All parts, in the order in which they are added.
    pub const ALL: [Self; 6] =
        [Self::Alive, Self::Forward, Self::Electricity, Self::Limit, Self::Collision, Self::Straightness];
}

/// One term of the reward: a row of [`TERMS`].
#[derive(Debug)]
pub struct Term {
    /// The weight's name in [`RewardConfig`] and in `[env.reward]`.
    pub name: &'static str,
    /// The part to which it is added.
    pub part: Part,
    /// Its weight in a configuration.
    pub weight: fn(&RewardConfig) -> f64,
    /// What is weighed, of one control step.
    pub value: fn(&RewardConfig, &Observed) -> f64,
}

/// Every term of the reward; those of one part in the order in which they are added.
pub const TERMS: [Term; 9] = [
    Term {
        name: "alive",
        part: Part::Alive,
        weight: |config| config.alive,
        value: |config, seen| if seen.torso_height_m > config.alive_height_m { 1.0 } else { -1.0 },
    },
    Term {
        name: "fall",
        part: Part::Alive,
        weight: |config| config.fall,
        value: |_, seen| if seen.fell { 1.0 } else { 0.0 },
    },
    Term {
        name: "forward",
        part: Part::Forward,
        weight: |config| config.forward,
        value: |_, seen| seen.velocity_m_s[0],
    },
    Term {
        name: "electricity",
        part: Part::Electricity,
        weight: |config| config.electricity,
        value: |config, seen| match config.electricity_form {
            Electricity::ActionTimesSpeed => mean(
                seen.action
                    .iter()
                    .zip(&seen.joint_speeds_rad_s)
                    .map(|(a, speed)| (a * JOINT_SPEED_SCALE * speed).abs()),
            ),
            Electricity::ServoPower => seen.servo_power_w,
        },
    },
    Term {
        name: "stall",
        part: Part::Electricity,
        weight: |config| config.stall,
        value: |_, seen| mean(seen.action.iter().map(|a| a * a)),
    },
    Term {
        name: "joint_at_limit",
        part: Part::Limit,
        weight: |config| config.joint_at_limit,
        value: |_, seen| seen.joint_positions.iter().filter(|q| q.abs() > AT_LIMIT_SHARE).count() as f64,
    },
    Term {
        name: "feet_collision",
        part: Part::Collision,
        weight: |config| config.feet_collision,
        value: |_, seen| seen.touching_legs as f64,
    },
    Term {
        name: "drift",
        part: Part::Straightness,
        weight: |config| config.drift,
        value: |_, seen| seen.velocity_m_s[1].abs(),
    },
    Term {
        name: "heading",
        part: Part::Straightness,
        weight: |config| config.heading,
        value: |_, seen| seen.yaw_rad.abs(),
    },
];

/// Over the joints.
fn mean(values: impl Iterator<Item = f64>) -> f64 {
    values.sum::<f64>() / JOINT_COUNT as f64
}

/// The weighted terms of one control step, in the order of [`TERMS`].
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct RewardTerms([f64; TERMS.len()]);

impl RewardTerms {
    /// Each term's name and what it adds to the reward.
    pub fn by_name(&self) -> impl Iterator<Item = (&'static str, f64)> + '_ {
        TERMS.iter().map(|term| term.name).zip(self.0)
    }

    /// The reward: terms are added to their part, then the parts.
    #[must_use]
    pub fn sum(&self) -> f64 {
        // Minus zero changes no sum, where zero would change the sign of a zero.
        Part::ALL.iter().fold(-0.0, |reward, part| {
            let of_part = TERMS.iter().zip(self.0).filter(|(term, _)| term.part == *part);
            reward + of_part.fold(-0.0, |sum, (_, weighted)| sum + weighted)
        })
    }
}

impl RewardConfig {
    /// Weighs one control step.
    #[must_use]
    pub fn weigh(&self, seen: &Observed) -> RewardTerms {
        RewardTerms(TERMS.each_ref().map(|term| (term.weight)(self) * (term.value)(self, seen)))
    }
}

#[cfg(test)]
mod tests;
