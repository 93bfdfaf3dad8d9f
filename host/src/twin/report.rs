//! What a comparison of twin and robot says: for people, and field by field as JSON.

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
