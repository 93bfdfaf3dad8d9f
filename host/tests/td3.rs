//! Whole training runs on a task of one number, small enough to learn in seconds.
#![cfg(feature = "train")]
#![allow(missing_docs)]

use host::env::{Env, Step};
use host::run_folder;
use host::td3::POLICY_DESCRIPTION;
use host::td3::checkpoint::{self, CheckpointError};
use host::td3::config::{Learning, Schedule, Td3Config};
use host::td3::device::Device;
use host::td3::outcome::{Ending, Event, Outcome, TrainError};
use host::td3::policy::Policy;
use host::td3::trainer::Run;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

/// A cart on a line that is to stand at the origin; it starts anywhere within
/// a metre, an episode lasts 30 steps, and 3 m away it falls off.
struct Cart {
    position: f32,
    steps: u32,
    /// Breaks down after this many steps in all episodes together.
    steps_to_live: u32,
}

impl Cart {
    fn boxed() -> Box<dyn Env> {
        Box::new(Self { position: 0.0, steps: 0, steps_to_live: u32::MAX })
    }

    fn mortal() -> Box<dyn Env> {
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

fn learning(epochs: u64) -> Learning {
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

fn train(learning: &Learning, seed: u64, folder: &Path, resume: bool, stop_after: u64) -> Outcome {
    train_on(Device::Cpu, learning, seed, folder, resume, stop_after)
}

fn train_on(
    device: Device,
    learning: &Learning,
    seed: u64,
    folder: &Path,
    resume: bool,
    stop_after: u64,
) -> Outcome {
    let stop = AtomicBool::new(false);
    let run = Run { learning, make_env: &Cart::boxed, seed, device, folder, stop: &stop };
    run.train(resume, &mut |event| {
        if matches!(event, Event::Round { updates, .. } if updates >= stop_after) {
            stop.store(true, Ordering::Relaxed);
        }
    })
    .unwrap()
}

/// Everything a run leaves but its wall-clock times.
fn leavings(folder: &Path) -> (Vec<u8>, Vec<u8>, Vec<String>) {
    let read = |name: &str| std::fs::read(folder.join(name)).unwrap();
    let curve = String::from_utf8(read(run_folder::LEARNING_CURVE)).unwrap();
    let without_time = |line: &str| {
        let mut columns: Vec<_> = line.split(',').collect();
        columns.remove(2);
        columns.join(",")
    };
    (read(run_folder::POLICY), read(POLICY_DESCRIPTION), curve.lines().map(without_time).collect())
}

fn final_tensors(folder: &Path) -> Vec<u8> {
    let name = |entry: std::io::Result<std::fs::DirEntry>| entry.unwrap().path();
    let mut files = std::fs::read_dir(folder.join(checkpoint::FOLDER)).unwrap().map(name);
    std::fs::read(files.find(|path| path.extension().is_some_and(|e| e == "safetensors")).unwrap()).unwrap()
}

#[test]
fn a_cart_learns_to_stand_at_the_origin() {
    let folder = tempfile::tempdir().unwrap();

    let outcome = train(&learning(20), 1, folder.path(), false, u64::MAX);

    let untrained = outcome.curve[0].reward;
    let best = outcome.curve[outcome.best].reward;
    // 30 steps at best; the way to the origin costs about one.
    assert!(best > 26.0 && untrained < best - 3.0, "{untrained} -> {best}");
    let mut policy = Policy::load(&folder.path().join(run_folder::POLICY)).unwrap();
    let mut action = [0.0];
    policy.act(&[1.0, 0.5], &mut action);
    assert!(action[0] < -0.5, "{action:?}");
    policy.act(&[-1.0, 0.5], &mut action);
    assert!(action[0] > 0.5, "{action:?}");
}

/// The paper's order: no random steps, one update a hand-over.
#[test]
fn a_run_without_a_warm_up_acts_first_and_learns_from_the_second_round_on() {
    let folder = tempfile::tempdir().unwrap();
    let mut learning = learning(1);
    learning.schedule.warm_up_env_steps = 0;
    learning.schedule.round_updates = 1;

    let outcome = train(&learning, 1, folder.path(), false, u64::MAX);

    assert_eq!(outcome.updates, 100);
    // A round more than there are updates: the first has nothing to learn from.
    assert_eq!(outcome.env_steps, 202);
}

#[test]
fn one_seed_has_one_result_and_another_seed_another() {
    let folders = [(); 3].map(|()| tempfile::tempdir().unwrap());

    for (folder, seed) in folders.iter().zip([5, 5, 6]) {
        train(&learning(3), seed, folder.path(), false, u64::MAX);
    }

    let [first, again, other] = folders.each_ref().map(|folder| leavings(folder.path()));
    assert_eq!(first, again);
    assert_ne!(first.0, other.0);
    assert_eq!(final_tensors(folders[0].path()), final_tensors(folders[1].path()));
}

/// Stopped in the warm-up, in the middle of an epoch and at its end.
#[test]
fn an_interrupted_run_ends_as_if_it_had_not_been() {
    let whole = tempfile::tempdir().unwrap();
    train(&learning(4), 2, whole.path(), false, u64::MAX);

    for stops in [vec![0], vec![140], vec![20, 200, 360]] {
        let broken = tempfile::tempdir().unwrap();
        let mut resume = false;
        for &stop in &stops {
            let outcome = train(&learning(4), 2, broken.path(), resume, stop);
            assert_eq!(outcome.ending, Ending::Stopped);
            resume = true;
        }
        let outcome = train(&learning(4), 2, broken.path(), true, u64::MAX);

        assert_eq!(outcome.ending, Ending::Done);
        assert_eq!(leavings(whole.path()), leavings(broken.path()), "stops at {stops:?}");
        assert_eq!(final_tensors(whole.path()), final_tensors(broken.path()), "stops at {stops:?}");
    }
}

#[test]
fn a_task_that_blows_up_stops_the_run_and_keeps_the_best_policy() {
    let folder = tempfile::tempdir().unwrap();
    let stop = AtomicBool::new(false);
    let learning = learning(20);
    let run = Run {
        learning: &learning,
        make_env: &Cart::mortal,
        seed: 0,
        device: Device::Cpu,
        folder: folder.path(),
        stop: &stop,
    };

    let error = run.train(false, &mut |_| {}).unwrap_err();

    assert!(matches!(error, TrainError::Collect(_)), "{error}");
    assert!(Policy::load(&folder.path().join(run_folder::POLICY)).is_ok());
}

#[test]
fn learning_that_diverges_stops_and_keeps_the_best_policy() {
    let folder = tempfile::tempdir().unwrap();
    let stop = AtomicBool::new(false);
    let mut learning = learning(20);
    learning.td3.critic_learning_rate = 1e30;
    let run = Run {
        learning: &learning,
        make_env: &Cart::boxed,
        seed: 0,
        device: Device::Cpu,
        folder: folder.path(),
        stop: &stop,
    };

    let error = run.train(false, &mut |_| {}).unwrap_err();

    assert!(matches!(error, TrainError::Diverged { .. }), "{error}");
    let policy = Policy::load(&folder.path().join(run_folder::POLICY)).unwrap();
    assert!(policy.is_finite());
}

#[test]
fn a_damaged_checkpoint_is_an_error_and_no_panic() {
    let folder = tempfile::tempdir().unwrap();
    let learning = learning(1);
    train(&learning, 0, folder.path(), false, u64::MAX);
    let state = folder.path().join(checkpoint::FOLDER).join("state.json");
    let text = std::fs::read_to_string(&state).unwrap();
    let layout = host::td3::replay::Layout { observation_len: 2, action_len: 1 };
    let load = || checkpoint::load(folder.path(), &learning.td3, layout, 3).map(|_| ());

    assert!(load().is_ok());

    std::fs::write(&state, &text[..text.len() / 2]).unwrap();
    assert!(matches!(load(), Err(CheckpointError::Format { .. })));

    std::fs::write(&state, text.replace("\"version\": 2", "\"version\": 99")).unwrap();
    assert!(matches!(load(), Err(CheckpointError::Version { version: 99, .. })));

    std::fs::write(&state, text.replace("\"best\": ", "\"best\": 7")).unwrap();
    assert!(matches!(load(), Err(CheckpointError::Contradiction { what: "best", .. })));

    let round = text.replace("\"round\": ", "\"round\": 9999999999999999");
    assert_ne!(round, text);
    std::fs::write(&state, round).unwrap();
    assert!(matches!(load(), Err(CheckpointError::Contradiction { what: "round", .. })));

    std::fs::write(&state, &text).unwrap();
    let wider = Td3Config { hidden_width: 33, ..learning.td3.clone() };
    assert!(matches!(checkpoint::load(folder.path(), &wider, layout, 3), Err(CheckpointError::Tensors(_))));
}

/// Whole runs on libtorch. What makes them like those on plain memory is held to
/// numbers beside the code; here, that a run's order of things is the same.
#[cfg(feature = "torch")]
mod on_libtorch {
    use super::*;

    #[test]
    fn a_run_starts_and_first_learns_as_on_plain_memory() {
        let (plain, torch) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
        // One round of updates, on experience of the warm-up alone.
        let mut learning = learning(1);
        learning.schedule.updates_per_epoch = 20;

        let plain = train_on(Device::Cpu, &learning, 4, plain.path(), false, u64::MAX).curve;
        let torch = train_on(Device::Torch, &learning, 4, torch.path(), false, u64::MAX).curve;

        assert_eq!(plain[0].reward, torch[0].reward, "the untrained policy");
        for (plain, torch) in [
            (plain[1].critic_loss, torch[1].critic_loss),
            (plain[1].actor_loss, torch[1].actor_loss),
            (plain[1].q_mean, torch[1].q_mean),
        ] {
            assert!(plain != 0.0 && (plain - torch).abs() < 1e-4, "{plain} {torch}");
        }
    }

    #[test]
    fn a_cart_learns_to_stand_at_the_origin() {
        let folder = tempfile::tempdir().unwrap();

        let outcome = train_on(Device::Torch, &learning(20), 1, folder.path(), false, u64::MAX);

        let untrained = outcome.curve[0].reward;
        let best = outcome.curve[outcome.best].reward;
        assert!(best > 26.0 && untrained < best - 3.0, "{untrained} -> {best}");
    }

    #[test]
    fn an_interrupted_run_ends_as_if_it_had_not_been() {
        let (whole, broken) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
        train_on(Device::Torch, &learning(4), 2, whole.path(), false, u64::MAX);

        train_on(Device::Torch, &learning(4), 2, broken.path(), false, 140);
        train_on(Device::Torch, &learning(4), 2, broken.path(), true, u64::MAX);

        assert_eq!(leavings(whole.path()), leavings(broken.path()));
        assert_eq!(final_tensors(whole.path()), final_tensors(broken.path()));
    }

    /// Where it stops does not matter to where it goes on.
    #[test]
    fn a_checkpoint_goes_on_on_either_device() {
        for (first, second) in [(Device::Cpu, Device::Torch), (Device::Torch, Device::Cpu)] {
            let folder = tempfile::tempdir().unwrap();

            train_on(first, &learning(20), 1, folder.path(), false, 900);
            let outcome = train_on(second, &learning(20), 1, folder.path(), true, u64::MAX);

            assert_eq!((outcome.ending, outcome.updates), (Ending::Done, 2000));
            assert!(outcome.curve[outcome.best].reward > 26.0, "{first} to {second}");
        }
    }

    #[test]
    fn learning_that_diverges_stops_and_keeps_the_best_policy() {
        let folder = tempfile::tempdir().unwrap();
        let stop = AtomicBool::new(false);
        let mut learning = learning(20);
        learning.td3.critic_learning_rate = 1e30;
        let (seed, device) = (0, Device::Torch);
        let make_env = &Cart::boxed;
        let run = Run { learning: &learning, make_env, seed, device, folder: folder.path(), stop: &stop };

        let error = run.train(false, &mut |_| {}).unwrap_err();

        assert!(matches!(error, TrainError::Diverged { .. }), "{error}");
        assert!(Policy::load(&folder.path().join(run_folder::POLICY)).unwrap().is_finite());
    }
}
