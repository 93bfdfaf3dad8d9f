//! The Ant's task: walk along the world's x axis at 60 decisions a second.
//!
//! Holds the meaning of actions and observations and the end of an episode. Does
//! not depend on a learner.
//!
//! An action is eight position targets, 1 = 45 degrees from neutral, hips 1 to
//! 4, then knees 1 to 4. The body is the same on all four sides, so any direction
//! would do; x lies between legs 4 and 1.
//!
//! # Observation
//! | index | what | unit, frame |
//! |---|---|---|
//! | 0 | height of the torso's middle | m |
//! | 1..5 | orientation quaternion x, y, z, w, with w >= 0 | torso to world |
//! | 5..13 | joint angles, in the order of the action | 1 = 45 degrees |
//! | 13..16 | velocity of the torso | m/s, world |
//! | 16..19 | angular velocity of the torso | rad/s, world |
//! | 19..27 | joint speeds, in the order of the action | 0.1 rad/s |
//!
//! # Source
//! Paper, section 2.2: the model's 111 observations without the torso's x and
//! y and without external forces; the scaling of joint angles and speeds is
//! pybullet-gym's.

use super::randomisation::{Randomisation, Robots};
use super::reward::{JOINT_SPEED_SCALE, Observed, RewardConfig, RewardTerms};
use super::start::{Perturbation, Start};
use super::torso::TorsoState;
use super::world::World;
use crate::env::{Env, Step};
use crate::gait::scale::POLICY_DEG_PER_ACTION;
use crate::robot::Robot;
use protocol::{JOINT_COUNT, LEG_COUNT};
use serde::{Deserialize, Serialize};

/// Numbers in an observation.
pub const OBSERVATION_LEN: usize = 27;
/// Numbers in an action.
pub const ACTION_LEN: usize = JOINT_COUNT;
/// Control steps in a second.
pub const CONTROL_RATE_HZ: f64 = protocol::FRAME_RATE_HZ as f64;
/// Degrees from neutral of an action of 1.
///
/// # Source
/// Paper, Table 1, "joint gear".
pub const ACTION_DEG: f64 = POLICY_DEG_PER_ACTION;

/// Legs whose middle lines are nearer than this touch: two tubes and some servo.
const TOUCHING_M: f64 = 0.02;

/// `[env]` of a configuration: the task.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct AntEnvConfig {
    /// An episode is cut after this many control steps; 0 never cuts.
    pub episode_steps: u32,
    /// The setpoint of the servos moves no faster than this; without a limit it
    /// jumps to the action. A policy trained with the limit learns a gait that
    /// servos, and a table played open loop, can follow.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub slew_limit_rad_s: Option<f64>,
    /// The setpoint stays within this many action units either way. Below 1 it
    /// leaves room to play the gait at more than the policy's own stroke
    /// before a joint meets its limit.
    pub setpoint_limit: f64,
    /// A torso that leans farther than this has fallen: the episode ends. A
    /// tight limit takes the gain out of lunging forward and toppling over.
    pub max_tilt_rad: f64,
    /// How much starts differ.
    pub start: Perturbation,
    /// How much the robots of episodes differ from the described one.
    pub randomisation: Randomisation,
    /// Weights of the reward.
    pub reward: RewardConfig,
}

impl Default for AntEnvConfig {
    /// The paper's task; 1000 steps is pybullet-gym's time limit.
    fn default() -> Self {
        Self {
            episode_steps: 1000,
            slew_limit_rad_s: None,
            setpoint_limit: 1.0,
            max_tilt_rad: 1.0,
            start: Perturbation::default(),
            randomisation: Randomisation::NONE,
            reward: RewardConfig::default(),
        }
    }
}

