//! What `twin validate` and `twin fit` found: the types of their JSON.
//!
//! Holds numbers only, as shares of 1 where nothing else is said. Does not depend
//! on how they are computed or printed.

use super::parameters::Parameter;
use crate::robot::Robot;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// The same number, measured and predicted.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Both {
    /// Mean over the trials.
    pub measured: f64,
    /// By the simulated robot.
    pub predicted: f64,
}

/// One gait at one amplification.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Condition {
    /// Name in the trials: `psto`, `original`.
    pub method: String,
    /// Multiple of the table's stroke at 1.0.
    pub amplification: f64,
    /// Number of measured trials.
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
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Method {
    /// Of speed.
    pub speed_mare: f64,
    /// Of power.
    pub power_mare: f64,
    /// Of the cost of transport.
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
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
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
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Repeatability {
    /// Of speed.
    pub speed: f64,
    /// Of power.
    pub power: f64,
    /// Of cost of transport.
    pub cost_of_transport: f64,
}

/// What half the physics step changes: means over the gaits of `|whole / half - 1|`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct HalfStep {
    /// Of speed.
    pub speed: f64,
    /// Of cost of transport.
    pub cost_of_transport: f64,
}

/// Result of `twin validate`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Report {
    /// How long a row of a table was held.
    pub sample_s: f64,
    /// What the trials' cost of transport was computed with.
    pub weight_n: f64,
    /// One entry a gait and amplification.
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

/// A parameter that was fitted.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Fitted {
    /// In the unit of its field.
    pub value: f64,
    /// Standard deviation over the sets of parameters that score about as well.
    pub spread: Option<f64>,
}

/// Result of `twin fit`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FitReport {
    /// Folder of the fitted robot.
    pub robot: String,
    /// Mean of the mean absolute relative errors of speed, power and cost of transport.
    pub score: f64,
    /// Random seed.
    pub seed: u64,
    /// Sets of parameters that were tried.
    pub evaluations: u64,
    /// By their paths in the description.
    pub parameters: BTreeMap<String, Fitted>,
    /// The fitted robot against the trials that it was fitted to.
    pub validation: Report,
}

impl FitReport {
    /// Reads the result out of the fitted robot; none for a robot without a fit.
    #[must_use]
    pub fn of(robot: &Robot, folder: String, parameters: &[Parameter], validation: Report) -> Option<Self> {
        let record = robot.twin.as_ref()?;
        let fitted = |parameter: &Parameter| {
            let spread = record.spread.get(parameter.name).copied();
            (parameter.name.to_owned(), Fitted { value: parameter.value_of(robot), spread })
        };
        Some(Self {
            robot: folder,
            score: record.score,
            seed: record.seed,
            evaluations: record.evaluations,
            parameters: parameters.iter().map(fitted).collect(),
            validation,
        })
    }
}
