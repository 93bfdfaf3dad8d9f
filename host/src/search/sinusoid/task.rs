//! The score of a gait: the learning task's reward, played open loop.
//!
//! Holds the episodes. The environment is the one that policies learn in, ends
//! and limits included, so every term of its reward counts; the gait is its
//! actions, 60 per second. Does not depend on how gaits are searched. The slew limit changes the first strokes of an
//! episode, while the legs come from where they were put to where the gait is,
//! and nothing after: [`super::wave::bounds`] keeps the gait within it.

use crate::energy::STANDARD_GRAVITY_M_S2;
use crate::env::Env as _;
use crate::robot::Robot;
use crate::search::optimise::space::Motion;
use crate::sim::ant_env::{ACTION_DEG, ACTION_LEN, CONTROL_RATE_HZ, OBSERVATION_LEN};
use crate::sim::{AntEnv, AntEnvConfig};
use rayon::prelude::*;
use serde::Serialize;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// Means over the episodes of a gait.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct GaitScore {
    /// Reward over the steps that the episodes were to last; steps after a fall count as 0.
    pub reward_per_step: f64,
    /// Along the world's x, over the time that it walked.
    pub speed_m_s: f64,
    /// Servos and electronics.
    pub power_w: f64,
    /// Energy per weight and distance along x; infinite if it got nowhere, or backwards.
    pub cost_of_transport: f64,
    /// Episodes that ended by a fall.
    pub falls: usize,
    /// Control steps that were simulated.
    pub steps: u64,
}

impl GaitScore {
    /// The score of a gait that was not tried.
    pub const NOTHING: Self = Self {
        reward_per_step: 0.0,
        speed_m_s: 0.0,
        power_w: 0.0,
        cost_of_transport: f64::INFINITY,
        falls: 0,
        steps: 0,
    };
}

/// Control steps as simulated time.
#[must_use]
pub fn seconds(steps: u64) -> f64 {
    steps as f64 / CONTROL_RATE_HZ
}

/// A robot and what it is rewarded for.
#[derive(Debug, Clone, Copy)]
pub struct Task<'a> {
    /// Whose gait it is.
    pub robot: &'a Robot,
    /// The preset's.
    pub env: AntEnvConfig,
}

/// Sums over an episode.
#[derive(Debug, Clone, Copy, Default)]
struct Episode {
    reward: f64,
    forward_m: f64,
    energy_j: f64,
    weight_n: f64,
    steps: u64,
    fell: bool,
}

