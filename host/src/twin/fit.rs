//! Looks for the robot that would have done what was measured.
//!
//! Owns the search: CMA-ES over the chosen parameters, scaled to 0..1, several
//! times over, since the score has more than one valley. The same seed gives the same robot on any
//! number of cores: a set's score depends on the set alone.

use super::files::{Gait, Tables, Trials};
use super::parameters::{Parameter, record};
use super::plan::{Budget, From, Leg};
use super::predict::{Prediction, TRIAL_S, mean_step_rad, predict};
use super::score::{line_to, mean_relative_error};
use super::{TwinError, power};
use crate::robot::Robot;
use cmaes::{CMAESOptions, DVector};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use std::sync::Mutex;

/// Fewer conditions than this say too little about so many parameters.
const LEAST_CONDITIONS: usize = 3;
/// Random sets begin in this middle part of each range.
const MIDDLE: (f64, f64) = (0.2, 0.8);
/// Sets that score within this share of the best are about as good.
const ABOUT_AS_GOOD: f64 = 0.1;
/// A search needs a few generations.
const LEAST_EVALUATIONS: u64 = 20;
/// A robot that fell, or did not walk, is out.
const OUT: f64 = 10.0;

/// How far a search has come.
#[derive(Debug)]
pub struct Progress<'a> {
    /// Sets tried.
    pub evaluations: u64,
    /// The best score so far.
    pub score: f64,
    /// The robot that has it.
    pub best: &'a Robot,
}

/// What a search found.
#[derive(Debug, Clone, PartialEq)]
pub struct Fit {
    /// The description, with its record.
    pub robot: Robot,
    /// Whether it was told to stop.
    pub stopped: bool,
}

/// One table with what was measured of it.
struct Case {
    angles_rad: Vec<[f64; 8]>,
    measured: [f64; 3],
    duration_s: f64,
}

