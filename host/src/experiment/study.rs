//! All that a study came to: what figures, report and JSON are made of.
//!
//! Owns the shape alone; nothing here computes.

use super::books::Books;
use super::method::Method;
use super::summary::{Best, Condition};
use super::trial::Trial;
use crate::gait::stride::Sample;
use crate::learn::curves::RunCurves;
use serde::{Deserialize, Serialize};

/// Where trials were walked.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Venue {
    /// The direct simulation.
    Twin,
    /// The real firmware in an emulator, and the twin around it.
    VirtualRobot,
    /// A robot on a port.
    Robot,
}

/// One of the paper's claims, held to the conditions at hand.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Claim {
    /// What the paper says, in section 3.
    pub text: String,
    /// Whether it is so here; `None` if the conditions that it needs were not run.
    pub holds: Option<bool>,
    /// The numbers behind it.
    pub evidence: String,
}

/// A gait that took part.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct GaitNote {
    /// How it came to be.
    pub method: Method,
    /// The command that made it.
    pub command: String,
    /// Its seed.
    pub seed: Option<u64>,
    /// Simulated time that its making took.
    pub simulated_s: Option<f64>,
    /// Duration of a stride.
    pub period_s: f64,
    /// SHA-256 of the table that is played.
    pub gait_sha256: String,
    /// Wall-clock time of its making, if it was made now.
    pub prepare_wall_s: Option<f64>,
    /// What is to be known of it besides.
    pub remark: Option<String>,
}

/// The averaged stride of PSTO's policy: Figure 4.
#[derive(Debug, Clone, PartialEq)]
pub struct LearnedStride {
    /// Duration.
    pub period_s: f64,
    /// Evenly spaced over it, in actions: 1 is 45 degrees at the policy's own stroke.
    pub samples: Vec<Sample>,
    /// Standard deviation over strides and trials, as many.
    pub deviations: Vec<Sample>,
}

/// One pair of legs.
#[derive(Debug, Clone, PartialEq)]
pub struct LegStudy {
    /// Shins, in units of 23 cm.
    pub leg: f64,
    /// The gaits that were compared.
    pub gaits: Vec<GaitNote>,
    /// How PSTO's policy learned: Figure 3.
    pub learning: Option<RunCurves>,
    /// What it learned: Figure 4.
    pub stride: Option<LearnedStride>,
}

/// A parameter that the study was made with, for the report.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Parameter {
    /// What it is.
    pub name: String,
    /// Its value, with the unit.
    pub value: String,
}

/// A whole study.
#[derive(Debug, Clone, PartialEq)]
pub struct Study {
    /// Where trials were walked.
    pub venue: Venue,
    /// Both pairs of legs, or one.
    pub legs: Vec<LegStudy>,
    /// Every condition of the plan.
    pub conditions: Vec<Condition>,
    /// As in Table 2.
    pub best: Vec<Best>,
    /// Where the energy of each goes, in the twin; empty for a real robot.
    pub books: Vec<Books>,
    /// Section 3, claim by claim.
    pub claims: Vec<Claim>,
    /// Every trial.
    pub trials: Vec<Trial>,
    /// Everything that was chosen, seeds among it.
    pub parameters: Vec<Parameter>,
    /// Robots and presets with every number, as files have them.
    pub descriptions: Vec<Parameter>,
    /// What is missing, and why: such as the authors' tables.
    pub skipped: Vec<String>,
    /// Making the gaits: training, recording, searching; 0 where they were there.
    pub prepare_wall_s: f64,
    /// Trials and figures.
    pub wall_s: f64,
}
