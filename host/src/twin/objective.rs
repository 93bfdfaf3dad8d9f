//! The score of a set of parameters: how far its predictions are from the trials.
//!
//! Holds the score, and counts and keeps every set that was tried. A set's
//! score depends on the set alone, whichever thread computes it.

use super::files::{Gait, Tables, Trials};
use super::parameters::{Parameter, record};
use super::predict::{Prediction, TRIAL_S, mean_step_rad, predict};
use super::score::line_to;
use super::{Measured, TwinError, power};
use crate::robot::{PowerLine, Robot, TwinRecord};
use protocol::JOINT_COUNT;
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::sync::Mutex;

/// Sets that score within this share of the best are about as good.
const ABOUT_AS_GOOD: f64 = 0.1;
/// The score of a robot that fell, or did not walk: worse than any that did.
const OUT: f64 = 2.0 * MOST_ERROR;
/// An error counts as no more than that many times what was measured, so that
/// a robot that hardly walks has a cost of transport that can be reckoned with.
const MOST_ERROR: f64 = 5.0;

/// One table with what was measured of it.
struct Case {
    angles_rad: Vec<[f64; JOINT_COUNT]>,
    measured: [f64; 3],
    duration_s: f64,
}

/// What a set of parameters comes to.
#[derive(Debug, Clone, PartialEq)]
pub struct Verdict {
    /// Mean of the mean absolute relative errors of speed, power and cost of transport.
    pub score: f64,
    /// Relative errors of each gait's speed, then power, then cost of transport.
    pub errors: Vec<f64>,
    /// The description, with the power model that suits it best.
    pub robot: Robot,
}

/// What a fit makes small.
pub struct Objective<'a> {
    start: &'a Robot,
    parameters: &'a [Parameter],
    cases: Vec<Case>,
    weight_n: f64,
    methods: Vec<String>,
    seed: u64,
    tried: Mutex<Vec<(Vec<f64>, f64)>>,
}

impl<'a> Objective<'a> {
    /// # Errors
    /// [`TwinError::NoTable`] for trials of a gait that has no table.
    pub fn new(
        start: &'a Robot,
        tables: &Tables,
        trials: &Trials,
        parameters: &'a [Parameter],
        seed: u64,
    ) -> Result<Self, TwinError> {
        let case = |(gait, measured): (&Gait, &Measured)| {
            Ok(Case {
                angles_rad: tables.angles_rad(gait, start)?,
                measured: measured.mean(),
                duration_s: measured.duration_s.unwrap_or(TRIAL_S),
            })
        };
        let cases = trials.measured.iter().map(case).collect::<Result<_, TwinError>>()?;
        let mut methods: Vec<String> = trials.measured.keys().map(|gait| gait.method.clone()).collect();
        methods.dedup();
        let weight_n = trials.weight_n;
        Ok(Self { start, parameters, cases, weight_n, methods, seed, tried: Mutex::default() })
    }

    /// Gaits that it looks at.
    pub fn conditions(&self) -> usize {
        self.cases.len()
    }

    /// Sets tried so far.
    pub fn evaluations(&self) -> u64 {
        self.tried.lock().map_or(0, |tried| tried.len() as u64)
    }

    /// Judges a set, each parameter as a share of its range.
    pub fn judge(&self, shares: &[f64]) -> Verdict {
        let values: Vec<f64> =
            self.parameters.iter().zip(shares).map(|(parameter, share)| parameter.value_at(*share)).collect();
        let mut robot = self.start.clone();
        record(&mut robot);
        for (parameter, value) in self.parameters.iter().zip(&values) {
            parameter.put(&mut robot, *value);
        }
        let verdict = self.judge_robot(robot);
        if let Ok(mut tried) = self.tried.lock() {
            tried.push((values, verdict.score));
        }
        verdict
    }