impl Task<'_> {
    /// Control steps of an episode without a fall.
    #[must_use]
    pub fn episode_steps(&self) -> u64 {
        u64::from(self.env.episode_steps).max(1)
    }

    /// Plays each motion from each start, on all cores; the scores do not depend on how many there
    /// are.
    #[must_use]
    pub fn scores(&self, motions: &[Motion], starts: &[u64]) -> Vec<GaitScore> {
        let all: Vec<(usize, u64)> =
            (0..motions.len()).flat_map(|m| starts.iter().map(move |&start| (m, start))).collect();
        let episodes: Vec<Episode> =
            all.into_par_iter().map(|(m, start)| self.sound(&motions[m], start)).collect();
        episodes.chunks(starts.len().max(1)).map(|episodes| self.mean(episodes)).collect()
    }

    /// An episode; a simulation that diverged counts as an immediate fall.
    fn sound(&self, motion: &Motion, start: u64) -> Episode {
        // A simulation that diverges triggers assertions of the engine.
        let episode = catch_unwind(AssertUnwindSafe(|| self.play(motion, start)));
        let is_sound = |episode: &Episode| {
            [episode.reward, episode.forward_m, episode.energy_j].iter().all(|sum| sum.is_finite())
        };
        episode.ok().filter(is_sound).unwrap_or(Episode {
            weight_n: 1.0,
            steps: self.episode_steps(),
            fell: true,
            ..Episode::default()
        })
    }

    fn play(&self, motion: &Motion, start: u64) -> Episode {
        let mut env = AntEnv::new(self.robot, self.env);
        let mut observation = [0.0; OBSERVATION_LEN];
        env.reset(start, &mut observation);
        let robot = env.world().robot();
        let electronics_w = robot.power.electronics_w;
        let mut episode = Episode { weight_n: robot.mass_kg() * STANDARD_GRAVITY_M_S2, ..Episode::default() };
        for step in 0..self.episode_steps() {
            let angles_rad = motion.angles_rad(step as f64 / CONTROL_RATE_HZ, 1.0);
            let action: [f32; ACTION_LEN] = angles_rad.map(|angle| (angle.to_degrees() / ACTION_DEG) as f32);
            let outcome = env.step(&action, &mut observation);
            episode.reward += f64::from(outcome.reward);
            episode.forward_m += f64::from(outcome.forward_speed_m_s) / CONTROL_RATE_HZ;
            episode.energy_j += (env.servo_power_w() + electronics_w) / CONTROL_RATE_HZ;
            episode.steps += 1;
            if outcome.terminated {
                episode.fell = true;
                break;
            }
        }
        episode
    }

    /// Sums in the order of the starts: floating-point sums depend on it.
    fn mean(&self, episodes: &[Episode]) -> GaitScore {
        let sum = |of: fn(&Episode) -> f64| episodes.iter().map(of).sum::<f64>();
        let asked = episodes.len() as f64 * self.episode_steps() as f64;
        let steps: u64 = episodes.iter().map(|episode| episode.steps).sum();
        let time_s = seconds(steps);
        let (forward_m, energy_j) = (sum(|e| e.forward_m), sum(|e| e.energy_j));
        let weight_n = sum(|e| e.weight_n) / episodes.len() as f64;
        GaitScore {
            reward_per_step: sum(|e| e.reward) / asked,
            speed_m_s: forward_m / time_s,
            power_w: energy_j / time_s,
            cost_of_transport: if forward_m > 0.0 {
                energy_j / (weight_n * forward_m)
            } else {
                f64::INFINITY
            },
            falls: episodes.iter().filter(|episode| episode.fell).count(),
            steps,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::learn::preset::Preset;
    use crate::learn::run_config::RunConfig;
    use crate::robot::LegScale;
    use protocol::gait::COEFFICIENT_COUNT;
    use protocol::{JOINT_COUNT, LEG_COUNT};

    fn still(knee_deg: f64) -> Motion {
        let mut centres_deg = [0.0; JOINT_COUNT];
        centres_deg[LEG_COUNT..].fill(knee_deg);
        Motion { period_s: 1.0, centres_deg, curves_deg: [[0.0; COEFFICIENT_COUNT]; JOINT_COUNT] }
    }

    #[test]
    fn a_standing_robot_earns_what_standing_brings_and_pays_for_its_electronics() {
        let robot = Robot::ant(LegScale::LONG).expect("a leg scale");
        let mut env = RunConfig::preset(Preset::Walk).expect("it comes with the program").env;
        env.episode_steps = 300;
        env.start.joint_rad = 0.0;
        let task = Task { robot: &robot, env };

        let score = task.scores(&[still(0.0), still(10.0)], &[1, 2, 3]);

        assert_eq!(score.len(), 2);
        assert!(score[0].speed_m_s.abs() < 0.01 && score[0].falls == 0, "{:?}", score[0]);
        assert!((score[0].reward_per_step - env.reward.alive).abs() < 0.03, "{:?}", score[0]);
        assert!(score[0].power_w >= robot.power.electronics_w && score[0].power_w < 0.5, "{:?}", score[0]);
        assert_eq!(score[0].steps, 900);
        assert_ne!(score[0], score[1]);
    }

    #[test]
    fn a_fall_ends_an_episode_and_the_steps_after_it_bring_nothing() {
        let robot = Robot::ant(LegScale::LONG).expect("a leg scale");
        let mut env = RunConfig::preset(Preset::Walk).expect("it comes with the program").env;
        env.episode_steps = 300;
        // Nothing stands as upright as this.
        env.max_tilt_rad = 1e-9;
        let task = Task { robot: &robot, env };

        let score = task.scores(&[still(0.0)], &[1, 2]);

        assert_eq!((score[0].falls, score[0].steps), (2, 2));
        assert!(score[0].reward_per_step.abs() < 0.01, "{:?}", score[0]);
    }
}
