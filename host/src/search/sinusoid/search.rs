//! Bayesian optimisation of a sinusoidal gait.
//!
//! Holds what a search is asked and what it returns, and its budget, in control
//! steps as a learner's is. A large budget is spent on several rounds, each a
//! search of its own, of which the best counts; `state` runs them. Does not
//! depend on flags and files.

mod state;

use super::draw::{Stream, seeds};
use super::task::{GaitScore, Task};
use super::wave::{DIMENSION, Pairs, Sinusoid};
use crate::search::optimise::basis::Basis;
use crate::search::optimise::space::Motion;
use state::SearchState;

/// Episodes of an evaluation. With the presets' 1000 steps each, TD3's budget is 315 evaluations.
pub const STARTS: usize = 8;
/// Control steps of a round: TD3's budget, 42,000 s. Several rounds find better gaits than one longer
/// search, whose surrogate's work grows with the cube of the points.
pub const ROUND_STEPS: u64 = 2_520_000;
/// A Gaussian process over so many numbers needs more points than numbers.
const LEAST_DESIGN: u64 = DIMENSION as u64 + 1;
/// Evaluations of a batch: they take about as much time as the surrogate that suggests them.
const BATCH: usize = 4;
/// Share of the budget for the comparison of the best.
const FINAL_SHARE: f64 = 0.05;
/// Gaits in the comparison of the best.
const FINALISTS: usize = 5;

/// Where a point came from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stage {
    /// The Latin hypercube.
    Design,
    /// The surrogate, among all gaits.
    Everywhere,
    /// The surrogate, near the best.
    Near,
    /// The last comparison.
    Final,
}

impl Stage {
    /// In `evaluations.csv`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Design => "design",
            Self::Everywhere => "everywhere",
            Self::Near => "near",
            Self::Final => "final",
        }
    }
}

/// A gait that was tried.
#[derive(Debug, Clone, PartialEq)]
pub struct Evaluation {
    /// In which round, from 0.
    pub round: u32,
    /// Why it was tried.
    pub stage: Stage,
    /// In the unit cube.
    pub point: Vec<f64>,
    /// Its waves.
    pub gait: Sinusoid,
    /// Over its episodes.
    pub score: GaitScore,
}

/// Progress of a search.
#[derive(Debug)]
pub struct Progress<'a> {
    /// Gaits tried.
    pub evaluations: usize,
    /// Control steps simulated.
    pub steps: u64,
    /// The best gait so far.
    pub best: &'a Evaluation,
}

/// Result of a search.
#[derive(Debug, Clone, PartialEq)]
pub struct Found {
    /// The gait's curves, at the stroke that was tuned.
    pub motion: Motion,
    /// Its waves.
    pub gait: Sinusoid,
    /// On the last comparison's starts; of a search that was stopped, on the search's own.
    pub score: GaitScore,
    /// Everything that was tried, in order.
    pub evaluations: Vec<Evaluation>,
    /// Control steps simulated.
    pub steps: u64,
    /// Whether it was stopped before its end.
    pub stopped: bool,
}

impl Found {
    /// Rounds that were begun.
    #[must_use]
    pub fn rounds(&self) -> u32 {
        self.evaluations.iter().map(|tried| tried.round + 1).max().unwrap_or(0)
    }
}

/// A search, before it runs.
#[derive(Debug, Clone)]
pub struct Search<'a> {
    /// Robot and reward.
    pub task: Task<'a>,
    /// Curves that are like waves.
    pub basis: Basis,
    /// Which legs swing together.
    pub pairs: Pairs,
    /// Random seed.
    pub seed: u64,
    /// Control steps to simulate.
    pub budget: u64,
    /// Control steps that a round has at least, where there are two or more.
    pub round_steps: u64,
}

