//! What a control step is worth to the learner: the paper's five terms, and two of ours.
//!
//! Owns the arithmetic and its weights; refuses to look at the world itself,
//! so that each term can be checked by hand. The defaults are the paper's
//! terms with pybullet-gym's constants, which the paper builds on; our two
//! terms are off there.

use serde::{Deserialize, Serialize};

/// A joint beyond this share of its range counts as stuck at its limit.
///
/// # Source
/// pybullet-gym, `robot_locomotors.py`.
pub const AT_LIMIT_SHARE: f64 = 0.99;
/// pybullet-gym sees joint speeds scaled by this, in observation and cost alike.
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

/// Weights of the terms; costs are negative.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RewardConfig {
    /// For each step in which the torso is above `alive_height_m`; lost for each other.
    pub alive: f64,
    /// Between lying and standing.
    pub alive_height_m: f64,
    /// For each m/s along the world's x.
    pub forward: f64,
    /// How effort is measured.
    pub electricity_form: Electricity,
    /// For each unit of effort.
    pub electricity: f64,
    /// For each unit of mean squared action: holding far out costs as well.
    pub stall: f64,
    /// For each joint at its limit.
    pub joint_at_limit: f64,
    /// For each pair of legs that touch.
    pub feet_collision: f64,
    /// Once, for the fall that ends an episode. Ours.
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

/// What the terms look at: one control step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Observed {
    /// Torso's middle above the ground.
    pub torso_height_m: f64,
    /// Displacement over the step, per second, along x and y.
    pub velocity_m_s: [f64; 2],
    /// Heading.
    pub yaw_rad: f64,
    /// As the policy gave it, clipped.
    pub action: [f64; 8],
    /// 1 is the end of the policy's range.
    pub joint_positions: [f64; 8],
    /// At the end of the step.
    pub joint_speeds_rad_s: [f64; 8],
    /// Mean over the step.
    pub servo_power_w: f64,
    /// Pairs of legs that touch.
    pub touching_legs: usize,
}

/// The terms, weighted; their sum is the reward.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct RewardTerms {
    /// Standing up; the cost of a fall included.
    pub alive: f64,
    /// Getting on.
    pub forward: f64,
    /// Effort, stalling included.
    pub electricity: f64,
    /// Joints stuck at their limits.
    pub joints_at_limit: f64,
    /// Legs touching each other.
    pub feet_collision: f64,
    /// Going and facing sideways. Ours.
    pub straightness: f64,
}

impl RewardTerms {
    /// The reward.
    #[must_use]
    pub fn sum(&self) -> f64 {
        self.alive
            + self.forward
            + self.electricity
            + self.joints_at_limit
            + self.feet_collision
            + self.straightness
    }
}

fn mean(values: impl Iterator<Item = f64>) -> f64 {
    values.sum::<f64>() / 8.0
}

impl RewardConfig {
    /// Weighs one control step.
    #[must_use]
    pub fn weigh(&self, seen: &Observed) -> RewardTerms {
        let effort = match self.electricity_form {
            Electricity::ActionTimesSpeed => mean(
                seen.action
                    .iter()
                    .zip(&seen.joint_speeds_rad_s)
                    .map(|(a, speed)| (a * JOINT_SPEED_SCALE * speed).abs()),
            ),
            Electricity::ServoPower => seen.servo_power_w,
        };
        let at_limit = seen.joint_positions.iter().filter(|q| q.abs() > AT_LIMIT_SHARE).count();
        RewardTerms {
            alive: if seen.torso_height_m > self.alive_height_m { self.alive } else { -self.alive },
            forward: self.forward * seen.velocity_m_s[0],
            electricity: self.electricity * effort + self.stall * mean(seen.action.iter().map(|a| a * a)),
            joints_at_limit: self.joint_at_limit * at_limit as f64,
            feet_collision: self.feet_collision * seen.touching_legs as f64,
            straightness: self.drift * seen.velocity_m_s[1].abs() + self.heading * seen.yaw_rad.abs(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn walking() -> Observed {
        Observed {
            torso_height_m: 0.15,
            velocity_m_s: [0.12, -0.03],
            yaw_rad: -0.2,
            action: [0.5, -0.5, 1.0, 0.0, 0.0, 0.0, 0.0, -1.0],
            joint_positions: [0.5, -0.5, 0.995, 0.0, 0.0, 0.0, 0.0, -1.01],
            joint_speeds_rad_s: [2.0, -1.0, 0.0, 2.0, 0.0, 0.0, 0.0, 1.0],
            servo_power_w: 0.6,
            touching_legs: 1,
        }
    }

    fn assert_near(value: f64, expected: f64) {
        assert!((value - expected).abs() < 1e-12, "{value} is not {expected}");
    }

    #[test]
    fn the_papers_five_terms_are_as_worked_out_by_hand() {
        let terms = RewardConfig::default().weigh(&walking());

        assert_near(terms.alive, 1.0);
        assert_near(terms.forward, 0.12);
        // |0.5*2| + |0.5*1| + |1*0| + |1*1| = 2.5, by 0.1, over 8, by -2; squares 0.25+0.25+1+1 = 2.5.
        assert_near(terms.electricity, -2.0 * 0.25 / 8.0 - 0.1 * 2.5 / 8.0);
        assert_near(terms.joints_at_limit, -0.2);
        assert_near(terms.feet_collision, -1.0);
        assert_near(terms.straightness, 0.0);
        assert_near(terms.sum(), 1.0 + 0.12 - 0.09375 - 0.2 - 1.0);
    }

    #[test]
    fn a_torso_at_five_centimetres_or_less_is_not_alive() {
        let lying = Observed { torso_height_m: 0.05, ..walking() };

        assert_near(RewardConfig::default().weigh(&lying).alive, -1.0);
    }

    #[test]
    fn electricity_can_be_the_servos_true_power() {
        let config = RewardConfig {
            electricity_form: Electricity::ServoPower,
            electricity: -0.5,
            stall: 0.0,
            ..RewardConfig::default()
        };

        assert_near(config.weigh(&walking()).electricity, -0.3);
    }

    #[test]
    fn drift_and_heading_cost_either_way() {
        let config = RewardConfig { drift: -1.0, heading: -0.5, ..RewardConfig::default() };

        assert_near(config.weigh(&walking()).straightness, -0.03 - 0.1);
    }
}
