//! Plays a policy in simulation and writes down the stride it walks.
//!
//! Owns the trials and the two files, `trajectory.csv` and `record.json`.
//! What is recorded are the setpoints that the servos were given, not what the
//! policy asked for: a robot that plays them open loop gets the same orders.

use crate::env::Env as _;
use crate::robot::Robot;
use crate::run_folder::{self, FileError};
use crate::sim::ant_env::{ACTION_LEN, CONTROL_RATE_HZ, OBSERVATION_LEN};
use crate::sim::{AntEnv, AntEnvConfig};
use crate::stride::{self, Sample, Stride, StrideError};
use crate::td3::policy::Policy;
use crate::td3::random::{Purpose, episode_seed};
use protocol::Joint;
use serde::Serialize;
use std::path::Path;
use thiserror::Error;

/// What the recording came to, beside the trajectory.
pub const RECORD: &str = "record.json";
/// Until the gait has settled; not recorded.
pub const TRANSIENT_S: f64 = 3.0;
/// Recorded after that; with the transient the 12 s of a trial on the robot.
pub const RECORDED_S: f64 = 9.0;

/// Why there is no recording.
#[derive(Debug, Error)]
pub enum RecordError {
    /// The policy belongs to another robot.
    #[error(
        "the policy takes {observation_len} observations and gives {action_len} actions; the Ant has \
         {OBSERVATION_LEN} and {ACTION_LEN}"
    )]
    OtherRobot {
        /// What the policy takes.
        observation_len: usize,
        /// What the policy gives.
        action_len: usize,
    },
    /// It cannot walk yet.
    #[error("the robot fell in {fell} of {trials} trials, at most half may")]
    Fell {
        /// Trials that ended early.
        fell: usize,
        /// All trials.
        trials: usize,
    },
    /// It moves, but not in strides.
    #[error("no stride in {trials} trials")]
    NoStride {
        /// Trials looked at.
        trials: usize,
        /// Why.
        source: StrideError,
    },
    /// The disk's reason.
    #[error(transparent)]
    File(#[from] FileError),
}

/// What was seen over the recorded part of all trials in which the robot stayed up.
#[derive(Debug, Clone, Serialize)]
pub struct Recording {
    /// Mean duration of a stride.
    pub period_s: f64,
    /// Trials played.
    pub trials: usize,
    /// Trials in which the robot fell.
    pub fell: usize,
    /// Strides in the average.
    pub strides_averaged: usize,
    /// Strides unlike the others.
    pub strides_left_out: usize,
    /// Correlation of the motion with itself one stride later.
    pub likeness: f64,
    /// Standard deviation about the average stride, action units, in joint order.
    pub spread: Sample,
    /// Mean speed along x.
    pub speed_m_s: f64,
    /// Mean reward of a control step.
    pub reward_per_step: f64,
    /// Mean electrical power, servos and electronics.
    pub power_w: f64,
    /// One sample a row of the trajectory.
    #[serde(skip)]
    pub samples: Vec<Sample>,
}

#[derive(Debug, Clone, Default)]
struct Trial {
    setpoints: Vec<Sample>,
    reward: f64,
    speed: f64,
    servo_power_w: f64,
    fell: bool,
}

/// Plays `trials` trials from perturbed starts and averages their strides.
///
/// # Errors
/// [`RecordError`] if the policy fits another robot, falls, or does not stride.
pub fn record(
    policy: &Policy,
    robot: &Robot,
    env: AntEnvConfig,
    seed: u64,
    trials: usize,
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
    let Stride { period_s, samples, averaged, left_out, spread, likeness } =
        stride::average(&setpoints, CONTROL_RATE_HZ)
            .map_err(|source| RecordError::NoStride { trials, source })?;
    let steps = stayed.iter().map(|trial| trial.setpoints.len()).sum::<usize>() as f64;
    let mean = |value: fn(&Trial) -> f64| stayed.iter().map(|trial| value(trial)).sum::<f64>() / steps;
    Ok(Recording {
        period_s,
        trials,
        fell,
        strides_averaged: averaged,
        strides_left_out: left_out,
        likeness,
        spread,
        speed_m_s: mean(|trial| trial.speed),
        reward_per_step: mean(|trial| trial.reward),
        power_w: mean(|trial| trial.servo_power_w) + robot.power.electronics_w,
        samples,
    })
}

