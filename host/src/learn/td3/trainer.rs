//! A training run: gather, learn, evaluate, save, until the schedule is done.
//!
//! Holds the main loop and the run folder's learning files. Does not depend on the
//! task. One thread gathers round `r` while this one learns from everything up to
//! `r - 1` and then helps to gather; they wait for each other at the end of a round
//! and nowhere else, so that timing does not change the result.

use super::MakeEnv;
use super::agent::{Agent, Losses};
use super::checkpoint::{self, Progress};
use super::collect::{Collector, Order, Round};
use super::config::Learning;
use super::curve::{CurvePoint, to_csv};
use super::device::Device;
use super::evaluate::evaluate;
use super::events::EventFile;
use super::learner::Learner;
use super::outcome::{Ending, Event, Outcome, TrainError};
use super::policy_description::PolicyDescription;
use super::random::{Purpose, stream};
use super::replay::{Layout, ReplayBuffer};
use crate::run_folder;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc;
use std::time::Instant;

/// A mean value beyond this means divergence: rewards are of order 1 and gamma is at
/// most 0.9999.
const DIVERGED_Q: f64 = 1e6;

/// The inputs of a training run.
pub struct Run<'a> {
    /// Algorithm and schedule, checked.
    pub learning: &'a Learning,
    /// Builds the task, once for each environment.
    pub make_env: MakeEnv<'a>,
    /// Random seed.
    pub seed: u64,
    /// Device of the updates; a resumed run may change it.
    pub device: Device,
    /// The run folder, which must exist.
    pub folder: &'a Path,
    /// Set to true, stops the run at the end of the round.
    pub stop: &'a AtomicBool,
}

struct State {
    learner: Learner,
    replay: ReplayBuffer,
    progress: Progress,
    events: EventFile,
}

/// Channels to the thread that gathers.
struct GatheringThread {
    orders: mpsc::Sender<Arc<Round>>,
    done: mpsc::Receiver<()>,
}

impl GatheringThread {
    /// Starts a round.
    fn begin(&self, order: Order) -> Result<Arc<Round>, TrainError> {
        let round = Arc::new(Round::new(order));
        self.orders.send(Arc::clone(&round)).map_err(|_| TrainError::CollectorGone)?;
        Ok(round)
    }

    /// Waits until the thread works on no environment of the round.
    fn wait(&self) -> Result<(), TrainError> {
        self.done.recv().map_err(|_| TrainError::CollectorGone)
    }
}

