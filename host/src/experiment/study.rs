//! The whole result of a study: what figures, report and JSON are made of.
//!
//! Holds data only. Does not depend on how it is computed or shown.

use super::energy_balance::EnergyBalance;
use super::materials::{GaitNote, LearnedStride};
use super::summary::{Best, Condition};
use super::trial::Trial;
use crate::learn::curves::RunCurves;
use crate::robot::LegScale;
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

/// One of the paper's claims, tested on the conditions of a study.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Claim {
    /// What the paper says, in section 3.
    pub text: String,
    /// The verdict; `None` if the conditions that it needs were not run.
    pub holds: Option<bool>,
    /// The numbers behind it.
    pub evidence: String,
}

/// One pair of legs.
#[derive(Debug, Clone, PartialEq)]
pub struct LegStudy {
    /// Shins, in units of 23 cm.
    pub leg: LegScale,
    /// The gaits that were compared.
    pub gaits: Vec<GaitNote>,
    /// How PSTO's policy learned: Figure 3.
    pub learning: Option<RunCurves>,
    /// What it learned: Figure 4.
    pub stride: Option<LearnedStride>,
}

/// A parameter that the study was made with, for the report.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Parameter {
    /// What it is.
    pub name: String,
    /// Its value, with the unit.
    pub value: String,
}

/// A whole study.
#[derive(Debug, Clone, PartialEq)]
pub struct Study {
    /// Name of the robot, whose description may differ in its legs.
    pub robot: String,
    /// Where trials were walked.
    pub venue: Venue,
    /// Both pairs of legs, or one.
    pub legs: Vec<LegStudy>,
    /// Every condition of the plan.
    pub conditions: Vec<Condition>,
    /// As in Table 2.
    pub best: Vec<Best>,
    /// Where the energy of each method goes, in simulation; empty for a real robot.
    pub energy: Vec<EnergyBalance>,
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
    /// Training, recording and searching, in seconds; 0 where the gaits were there.
    pub prepare_wall_s: f64,
    /// Trials and figures, in seconds.
    pub wall_s: f64,
}

impl Study {
    /// Whether the robot is the paper's.
    #[must_use]
    pub fn is_ants(&self) -> bool {
        self.robot == "Ant"
    }
}
