//! What is timed: short slices of each kind of work, to be taken in turns.
//!
//! Owns the work; refuses to know how often it is repeated and what is made of it.

use super::BenchError;
use super::plain::PlainTd3;
use crate::env::Env;
use crate::learn::td3::agent::Agent;
use crate::learn::td3::config::{Learning, Schedule};
use crate::learn::td3::device::Device;
use crate::learn::td3::kernels::{Matrix, Target, multiply};
use crate::learn::td3::learner::Learner;
use crate::learn::td3::outcome::Event;
use crate::learn::td3::random::{Purpose, stream};
use crate::learn::td3::replay::{Layout, Replay};
use crate::learn::td3::run_config::RunConfig;
use crate::learn::td3::trainer::Run;
use crate::robot::Robot;
use crate::sim::AntEnv;
use rand::Rng as _;
use std::sync::atomic::AtomicBool;
use std::time::Instant;
use tch::{Kind, Tensor};

/// Sides of the square matrices whose product's rate counts: the faster one does.
const SIDES: [usize; 2] = [512, 1024];
/// Control steps a second of `threads` walking Ants together; observation,
/// reward and new episodes included.
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
fn trot(step: u32) -> [f32; 8] {
    let phase = core::f32::consts::TAU * (step as f32 / 60.0) / 1.6;
    core::array::from_fn(|joint| {
        let phase = phase + core::f32::consts::PI * (joint % 2) as f32;
        // Counter-clockwise is backwards on the left and forwards on the right.
        let side = if joint % 4 < 2 { 1.0 } else { -1.0 };
        let angle_rad = if joint < 4 { side * 0.5 * phase.sin() } else { 0.3 * phase.cos() };
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

/// Updates a second, batches drawn.
pub struct UpdatesPerS {
    /// On plain memory.
    pub ours: f64,
    /// The same losses in plain tch.
    pub plain: f64,
    /// The learner's own update on libtorch.
    pub torch: f64,
}

/// All learners with the same experience of random numbers.
pub struct Learners {
    ours: Agent,
    plain: PlainTd3,
    /// What `train --device torch` learns with.
    torch: Learner,
    replay: Replay,
    batch_size: usize,
    rounds: u64,
}

impl Learners {
    pub fn new(config: &RunConfig, layout: Layout) -> Result<Self, BenchError> {
        let mut rng = stream(config.seed, Purpose::Explore, 0);
        let rows: Vec<f32> =
            (0..config.td3.buffer_size * layout.row_len()).map(|_| rng.random_range(-1.0..1.0)).collect();
        let mut replay = Replay::new(layout, config.td3.buffer_size);
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

    /// Operations of one update's matrix products.
    pub fn arithmetic(&self) -> f64 {
        self.ours.arithmetic_of_an_update(self.batch_size)
    }

    /// Times so many updates of each.
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

/// Billion operations a second of the better of both libraries' matrix products, and libtorch's.
pub fn gemm_gflops() -> (f64, f64) {
    let mut best = (0.0_f64, 0.0_f64);
    for side in SIDES {
        let operations = 2.0 * (side as f64).powi(3);
        let numbers = vec![0.5_f32; side * side];
        let mut product = numbers.clone();
        let (left, right) = (Matrix::dense(&numbers, side), Matrix::dense(&numbers, side));
        let ours = rate(operations, || multiply(&mut product, left, right, Target::Replace));
        let factor = Tensor::from_slice(&numbers).view([side as i64, side as i64]);
        let out = Tensor::zeros([side as i64, side as i64], (Kind::Float, tch::Device::Cpu));
        let theirs = rate(operations, || {
            let _ = factor.mm_out(&out, &factor);
        });
        best = (best.0.max(ours).max(theirs), best.1.max(theirs));
    }
    best
}

/// Billion operations a second, over a tenth of a second or more.
fn rate(operations: f64, mut work: impl FnMut()) -> f64 {
    work();
    let (began, mut times) = (Instant::now(), 0.0);
    while began.elapsed().as_secs_f64() < 0.1 {
        work();
        times += 1.0;
    }
    times * operations / began.elapsed().as_secs_f64() / 1e9
}

/// What a training run past its warm-up came to.
pub struct Training {
    /// Control steps a second: gathering, learning, evaluation, checkpoint and
    /// policy included, in their shares.
    pub steps_per_s: f64,
    /// The same up to the evaluation.
    pub learn_steps_per_s: f64,
    /// How long the evaluation's episodes lasted.
    pub episode_steps: f64,
}

/// Trains for so many updates, a multiple of the schedule's round.
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
    // The schedule has updates, so a first round of them was heard of.
    let (began, before) = first.unwrap_or((learned, 0));
    let steps = (outcome.env_steps - before) as f64;
    Ok(Training {
        steps_per_s: steps / (ended - began).as_secs_f64(),
        learn_steps_per_s: steps / (learned - began).as_secs_f64(),
        episode_steps,
    })
}

/// One epoch of so many updates, its evaluation as large a share of it as in the whole run.
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
    use crate::sim::{AntEnvConfig, Perturbation};

    #[test]
    fn what_the_benchmark_calls_walking_gets_on() {
        let robot = Robot::ant(1.0).expect("1.0 is a leg scale");
        let mut env =
            AntEnv::new(&robot, AntEnvConfig { start: Perturbation::NONE, ..AntEnvConfig::default() });

        walk(&mut env, 0, 600);

        let [x_m, ..] = env.world().torso().position_m;
        assert!(x_m > 1.0, "{x_m} m in 10 s");
    }
}
