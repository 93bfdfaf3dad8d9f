use super::*;

impl Collector {
    /// A round gathered by one thread.
    fn gather(&self, order: Order) -> Result<Vec<f32>, CollectError> {
        let round = Round::new(order);
        self.help(&round);
        round.rows()
    }
}
use crate::env::Step;
use crate::learn::td3::policy::DenseLayer;

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
    let collector = Collector::new(&make_env, LAYOUT, 4, 2);
    let rows = collector
        .gather(Order { round: 0, before: 0, env_steps: 40_000, policy, noise, correlation })
        .unwrap();
    rows.chunks(LAYOUT.row_len()).take(20_000).map(|row| row[LAYOUT.action()]).collect()
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
    let collector = Collector::new(&make_env, LAYOUT, 4, 1);

    let rows = collector
        .gather(Order { round: 0, before: 0, env_steps: 6, policy: None, noise: 0.2, correlation: 0.0 })
        .unwrap();

    let column = |at: usize| -> Vec<f32> { rows.chunks(LAYOUT.row_len()).map(|row| row[at]).collect() };
    assert_eq!(column(LAYOUT.not_terminal()), [1.0, 0.0, 1.0, 1.0, 1.0, 1.0]);
    assert_eq!(column(LAYOUT.next_observation()), [1.0, 2.0, 1.0, 2.0, 1.0, 2.0]);
    assert_eq!(column(0), [0.0, 1.0, 0.0, 1.0, 0.0, 1.0]);
}

#[test]
fn environments_do_not_share_their_noise() {
    let make_env = || -> Box<dyn Env> { Box::new(Void) };
    for policy in [None, still()] {
        let collector = Collector::new(&make_env, LAYOUT, 4, 3);
        let rows = collector
            .gather(Order { round: 0, before: 0, env_steps: 3, policy, noise: 0.2, correlation: 0.95 })
            .unwrap();

        let first: Vec<_> = rows.chunks(LAYOUT.row_len()).map(|row| row[LAYOUT.action()]).collect();

        assert!(first[0] != first[1] && first[1] != first[2], "{first:?}");
    }
}

/// Counts its steps over all episodes, which never end.
struct Counter(u32);

impl Env for Counter {
    fn observation_len(&self) -> usize {
        1
    }

    fn action_len(&self) -> usize {
        2
    }

    fn reset(&mut self, seed: u64, observation: &mut [f32]) {
        observation.fill((seed % 1000) as f32);
    }

    fn step(&mut self, _action: &[f32], observation: &mut [f32]) -> Step {
        self.0 += 1;
        observation.fill(self.0 as f32);
        let truncated = self.0.is_multiple_of(3);
        Step { reward: 0.0, terminated: false, truncated, forward_speed_m_s: 0.0 }
    }
}

/// Ten steps for eight environments: two have one more, others the next time.
#[test]
fn environments_take_turns_over_the_rounds() {
    let make_env = || -> Box<dyn Env> { Box::new(Counter(0)) };
    let collector = Collector::new(&make_env, LAYOUT, 4, 8);

    let steps: Vec<Vec<f32>> = (0..4)
        .map(|round| {
            let order = Order {
                round,
                before: 10 * round,
                env_steps: 10,
                policy: None,
                noise: 0.2,
                correlation: 0.0,
            };
            let rows = collector.gather(order).unwrap();
            assert_eq!(rows.len(), 10 * LAYOUT.row_len());
            rows.chunks(LAYOUT.row_len()).map(|row| row[LAYOUT.next_observation()]).collect()
        })
        .collect();

    assert_eq!(steps[0], [1.0, 2.0, 1.0, 2.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0]);
    assert_eq!(steps[1], [3.0, 3.0, 2.0, 3.0, 2.0, 3.0, 2.0, 2.0, 2.0, 2.0]);
    let most: f32 = steps.concat().into_iter().fold(0.0, f32::max);
    assert_eq!(most, 5.0, "40 steps are 5 for each");
}

#[test]
fn it_makes_no_difference_who_helps() {
    let make_env = || -> Box<dyn Env> { Box::new(Counter(0)) };
    let gather = |helpers: usize| {
        let collector = Collector::new(&make_env, LAYOUT, 4, 8);
        let rows: Vec<Vec<f32>> = (0..20)
            .map(|round| {
                let round = Round::new(Order {
                    round,
                    before: 100 * round,
                    env_steps: 100,
                    policy: still(),
                    noise: 0.2,
                    correlation: 0.5,
                });
                std::thread::scope(|scope| {
                    for _ in 0..helpers {
                        scope.spawn(|| collector.help(&round));
                    }
                });
                round.rows().unwrap()
            })
            .collect();
        (rows, collector.episodes())
    };

    let alone = gather(1);

    assert_eq!(gather(3), alone);
    // No two environments ever play the same episode.
    let numbers: Vec<u64> = alone.1.iter().map(|episode| episode.number % 8).collect();
    assert_eq!(numbers, [0, 1, 2, 3, 4, 5, 6, 7]);
}