/// The Ant in its world, as an [`Env`].
pub struct AntEnv {
    world: World,
    config: AntEnvConfig,
    /// Samples a robot for each episode, if randomisation is on.
    robots: Option<Robots>,
    /// The servos' setpoints, in action units, after the slew limit.
    setpoint_action: [f64; JOINT_COUNT],
    torso: TorsoState,
    steps: u32,
    terms: RewardTerms,
    servo_power_w: f64,
}

impl AntEnv {
    /// The described robot, standing; call [`Env::reset`] before the first step.
    #[must_use]
    pub fn new(robot: &Robot, config: AntEnvConfig) -> Self {
        let world = World::new(robot);
        let torso = world.torso();
        Self {
            world,
            config,
            robots: Robots::like(robot, config.randomisation),
            setpoint_action: [0.0; JOINT_COUNT],
            torso,
            steps: 0,
            terms: RewardTerms::default(),
            servo_power_w: 0.0,
        }
    }

    /// The servos' present setpoints, in action units: the last action after the
    /// slew limit. Sampled every step, this is the gait to record.
    #[must_use]
    pub fn setpoint_action(&self) -> [f64; JOINT_COUNT] {
        self.setpoint_action
    }

    /// The weighted terms of the last step's reward.
    #[must_use]
    pub fn reward_terms(&self) -> RewardTerms {
        self.terms
    }

    /// Mean electrical power of the servos over the last step.
    #[must_use]
    pub fn servo_power_w(&self) -> f64 {
        self.servo_power_w
    }

    /// The world, with the episode's robot in it.
    #[must_use]
    pub fn world(&self) -> &World {
        &self.world
    }

    /// Moves the setpoint towards the action, no faster than the limit.
    fn slew(&mut self, action: &[f64; JOINT_COUNT]) {
        let reach = self
            .config
            .slew_limit_rad_s
            .map_or(f64::INFINITY, |limit| limit / ACTION_DEG.to_radians() / CONTROL_RATE_HZ);
        // Not `clamp`, which panics where the limit is NaN.
        let limit = self.config.setpoint_limit;
        for (setpoint, &asked) in self.setpoint_action.iter_mut().zip(action) {
            let asked = asked.min(limit).max(-limit);
            *setpoint += (asked - *setpoint).clamp(-reach, reach);
        }
    }

    fn observe(&self, observation: &mut [f32]) {
        let TorsoState { position_m, orientation_xyzw, velocity_m_s, angular_velocity_rad_s } = self.torso;
        // q and -q are the same orientation: show the policy only one of them.
        let sign = if orientation_xyzw[3] < 0.0 { -1.0 } else { 1.0 };
        let numbers = core::iter::once(position_m[2])
            .chain(orientation_xyzw.map(|q| sign * q))
            .chain(self.joint_positions())
            .chain(velocity_m_s)
            .chain(angular_velocity_rad_s)
            .chain(self.world.joint_speeds_rad_s().map(|speed| JOINT_SPEED_SCALE * speed));
        for (place, number) in observation.iter_mut().zip(numbers) {
            *place = number as f32;
        }
    }

    fn joint_positions(&self) -> [f64; JOINT_COUNT] {
        self.world.joint_angles_rad().map(|angle| angle.to_degrees() / ACTION_DEG)
    }

    /// Pairs of neighbouring legs whose shins touch; opposite ones cannot meet.
    fn touching_legs(&self) -> usize {
        let (knees, feet) = (self.world.knees_m(), self.world.feet_m());
        (0..LEG_COUNT)
            .filter(|&leg| {
                let next = (leg + 1) % LEG_COUNT;
                segment_distance_m([knees[leg], feet[leg]], [knees[next], feet[next]]) < TOUCHING_M
            })
            .count()
    }
}

impl Env for AntEnv {
    fn observation_len(&self) -> usize {
        OBSERVATION_LEN
    }

    fn action_len(&self) -> usize {
        ACTION_LEN
    }