/// Searches until the budget is spent or `progress` says to stop by `false`.
///
/// The score is the mean of the mean absolute relative errors of speed, power
/// and cost of transport over `trials`, and nothing else.
///
/// # Errors
/// [`TwinError`] for trials without tables, too few of them, or no budget.
pub fn fit(
    start: &Robot,
    tables: &Tables,
    trials: &Trials,
    parameters: &[Parameter],
    budget: &Budget,
    progress: &mut dyn FnMut(&Progress<'_>) -> bool,
) -> Result<Fit, TwinError> {
    let cases = cases(start, tables, trials)?;
    if cases.len() < LEAST_CONDITIONS {
        return Err(TwinError::TooFew { conditions: cases.len(), needed: LEAST_CONDITIONS });
    }
    if budget.evaluations < LEAST_EVALUATIONS || parameters.is_empty() {
        return Err(TwinError::Budget {
            parameters: parameters.len(),
            evaluations: budget.evaluations,
            least: LEAST_EVALUATIONS,
        });
    }
    let tried: Mutex<Vec<(Vec<f64>, f64)>> = Mutex::new(Vec::new());
    let objective = |shares: &DVector<f64>| -> f64 {
        let values = values_at(parameters, shares);
        let score = judge(&with(start, parameters, &values), &cases, trials.weight_n).0;
        if let Ok(mut tried) = tried.lock() {
            tried.push((values, score));
        }
        score
    };
    let mut best = Best { score: f64::INFINITY, robot: start.clone(), shares: Vec::new() };
    let mut evaluations = 0;
    let mut stopped = false;
    for leg in budget.legs() {
        let mut search = CMAESOptions::new(first_shares(&leg, start, parameters, &best), leg.step)
            .seed(leg.seed)
            .max_function_evals(usize::try_from(leg.until.saturating_sub(evaluations)).unwrap_or(usize::MAX))
            .build(&objective)
            .map_err(|_| TwinError::Budget {
                parameters: parameters.len(),
                evaluations: budget.evaluations,
                least: LEAST_EVALUATIONS,
            })?;
        let before = evaluations;
        loop {
            let ended = search.next_parallel().is_some();
            evaluations = before + search.function_evals() as u64;
            if let Some(individual) = search.overall_best_individual()
                && individual.value < best.score
            {
                let values = values_at(parameters, &individual.point);
                let (score, mut robot) = judge(&with(start, parameters, &values), &cases, trials.weight_n);
                record(&mut robot).score = score;
                best = Best { score, robot, shares: individual.point.iter().copied().collect() };
            }
            stopped = !progress(&Progress { evaluations, score: best.score, best: &best.robot });
            if ended || stopped {
                break;
            }
        }
        if stopped || evaluations >= budget.evaluations {
            break;
        }
    }
    let tried = tried.into_inner().unwrap_or_default();
    let Best { score, mut robot, .. } = best;
    let names: Vec<_> = parameters.iter().map(|parameter| parameter.name).collect();
    let mut methods: Vec<String> = trials.measured.keys().map(|gait| gait.method.clone()).collect();
    methods.dedup();
    let lines = lines(&robot, &cases);
    let of_fit = record(&mut robot);
    (of_fit.free_power, of_fit.baseline_power) = lines;
    (of_fit.methods, of_fit.seed, of_fit.evaluations, of_fit.score) =
        (methods, budget.seed, evaluations, score);
    of_fit.spread = spread(&names, &tried, score);
    robot.check()?;
    Ok(Fit { robot, stopped })
}

/// The best set so far.
struct Best {
    score: f64,
    robot: Robot,
    shares: Vec<f64>,
}

fn values_at(parameters: &[Parameter], shares: &DVector<f64>) -> Vec<f64> {
    parameters.iter().zip(shares.iter()).map(|(parameter, share)| parameter.value_at(*share)).collect()
}

fn first_shares(leg: &Leg, start: &Robot, parameters: &[Parameter], best: &Best) -> Vec<f64> {
    let mut random = ChaCha8Rng::seed_from_u64(leg.seed);
    let shares = |of: &mut dyn FnMut(&Parameter) -> f64| parameters.iter().map(of).collect();
    match leg.from {
        From::Best if !best.shares.is_empty() => best.shares.clone(),
        From::Robot => shares(&mut |parameter| parameter.share_of(start)),
        From::Random => shares(&mut |_| random.random_range(MIDDLE.0..=MIDDLE.1)),
        From::DataSheets | From::Best => shares(&mut |parameter| parameter.first_share()),
    }
}

fn cases(robot: &Robot, tables: &Tables, trials: &Trials) -> Result<Vec<Case>, TwinError> {
    let case = |(gait, measured): (&Gait, &super::Measured)| {
        Ok(Case {
            angles_rad: tables.angles_rad(gait, robot)?,
            measured: measured.mean(),
            duration_s: measured.duration_s.unwrap_or(TRIAL_S),
        })
    };
    trials.measured.iter().map(case).collect()
}

fn with(start: &Robot, parameters: &[Parameter], values: &[f64]) -> Robot {
    let mut robot = start.clone();
    for (parameter, value) in parameters.iter().zip(values) {
        parameter.put(&mut robot, *value);
    }
    robot
}

fn play(robot: &Robot, cases: &[Case]) -> Vec<Prediction> {
    let sample_s = sample_s(robot);
    cases.par_iter().map(|case| predict(robot, sample_s, &case.angles_rad, case.duration_s)).collect()
}

fn sample_s(robot: &Robot) -> f64 {
    robot.twin.as_ref().map_or(f64::INFINITY, |twin| twin.sample_s)
}

/// The score of a robot, and the robot with the power model that suits it best.
fn judge(robot: &Robot, cases: &[Case], weight_n: f64) -> (f64, Robot) {
    let mut robot = robot.clone();
    record(&mut robot);
    let predictions = play(&robot, cases);
    let measured = |k: usize| -> Vec<f64> { cases.iter().map(|case| case.measured[k]).collect() };
    robot.power = power::best(&robot.power, &predictions, &measured(1));
    if predictions.iter().any(|prediction| prediction.fell || prediction.speed_m_s < 1e-3) {
        return (OUT, robot);
    }
    let speeds: Vec<f64> = predictions.iter().map(|prediction| prediction.speed_m_s).collect();
    let powers: Vec<f64> = predictions.iter().map(|prediction| power::of(&robot.power, prediction)).collect();
    let costs: Vec<f64> = powers.iter().zip(&speeds).map(|(p, v)| p / (weight_n * v)).collect();
    let errors = [speeds, powers, costs];
    let score =
        errors.iter().enumerate().map(|(k, e)| mean_relative_error(e, &measured(k))).sum::<f64>() / 3.0;
    (if score.is_finite() { score } else { OUT }, robot)
}

/// The free power model, and the one without physics.
fn lines(robot: &Robot, cases: &[Case]) -> (crate::robot::PowerLine, crate::robot::PowerLine) {
    let measured_w: Vec<f64> = cases.iter().map(|case| case.measured[1]).collect();
    let work: Vec<f64> = play(robot, cases).iter().map(|prediction| prediction.mechanical_w).collect();
    let steps: Vec<f64> = cases.iter().map(|case| mean_step_rad(&case.angles_rad)).collect();
    (line_to(&work, &measured_w), line_to(&steps, &measured_w))
}

/// Standard deviation of each parameter over the sets that are about as good.
fn spread(names: &[&str], tried: &[(Vec<f64>, f64)], best: f64) -> std::collections::BTreeMap<String, f64> {
    let mut good: Vec<&Vec<f64>> = tried
        .iter()
        .filter(|(_, score)| *score <= best * (1.0 + ABOUT_AS_GOOD))
        .map(|(values, _)| values)
        .collect();
    // Threads note their sets in any order, and sums of floats depend on it.
    good.sort_by(|a, b| a.partial_cmp(b).unwrap_or(std::cmp::Ordering::Equal));
    let count = good.len().max(1) as f64;
    let deviation = |k: usize| {
        let mean = good.iter().map(|values| values[k]).sum::<f64>() / count;
        (good.iter().map(|values| (values[k] - mean).powi(2)).sum::<f64>() / count).sqrt()
    };
    names.iter().enumerate().map(|(k, name)| ((*name).to_owned(), deviation(k))).collect()
}
