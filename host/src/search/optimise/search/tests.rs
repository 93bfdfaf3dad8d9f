//! Order, budget and determinism of a search, on walks of half a second.

use super::*;
use crate::gait::gait_file::GaitFile;
use crate::robot::LegScale;
use crate::search::optimise::basis::Basis;
use crate::search::optimise::score::{Aim, Counted};
use crate::search::optimise::space::Bounds;
use std::path::Path;

const TEST: Test = Test { aim: Aim::Cost { at_least_m_s: 0.2 }, counted: Counted::Distance, duration_s: 0.5 };

/// A search of the Ant, handed to `go` with its flag to stop.
fn with_search<T>(budget: u64, stop: &AtomicBool, go: impl FnOnce(&Search<'_>) -> T) -> T {
    let robot = Robot::ant(LegScale::LONG).expect("the Ant");
    let basis = Basis::new().expect("the algebra holds");
    let bounds = Bounds::of(&robot);
    let space = |waves| Space::new(basis.clone(), bounds, waves);
    let tolerances = Tolerances::default();
    go(&Search { robot: &robot, space: &space, test: TEST, tolerances, seed: 5, budget, stop })
}

fn found(budget: u64, start: &Start, stop_after: u64) -> Found {
    let stop = AtomicBool::new(false);
    with_search(budget, &stop, |search| {
        search.run(start, &mut |progress| stop.store(progress.trials >= stop_after, Ordering::Relaxed))
    })
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

        assert!(found.stopped && found.trials < 400, "{after}: {}", found.trials);
        assert!(found.motion.curves_deg.iter().flatten().any(|c| *c != 0.0), "{after}: it stands");
    }
}

#[test]
fn a_search_that_is_told_to_stop_in_its_first_stage_tries_nothing_more() {
    let stop = AtomicBool::new(true);

    let found = with_search(10_000, &stop, |search| search.run(&Start::Sinusoid, &mut |_| ()));

    // What is left are the walks by which one is chosen.
    assert!(
        found.stopped && found.trials <= (CANDIDATES * VALIDATION_ROBOTS_AFTER_STOP) as u64,
        "{}",
        found.trials
    );
}

#[test]
fn a_budget_is_exceeded_by_a_generation_and_the_validation_at_most() {
    for (budget, most) in [(100, 110), (300, 330), (600, 800), (2000, 2200)] {
        let found = found(budget, &Start::Sinusoid, u64::MAX);

        assert!((budget * 9 / 10..=most).contains(&found.trials), "{budget}: {}", found.trials);
    }
}

#[test]
fn no_search_ends_with_a_worse_gait_than_it_started_from() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/gaits/ant-1L/searched.toml");
    let gait = GaitFile::load(Path::new(path)).expect("a gait file");
    // Three waves a stride, of which a search of the least budget can only lose some.
    let began_at = Motion::of(&gait, 1.0);

    let found = found(100, &Start::Gait(Box::new(began_at.clone())), u64::MAX);

    let place = found.pool.motions().position(|motion| {
        let apart = motion.curves_deg.iter().flatten().zip(began_at.curves_deg.iter().flatten());
        apart.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) < 0.01
    });
    assert!(place.is_some(), "the start itself was not validated");
    let best = found.pool.best(&TEST).expect("some were validated");
    assert_eq!(best.motion, &found.motion);
}

#[test]
fn a_search_goes_on_from_the_best_for_its_own_aim_and_never_comes_to_less() {
    let aim = |at_least_m_s: f64| Test { aim: Aim::Cost { at_least_m_s }, ..TEST };
    let stop = AtomicBool::new(false);
    let mut found = found(600, &Start::Sinusoid, u64::MAX);
    let fast = aim(0.4);
    let score = |found: &Found| found.pool.best(&fast).map(|best| best.score).expect("some were validated");
    let (before, validated) = (score(&found), found.pool.motions().count());
    let robot = Robot::ant(LegScale::LONG).expect("1.0 is a leg scale");

    let trials = found.trials;
    let mut steps = Vec::new();
    for number in [0, 1] {
        with_search(400, &stop, |search| {
            let search = Search { robot: &robot, test: fast, stop: &stop, ..*search };
            search.go_on(&mut found, number, &mut |progress| steps.push(progress.trials));
        });
    }

    assert!(score(&found) < before, "{} after {before}", score(&found));
    assert_eq!(found.pool.motions().count(), validated + 2 * WAVES.len() * FINALISTS);
    let spent = found.trials - trials;
    assert!((720..=880).contains(&spent) && steps.len() > 20, "{spent} in {} generations", steps.len());
}

/// In half a second a robot walks no stride, but better gaits must score better.
#[test]
fn more_trials_find_a_better_gait() {
    let robot = Robot::ant(LegScale::LONG).expect("1.0 is a leg scale");
    let robots: Vec<Draw> = (0..8).map(|k| Tolerances::default().draw(&robot, 77, k)).collect();
    let score = |budget: u64| TEST.score(&robots, &found(budget, &Start::Nothing, u64::MAX).motion);

    let (few, many) = (score(50), score(2000));

    assert!(many < 0.8 * few, "{few} with few trials, {many} with many");
}
