use super::super::policy::DenseLayer;
use super::*;

const LAYOUT: Layout = Layout { observation_len: 2, action_len: 1 };

fn config() -> Td3Config {
    Td3Config { hidden_layers: 2, hidden_width: 8, batch_size: 4, ..Td3Config::default() }
}

fn agent() -> Agent {
    Agent::new(&config(), LAYOUT, 7)
}

/// Four rows: observation, action, reward, not terminal, next observation.
fn rows() -> Vec<f32> {
    let mut rows = Vec::new();
    for i in 0..4 {
        let x = i as f32 / 4.0;
        rows.extend([x, -x, 0.5 - x, 1.0 + x, if i == 3 { 0.0 } else { 1.0 }, x + 0.1, 0.3 - x]);
    }
    rows
}

/// Weights of zero and an output of `value`: a constant.
fn make_constant(network: &mut Mlp, value: f32) {
    let mut layers = network.layers_of(&network.parameters);
    for DenseLayer { weight, bias } in &mut layers {
        weight.fill(0.0);
        bias.fill(0.0);
    }
    layers.last_mut().unwrap().bias.fill(value);
    network.set_layers(&layers);
}

/// The network's answer to one input.
fn answer(network: &Mlp, input: &[f32]) -> f32 {
    let mut activations = Activations::default();
    network.forward(Matrix::dense(input, input.len()), &mut activations);
    activations.output()[0]
}

/// The critics' targets for [`rows`] with noise made of these normal numbers.
fn target(agent: &mut Agent, normals: [f32; 4]) -> Vec<f32> {
    agent.compute_targets(&rows(), &normals);
    agent.scratch.target.clone()
}

#[test]
fn the_target_takes_the_smaller_critic_and_stops_at_an_end() {
    for values in [[5.0, 3.0], [3.0, 5.0]] {
        let mut agent = agent();
        for (critic, value) in agent.target_critics.iter_mut().zip(values) {
            make_constant(critic, value);
        }

        let target = target(&mut agent, [0.0; 4]);

        // Reward + 0.99 · 3; the last row ended, its reward is all there is.
        let expected = [1.0 + 2.97, 1.25 + 2.97, 1.5 + 2.97, 1.75];
        for (got, want) in target.iter().zip(expected) {
            assert!((got - want).abs() < 1e-5, "{target:?}");
        }
    }
}

#[test]
fn the_target_values_the_smoothed_action_clipped_to_its_range() {
    let mut agent = agent();
    // The target actor says tanh(1.5) = 0.905 everywhere.
    make_constant(&mut agent.target_actor, 1.5);
    let a = 1.5_f32.tanh();

    // Noise is 0.2 of these, at most 0.5 either way.
    let target = target(&mut agent, [2.0, -9.0, 0.0, 0.25]);

    for (row, action) in [1.0, a - 0.5, a].into_iter().enumerate() {
        let x = row as f32 / 4.0;
        let critic_input = [x + 0.1, 0.3 - x, action];
        let values = agent.target_critics.each_ref().map(|critic| answer(critic, &critic_input));
        let want = 1.0 + x + 0.99 * values[0].min(values[1]);
        assert!((target[row] - want).abs() < 1e-5, "{target:?}");
    }
}

#[test]
fn smoothing_noise_has_the_asked_spread_and_limit() {
    let agent = agent();
    let mut rng = stream(1, Purpose::Smooth, 0);

    let noise: Vec<f32> =
        (0..20_000).map(|_| agent.config.smoothing_noise(rng.sample(StandardNormal))).collect();

    let spread = (noise.iter().map(|n| n * n).sum::<f32>() / noise.len() as f32).sqrt();
    assert!((spread - 0.2).abs() < 0.005, "{spread}");
    let largest = noise.iter().fold(0.0_f32, |largest, n| largest.max(n.abs()));
    assert_eq!(largest, 0.5);
}

/// Every network's parameters and derivatives, but the critics'.
fn all_but_the_critics(agent: &Agent) -> Vec<Mlp> {
    let [target1, target2] = agent.target_critics.clone();
    vec![agent.actor.clone(), agent.target_actor.clone(), target1, target2]
}

#[test]
fn the_actor_and_the_targets_wait_for_every_second_update() {
    let mut agent = agent();
    let mut rng = stream(0, Purpose::Smooth, 0);
    let (waiting, critics) = (all_but_the_critics(&agent), agent.critics.clone());

    let losses = agent.update(&rows(), &mut rng);

    assert_eq!(all_but_the_critics(&agent), waiting);
    assert_eq!(losses.actor, None);
    assert!(agent.critics[0] != critics[0] && agent.critics[1] != critics[1]);

    let losses = agent.update(&rows(), &mut rng);

    for (after, before) in all_but_the_critics(&agent).iter().zip(&waiting) {
        assert_ne!(after.parameters, before.parameters);
    }
    assert!(losses.actor.is_some());
}

