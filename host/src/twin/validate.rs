//! Holds predictions against measurements.
//!
//! Owns the report that people and scripts read; its fields are its JSON.

use super::TwinError;
use super::files::{Gait, Measured, Tables, Trials};
use super::predict::{Prediction, TRIAL_S, mean_step_rad, predict, predict_in};
use super::score::{line_to, mean_relative_error, spearman};
use crate::robot::Robot;
use crate::sim::World;
use rayon::prelude::*;
use serde::Serialize;
use std::collections::BTreeMap;

/// A number of the robot's and of the twin's.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Both {
    /// Mean over the trials.
    pub measured: f64,
    /// By the twin.
    pub predicted: f64,
}

/// One gait.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Condition {
    /// Such as `psto`.
    pub method: String,
    /// Multiple of the stroke.
    pub amplification: f64,
    /// How many were measured.
    pub trials: usize,
    /// How long each was simulated.
    pub duration_s: f64,
    /// Net distance over time.
    pub speed_m_s: Both,
    /// Electrical, the electronics included.
    pub power_w: Both,
    /// With the weight that the trials used.
    pub cost_of_transport: Both,
    /// By the power model without a bound on the efficiency, if the robot has one.
    pub free_power_w: Option<f64>,
    /// By the line over the table's steps.
    pub baseline_power_w: f64,
}

/// Errors of one method: means over amplifications of `|predicted / measured - 1|`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Method {
    /// Of speed.
    pub speed_mare: f64,
    /// Of power.
    pub power_mare: f64,
    /// Of cost of transport.
    pub cot_mare: f64,
    /// Of power by the free model.
    pub free_power_mare: Option<f64>,
    /// Of power by the line over the table's steps.
    pub baseline_power_mare: f64,
    /// Whether the twin was fitted to these trials.
    pub fitted: bool,
    /// Amplification with the highest speed.
    pub fastest_amplification: Both,
    /// Amplification with the lowest cost of transport.
    pub cheapest_amplification: Both,
}

/// Two methods at the same amplification.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Pair {
    /// One.
    pub a: String,
    /// The other.
    pub b: String,
    /// Of both.
    pub amplification: f64,
    /// Whether robot and twin say the same of which is faster.
    pub faster_agrees: bool,
    /// And of which costs less.
    pub cheaper_agrees: bool,
}

/// Standard deviation of a trial about its gait's mean, as a share of it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Repeatability {
    /// Of speed.
    pub speed: f64,
    /// Of power.
    pub power: f64,
    /// Of cost of transport.
    pub cost_of_transport: f64,
}

/// What half the physics step changes: means over the gaits of `|whole / half - 1|`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct HalfStep {
    /// Of speed.
    pub speed: f64,
    /// Of cost of transport.
    pub cost_of_transport: f64,
}

/// How to play the tables.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Options {
    /// How long a sample was held; none is as fitted.
    pub sample_s: Option<f64>,
    /// Whether to play all of them with half the physics step, too.
    pub half_step: bool,
}

/// All of it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Report {
    /// How long a sample was held.
    pub sample_s: f64,
    /// What the trials' cost of transport was computed with.
    pub weight_n: f64,
    /// A gait each.
    pub conditions: Vec<Condition>,
    /// By name.
    pub methods: BTreeMap<String, Method>,
    /// Rank correlation over all conditions; none with fewer than two.
    pub spearman_speed: Option<f64>,
    /// The same of cost of transport.
    pub spearman_cot: Option<f64>,
    /// Every two methods at every amplification that both have.
    pub pairs: Vec<Pair>,
    /// Over all conditions.
    pub baseline_power_mare: f64,
    /// None if no gait was walked twice.
    pub repeatability: Option<Repeatability>,
    /// None unless it was asked for.
    pub half_step: Option<HalfStep>,
}

