//! Plays a policy in simulation and averages its stride.
//!
//! Holds the trials; `files` writes the result, `figure` draws it. Does not depend on
//! how the policy was learned. Setpoints of the servos are recorded, not the policy's
//! actions: a robot that plays them open loop gets the same setpoints.

mod figure;
mod files;

pub(crate) use figure::of_stride;
pub use files::{FIGURE, SPREAD};

use crate::env::Env as _;
use crate::gait::fit::{self, FitError, JointFit, Scale, Seam};
use crate::gait::policy_record::RecordSummary;
use crate::gait::stride::{self, Sample, Stride, StrideError, window};
use crate::learn::td3::policy::Policy;
use crate::learn::td3::random::{Purpose, episode_seed};
use crate::plot::PlotError;
use crate::robot::Robot;
use crate::run_folder::FileError;
use crate::sim::ant_env::{ACTION_DEG, ACTION_LEN, CONTROL_RATE_HZ, OBSERVATION_LEN};
use crate::sim::{AntEnv, AntEnvConfig, Randomisation};
use protocol::JOINT_COUNT;
use thiserror::Error;

/// Time until the gait has settled; not recorded.
pub const TRANSIENT_S: f64 = 3.0;
/// Time recorded after that; both together are the 12 s of a trial on the robot.
pub const RECORDED_S: f64 = 9.0;

/// Why there is no recording.
#[derive(Debug, Error)]
pub enum RecordError {
    /// The policy's input or output is of another size than the Ant's.
    #[error(
        "the policy takes {observation_len} observations and returns {action_len} actions; the Ant has \
         {OBSERVATION_LEN} and {ACTION_LEN}"
    )]
    OtherRobot {
        /// Inputs of the policy.
        observation_len: usize,
        /// Outputs of the policy.
        action_len: usize,
    },
    /// The policy falls too often.
    #[error("the robot fell in {fell} of {trials} trials; at most half are allowed")]
    Fell {
        /// Trials in which it fell.
        fell: usize,
        /// All trials.
        trials: usize,
    },
    /// The motion does not repeat.
    #[error("no stride in {trials} trials")]
    NoStride {
        /// All trials.
        trials: usize,
        /// Why.
        source: StrideError,
    },
    /// The picture's reason.
    #[error(transparent)]
    Plot(#[from] PlotError),
    /// The disk's reason.
    #[error(transparent)]
    File(#[from] FileError),
}

/// Which part of every trial is averaged.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Part {
    /// All strides, each over its own duration.
    Strides,
    /// One window of fixed length, as in the paper.
    Window {
        /// Its length.
        window_s: f64,
    },
}

/// A recording: the summary of `record.json`, and the average stride.
#[derive(Debug, Clone)]
pub struct Recording {
    /// Means over the trials.
    pub summary: RecordSummary,
    /// The average stride, a row of the trajectory each.
    pub samples: Vec<Sample>,
    /// Standard deviation from each sample, in action units.
    pub deviations: Vec<Sample>,
    /// The degree-10 curves in degrees, with the seam that `fit` takes by default.
    pub fits: Result<[JointFit; JOINT_COUNT], FitError>,
}

#[derive(Debug, Clone, Default)]
struct Trial {
    setpoints: Vec<Sample>,
    reward: f64,
    speed: f64,
    servo_power_w: f64,
    fell: bool,
}

/// The scale of the policy's own stroke.
const SCALE: Scale = Scale {
    signs: [1.0; JOINT_COUNT],
    unit_deg: ACTION_DEG,
    centre_unit_deg: ACTION_DEG,
    centre_offset_deg: 0.0,
    limit_deg: ACTION_DEG,
};

