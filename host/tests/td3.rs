//! Whole training runs on a task of one number, small enough to learn in seconds.
#![cfg(feature = "train")]
#![allow(missing_docs)]

mod cart;

use cart::{Cart, Ride, learning};
use host::learn::td3::checkpoint::{self, CheckpointError};
use host::learn::td3::config::{Learning, Td3Config};
use host::learn::td3::device::Device;
use host::learn::td3::outcome::{Ending, Outcome, TrainError};
use host::learn::td3::policy::Policy;
use host::learn::td3::policy_description::POLICY_DESCRIPTION;
use host::run_folder;
use std::path::Path;

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
    Ride { device, resume, stop_after, ..Ride::new(learning, seed, folder) }.train().unwrap()
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
    let learning = learning(20);
    let run = Ride { make_env: Cart::mortal, ..Ride::new(&learning, 0, folder.path()) };

    let error = run.train().unwrap_err();

    assert!(matches!(error, TrainError::Collect(_)), "{error}");
    assert!(Policy::load(&folder.path().join(run_folder::POLICY)).is_ok());
}

#[test]
fn learning_that_diverges_stops_and_keeps_the_best_policy() {
    let folder = tempfile::tempdir().unwrap();
    let mut learning = learning(20);
    learning.td3.critic_learning_rate = 1e30;

    let error = Ride::new(&learning, 0, folder.path()).train().unwrap_err();

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
    let layout = host::learn::td3::replay::Layout { observation_len: 2, action_len: 1 };
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
        let mut learning = learning(20);
        learning.td3.critic_learning_rate = 1e30;
        let run = Ride { device: Device::Torch, ..Ride::new(&learning, 0, folder.path()) };

        let error = run.train().unwrap_err();

        assert!(matches!(error, TrainError::Diverged { .. }), "{error}");
        assert!(Policy::load(&folder.path().join(run_folder::POLICY)).unwrap().is_finite());
    }
}
