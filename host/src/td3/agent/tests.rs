use super::super::networks::numbers;
use super::*;

const LAYOUT: Layout = Layout { observation_len: 2, action_len: 1 };

fn config() -> Td3Config {
    Td3Config { hidden_layers: 2, hidden_width: 8, batch_size: 4, ..Td3Config::default() }
}

fn agent() -> Agent {
    Agent::new(&config(), LAYOUT, 7)
}

/// Four rows: observation, action, reward, continuation, next observation.
fn rows() -> Vec<f32> {
    let mut rows = Vec::new();
    for i in 0..4 {
        let x = i as f32 / 4.0;
        rows.extend([x, -x, 0.5 - x, 1.0 + x, if i == 3 { 0.0 } else { 1.0 }, x + 0.1, 0.3 - x]);
    }
    rows
}

fn batch() -> Tensor {
    Tensor::from_slice(&rows()).view([4, LAYOUT.row_len() as i64])
}

/// Sets every weight to zero and the output biases to `values`: a constant.
fn make_constant(network: &mut Mlp, values: &[f32]) {
    let mut flat = vec![0.0; network.parameters.numel()];
    // The output's biases are the last span, padded to 16 numbers.
    let start = flat.len() - 16;
    flat[start..start + values.len()].copy_from_slice(values);
    network.load(&flat);
}

fn flat(tensor: &Tensor) -> Vec<f32> {
    numbers(&tensor.contiguous())
}

#[test]
fn the_target_takes_the_smaller_critic_and_stops_at_an_end() {
    let mut agent = agent();
    make_constant(&mut agent.target_critics, &[5.0, 3.0]);

    let target = flat(&agent.target(&batch(), &Tensor::zeros([4, 1], (Kind::Float, tch::Device::Cpu))));

    // Reward + 0.99 · 3; the last row ended, its reward is all there is.
    let expected = [1.0 + 2.97, 1.25 + 2.97, 1.5 + 2.97, 1.75];
    for (got, want) in target.iter().zip(expected) {
        assert!((got - want).abs() < 1e-5, "{target:?}");
    }
}

#[test]
fn the_target_judges_the_smoothed_action_inside_its_range() {
    let mut agent = agent();
    // The target actor says tanh(1.5) = 0.905 everywhere.
    make_constant(&mut agent.target_actor, &[1.5]);
    let noise = Tensor::from_slice(&[0.5_f32, -0.5, 0.0, 0.05]).view([4, 1]);
    let next = columns(&batch(), LAYOUT.next_observation(), 2);
    let judged = |actions: [f32; 4]| {
        let actions = Tensor::from_slice(&actions).view([4, 1]);
        let values = agent.target_critics.forward(&Tensor::cat(&[&next, &actions], 1));
        flat(&values.output().amin([0_i64].as_slice(), false))
    };
    let a = 1.5_f32.tanh();

    let target = flat(&agent.target(&batch(), &noise));

    let values = judged([1.0, a - 0.5, a, a + 0.05]);
    for row in 0..3 {
        let want = 1.0 + row as f32 / 4.0 + 0.99 * values[row];
        assert!((target[row] - want).abs() < 1e-5, "{target:?}");
    }
}

#[test]
fn smoothing_noise_has_the_asked_spread_and_limit() {
    let agent = agent();
    let mut rng = stream(1, Purpose::Smooth, 0);
    let normals: Vec<f32> = (0..20_000).map(|_| rng.sample(StandardNormal)).collect();

    let noise = flat(&agent.smoothing_noise(&normals));

    let spread = (noise.iter().map(|n| n * n).sum::<f32>() / noise.len() as f32).sqrt();
    assert!((spread - 0.2).abs() < 0.005, "{spread}");
    let largest = noise.iter().fold(0.0_f32, |largest, n| largest.max(n.abs()));
    assert_eq!(largest, 0.5);
}

#[test]
fn the_actor_and_the_targets_wait_for_every_second_update() {
    let mut agent = agent();
    let mut rng = stream(0, Purpose::Smooth, 0);
    let actor = flat(&agent.actor.parameters);
    let critics = flat(&agent.critics.parameters);
    let target = flat(&agent.target_critics.parameters);

    agent.update(&rows(), &mut rng, false);

    assert_eq!(flat(&agent.actor.parameters), actor);
    assert_eq!(flat(&agent.target_critics.parameters), target);
    assert_ne!(flat(&agent.critics.parameters), critics);

    agent.update(&rows(), &mut rng, false);

    assert_ne!(flat(&agent.actor.parameters), actor);
    assert_ne!(flat(&agent.target_critics.parameters), target);
}