/// Plays `trials` trials from perturbed starts and averages a part of each.
///
/// # Errors
/// [`RecordError`] if the policy is for another robot, falls too often, or has no stride.
pub fn record(
    policy: &Policy,
    robot: &Robot,
    env: AntEnvConfig,
    seed: u64,
    trials: usize,
    part: Part,
) -> Result<Recording, RecordError> {
    let (observation_len, action_len) = (policy.observation_len(), policy.action_len());
    if (observation_len, action_len) != (OBSERVATION_LEN, ACTION_LEN) {
        return Err(RecordError::OtherRobot { observation_len, action_len });
    }
    let played = play_all(policy, robot, env, seed, trials);
    let stayed: Vec<&Trial> = played.iter().filter(|trial| !trial.fell).collect();
    let fell = trials - stayed.len();
    if fell * 2 > trials || stayed.is_empty() {
        return Err(RecordError::Fell { fell, trials });
    }
    let setpoints: Vec<Vec<Sample>> = stayed.iter().map(|trial| trial.setpoints.clone()).collect();
    let (window_s, stride) = match part {
        Part::Strides => (None, stride::average(&setpoints, CONTROL_RATE_HZ)),
        Part::Window { window_s } => (Some(window_s), window::average(&setpoints, CONTROL_RATE_HZ, window_s)),
    };
    let Stride { period_s, samples, averaged, left_out, deviations, spread, correlation } =
        stride.map_err(|source| RecordError::NoStride { trials, source })?;
    let stride_s = window_s.and_then(|_| stride::period_s(&setpoints, CONTROL_RATE_HZ));
    let fits = fit_samples(&samples, window_s);
    let polynomial_r2 =
        fits.as_ref().map_or([None; JOINT_COUNT], |fits| fits.each_ref().map(|f| f.series.r2));
    let steps = stayed.iter().map(|trial| trial.setpoints.len()).sum::<usize>() as f64;
    let mean = |value: fn(&Trial) -> f64| stayed.iter().map(|trial| value(trial)).sum::<f64>() / steps;
    let summary = RecordSummary {
        period_s,
        window_s,
        strides_in_window: stride_s.map(|stride_s| period_s / stride_s),
        trials,
        fell,
        strides_averaged: averaged,
        strides_left_out: left_out,
        correlation,
        spread,
        spread_deg: spread.map(|spread| spread * ACTION_DEG),
        polynomial_r2,
        speed_m_s: mean(|trial| trial.speed),
        reward_per_step: mean(|trial| trial.reward),
        power_w: mean(|trial| trial.servo_power_w) + robot.power.electronics_w,
    };
    Ok(Recording { summary, samples, deviations, fits })
}

/// The curves with the seam that `fit` takes by default.
fn fit_samples(samples: &[Sample], window_s: Option<f64>) -> Result<[JointFit; JOINT_COUNT], FitError> {
    fit_with(samples, Seam::usual(window_s.is_some()))
}

/// The curves at the policy's own stroke.
fn fit_with(samples: &[Sample], seam: Seam) -> Result<[JointFit; JOINT_COUNT], FitError> {
    fit::fit(samples, &SCALE, seam)
}

/// The trials in order, distributed over the processor's cores.
fn play_all(policy: &Policy, robot: &Robot, mut env: AntEnvConfig, seed: u64, trials: usize) -> Vec<Trial> {
    // No time limit: the trial has its own length.
    env.episode_steps = 0;
    // The described robot: strides of varied robots have no common mean.
    env.randomisation = Randomisation::NONE;
    let mut played = vec![Trial::default(); trials];
    let workers = std::thread::available_parallelism().map_or(1, usize::from).min(trials).max(1);
    let share = trials.div_ceil(workers).max(1);
    std::thread::scope(|scope| {
        for (worker, part) in played.chunks_mut(share).enumerate() {
            let mut policy = policy.clone();
            scope.spawn(move || {
                let mut env = AntEnv::new(robot, env);
                for (index, trial) in part.iter_mut().enumerate() {
                    let number = (worker * share + index) as u64;
                    *trial = play(&mut policy, &mut env, episode_seed(seed, Purpose::RecordedTrial, number));
                }
            });
        }
    });
    played
}

fn play(policy: &mut Policy, env: &mut AntEnv, seed: u64) -> Trial {
    let mut trial = Trial::default();
    let (mut observation, mut action) = ([0.0; OBSERVATION_LEN], [0.0; ACTION_LEN]);
    env.reset(seed, &mut observation);
    let transient = (TRANSIENT_S * CONTROL_RATE_HZ).round() as u64;
    let steps = transient + (RECORDED_S * CONTROL_RATE_HZ).round() as u64;
    for step in 0..steps {
        policy.act(&observation, &mut action);
        let outcome = env.step(&action, &mut observation);
        if outcome.terminated {
            trial.fell = true;
            break;
        }
        if step >= transient {
            trial.setpoints.push(env.setpoint_action());
            trial.reward += f64::from(outcome.reward);
            trial.speed += f64::from(outcome.forward_speed_m_s);
            trial.servo_power_w += env.servo_power_w();
        }
    }
    trial
}

#[cfg(test)]
mod tests;
