use super::*;
use crate::env::Step;
use crate::td3::policy::DenseLayer;

/// Says nothing and never ends.
struct Void;

impl Env for Void {
    fn observation_len(&self) -> usize {
        1
    }

    fn action_len(&self) -> usize {
        2
    }

    fn reset(&mut self, _seed: u64, observation: &mut [f32]) {
        observation.fill(0.0);
    }

    fn step(&mut self, _action: &[f32], observation: &mut [f32]) -> Step {
        observation.fill(0.0);
        Step { reward: 0.0, terminated: false, truncated: false, forward_speed_m_s: 0.0 }
    }
}

const LAYOUT: Layout = Layout { observation_len: 1, action_len: 2 };

/// The first joint's actions of one environment over a round.
fn actions(policy: Option<Policy>, noise: f32, correlation: f32) -> Vec<f32> {
    let make_env = || -> Box<dyn Env> { Box::new(Void) };
    let mut collector = Collector::new(&make_env, LAYOUT, 4, 2);
    let rows = collector.gather(Order { round: 0, env_steps: 40_000, policy, noise, correlation }).unwrap();
    rows.chunks(LAYOUT.row_len()).step_by(2).map(|row| row[LAYOUT.action()]).collect()
}

fn still() -> Option<Policy> {
    Some(Policy::new(vec![DenseLayer { weight: vec![0.0; 2], bias: vec![0.0; 2] }]))
}

fn deviation_and_correlation(values: &[f32]) -> (f32, f32) {
    let square = values.iter().map(|v| v * v).sum::<f32>() / values.len() as f32;
    let product = values.windows(2).map(|pair| pair[0] * pair[1]).sum::<f32>() / values.len() as f32;
    (square.sqrt(), product / square)
}

#[test]
fn lasting_noise_is_as_strong_as_white_noise() {
    let (white, none) = deviation_and_correlation(&actions(still(), 0.2, 0.0));
    let (lasting, share) = deviation_and_correlation(&actions(still(), 0.2, 0.9));

    assert!((white - 0.2).abs() < 0.01 && none.abs() < 0.03, "{white} {none}");
    assert!((lasting - 0.2).abs() < 0.02 && (share - 0.9).abs() < 0.02, "{lasting} {share}");
}

#[test]
fn random_actions_last_as_long_as_the_noise_would() {
    let held = |correlation| {
        let actions = actions(None, 0.2, correlation);
        let changes = actions.windows(2).filter(|pair| pair[0] != pair[1]).count();
        actions.len() as f32 / changes as f32
    };

    assert!((held(0.0) - 1.0).abs() < 0.01, "{}", held(0.0));
    assert!((held(0.95) - 20.0).abs() < 2.0, "{}", held(0.95));
}

/// Ends its first episode by a fall after two steps, and every later one by the clock.
struct Falls {
    episodes: u32,
    steps: u32,
}

impl Env for Falls {
    fn observation_len(&self) -> usize {
        1
    }

    fn action_len(&self) -> usize {
        2
    }

    fn reset(&mut self, _seed: u64, observation: &mut [f32]) {
        self.episodes += 1;
        self.steps = 0;
        observation.fill(0.0);
    }

    fn step(&mut self, _action: &[f32], observation: &mut [f32]) -> Step {
        self.steps += 1;
        observation.fill(self.steps as f32);
        let over = self.steps == 2;
        let fell = over && self.episodes == 1;
        Step { reward: 0.0, terminated: fell, truncated: over && !fell, forward_speed_m_s: 0.0 }
    }
}

/// What the learner sees of an episode's end: the flag, and the state that it ended in.
#[test]
fn a_gathered_time_limit_keeps_its_value_and_a_gathered_fall_does_not() {
    let make_env = || -> Box<dyn Env> { Box::new(Falls { episodes: 0, steps: 0 }) };
    let mut collector = Collector::new(&make_env, LAYOUT, 4, 1);

    let rows = collector
        .gather(Order { round: 0, env_steps: 6, policy: None, noise: 0.2, correlation: 0.0 })
        .unwrap();

    let column = |at: usize| -> Vec<f32> { rows.chunks(LAYOUT.row_len()).map(|row| row[at]).collect() };
    assert_eq!(column(LAYOUT.continuation()), [1.0, 0.0, 1.0, 1.0, 1.0, 1.0]);
    assert_eq!(column(LAYOUT.next_observation()), [1.0, 2.0, 1.0, 2.0, 1.0, 2.0]);
    assert_eq!(column(0), [0.0, 1.0, 0.0, 1.0, 0.0, 1.0]);
}

#[test]
fn environments_do_not_share_their_noise() {
    let make_env = || -> Box<dyn Env> { Box::new(Void) };
    for policy in [None, still()] {
        let mut collector = Collector::new(&make_env, LAYOUT, 4, 3);
        let rows = collector
            .gather(Order { round: 0, env_steps: 3, policy, noise: 0.2, correlation: 0.95 })
            .unwrap();

        let first: Vec<_> = rows.chunks(LAYOUT.row_len()).map(|row| row[LAYOUT.action()]).collect();

        assert!(first[0] != first[1] && first[1] != first[2], "{first:?}");
    }
}