impl Search<'_> {
    /// Control steps of one evaluation without falls.
    fn evaluation_steps(&self) -> u64 {
        STARTS as u64 * self.task.episode_steps()
    }

    /// Starts that each of the best is compared on.
    fn final_starts(&self) -> u64 {
        let share = FINAL_SHARE * self.budget as f64;
        let each = share / (FINALISTS as f64 * self.task.episode_steps() as f64);
        (each as u64).max(STARTS as u64)
    }

    fn final_steps(&self) -> u64 {
        FINALISTS as u64 * self.final_starts() * self.task.episode_steps()
    }

    /// Searches that the budget is divided among.
    #[must_use]
    pub fn rounds(&self) -> u32 {
        u32::try_from(self.budget / self.round_steps.max(1)).unwrap_or(u32::MAX).max(1)
    }

    /// The first round has the search's own seed, so that a search of one round does not depend on rounds.
    fn round_seed(&self, round: u32) -> u64 {
        let later = seeds(self.seed, Stream::Rounds, round as usize);
        later.last().copied().unwrap_or(self.seed)
    }

    /// The minimum budget: a design, one batch, and the comparison.
    #[must_use]
    pub fn least_budget(&self) -> u64 {
        (LEAST_DESIGN + BATCH as u64 + FINALISTS as u64) * self.evaluation_steps()
    }

    /// Searches; `watch` is called after every batch and returns whether to go on. A budget below
    /// [`Self::least_budget`] is raised to it.
    pub fn run(&self, watch: &mut dyn FnMut(&Progress<'_>) -> bool) -> Found {
        let search = Self { budget: self.budget.max(self.least_budget()), ..self.clone() };
        SearchState::of(&search, watch).run()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::learn::preset::Preset;
    use crate::learn::run_config::RunConfig;
    use crate::robot::{LegScale, Robot};

    /// Short episodes, with a budget of `rounds` of the least.
    fn searched(rounds: u64, goes_on: &mut dyn FnMut(usize) -> bool) -> Found {
        let robot = Robot::ant(LegScale::LONG).expect("a leg scale");
        let mut env = RunConfig::preset(Preset::Walk).expect("it comes with the program").env;
        env.episode_steps = 20;
        let task = Task { robot: &robot, env };
        let basis = Basis::new().expect("sines can be fitted");
        let mut search =
            Search { task, basis, pairs: Pairs::Diagonal, seed: 5, budget: 0, round_steps: u64::MAX };
        search.round_steps = search.least_budget();
        search.budget = rounds * search.round_steps;
        let found = search.run(&mut |progress| goes_on(progress.evaluations));
        assert!(found.steps <= search.budget, "{} of {}", found.steps, search.budget);
        found
    }

    #[test]
    fn a_budget_of_three_rounds_is_three_searches_of_which_the_best_is_taken() {
        let found = searched(3, &mut |_| true);

        let count = |round: u32, stage: Stage| {
            found.evaluations.iter().filter(|tried| (tried.round, tried.stage) == (round, stage)).count()
        };
        assert_eq!(found.rounds(), 3);
        for round in 0..3 {
            assert!(count(round, Stage::Design) as u64 >= LEAST_DESIGN, "{found:#?}");
            assert!(count(round, Stage::Everywhere) >= BATCH, "{found:#?}");
        }
        let designs = |round: u32| found.evaluations.iter().find(|tried| tried.round == round);
        assert_ne!(designs(0).map(|tried| &tried.point), designs(1).map(|tried| &tried.point));
        let finals = found.evaluations.iter().filter(|tried| tried.stage == Stage::Final);
        assert_eq!(finals.clone().count(), FINALISTS);
        let most = finals.map(|tried| tried.score.reward_per_step).fold(f64::MIN, f64::max);
        assert_eq!(found.score.reward_per_step, most);
        // The finalists are the best of all rounds.
        let mut tried: Vec<&Evaluation> = found.evaluations.iter().collect();
        tried.retain(|tried| tried.stage != Stage::Final);
        tried.sort_by(|a, b| b.score.reward_per_step.total_cmp(&a.score.reward_per_step));
        assert!(tried[..FINALISTS].iter().any(|tried| tried.gait == found.gait));
    }

    #[test]
    fn a_search_that_is_stopped_in_its_second_round_keeps_the_best_of_both() {
        let whole = searched(2, &mut |_| true);
        let first = whole.evaluations.iter().filter(|tried| tried.round == 0).count();

        let stopped = searched(2, &mut |evaluations| evaluations <= first);

        assert!(stopped.stopped && stopped.rounds() == 2);
        let most =
            stopped.evaluations.iter().map(|tried| tried.score.reward_per_step).fold(f64::MIN, f64::max);
        assert_eq!(stopped.score.reward_per_step, most);
    }
}
