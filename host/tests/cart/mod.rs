//! A task of one number, small enough to learn in seconds, and runs on it.

use host::env::{Env, Step};
use host::learn::td3::config::{Learning, Schedule, Td3Config};
use host::learn::td3::device::Device;
use host::learn::td3::outcome::{Event, Outcome, TrainError};
use host::learn::td3::trainer::Run;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

/// A cart on a line that is to stand at the origin; it starts anywhere within
/// a metre, an episode lasts 30 steps, and 3 m away it falls off.
pub struct Cart {
    position: f32,
    steps: u32,
    /// Breaks down after this many steps in all episodes together.
    steps_to_live: u32,
}

impl Cart {
    pub fn boxed() -> Box<dyn Env> {
        Box::new(Self { position: 0.0, steps: 0, steps_to_live: u32::MAX })
    }

    pub fn mortal() -> Box<dyn Env> {
        Box::new(Self { position: 0.0, steps: 0, steps_to_live: 400 })
    }
}

impl Env for Cart {
    fn observation_len(&self) -> usize {
        2
    }

    fn action_len(&self) -> usize {
        1
    }

    fn reset(&mut self, seed: u64, observation: &mut [f32]) {
        self.position = (seed % 2001) as f32 / 1000.0 - 1.0;
        self.steps = 0;
        observation.copy_from_slice(&[self.position, 0.5]);
    }

    fn step(&mut self, action: &[f32], observation: &mut [f32]) -> Step {
        let velocity = 0.3 * action[0].clamp(-1.0, 1.0);
        self.position += velocity;
        self.steps += 1;
        self.steps_to_live -= 1;
        observation.copy_from_slice(&[self.position, 0.5]);
        let terminated = self.position.abs() > 3.0;
        let reward = if self.steps_to_live == 0 { f32::NAN } else { 1.0 - self.position.abs() };
        Step { reward, terminated, truncated: !terminated && self.steps >= 30, forward_speed_m_s: velocity }
    }
}

pub fn learning(epochs: u64) -> Learning {
    Learning {
        td3: Td3Config { hidden_layers: 2, hidden_width: 32, batch_size: 32, ..Td3Config::default() },
        schedule: Schedule {
            epochs,
            updates_per_epoch: 100,
            env_steps_per_update: 2,
            round_updates: 20,
            warm_up_env_steps: 200,
            training_envs: 3,
            evaluation_episodes: 8,
        },
    }
}

/// One run of it.
pub struct Ride<'a> {
    pub learning: &'a Learning,
    pub make_env: fn() -> Box<dyn Env>,
    pub seed: u64,
    pub device: Device,
    pub folder: &'a Path,
    pub resume: bool,
    /// Stops at the end of the round with this many updates.
    pub stop_after: u64,
}

impl<'a> Ride<'a> {
    /// From the beginning to the end, on plain memory.
    pub fn new(learning: &'a Learning, seed: u64, folder: &'a Path) -> Self {
        let (make_env, device) = (Cart::boxed, Device::Cpu);
        Self { learning, make_env, seed, device, folder, resume: false, stop_after: u64::MAX }
    }

    pub fn train(self) -> Result<Outcome, TrainError> {
        let Self { learning, make_env, seed, device, folder, resume, stop_after } = self;
        let stop = AtomicBool::new(false);
        let run = Run { learning, make_env: &make_env, seed, device, folder, stop: &stop };
        run.train(resume, &mut |event| {
            if matches!(event, Event::Round { updates, .. } if updates >= stop_after) {
                stop.store(true, Ordering::Relaxed);
            }
        })
    }
}