    fn judge_robot(&self, mut robot: Robot) -> Verdict {
        if robot.check().is_err() {
            // A foot larger than a short shin bears, for one.
            return Verdict { score: OUT, errors: vec![MOST_ERROR; 3 * self.cases.len()], robot };
        }
        let predictions = self.play(&robot);
        let measured = |k: usize| -> Vec<f64> { self.cases.iter().map(|case| case.measured[k]).collect() };
        robot.power = power::best(&robot.power, &predictions, &measured(1));
        let speeds: Vec<f64> = predictions.iter().map(|prediction| prediction.speed_m_s.max(1e-6)).collect();
        let powers: Vec<f64> =
            predictions.iter().map(|prediction| power::of(&robot.power, prediction)).collect();
        let costs: Vec<f64> = powers.iter().zip(&speeds).map(|(p, v)| p / (self.weight_n * v)).collect();
        let errors = [speeds, powers, costs].into_iter().enumerate().flat_map(|(k, predicted)| {
            let error_of = |(predicted, measured): (f64, f64)| predicted / measured - 1.0;
            predicted.into_iter().zip(measured(k)).map(error_of).collect::<Vec<f64>>()
        });
        let errors: Vec<f64> =
            errors.map(|e| if e.is_finite() { e.clamp(-1.0, MOST_ERROR) } else { MOST_ERROR }).collect();
        let walks = predictions.iter().all(|prediction| !prediction.fell && prediction.speed_m_s >= 1e-3);
        let score = errors.iter().map(|error| error.abs()).sum::<f64>() / errors.len().max(1) as f64;
        let score = if walks && score.is_finite() { score } else { OUT };
        let work: Vec<f64> = predictions.iter().map(|prediction| prediction.mechanical_w).collect();
        // Nothing of an earlier fit may be taken for this one's.
        *record(&mut robot) = TwinRecord {
            score,
            methods: self.methods.clone(),
            free_power: line_to(&work, &measured(1)),
            baseline_power: self.baseline_power(),
            seed: self.seed,
            evaluations: 0,
            spread: BTreeMap::new(),
            ..record(&mut robot).clone()
        };
        Verdict { score, errors, robot }
    }

    fn play(&self, robot: &Robot) -> Vec<Prediction> {
        let sample_s = robot.twin.as_ref().map_or(f64::INFINITY, |twin| twin.sample_s);
        self.cases
            .par_iter()
            .map(|case| predict(robot, sample_s, &case.angles_rad, case.duration_s))
            .collect()
    }

    /// The line to power over the tables' steps, without physics.
    fn baseline_power(&self) -> PowerLine {
        let measured_w: Vec<f64> = self.cases.iter().map(|case| case.measured[1]).collect();
        let steps: Vec<f64> = self.cases.iter().map(|case| mean_step_rad(&case.angles_rad)).collect();
        line_to(&steps, &measured_w)
    }

    /// Standard deviation of each parameter over the sets that are about as good as `best`.
    pub fn spread(&self, best: f64) -> BTreeMap<String, f64> {
        let Ok(tried) = self.tried.lock() else { return BTreeMap::new() };
        let mut good: Vec<&Vec<f64>> = tried
            .iter()
            .filter(|(_, score)| *score <= best * (1.0 + ABOUT_AS_GOOD))
            .map(|(values, _)| values)
            .collect();
        // Threads note their sets in any order, and sums of floats depend on it.
        good.sort_by(|a, b| a.partial_cmp(b).unwrap_or(std::cmp::Ordering::Equal));
        good.dedup();
        let count = good.len().max(1) as f64;
        let deviation = |k: usize| {
            let mean = good.iter().map(|values| values[k]).sum::<f64>() / count;
            (good.iter().map(|values| (values[k] - mean).powi(2)).sum::<f64>() / count).sqrt()
        };
        self.parameters
            .iter()
            .enumerate()
            .map(|(k, parameter)| (parameter.name.to_owned(), deviation(k)))
            .collect()
    }
}