#[test]
fn an_actor_update_leaves_the_critics_and_their_derivatives_alone() {
    let mut agent = agent();
    for critic in &mut agent.critics {
        critic.gradients.fill(0.25);
    }
    let (critics, actor) = (agent.critics.clone(), agent.actor.clone());

    agent.update_actor(&rows());

    assert_eq!(agent.critics, critics);
    assert_ne!(agent.actor.parameters, actor.parameters);
}

#[test]
fn targets_move_the_share_tau_of_the_way() {
    let mut agent = agent();
    for (fast, slow) in agent.critics.iter_mut().zip(&mut agent.target_critics) {
        fast.parameters.fill(1.0);
        slow.parameters.fill(0.0);
    }
    agent.actor.parameters.fill(-1.0);
    agent.target_actor.parameters.fill(0.0);

    agent.soft_update();
    agent.soft_update();

    // 1 - (1 - 0.005)²
    for critic in &agent.target_critics {
        assert!(critic.parameters.iter().all(|value| (value - 0.009_975).abs() < 1e-7));
    }
    assert!(agent.target_actor.parameters.iter().all(|value| (value + 0.009_975).abs() < 1e-7));
}

#[test]
fn the_critics_descend_the_squared_error() {
    let mut agent = agent();
    let target = [0.3, -0.2, 1.0, 0.5];
    agent.scratch.target = target.to_vec();
    let rows = rows();
    let errors = agent.critics.each_ref().map(|critic| {
        let error = |(row, target): (&[f32], f32)| answer(critic, &row[..3]) - target;
        rows.chunks(LAYOUT.row_len()).zip(target).map(error).sum::<f32>()
    });

    agent.update_critics(&rows);

    // The derivative by the output's bias is the mean of 2 (q - target).
    for (critic, error) in agent.critics.iter().zip(errors) {
        let bias = critic.layers_of(&critic.gradients).pop().unwrap().bias[0];
        assert!((bias - error * 2.0 / 4.0).abs() < 1e-5, "{bias} {error}");
    }
}

#[test]
fn the_actor_climbs_the_first_critic() {
    let mut agent = agent();
    let value_with = |agent: &Agent, shift: f32| {
        let mut actor = agent.actor.clone();
        let mut layers = actor.layers_of(&actor.parameters);
        layers.last_mut().unwrap().bias[0] += shift;
        actor.set_layers(&layers);
        let value = |row: &[f32]| {
            let action = answer(&actor, &row[..2]).tanh();
            f64::from(answer(&agent.critics[0], &[row[0], row[1], action]))
        };
        rows().chunks(LAYOUT.row_len()).map(value).sum::<f64>() / 4.0
    };
    let slope = (value_with(&agent, 0.01) - value_with(&agent, -0.01)) / 0.02;
    assert!(slope.abs() > 1e-4, "nothing to climb");

    agent.update_actor(&rows());

    let downhill = f64::from(agent.actor.layers_of(&agent.actor.gradients).pop().unwrap().bias[0]);
    assert!((downhill + slope).abs() < 0.02 * slope.abs() + 1e-5, "{downhill} {slope}");
}

/// Neither critic sees the other's error, and the actor climbs the first alone.
#[test]
fn what_the_second_critic_says_changes_no_derivative_but_its_own() {
    let derivatives = |change: f32| {
        let mut agent = agent();
        agent.scratch.target = vec![0.3, -0.2, 1.0, 0.5];
        agent.critics[1].parameters.iter_mut().for_each(|number| *number *= change);
        agent.update_actor(&rows());
        agent.update_critics(&rows());
        let [first, second] = agent.critics;
        (agent.actor.gradients, first.gradients, second.gradients)
    };

    let (as_it_was, changed) = (derivatives(1.0), derivatives(2.0));

    assert_eq!((&as_it_was.0, &as_it_was.1), (&changed.0, &changed.1));
    assert_ne!(as_it_was.2, changed.2);
}

/// NaN must reach the losses, where the trainer checks for it.
#[test]
fn a_value_that_is_no_number_shows_in_the_losses() {
    for copy in 0..2 {
        let mut agent = agent();
        agent.target_critics[copy].parameters[0] = f32::NAN;

        let losses = agent.update(&rows(), &mut stream(0, Purpose::Smooth, 0));

        assert!(!losses.is_finite(), "{copy}: {losses:?}");
    }
}

/// The paper's networks: 27-8, 3 x 128.
#[test]
fn the_arithmetic_of_the_papers_update_is_107_million_operations() {
    let layout = Layout { observation_len: 27, action_len: 8 };
    let agent = Agent::new(&Td3Config::default(), layout, 0);

    let count = agent.arithmetic_of_an_update(128);

    assert!((106e6..108e6).contains(&count), "{count}");
}
