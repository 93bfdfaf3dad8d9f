//! Two updates against PyTorch's, from the same weights, batches and noise.
//!
//! `reference.json` is checked in; `scripts/td3-reference.py` makes it.

use super::super::policy::DenseLayer;
use super::*;
use std::collections::BTreeMap;

const REFERENCE: &str = include_str!("reference.json");
const TOLERANCE: f32 = 1e-5;

/// A layer as PyTorch has it: `weight[output][input]`.
#[derive(Deserialize)]
struct Layer {
    weight: Vec<Vec<f32>>,
    bias: Vec<f32>,
}

/// Copies of a network.
type Copies = Vec<Vec<Layer>>;

#[derive(Deserialize)]
struct Update {
    batch: Vec<Vec<f32>>,
    normals: Vec<Vec<f32>>,
    clipped_noise: usize,
    second_critic_smaller: usize,
    target: Vec<f32>,
    critic_loss: f32,
    critic_gradients: Copies,
    actor_loss: Option<f32>,
    actor_gradients: Option<Copies>,
    after: BTreeMap<String, Copies>,
}

#[derive(Deserialize)]
struct Reference {
    observation_len: usize,
    action_len: usize,
    hidden: Vec<usize>,
    config: BTreeMap<String, f64>,
    before: BTreeMap<String, Copies>,
    updates: Vec<Update>,
}

impl Reference {
    fn read() -> Self {
        serde_json::from_str(REFERENCE).unwrap()
    }

    /// The agent before the first update.
    fn agent(&self) -> Agent {
        let number = |name: &str| self.config[name];
        let config = Td3Config {
            actor_learning_rate: number("actor_learning_rate"),
            critic_learning_rate: number("critic_learning_rate"),
            gamma: number("gamma"),
            tau: number("tau"),
            policy_delay: number("policy_delay") as u64,
            policy_noise: number("policy_noise") as f32,
            policy_noise_clip: number("policy_noise_clip") as f32,
            ..Td3Config::default()
        };
        let layout = Layout { observation_len: self.observation_len, action_len: self.action_len };
        let mut agent = Agent::with_hidden(&config, layout, &self.hidden, 0);
        for (name, copy, network) in networks(&mut agent) {
            let layers: Vec<_> = self.before[name][copy].iter().map(dense).collect();
            network.set_layers(&layers);
        }
        agent
    }
}

/// Name and number in the reference, and the network.
fn networks(agent: &mut Agent) -> [(&'static str, usize, &mut Mlp); 6] {
    let [critic1, critic2] = &mut agent.critics;
    let [target1, target2] = &mut agent.target_critics;
    [
        ("actor", 0, &mut agent.actor),
        ("critics", 0, critic1),
        ("critics", 1, critic2),
        ("target_actor", 0, &mut agent.target_actor),
        ("target_critics", 0, target1),
        ("target_critics", 1, target2),
    ]
}

/// Ours are `weight[input][output]`.
fn dense(layer: &Layer) -> DenseLayer {
    let inputs = layer.weight[0].len();
    let weight = (0..inputs).flat_map(|i| layer.weight.iter().map(move |row| row[i])).collect();
    DenseLayer { weight, bias: layer.bias.clone() }
}

#[track_caller]
fn assert_near(what: &str, got: &[f32], want: &[f32]) {
    assert_eq!(got.len(), want.len(), "{what}");
    for (index, (got, want)) in got.iter().zip(want).enumerate() {
        assert!((got - want).abs() <= TOLERANCE, "{what}, number {index}: {got} is not {want}");
    }
}

/// Compares `flat`, laid out as the network's parameters.
#[track_caller]
fn assert_layers(what: &str, network: &Mlp, flat: &[f32], want: &[Layer]) {
    let got = network.layers_of(flat);
    assert_eq!(got.len(), want.len());
    for (depth, (got, want)) in got.iter().zip(want).enumerate() {
        let want = dense(want);
        assert_near(&format!("{what}, weight {depth}"), &got.weight, &want.weight);
        assert_near(&format!("{what}, bias {depth}"), &got.bias, &want.bias);
    }
}

/// Holds an update to the reference: its losses and the critics' targets, then what
/// `agent` has of derivatives and parameters.
#[track_caller]
fn assert_update(number: usize, update: &Update, losses: Losses, target: &[f32], agent: &mut Agent) {
    assert_near(&format!("update {number}, target"), target, &update.target);
    assert_near(&format!("update {number}, critic loss"), &[losses.critic as f32], &[update.critic_loss]);
    for (critic, want) in agent.critics.iter().zip(&update.critic_gradients) {
        let what = format!("update {number}, gradient of a critic");
        assert_layers(&what, critic, &critic.gradients, want);
    }
    assert_eq!(losses.actor.is_some(), update.actor_loss.is_some());
    if let (Some(loss), Some(gradients)) = (update.actor_loss, &update.actor_gradients) {
        assert_near(&format!("update {number}, actor loss"), &[losses.actor.unwrap() as f32], &[loss]);
        let what = format!("update {number}, gradient of the actor");
        assert_layers(&what, &agent.actor, &agent.actor.gradients, &gradients[0]);
    }
    for (name, copy, network) in networks(agent) {
        let what = format!("after update {number}, {name} {copy}");
        assert_layers(&what, network, &network.parameters, &update.after[name][copy]);
    }
}

#[test]
fn two_updates_come_out_as_pytorchs() {
    let reference = Reference::read();
    let mut agent = reference.agent();

    for (number, update) in (1..).zip(&reference.updates) {
        let losses = agent.update_with(&update.batch.concat(), &update.normals.concat());

        let target = agent.scratch.target.clone();
        assert_update(number, update, losses, &target, &mut agent);
    }
}

#[cfg(feature = "torch")]
#[test]
fn two_updates_on_libtorch_come_out_as_pytorchs() {
    let reference = Reference::read();
    let mut agent = reference.agent();
    let mut torch = super::super::torch::TorchAgent::new(&agent, tch::Device::Cpu).unwrap();

    for (number, update) in (1..).zip(&reference.updates) {
        torch.update_with(&update.batch.concat(), &update.normals.concat()).unwrap();

        torch.store(&mut agent).unwrap();
        torch.store_gradients(&mut agent).unwrap();
        let target = torch.latest_target().unwrap();
        assert_update(number, update, torch.losses().unwrap(), &target, &mut agent);
    }
}

/// A reference that skips the hard cases would prove little.
#[test]
fn the_reference_meets_ends_clipped_noise_and_both_critics() {
    let reference = Reference::read();
    let layout = reference.agent().layout;

    for update in &reference.updates {
        let ended = update.batch.iter().filter(|row| row[layout.not_terminal()] == 0.0).count();
        assert!((1..6).contains(&ended) && update.clipped_noise > 0);
    }
    let second_smaller: usize = reference.updates.iter().map(|u| u.second_critic_smaller).sum();
    assert!((2..=10).contains(&second_smaller), "of 12 rows: {second_smaller}");
}
