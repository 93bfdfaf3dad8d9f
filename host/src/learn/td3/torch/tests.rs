use super::*;
use crate::learn::td3::random::{Purpose, stream};
use rand::Rng as _;

/// The Ant's.
const LAYOUT: Layout = Layout { observation_len: 27, action_len: 8 };

fn agent() -> Agent {
    Agent::new(&Td3Config { batch_size: 32, ..Td3Config::default() }, LAYOUT, 7)
}

/// `count` rows of random numbers; every fourth ends the task.
fn batch(count: usize, number: u64) -> Vec<f32> {
    let mut rng = stream(3, Purpose::Sample, number);
    let mut rows: Vec<f32> = (0..count * LAYOUT.row_len()).map(|_| rng.random_range(-1.0..1.0)).collect();
    for (index, row) in rows.chunks_exact_mut(LAYOUT.row_len()).enumerate() {
        row[LAYOUT.not_terminal()] = if index % 4 == 0 { 0.0 } else { 1.0 };
    }
    rows
}

fn normals(agent: &Agent, batch: &[f32], number: u64) -> Vec<f32> {
    let mut normals = Vec::new();
    agent.sample_normals(batch, &mut stream(3, Purpose::Smooth, number), &mut normals);
    normals
}

fn networks(agent: &Agent) -> [&Mlp; 6] {
    let [critic1, critic2] = &agent.critics;
    let [target1, target2] = &agent.target_critics;
    [&agent.actor, critic1, critic2, &agent.target_actor, target1, target2]
}

fn moments(agent: &Agent) -> Vec<(u64, &[f32], &[f32])> {
    let adams = [&agent.actor_adam, &agent.critics_adam[0], &agent.critics_adam[1]];
    adams.iter().map(|adam| (adam.steps, &adam.mean[..], &adam.square[..])).collect()
}

fn largest_difference(a: &[f32], b: &[f32]) -> f32 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
}

#[test]
fn what_was_handed_over_comes_back_bit_for_bit() {
    let mut agent = agent();
    for number in 0..3 {
        agent.update(&batch(32, number), &mut stream(1, Purpose::Smooth, number));
    }
    let mut back = self::agent();

    TorchAgent::new(&agent, Device::Cpu).unwrap().store(&mut back).unwrap();

    for (before, after) in networks(&agent).into_iter().zip(networks(&back)) {
        assert_eq!(before.parameters, after.parameters);
    }
    assert_eq!(moments(&agent), moments(&back));
    assert_eq!(agent.updates, back.updates);
}

#[test]
fn the_first_updates_are_those_on_plain_memory_to_rounding() {
    let mut plain = agent();
    let mut torch = TorchAgent::new(&plain, Device::Cpu).unwrap();
    let mut actor_loss = None;

    for number in 0..20 {
        let batch = batch(32, number);
        let normals = normals(&plain, &batch, number);
        let losses = plain.update(&batch, &mut stream(3, Purpose::Smooth, number));
        torch.update_with(&batch, &normals).unwrap();
        actor_loss = losses.actor.or(actor_loss);

        let same = torch.losses().unwrap();
        assert_eq!(same.actor.is_some(), actor_loss.is_some());
        let pairs = [
            (losses.critic, same.critic),
            (losses.q_mean, same.q_mean),
            (actor_loss.unwrap_or(0.0), same.actor.unwrap_or(0.0)),
        ];
        for (wanted, got) in pairs {
            assert!((wanted - got).abs() < 2e-4, "update {number}: {losses:?} {same:?}");
        }
    }

    let mut back = agent();
    torch.store(&mut back).unwrap();
    for (plain, torch) in networks(&plain).into_iter().zip(networks(&back)) {
        let difference = largest_difference(&plain.parameters, &torch.parameters);
        assert!(difference < 1e-3, "{difference}");
    }
    assert_eq!((back.updates, back.critics_adam[1].steps, back.actor_adam.steps), (20, 20, 10));
}

/// A run that is interrupted hands everything over and takes it up again.
#[test]
fn going_on_from_what_was_handed_back_changes_nothing() {
    let mut whole = TorchAgent::new(&agent(), Device::Cpu).unwrap();
    let mut broken = TorchAgent::new(&agent(), Device::Cpu).unwrap();

    for number in 0..6 {
        let batch = batch(32, number);
        let normals = normals(&agent(), &batch, number);
        whole.update_with(&batch, &normals).unwrap();
        broken.update_with(&batch, &normals).unwrap();
        let mut between = agent();
        broken.store(&mut between).unwrap();
        broken = TorchAgent::new(&between, Device::Cpu).unwrap();
    }

    let (mut one, mut other) = (agent(), agent());
    whole.store(&mut one).unwrap();
    broken.store(&mut other).unwrap();
    for (one, other) in networks(&one).into_iter().zip(networks(&other)) {
        assert_eq!(one.parameters, other.parameters);
    }
    assert_eq!(moments(&one), moments(&other));
}

/// NaN must reach the losses, where the trainer checks for it.
#[test]
fn a_value_that_is_no_number_shows_in_the_losses() {
    for copy in 0..2 {
        let mut agent = agent();
        agent.target_critics[copy].parameters[0] = f32::NAN;
        let mut torch = TorchAgent::new(&agent, Device::Cpu).unwrap();

        let batch = batch(32, 0);
        torch.update_with(&batch, &normals(&agent, &batch, 0)).unwrap();

        assert!(!torch.losses().unwrap().is_finite(), "{copy}");
    }
}

#[test]
fn a_batch_that_is_no_whole_rows_is_an_error_and_no_panic() {
    let mut torch = TorchAgent::new(&agent(), Device::Cpu).unwrap();

    assert!(torch.update_with(&[0.0; 10], &[]).is_err());
}

#[test]
fn a_gpu_agrees_with_plain_memory_where_there_is_one() {
    if !tch::Cuda::is_available() {
        println!("skipped: libtorch finds no CUDA GPU");
        return;
    }
    let mut plain = agent();
    let mut torch = TorchAgent::new(&plain, Device::Cuda(0)).unwrap();

    for number in 0..20 {
        let batch = batch(32, number);
        let normals = normals(&plain, &batch, number);
        let losses = plain.update(&batch, &mut stream(3, Purpose::Smooth, number));
        torch.update_with(&batch, &normals).unwrap();

        let same = torch.losses().unwrap();
        assert!((losses.critic - same.critic).abs() < 2e-4, "update {number}: {losses:?} {same:?}");
    }
}