    fn reset(&mut self, seed: u64, observation: &mut [f32]) {
        let start = Start::sampled(&self.config.start, seed);
        match &self.robots {
            Some(robots) => self.world.reset_as(robots.sampled(seed), &[0.0; JOINT_COUNT], &start),
            None => self.world.reset(&[0.0; JOINT_COUNT], &start),
        }
        self.setpoint_action = start.joint_offsets_rad.map(|angle| angle.to_degrees() / ACTION_DEG);
        self.torso = self.world.torso();
        self.steps = 0;
        self.terms = RewardTerms::default();
        self.servo_power_w = 0.0;
        self.observe(observation);
    }

    fn step(&mut self, action: &[f32], observation: &mut [f32]) -> Step {
        // A missing number or NaN leaves the setpoint as it is.
        let action = core::array::from_fn(|j| match action.get(j) {
            Some(a) if !a.is_nan() => f64::from(a.clamp(-1.0, 1.0)),
            _ => self.setpoint_action[j],
        });
        self.slew(&action);
        let setpoints = self.setpoint_action.map(|a| Some((a * ACTION_DEG).to_radians()));
        let before_m = self.torso.position_m;
        let mut servo_power_w = 0.0;
        for _ in 0..World::STEPS_PER_FRAME {
            servo_power_w += self.world.step(&setpoints).servo_power_w;
        }
        self.servo_power_w = servo_power_w / World::STEPS_PER_FRAME as f64;
        self.torso = self.world.torso();
        self.steps += 1;
        self.observe(observation);

        let velocity_m_s =
            [0, 1].map(|axis| (self.torso.position_m[axis] - before_m[axis]) * CONTROL_RATE_HZ);
        let terminated = self.torso.position_m[2] <= self.config.reward.alive_height_m
            || self.torso.tilt_rad() > self.config.max_tilt_rad;
        let truncated =
            !terminated && self.config.episode_steps > 0 && self.steps >= self.config.episode_steps;
        self.terms = self.config.reward.weigh(&Observed {
            torso_height_m: self.torso.position_m[2],
            velocity_m_s,
            yaw_rad: self.torso.yaw_rad(),
            action,
            joint_positions: self.joint_positions(),
            joint_speeds_rad_s: self.world.joint_speeds_rad_s(),
            servo_power_w: self.servo_power_w,
            touching_legs: self.touching_legs(),
            fell: terminated,
        });
        Step {
            reward: self.terms.sum() as f32,
            terminated,
            truncated,
            forward_speed_m_s: velocity_m_s[0] as f32,
        }
    }
}

/// Minimum distance between two segments, each given by its ends.
fn segment_distance_m(a: [[f64; 3]; 2], b: [[f64; 3]; 2]) -> f64 {
    let minus = |p: [f64; 3], q: [f64; 3]| [p[0] - q[0], p[1] - q[1], p[2] - q[2]];
    let dot = |p: [f64; 3], q: [f64; 3]| p[0] * q[0] + p[1] * q[1] + p[2] * q[2];
    let (along_a, along_b, between) = (minus(a[1], a[0]), minus(b[1], b[0]), minus(a[0], b[0]));
    let (aa, bb, ab) = (dot(along_a, along_a), dot(along_b, along_b), dot(along_a, along_b));
    let (a_between, b_between) = (dot(along_a, between), dot(along_b, between));
    // Nearest points of the two lines, clamped to one segment and then to the other.
    let determinant = aa * bb - ab * ab;
    let at_a = if determinant > 1e-9 * aa * bb {
        ((ab * b_between - bb * a_between) / determinant).clamp(0.0, 1.0)
    } else {
        0.0
    };
    let at_b = ((ab * at_a + b_between) / bb).clamp(0.0, 1.0);
    let at_a = ((ab * at_b - a_between) / aa).clamp(0.0, 1.0);
    let gap: [f64; 3] = core::array::from_fn(|i| between[i] + at_a * along_a[i] - at_b * along_b[i]);
    dot(gap, gap).sqrt()
}

#[cfg(test)]
mod tests;