/// The trials in order, shared out over the processor's cores.
fn play_all(policy: &Policy, robot: &Robot, mut env: AntEnvConfig, seed: u64, trials: usize) -> Vec<Trial> {
    // No time limit: the trial's length is decided here.
    env.episode_steps = 0;
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

impl Recording {
    /// Writes trajectory and description into the run's folder.
    ///
    /// # Errors
    /// [`RecordError::File`] with the old file still in place.
    pub fn save(&self, run: &Path) -> Result<(), RecordError> {
        run_folder::write(&run.join(run_folder::TRAJECTORY), self.to_csv().as_bytes())?;
        let description = serde_json::json!(self);
        Ok(run_folder::write(&run.join(RECORD), format!("{description:#}\n").as_bytes())?)
    }

    /// One stride, a row a sample: time, then every joint in action units.
    fn to_csv(&self) -> String {
        let mut csv = String::from("time_s");
        for joint in Joint::ALL {
            csv += ",";
            csv += joint.name();
        }
        csv += "\n";
        let interval_s = self.period_s / self.samples.len() as f64;
        for (row, sample) in self.samples.iter().enumerate() {
            csv += &format!("{:.6}", row as f64 * interval_s);
            for value in sample {
                csv += &format!(",{value:.6}");
            }
            csv += "\n";
        }
        csv
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::td3::policy::DenseLayer;

    /// Asks for the same pose whatever it sees: `observations` in, 8 out.
    fn statue(observations: usize) -> Policy {
        Policy::new(vec![DenseLayer { weight: vec![0.0; observations * 8], bias: vec![0.0; 8] }])
    }

    fn ant() -> Robot {
        Robot::ant(1.0).unwrap()
    }

    #[test]
    fn a_policy_that_stands_has_no_stride() {
        let error = record(&statue(OBSERVATION_LEN), &ant(), AntEnvConfig::default(), 0, 2).unwrap_err();

        assert!(matches!(error, RecordError::NoStride { source: StrideError::Still { .. }, .. }), "{error}");
    }

    #[test]
    fn a_policy_of_another_robot_is_refused() {
        let error = record(&statue(12), &ant(), AntEnvConfig::default(), 0, 2).unwrap_err();

        assert!(matches!(error, RecordError::OtherRobot { observation_len: 12, action_len: 8 }), "{error}");
    }

    #[test]
    fn a_policy_that_falls_is_refused() {
        let mut layer = DenseLayer { weight: vec![0.0; OBSERVATION_LEN * 8], bias: vec![0.0; 8] };
        layer.bias[4..].fill(-5.0);

        let error = record(&Policy::new(vec![layer]), &ant(), AntEnvConfig::default(), 0, 2).unwrap_err();

        assert!(matches!(error, RecordError::Fell { fell: 2, trials: 2 }), "{error}");
    }

    #[test]
    fn the_trajectory_names_its_columns_and_spaces_its_rows_evenly() {
        let recording = Recording {
            period_s: 0.5,
            trials: 1,
            fell: 0,
            strides_averaged: 1,
            strides_left_out: 0,
            likeness: 1.0,
            spread: [0.0; 8],
            speed_m_s: 0.1,
            reward_per_step: 0.0,
            power_w: 1.0,
            samples: vec![[0.25; 8], [-0.5; 8]],
        };

        let csv = recording.to_csv();

        let mut lines = csv.lines();
        assert_eq!(lines.next(), Some("time_s,hip1,hip2,hip3,hip4,knee1,knee2,knee3,knee4"));
        assert_eq!(lines.next().map(|line| &line[..17]), Some("0.000000,0.250000"));
        assert_eq!(lines.next().map(|line| &line[..18]), Some("0.250000,-0.500000"));
        assert_eq!(lines.next(), None);
    }
}
