//! Evaluation of a policy without noise, on the same episodes every time.
//!
//! Holds the episodes and their mean. Does not depend on how the policy was learned.

use super::MakeEnv;
use super::policy::Policy;
use super::random::{Purpose, episode_seed};

/// Means over the evaluation episodes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Evaluation {
    /// Sum of an episode's rewards.
    pub reward: f64,
    /// Mean speed towards the goal.
    pub speed_m_s: f64,
    /// Control steps of an episode.
    pub steps: f64,
}

#[derive(Debug, Clone, Copy, Default)]
struct Sums {
    reward: f64,
    speed: f64,
    steps: f64,
}

/// Plays `episodes` episodes of that seed and purpose, distributed over the processor's cores; the
/// result does not depend on their number.
pub fn evaluate(
    policy: &Policy,
    make_env: MakeEnv<'_>,
    (seed, purpose): (u64, Purpose),
    episodes: usize,
) -> Evaluation {
    let workers = std::thread::available_parallelism().map_or(1, usize::from).min(episodes).max(1);
    let mut sums = vec![Sums::default(); episodes];
    let share = episodes.div_ceil(workers);
    std::thread::scope(|scope| {
        for (worker, sums) in sums.chunks_mut(share).enumerate() {
            let mut policy = policy.clone();
            scope.spawn(move || {
                let mut env = make_env();
                for (index, sums) in sums.iter_mut().enumerate() {
                    let number = (worker * share + index) as u64;
                    *sums = play(&mut policy, env.as_mut(), episode_seed(seed, purpose, number));
                }
            });
        }
    });
    // Summed in the order of the episodes: floating-point sums depend on it.
    let total = sums.iter().fold(Sums::default(), |total, one| Sums {
        reward: total.reward + one.reward,
        speed: total.speed + one.speed / one.steps,
        steps: total.steps + one.steps,
    });
    let count = episodes as f64;
    Evaluation { reward: total.reward / count, speed_m_s: total.speed / count, steps: total.steps / count }
}

fn play(policy: &mut Policy, env: &mut dyn crate::env::Env, seed: u64) -> Sums {
    let mut observation = vec![0.0; env.observation_len()];
    let mut action = vec![0.0; env.action_len()];
    let mut sums = Sums::default();
    env.reset(seed, &mut observation);
    loop {
        policy.act(&observation, &mut action);
        let outcome = env.step(&action, &mut observation);
        sums.reward += f64::from(outcome.reward);
        sums.speed += f64::from(outcome.forward_speed_m_s);
        sums.steps += 1.0;
        if outcome.terminated || outcome.truncated {
            return sums;
        }
    }
}
