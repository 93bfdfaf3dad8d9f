//! Searches for the robot whose predictions are nearest to the measured trials.
//!
//! Holds the search: the score has several local minima, so local searches from
//! several starts find the best one, and CMA-ES refines it, where the score has
//! kinks without a gradient. The same seed gives the same robot on any number of
//! cores. Does not depend on how a robot is scored.

use super::TwinError;
use super::descent::Descent;
use super::files::{Tables, Trials};
use super::objective::{Objective, Verdict};
use super::parameters::{Parameter, record};
use super::plan::Budget;
use crate::robot::Robot;
use cmaes::{CMAESOptions, DVector};
use rayon::prelude::*;

/// Fewer conditions than this say too little about so many parameters.
const LEAST_CONDITIONS: usize = 3;
/// A search needs a few generations.
const LEAST_EVALUATIONS: u64 = 20;

/// Random sets that are scored between two reports of progress.
const AT_ONCE: usize = 8;

/// Progress of a search.
#[derive(Debug)]
pub struct Progress<'a> {
    /// Sets tried.
    pub evaluations: u64,
    /// The best score so far.
    pub score: f64,
    /// The robot that has it.
    pub best: &'a Robot,
}

/// Result of a search.
#[derive(Debug, Clone, PartialEq)]
pub struct Fit {
    /// The description, with its record.
    pub robot: Robot,
    /// Whether `progress` stopped it.
    pub stopped: bool,
}

/// The best set so far, and the callback that reports it.
struct Search<'a> {
    objective: &'a Objective<'a>,
    shares: Vec<f64>,
    best: Option<Verdict>,
    progress: &'a mut dyn FnMut(&Progress<'_>) -> bool,
    stopped: bool,
}

impl Search<'_> {
    /// Keeps a set if it is better, and reports progress; `false` if stopped.
    fn offer(&mut self, shares: &[f64], verdict: &Verdict) -> bool {
        let best = match self.best.take() {
            Some(best) if best.score <= verdict.score => best,
            _ => {
                self.shares = shares.to_vec();
                verdict.clone()
            }
        };
        let evaluations = self.objective.evaluations();
        let progress = Progress { evaluations, score: best.score, best: &best.robot };
        self.stopped |= !(self.progress)(&progress);
        self.best = Some(best);
        !self.stopped
    }

    /// Starts of the local searches: the given set, then random ones, the best first.
    fn begins(&mut self, budget: &Budget, start: &Robot, parameters: &[Parameter]) -> Vec<Vec<f64>> {
        let mut random: Vec<(f64, Vec<f64>)> = Vec::new();
        for some in budget.random(parameters).chunks(AT_ONCE) {
            let verdicts: Vec<Verdict> = some.par_iter().map(|shares| self.objective.judge(shares)).collect();
            for (shares, verdict) in some.iter().zip(verdicts) {
                self.offer(shares, &verdict);
                random.push((verdict.score, shares.clone()));
            }
            if self.stopped {
                break;
            }
        }
        random.sort_by(|(a, _), (b, _)| a.total_cmp(b));
        let first = budget.first(start, parameters);
        core::iter::once(first).chain(random.into_iter().map(|(_, shares)| shares)).collect()
    }

    fn descend(&mut self, from: &[f64], until: u64) {
        let mut descent = Descent::new(self.objective, from);
        while self.offer(&descent.shares, &descent.verdict)
            && self.objective.evaluations() + descent.cost() <= until
            && descent.step(self.objective)
        {}
        self.offer(&descent.shares, &descent.verdict);
    }

    fn refine(&mut self, budget: &Budget) -> Result<(), TwinError> {
        let left = budget.evaluations.saturating_sub(self.objective.evaluations());
        let objective = |shares: &DVector<f64>| self.objective.judge(shares.as_slice()).score;
        let mut search = CMAESOptions::new(self.shares.clone(), budget.first_step)
            .seed(budget.seed)
            .max_function_evals(usize::try_from(left).unwrap_or(usize::MAX).max(1))
            .build(objective)
            .map_err(|_| no_budget(self.shares.len(), budget))?;
        loop {
            let ended = search.next_parallel().is_some();
            let Some(individual) = search.overall_best_individual().cloned() else { return Ok(()) };
            let better = self.best.as_ref().is_none_or(|best| individual.value < best.score);
            let verdict = match &self.best {
                Some(best) if !better => best.clone(),
                // Judged twice: the optimiser keeps scores only.
                _ => self.objective.judge(individual.point.as_slice()),
            };
            let shares =
                if better { individual.point.iter().copied().collect() } else { self.shares.clone() };
            if !self.offer(&shares, &verdict) || ended {
                return Ok(());
            }
        }
    }
}

fn no_budget(parameters: usize, budget: &Budget) -> TwinError {
    TwinError::Budget { parameters, evaluations: budget.evaluations, least: LEAST_EVALUATIONS }
}

/// Searches until the budget is spent or `progress` returns `false`.
///
/// The score is the mean of the mean absolute relative errors of speed, power
/// and cost of transport over `trials`, and nothing else.
///
/// # Errors
/// [`TwinError`] for trials without tables, too few of them, or an invalid budget.
pub fn fit(
    start: &Robot,
    tables: &Tables,
    trials: &Trials,
    parameters: &[Parameter],
    budget: &Budget,
    progress: &mut dyn FnMut(&Progress<'_>) -> bool,
) -> Result<Fit, TwinError> {
    let objective = Objective::new(start, tables, trials, parameters, budget.seed)?;
    if objective.conditions() < LEAST_CONDITIONS {
        return Err(TwinError::TooFew { conditions: objective.conditions(), needed: LEAST_CONDITIONS });
    }
    parameters.iter().try_for_each(|parameter| parameter.check(start))?;
    if budget.evaluations < LEAST_EVALUATIONS || parameters.is_empty() {
        return Err(no_budget(parameters.len(), budget));
    }
    let mut search =
        Search { objective: &objective, shares: Vec::new(), best: None, progress, stopped: false };
    let begins = search.begins(budget, start, parameters);
    for (from, until) in begins.iter().zip(budget.descents(objective.evaluations(), begins.len())) {
        if !search.stopped {
            search.descend(from, until);
        }
    }
    if !search.stopped && objective.evaluations() < budget.evaluations {
        search.refine(budget)?;
    }
    let Search { best, stopped, .. } = search;
    let Some(Verdict { score, mut robot, .. }) = best else {
        return Err(no_budget(parameters.len(), budget));
    };
    let of_fit = record(&mut robot);
    of_fit.evaluations = objective.evaluations();
    of_fit.spread = objective.spread(score);
    robot.check()?;
    Ok(Fit { robot, stopped })
}