/// Plays every table that has trials, and compares.
///
/// # Errors
/// [`TwinError::NoTable`] for trials of a gait that has no table,
/// [`TwinError::SampleTime`] if neither robot nor `options` tells the sample time.
pub fn validate(
    robot: &Robot,
    tables: &Tables,
    trials: &Trials,
    options: &Options,
) -> Result<Report, TwinError> {
    let sample_s =
        options.sample_s.or(robot.twin.as_ref().map(|twin| twin.sample_s)).ok_or(TwinError::SampleTime)?;
    let cases: Vec<(&Gait, &Measured, Vec<[f64; 8]>)> = trials
        .measured
        .iter()
        .map(|(gait, measured)| Ok((gait, measured, tables.angles_rad(gait, robot)?)))
        .collect::<Result<_, TwinError>>()?;
    let baseline = robot.twin.as_ref().map_or_else(
        // A robot that was fitted to nothing has the line of these very trials.
        || {
            let steps: Vec<f64> = cases.iter().map(|(.., angles)| mean_step_rad(angles)).collect();
            let powers: Vec<f64> = cases.iter().map(|(_, measured, _)| measured.mean()[1]).collect();
            line_to(&steps, &powers)
        },
        |twin| twin.baseline_power,
    );
    let conditions: Vec<Condition> = cases
        .par_iter()
        .map(|(gait, measured, angles_rad)| {
            let duration_s = measured.duration_s.unwrap_or(TRIAL_S);
            let prediction = predict(robot, sample_s, angles_rad, duration_s);
            let [speed, power, cost] = measured.mean();
            let predicted_cost = cost_of_transport(&prediction, trials);
            Condition {
                method: gait.method.clone(),
                amplification: gait.amplification(),
                trials: measured.trials.len(),
                duration_s,
                speed_m_s: Both { measured: speed, predicted: prediction.speed_m_s },
                power_w: Both { measured: power, predicted: prediction.power_w },
                cost_of_transport: Both { measured: cost, predicted: predicted_cost },
                free_power_w: robot.twin.as_ref().map(|twin| prediction.free_power_w(&twin.free_power)),
                baseline_power_w: baseline.at(mean_step_rad(angles_rad)),
            }
        })
        .collect();
    let fitted = robot.twin.as_ref().map_or(&[][..], |twin| &twin.methods);
    let ranks = |of: fn(&Condition) -> Both| {
        let predicted: Vec<f64> = conditions.iter().map(|condition| of(condition).predicted).collect();
        let measured: Vec<f64> = conditions.iter().map(|condition| of(condition).measured).collect();
        spearman(&predicted, &measured)
    };
    Ok(Report {
        sample_s,
        weight_n: trials.weight_n,
        methods: methods(&conditions, fitted),
        spearman_speed: ranks(|condition| condition.speed_m_s),
        spearman_cot: ranks(|condition| condition.cost_of_transport),
        pairs: pairs(&conditions),
        baseline_power_mare: baseline_error(&conditions.iter().collect::<Vec<_>>()),
        repeatability: repeatability(trials),
        half_step: options.half_step.then(|| half_step(robot, sample_s, trials, &cases, &conditions)),
        conditions,
    })
}

fn cost_of_transport(prediction: &Prediction, trials: &Trials) -> f64 {
    prediction.power_w / (trials.weight_n * prediction.speed_m_s.max(1e-6))
}

fn half_step(
    robot: &Robot,
    sample_s: f64,
    trials: &Trials,
    cases: &[(&Gait, &Measured, Vec<[f64; 8]>)],
    conditions: &[Condition],
) -> HalfStep {
    let finer: Vec<Prediction> = cases
        .par_iter()
        .map(|(_, measured, angles_rad)| {
            let mut world = World::refined(robot, 2);
            predict_in(&mut world, sample_s, angles_rad, measured.duration_s.unwrap_or(TRIAL_S))
        })
        .collect();
    let change = |whole: fn(&Condition) -> Both, half: &dyn Fn(&Prediction) -> f64| {
        let whole: Vec<f64> = conditions.iter().map(|condition| whole(condition).predicted).collect();
        mean_relative_error(&whole, &finer.iter().map(half).collect::<Vec<_>>())
    };
    HalfStep {
        speed: change(|c| c.speed_m_s, &|p| p.speed_m_s),
        cost_of_transport: change(|c| c.cost_of_transport, &|p| cost_of_transport(p, trials)),
    }
}