#[test]
fn an_actor_update_leaves_the_critics_and_their_derivatives_alone() {
    let mut agent = agent();
    let _ = agent.critics.gradients.fill_(0.25);
    let critics = flat(&agent.critics.parameters);
    let actor = flat(&agent.actor.parameters);

    let _ = agent.update_actor(&batch());

    assert_eq!(flat(&agent.critics.parameters), critics);
    assert!(flat(&agent.critics.gradients).iter().all(|&g| g == 0.25));
    assert_ne!(flat(&agent.actor.parameters), actor);
}

#[test]
fn targets_move_the_share_tau_of_the_way() {
    let mut agent = agent();
    let _ = agent.critics.parameters.fill_(1.0);
    let _ = agent.target_critics.parameters.fill_(0.0);

    agent.follow();
    agent.follow();

    // 1 - (1 - 0.005)²
    for value in flat(&agent.target_critics.parameters) {
        assert!((value - 0.009_975).abs() < 1e-7, "{value}");
    }
}

#[test]
fn the_critics_descend_the_squared_error() {
    let mut agent = agent();
    let target = Tensor::from_slice(&[0.3_f32, -0.2, 1.0, 0.5]).view([4, 1]);
    let values = agent.critics.forward(&columns(&batch(), 0, 3)).output().shallow_clone();
    let error = flat(&(values - target.unsqueeze(0)));

    agent.update_critics(&batch(), &target, false);

    // The derivative by an output's bias is the mean of 2 (q - target).
    let gradients = flat(&agent.critics.gradients);
    let biases = &gradients[gradients.len() - 16..];
    for critic in 0..2 {
        let want = error[critic * 4..][..4].iter().sum::<f32>() * 2.0 / 4.0;
        assert!((biases[critic] - want).abs() < 1e-5, "{biases:?} {want}");
    }
}

#[test]
fn the_actor_climbs_the_first_critic() {
    let mut agent = agent();
    let bias = agent.actor.parameters.numel() - 16;
    let value_with = |agent: &mut Agent, shift: f32| {
        let before = flat(&agent.actor.parameters);
        let mut shifted = before.clone();
        shifted[bias] += shift;
        agent.actor.load(&shifted);
        let observation = columns(&batch(), 0, 2);
        let action = act(&agent.actor.forward(&observation)).squeeze_dim(0);
        let values = agent.critics.forward_first(&Tensor::cat(&[observation, action], 1));
        agent.actor.load(&before);
        values.output().mean(Kind::Double).double_value(&[])
    };
    let slope = (value_with(&mut agent, 0.01) - value_with(&mut agent, -0.01)) / 0.02;
    assert!(slope.abs() > 1e-4, "nothing to climb");

    let _ = agent.update_actor(&batch());

    let downhill = f64::from(flat(&agent.actor.gradients)[bias]);
    assert!((downhill + slope).abs() < 0.02 * slope.abs() + 1e-5, "{downhill} {slope}");
}

/// Each update moves what it is to move, and nothing else.
#[test]
fn a_critic_update_leaves_the_actor_and_every_target_alone() {
    let mut agent = agent();
    let names = ["actor", "target actor", "target critics"];
    let untouched = |agent: &Agent| {
        [&agent.actor, &agent.target_actor, &agent.target_critics]
            .map(|n| (flat(&n.parameters), flat(&n.gradients)))
    };
    let (before, critics) = (untouched(&agent), flat(&agent.critics.parameters));

    agent.update(&rows(), &mut stream(0, Purpose::Smooth, 0), false);

    for ((name, before), after) in names.iter().zip(before).zip(untouched(&agent)) {
        assert_eq!(before, after, "{name}");
    }
    assert_ne!(flat(&agent.critics.parameters), critics);
}

/// Neither critic sees the other's error, and the actor climbs the first alone.
#[test]
fn what_the_second_critic_says_changes_no_derivative_but_its_own() {
    let target = Tensor::from_slice(&[0.3_f32, -0.2, 1.0, 0.5]).view([4, 1]);
    let derivatives = |change: f32| {
        let mut agent = agent();
        let mut second = agent.critics.layers_of(&agent.critics.parameters, 1);
        second[0].weight.iter_mut().for_each(|weight| *weight *= change);
        agent.critics.set_layers(1, &second);
        let _ = agent.update_actor(&batch());
        agent.update_critics(&batch(), &target, false);
        let of_critic = |copy| agent.critics.layers_of(&agent.critics.gradients, copy);
        (flat(&agent.actor.gradients), of_critic(0), of_critic(1))
    };

    let (as_it_was, changed) = (derivatives(1.0), derivatives(2.0));

    assert_eq!((&as_it_was.0, &as_it_was.1), (&changed.0, &changed.1));
    assert_ne!(as_it_was.2, changed.2);
}