impl Run<'_> {
    /// Trains from the beginning, or from the folder's checkpoint.
    ///
    /// # Errors
    /// [`TrainError`]; the best policy so far stays in the folder.
    pub fn train(&self, resume: bool, on_event: &mut dyn FnMut(Event)) -> Result<Outcome, TrainError> {
        let layout = {
            let env = (self.make_env)();
            Layout { observation_len: env.observation_len(), action_len: env.action_len() }
        };
        let (config, envs) = (&self.learning.td3, self.learning.schedule.training_envs);
        let (mut state, collector) = if resume {
            let saved = checkpoint::load(self.folder, config, layout, envs)?;
            let learner = Learner::new(saved.agent, self.device)?;
            let events = EventFile::create(self.folder, &saved.progress.curve, saved.progress.wall_s)?;
            let collector = Collector::restore(self.make_env, layout, self.seed, saved.episodes);
            (State { learner, replay: saved.replay, progress: saved.progress, events }, collector)
        } else {
            let state = State {
                learner: Learner::new(Agent::new(config, layout, self.seed), self.device)?,
                replay: ReplayBuffer::new(layout, config.buffer_size),
                progress: Progress::default(),
                events: EventFile::create(self.folder, &[], 0.0)?,
            };
            (state, Collector::new(self.make_env, layout, self.seed, envs))
        };
        std::thread::scope(|scope| {
            let (orders, inbox) = mpsc::channel::<Arc<Round>>();
            let (outbox, done) = mpsc::channel();
            let collector = &collector;
            let thread = scope.spawn(move || {
                // The thread ends when either channel is closed.
                for round in inbox {
                    collector.help(&round);
                    if outbox.send(()).is_err() {
                        break;
                    }
                }
            });
            let gathering = GatheringThread { orders, done };
            let outcome = self.rounds(&mut state, collector, &gathering, on_event);
            drop(gathering);
            // Joined explicitly: the scope would panic if the thread did.
            if thread.join().is_err() { Err(TrainError::CollectorGone) } else { outcome }
        })
    }

    /// The main loop: a round of gathering and learning at a time.
    fn rounds(
        &self,
        state: &mut State,
        collector: &Collector,
        gathering: &GatheringThread,
        on_event: &mut dyn FnMut(Event),
    ) -> Result<Outcome, TrainError> {
        let schedule = &self.learning.schedule;
        let began = Instant::now();
        let before_s = state.progress.wall_s;
        if state.progress.curve.is_empty() {
            self.evaluate(state, on_event)?;
        } else {
            on_event(Event::Resumed { updates: state.learner.updates() });
        }
        let mut ending = Ending::Done;
        while state.learner.updates() < schedule.total_updates() {
            let round = gathering.begin(self.order(state)?)?;
            // Without a warm-up, the replay buffer is empty in the first round.
            if state.progress.env_steps >= schedule.warm_up_env_steps.max(1) {
                self.learn(state)?;
            }
            // Helps the other thread with the environments that are left.
            catch_unwind(AssertUnwindSafe(|| collector.help(&round)))
                .map_err(|_| TrainError::CollectorGone)?;
            gathering.wait()?;
            state.replay.extend(&round.rows()?);
            state.progress.round += 1;
            state.progress.env_steps += schedule.round_env_steps();
            state.progress.wall_s = before_s + began.elapsed().as_secs_f64();
            on_event(Event::Round { updates: state.learner.updates(), env_steps: state.progress.env_steps });
            let stop = self.stop.load(Ordering::Relaxed);
            let epoch_ended = state.learner.updates()
                > state.progress.curve.last().map_or(0, |point| point.updates)
                && state.learner.updates().is_multiple_of(schedule.updates_per_epoch);
            if epoch_ended {
                self.evaluate(state, on_event)?;
            }
            if epoch_ended || stop {
                state.progress.wall_s = before_s + began.elapsed().as_secs_f64();
                let episodes = collector.episodes();
                let agent = state.learner.agent()?;
                checkpoint::save(self.folder, agent, &state.replay, episodes, &state.progress)?;
            }
            if stop && state.learner.updates() < schedule.total_updates() {
                ending = Ending::Stopped;
                break;
            }
        }
        Ok(Outcome {
            ending,
            curve: state.progress.curve.clone(),
            best: state.progress.best,
            updates: state.learner.updates(),
            env_steps: state.progress.env_steps,
            wall_s: state.progress.wall_s,
        })
    }

    fn order(&self, state: &mut State) -> Result<Order, TrainError> {
        let schedule = &self.learning.schedule;
        let warm = state.progress.env_steps >= schedule.warm_up_env_steps;
        Ok(Order {
            round: state.progress.round,
            before: state.progress.env_steps,
            env_steps: schedule.round_env_steps(),
            policy: warm.then(|| state.learner.policy()).transpose()?,
            noise: self.learning.td3.exploration_noise,
            correlation: self.learning.td3.exploration_correlation,
        })
    }

    /// One round of updates; an error if losses or weights become NaN, infinite or too large.
    fn learn(&self, state: &mut State) -> Result<(), TrainError> {
        let round = state.progress.round;
        let mut sample = stream(self.seed, Purpose::Sample, round);
        let mut smooth = stream(self.seed, Purpose::Smooth, round);
        let mut batch = Vec::new();
        for _ in 0..self.learning.schedule.round_updates {
            state.replay.sample(self.learning.td3.batch_size, &mut sample, &mut batch);
            state.learner.update(&batch, &mut smooth)?;
        }
        let losses = state.learner.losses()?;
        let actor = losses.actor.or(state.progress.losses.actor);
        state.progress.losses = Losses { actor, ..losses };
        let Losses { critic, q_mean, .. } = state.progress.losses;
        if !state.progress.losses.is_finite()
            || q_mean.abs() > DIVERGED_Q
            || !state.learner.policy()?.is_finite()
        {
            return Err(TrainError::Diverged {
                updates: state.learner.updates(),
                critic_loss: critic,
                q_mean,
            });
        }
        Ok(())
    }

    /// Evaluates the policy, writes the learning curve, and the policy if it is the best so far.
    fn evaluate(&self, state: &mut State, on_event: &mut dyn FnMut(Event)) -> Result<(), TrainError> {
        let policy = state.learner.policy()?;
        let episodes = self.learning.schedule.evaluation_episodes;
        let evaluation = evaluate(&policy, self.make_env, (self.seed, Purpose::EvaluationEpisode), episodes);
        if !(evaluation.reward.is_finite() && evaluation.speed_m_s.is_finite()) {
            let Losses { critic, q_mean, .. } = state.progress.losses;
            return Err(TrainError::Diverged {
                updates: state.learner.updates(),
                critic_loss: critic,
                q_mean,
            });
        }
        let progress = &mut state.progress;
        let point = CurvePoint {
            env_steps: progress.env_steps,
            updates: state.learner.updates(),
            wall_s: progress.wall_s,
            reward: evaluation.reward,
            speed_m_s: evaluation.speed_m_s,
            episode_steps: evaluation.steps,
            critic_loss: progress.losses.critic,
            actor_loss: progress.losses.actor.unwrap_or(0.0),
            q_mean: progress.losses.q_mean,
        };
        let best = progress.curve.get(progress.best).is_none_or(|best| point.reward > best.reward);
        progress.curve.push(point);
        if best {
            progress.best = progress.curve.len() - 1;
            policy.save(&self.folder.join(run_folder::POLICY))?;
            self.describe(&point)?;
        }
        run_folder::write(&self.folder.join(run_folder::LEARNING_CURVE), to_csv(&progress.curve).as_bytes())?;
        state.events.append(&point)?;
        on_event(Event::Evaluated { point, best });
        Ok(())
    }

    /// Writes `policy.json`.
    fn describe(&self, point: &CurvePoint) -> Result<(), TrainError> {
        let description = PolicyDescription {
            seed: self.seed,
            updates: point.updates,
            env_steps: point.env_steps,
            reward: point.reward,
            speed_m_s: point.speed_m_s,
            learning: self.learning.clone(),
        };
        Ok(description.save(self.folder)?)
    }
}
