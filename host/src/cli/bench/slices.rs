//! What `bench` times: short slices of each kind of work, to be run alternately.
//!
//! Holds the work. Does not depend on how often it is repeated or how it is reported.

use super::BenchError;
use super::plain::PlainTd3;
use crate::env::Env;
use crate::learn::run_config::RunConfig;
use crate::learn::td3::agent::Agent;
use crate::learn::td3::config::{Learning, Schedule};
use crate::learn::td3::device::Device;
use crate::learn::td3::kernels::{Matrix, Output, multiply};
use crate::learn::td3::learner::Learner;
use crate::learn::td3::outcome::Event;
use crate::learn::td3::random::{Purpose, stream};
use crate::learn::td3::replay::{Layout, ReplayBuffer};
use crate::learn::td3::trainer::Run;
use crate::robot::Robot;
use crate::sim::AntEnv;
use crate::sim::ant_env::ACTION_LEN;
use protocol::LEG_COUNT;
use rand::Rng as _;
use std::sync::atomic::AtomicBool;
use std::time::Instant;
use tch::{Kind, Tensor};

/// Sides of the square matrices that are multiplied; the better rate counts.
const SIDES: [usize; 2] = [512, 1024];

/// Control steps a second of one walking Ant in each of `threads` threads, together;
/// observation, reward and new episodes included.
pub fn env_steps_per_s(config: &RunConfig, robot: &Robot, threads: u64, steps: u32) -> f64 {
    let mut walkers: Vec<AntEnv> = (0..threads).map(|_| AntEnv::new(robot, config.env)).collect();
    let began = Instant::now();
    std::thread::scope(|scope| {
        for (seed, env) in (0..).zip(&mut walkers) {
            scope.spawn(move || walk(env, seed, steps));
        }
    });
    f64::from(steps) * threads as f64 / began.elapsed().as_secs_f64()
}

/// A trot along x: diagonal legs together, 1.6 s a stride, hips by 0.5 rad and
/// knees by 0.3 rad either way. `scripts/peers/task.py` has the same.
fn trot(step: u32) -> [f32; ACTION_LEN] {
    let phase = core::f32::consts::TAU * (step as f32 / protocol::FRAME_RATE_HZ as f32) / 1.6;
    core::array::from_fn(|joint| {
        let phase = phase + core::f32::consts::PI * (joint % 2) as f32;
        // Counter-clockwise is backwards on the left and forwards on the right.
        let side = if joint % LEG_COUNT < 2 { 1.0 } else { -1.0 };
        let angle_rad = if joint < LEG_COUNT { side * 0.5 * phase.sin() } else { 0.3 * phase.cos() };
        angle_rad / core::f32::consts::FRAC_PI_4
    })
}

fn walk(env: &mut AntEnv, seed: u64, steps: u32) {
    let mut observation = vec![0.0; env.observation_len()];
    env.reset(seed, &mut observation);
    for step in 0..steps {
        let outcome = env.step(&trot(step), &mut observation);
        if outcome.terminated || outcome.truncated {
            env.reset(seed, &mut observation);
        }
    }
}

/// Updates a second, batches sampled.
pub struct UpdatesPerS {
    /// The learner's on plain memory.
    pub ours: f64,
    /// The same losses in plain tch.
    pub plain: f64,
    /// The learner's own update on libtorch.
    pub torch: f64,
}

/// All learners, with the same replay buffer of random numbers.
pub struct Learners {
    ours: Agent,
    plain: PlainTd3,
    /// What `train --device torch` learns with.
    torch: Learner,
    replay: ReplayBuffer,
    batch_size: usize,
    rounds: u64,
}

impl Learners {
    pub fn new(config: &RunConfig, layout: Layout) -> Result<Self, BenchError> {
        let mut rng = stream(config.seed, Purpose::Explore, 0);
        let rows: Vec<f32> =
            (0..config.td3.buffer_size * layout.row_len()).map(|_| rng.random_range(-1.0..1.0)).collect();
        let mut replay = ReplayBuffer::new(layout, config.td3.buffer_size);
        replay.extend(&rows);
        Ok(Self {
            ours: Agent::new(&config.td3, layout, config.seed),
            plain: PlainTd3::new(&config.td3, layout)?,
            torch: Learner::new(Agent::new(&config.td3, layout, config.seed), Device::Torch)?,
            replay,
            batch_size: config.td3.batch_size,
            rounds: 0,
        })
    }

    /// Multiplications and additions in the matrix products of one update.
    pub fn arithmetic(&self) -> f64 {
        self.ours.arithmetic_of_an_update(self.batch_size)
    }

