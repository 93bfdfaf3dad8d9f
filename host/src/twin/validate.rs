//! Compares predictions with measurements.

use super::TwinError;
use super::files::{Gait, Measured, Tables, Trials};
use super::predict::{Prediction, TRIAL_S, mean_step_rad, predict, predict_in};
use super::report::{Both, Condition, HalfStep, Method, Pair, Repeatability, Report};
use super::score::{line_to, mean_relative_error, spearman};
use crate::robot::Robot;
use crate::sim::World;
use protocol::JOINT_COUNT;
use rayon::prelude::*;
use std::collections::BTreeMap;

/// How to play the tables.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Options {
    /// How long a sample was held; none is as fitted.
    pub sample_s: Option<f64>,
    /// Whether to play all of them with half the physics step, too.
    pub half_step: bool,
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
    let cases: Vec<(&Gait, &Measured, Vec<[f64; JOINT_COUNT]>)> = trials
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
    cases: &[(&Gait, &Measured, Vec<[f64; JOINT_COUNT]>)],
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
