//! `results.json`, and what `host experiment --json` prints.
//!
//! Holds the fields of the JSON, both ways. Does not depend on how a study is
//! walked.

use super::energy_balance::EnergyBalance;
use super::materials::GaitNote;
use super::study::{Claim, Parameter, Study, Venue};
use super::summary::{Best, Condition};
use crate::robot::LegScale;
use serde::{Deserialize, Serialize};

/// A study for scripts.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct StudySummary {
    /// Folder of the study.
    pub out: String,
    /// Path of the report.
    pub report: String,
    /// Where trials were walked.
    pub on: Venue,
    /// Every condition of the plan.
    pub conditions: Vec<Condition>,
    /// As in Table 2.
    pub best: Vec<Best>,
    /// Where the energy of each method goes; empty for a real robot.
    pub energy: Vec<EnergyBalance>,
    /// Section 3, claim by claim.
    pub claims: Vec<Claim>,
    /// The gaits that were compared.
    pub gaits: Vec<StudyGait>,
    /// Everything that was chosen.
    pub parameters: Vec<Parameter>,
    /// What is missing, and why.
    pub skipped: Vec<String>,
    /// Training and searches, in seconds; 0 where the gaits were there.
    pub prepare_wall_s: f64,
    /// Trials and figures, in seconds.
    pub wall_s: f64,
}

/// A gait and the legs that it was walked on.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct StudyGait {
    /// Shins, in units of 23 cm.
    pub leg: LegScale,
    /// Its origin.
    pub gait: GaitNote,
}

impl StudySummary {
    /// Of a study whose folder and report have these paths.
    #[must_use]
    pub fn of(study: &Study, skipped: Vec<String>, out: String, report: String) -> Self {
        let of_leg = |leg: &super::study::LegStudy| {
            let leg_scale = leg.leg;
            leg.gaits.clone().into_iter().map(move |gait| StudyGait { leg: leg_scale, gait })
        };
        Self {
            out,
            report,
            on: study.venue,
            conditions: study.conditions.clone(),
            best: study.best.clone(),
            energy: study.energy.clone(),
            claims: study.claims.clone(),
            gaits: study.legs.iter().flat_map(of_leg).collect(),
            parameters: study.parameters.clone(),
            skipped,
            prepare_wall_s: study.prepare_wall_s,
            wall_s: study.wall_s,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiment::by_hand;
    use crate::experiment::method::Method;

    #[test]
    fn a_summary_is_read_as_it_was_written() {
        let mut study = by_hand::study(
            &[crate::robot::LegScale::LONG],
            vec![by_hand::condition(Method::Psto, crate::robot::LegScale::LONG, 1.4)],
        );
        study.claims.push(Claim { text: "a".into(), holds: None, evidence: "b".into() });
        study.legs[0].gaits.push(GaitNote {
            method: Method::Psto,
            command: "host fit".into(),
            seed: Some(3),
            simulated_s: None,
            period_s: 1.5,
            gait_sha256: "ab".into(),
            prepare_wall_s: None,
            remark: None,
        });
        let written = StudySummary::of(&study, vec!["c".into()], "out".into(), "out/report.html".into());

        let json = serde_json::to_value(&written).unwrap();

        assert_eq!((&json["on"], &json["gaits"][0]["gait"]["method"]), (&"twin".into(), &"psto".into()));
        assert_eq!(serde_json::from_value::<StudySummary>(json).unwrap(), written);
    }
}