    /// Times `updates` updates of each learner.
    pub fn updates_per_s(&mut self, updates: u32) -> Result<UpdatesPerS, BenchError> {
        self.rounds += 1;
        let mut sample = stream(1, Purpose::Sample, self.rounds);
        let mut smooth = stream(1, Purpose::Smooth, self.rounds);
        let mut batch = Vec::new();
        let began = Instant::now();
        for _ in 0..updates {
            self.replay.sample(self.batch_size, &mut sample, &mut batch);
            self.ours.update(&batch, &mut smooth);
        }
        let ours = f64::from(updates) / began.elapsed().as_secs_f64();
        let began = Instant::now();
        for _ in 0..updates {
            self.replay.sample(self.batch_size, &mut sample, &mut batch);
            self.plain.update(&batch);
        }
        let plain = f64::from(updates) / began.elapsed().as_secs_f64();
        let began = Instant::now();
        for _ in 0..updates {
            self.replay.sample(self.batch_size, &mut sample, &mut batch);
            self.torch.update(&batch, &mut smooth)?;
        }
        let torch = f64::from(updates) / began.elapsed().as_secs_f64();
        Ok(UpdatesPerS { ours, plain, torch })
    }
}

/// Gflop/s of large matrix products: the better of both libraries, and libtorch's.
pub fn gemm_gflops() -> (f64, f64) {
    let mut best = (0.0_f64, 0.0_f64);
    for side in SIDES {
        let operations = 2.0 * (side as f64).powi(3);
        let numbers = vec![0.5_f32; side * side];
        let mut product = numbers.clone();
        let (left, right) = (Matrix::dense(&numbers, side), Matrix::dense(&numbers, side));
        let ours = rate(operations, || multiply(&mut product, left, right, Output::Overwrite));
        let factor = Tensor::from_slice(&numbers).view([side as i64, side as i64]);
        let out = Tensor::zeros([side as i64, side as i64], (Kind::Float, tch::Device::Cpu));
        let theirs = rate(operations, || {
            let _ = factor.mm_out(&out, &factor);
        });
        best = (best.0.max(ours).max(theirs), best.1.max(theirs));
    }
    best
}

/// Gflop/s of `work`, repeated for at least 0.1 s.
fn rate(operations: f64, mut work: impl FnMut()) -> f64 {
    work();
    let (began, mut times) = (Instant::now(), 0.0);
    while began.elapsed().as_secs_f64() < 0.1 {
        work();
        times += 1.0;
    }
    times * operations / began.elapsed().as_secs_f64() / 1e9
}

/// Speed of a training run after its warm-up.
pub struct Training {
    /// Control steps a second, with gathering, learning, evaluation, checkpoint and policy.
    pub steps_per_s: f64,
    /// The same without the evaluation.
    pub learn_steps_per_s: f64,
    /// Control steps of an episode of the evaluation.
    pub episode_steps: f64,
}

/// Trains for `updates` updates, a multiple of the schedule's round.
pub fn training(config: &RunConfig, robot: &Robot, updates: u64) -> Result<Training, BenchError> {
    let learning = shortened(config, updates);
    let folder = tempfile::tempdir().map_err(|source| BenchError::Folder { source })?;
    let run = Run {
        learning: &learning,
        make_env: &|| -> Box<dyn Env> { Box::new(AntEnv::new(robot, config.env)) },
        seed: config.seed,
        device: Device::Cpu,
        folder: folder.path(),
        stop: &AtomicBool::new(false),
    };
    let mut first: Option<(Instant, u64)> = None;
    let mut learned = Instant::now();
    let mut episode_steps = f64::NAN;
    let outcome = run.train(false, &mut |event| match event {
        Event::Round { updates: 1.., env_steps } => {
            learned = Instant::now();
            first.get_or_insert((learned, env_steps));
        }
        Event::Evaluated { point, .. } => episode_steps = point.episode_steps,
        Event::Round { .. } | Event::Resumed { .. } => {}
    })?;
    let ended = Instant::now();
    // The schedule has updates, so there was a first round with some.
    let (began, before) = first.unwrap_or((learned, 0));
    let steps = (outcome.env_steps - before) as f64;
    Ok(Training {
        steps_per_s: steps / (ended - began).as_secs_f64(),
        learn_steps_per_s: steps / (learned - began).as_secs_f64(),
        episode_steps,
    })
}

/// One epoch of `updates` updates, with an evaluation of the same share as in the whole run.
fn shortened(config: &RunConfig, updates: u64) -> Learning {
    let schedule = &config.schedule;
    let share = updates as f64 / schedule.updates_per_epoch as f64;
    let mut learning = config.learning();
    learning.schedule = Schedule {
        epochs: 1,
        updates_per_epoch: updates,
        warm_up_env_steps: 1_000,
        evaluation_episodes: ((schedule.evaluation_episodes as f64 * share).round() as usize).max(1),
        ..schedule.clone()
    };
    learning
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::LegScale;
    use crate::sim::{AntEnvConfig, Perturbation};

    #[test]
    fn the_trot_of_the_benchmark_walks_forward() {
        let robot = Robot::ant(LegScale::LONG).expect("1.0 is a leg scale");
        let mut env =
            AntEnv::new(&robot, AntEnvConfig { start: Perturbation::NONE, ..AntEnvConfig::default() });

        walk(&mut env, 0, 600);

        let [x_m, ..] = env.world().torso().position_m;
        assert!(x_m > 1.0, "{x_m} m in 10 s");
    }
}
