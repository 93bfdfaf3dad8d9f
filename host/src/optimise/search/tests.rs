//! The search's order, budget and determinism, on walks of half a second.

use super::*;
use crate::optimise::basis::Basis;
use crate::optimise::score::Aim;
use crate::optimise::space::Bounds;

fn found(budget: u64, start: &Start, stop_after: u64) -> Found {
    let robot = Robot::ant(1.0).expect("1.0 is a leg scale");
    let basis = Basis::new().expect("the algebra holds");
    let bounds = Bounds::of(&robot);
    let space = |waves| Space::new(basis.clone(), bounds, waves);
    let test = Test { aim: Aim::Cost { at_least_m_s: 0.2 }, duration_s: 0.5 };
    let tolerances = Tolerances::default();
    let search = Search { robot: &robot, space: &space, test, tolerances, seed: 5, budget };
    search.run(start, &mut |progress| progress.trials < stop_after)
}

#[test]
fn one_core_finds_what_two_find() {
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| found(400, &Start::Sinusoid, u64::MAX))
    };

    assert_eq!(with(1), with(2));
}

#[test]
fn a_search_that_is_told_to_stop_has_the_best_so_far() {
    for after in [1, 100, 250] {
        let found = found(400, &Start::Nothing, after);

        assert!(found.stopped && found.trials < 400 + JUDGES * 3, "{after}: {}", found.trials);
        assert!(found.motion.curves_deg.iter().flatten().any(|c| *c != 0.0), "{after}: it stands");
    }
}

#[test]
fn a_budget_is_kept_to_a_generation_and_the_judges() {
    let found = found(600, &Start::Sinusoid, u64::MAX);

    assert!((500..900).contains(&found.trials), "{}", found.trials);
}

/// In half a second a robot walks no stride, but better gaits must score better.
#[test]
fn more_trials_find_a_better_gait() {
    let robot = Robot::ant(1.0).expect("1.0 is a leg scale");
    let test = Test { aim: Aim::Cost { at_least_m_s: 0.2 }, duration_s: 0.5 };
    let judges: Vec<Draw> = (0..8).map(|k| Tolerances::default().draw(&robot, 77, k)).collect();
    let score = |budget: u64| test.score(&judges, &found(budget, &Start::Nothing, u64::MAX).motion);

    let (few, many) = (score(50), score(2000));

    assert!(many < 0.8 * few, "{few} with few trials, {many} with many");
}