fn error_of(conditions: &[&Condition], of: fn(&Condition) -> Both) -> f64 {
    let predicted: Vec<f64> = conditions.iter().map(|condition| of(condition).predicted).collect();
    let measured: Vec<f64> = conditions.iter().map(|condition| of(condition).measured).collect();
    mean_relative_error(&predicted, &measured)
}

fn baseline_error(conditions: &[&Condition]) -> f64 {
    error_of(conditions, |c| Both { predicted: c.baseline_power_w, ..c.power_w })
}

fn methods(conditions: &[Condition], fitted: &[String]) -> BTreeMap<String, Method> {
    let mut by_method: BTreeMap<String, Vec<&Condition>> = BTreeMap::new();
    for condition in conditions {
        by_method.entry(condition.method.clone()).or_default().push(condition);
    }
    let best = |of: &[&Condition], value: &dyn Fn(&Condition) -> f64| {
        of.iter().max_by(|a, b| value(a).total_cmp(&value(b))).map_or(0.0, |best| best.amplification)
    };
    by_method
        .into_iter()
        .map(|(name, of)| {
            let free = of.iter().all(|condition| condition.free_power_w.is_some());
            let method = Method {
                speed_mare: error_of(&of, |c| c.speed_m_s),
                power_mare: error_of(&of, |c| c.power_w),
                cot_mare: error_of(&of, |c| c.cost_of_transport),
                free_power_mare: free.then(|| {
                    error_of(&of, |c| Both { predicted: c.free_power_w.unwrap_or(0.0), ..c.power_w })
                }),
                baseline_power_mare: baseline_error(&of),
                fitted: fitted.contains(&name),
                fastest_amplification: Both {
                    measured: best(&of, &|c| c.speed_m_s.measured),
                    predicted: best(&of, &|c| c.speed_m_s.predicted),
                },
                cheapest_amplification: Both {
                    measured: best(&of, &|c| -c.cost_of_transport.measured),
                    predicted: best(&of, &|c| -c.cost_of_transport.predicted),
                },
            };
            (name, method)
        })
        .collect()
}

fn pairs(conditions: &[Condition]) -> Vec<Pair> {
    let mut pairs = Vec::new();
    for (i, a) in conditions.iter().enumerate() {
        for b in &conditions[i + 1..] {
            if a.method == b.method || a.amplification != b.amplification {
                continue;
            }
            let agree = |of: fn(&Condition) -> Both| {
                (of(a).measured > of(b).measured) == (of(a).predicted > of(b).predicted)
            };
            pairs.push(Pair {
                a: a.method.clone(),
                b: b.method.clone(),
                amplification: a.amplification,
                faster_agrees: agree(|c| c.speed_m_s),
                cheaper_agrees: agree(|c| c.cost_of_transport),
            });
        }
    }
    pairs
}

fn repeatability(trials: &Trials) -> Option<Repeatability> {
    let mut squares = [0.0; 3];
    let mut freedom = 0;
    for measured in trials.measured.values().filter(|measured| measured.trials.len() > 1) {
        let mean = measured.mean();
        for trial in &measured.trials {
            for k in 0..3 {
                squares[k] += (trial[k] / mean[k] - 1.0).powi(2);
            }
        }
        freedom += measured.trials.len() - 1;
    }
    let [speed, power, cost_of_transport] = squares.map(|sum| (sum / freedom.max(1) as f64).sqrt());
    (freedom > 0).then_some(Repeatability { speed, power, cost_of_transport })
}
