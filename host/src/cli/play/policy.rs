//! A policy in closed loop: it walks the simulated robot, and the real one gets the
//! same setpoints.
//!
//! The two robots are not coupled: the policy does not sense what the real one meets.
//! The simulation runs no farther ahead than the robot's buffer. Does not depend on the
//! link.

use super::{Args, Programme};
use crate::cli::Failure;
use crate::cli::explain::{failure, failure_with_help};
use crate::cli::{Cause, recording};
use crate::device::stream::PoseDeg;
use crate::env::Env as _;
use crate::gait::scale::{OWN_STROKE, TABLE_DEG_PER_ACTION};
use crate::gait::trajectory::Trajectory;
use crate::learn::record::RecordError;
use crate::learn::run_config::RunConfig;
use crate::learn::td3::policy::Policy;
use crate::learn::td3::random::{Purpose, episode_seed};
use crate::robot::Robot;
use crate::run_folder;
use crate::sim::ant_env::{ACTION_DEG, ACTION_LEN, CONTROL_RATE_HZ, OBSERVATION_LEN};
use crate::sim::{AntEnv, Randomisation};
use protocol::JOINT_COUNT;
use std::path::Path;

/// As a trial on the robot.
const DEFAULT_S: f64 = 12.0;

pub fn programme(args: &Args, run: &Path) -> Result<Programme, Failure> {
    if let Some(flag) = args.recording.given() {
        let error = recording::BadFlag::NotForPolicies { flag };
        return Err(failure_with_help(
            Cause::Usage,
            error,
            "a policy knows its own columns, scales and pace",
        ));
    }
    let config = RunConfig::load(&run.join(run_folder::CONFIG)).map_err(untrained)?;
    let robot = Robot::of_trained_run(run).map_err(untrained)?;
    let policy = Policy::load(&run.join(run_folder::POLICY)).map_err(untrained)?;
    let (observation_len, action_len) = (policy.observation_len(), policy.action_len());
    if (observation_len, action_len) != (OBSERVATION_LEN, ACTION_LEN) {
        return Err(failure(Cause::Input, RecordError::OtherRobot { observation_len, action_len }));
    }
    let mut env_config = config.env;
    // No time limit: the length is decided here.
    env_config.episode_steps = 0;
    // What the real robot is likeliest to be like.
    env_config.randomisation = Randomisation::NONE;
    let mut env = AntEnv::new(&robot, env_config);
    let mut observation = [0.0; OBSERVATION_LEN];
    env.reset(episode_seed(config.seed, Purpose::RecordedTrial, 0), &mut observation);
    let frames = (args.seconds.unwrap_or(DEFAULT_S) * CONTROL_RATE_HZ).round() as u32;
    let walk =
        Walk { policy, env, observation, means: means(run), amplitude: args.amplitude.unwrap_or(OWN_STROKE) };
    let name = format!("the policy of {}", run.display());
    Ok(Programme {
        name,
        poses: Box::new(walk.take(frames as usize)),
        frames,
        limit_deg: robot.joint_limit_deg,
    })
}

fn untrained(error: impl std::error::Error + Send + Sync + 'static) -> Failure {
    failure_with_help(Cause::Input, error, "train first: cargo run -p host -- train; or name another run")
}

/// What the amplitude scales about: the recorded stride's means, where there is one.
fn means(run: &Path) -> PoseDeg {
    let recorded = Trajectory::read(&run.join(run_folder::TRAJECTORY), None).ok();
    let Some(rows) = recorded.map(|trajectory| trajectory.actions) else { return [0.0; JOINT_COUNT] };
    std::array::from_fn(|joint| rows.iter().map(|row| row[joint]).sum::<f64>() / rows.len() as f64)
}

struct Walk {
    policy: Policy,
    env: AntEnv,
    observation: [f32; OBSERVATION_LEN],
    means: PoseDeg,
    amplitude: f64,
}

/// Ends where the simulated robot falls.
impl Iterator for Walk {
    type Item = PoseDeg;

    fn next(&mut self) -> Option<PoseDeg> {
        let mut action = [0.0; ACTION_LEN];
        self.policy.act(&self.observation, &mut action);
        let outcome = self.env.step(&action, &mut self.observation);
        if outcome.terminated {
            return None;
        }
        let asked = self.env.setpoint_action();
        Some(std::array::from_fn(|joint| {
            let mean = self.means[joint];
            ACTION_DEG * mean + self.amplitude * TABLE_DEG_PER_ACTION * (asked[joint] - mean)
        }))
    }
}
