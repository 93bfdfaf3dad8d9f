//! The claims of the paper's section 3, tested on the conditions of a study.
//!
//! Holds what each claim means in numbers. A claim of order ("lower than both")
//! holds if the means are in that order; its evidence says by how much, and
//! whether the intervals overlap. There is no verdict where a condition that it
//! needs was not run. Does not depend on where trials were walked.

mod amplifications;
mod best;
mod same_speed;

use super::comparison::Comparison;
use super::method::Method;
use super::study::{Claim, LegStudy};
use super::summary::{Best, Condition, Mean};
use crate::paper;
use crate::robot::LegScale;

const LONG: LegScale = LegScale::LONG;
const SHORT: LegScale = LegScale::SHORT;
/// From this amplification on, the paper's "mid to high".
const MID: f64 = 1.6;

/// What claims are tested on.
struct Held<'a> {
    conditions: &'a [Condition],
    best: &'a [Best],
    legs: &'a [LegStudy],
}

/// Every claim, in the paper's order.
#[must_use]
pub fn judge(conditions: &[Condition], best: &[Best], legs: &[LegStudy]) -> Vec<Claim> {
    let held = Held { conditions, best, legs };
    vec![
        held.longer_legs_learn_more(),
        held.least_power_at_a_speed(),
        held.cheapest_at(LONG, 2.0, "14 %"),
        held.cheapest_everywhere(LONG),
        held.sinusoid_cheapest_at_low_amplification(),
        held.psto_cheapest_from_mid_amplification(),
        held.saves_at_2_2(),
        held.fastest(LONG, "39 %"),
        held.fastest(SHORT, "18 %"),
        held.fastest_at(LONG, 2.0),
        held.fastest_at(SHORT, 2.4),
        held.legs_equally_fast(),
        held.original_leaves_its_range(),
        held.best_of_table_2(LONG, "15 % lower, 10 % faster"),
        held.best_of_table_2(SHORT, "26 % lower, 30 % faster"),
        held.sinusoid_cheapest_when_slow(),
        held.psto_cheapest_when_fast(),
        held.crossing_earlier_with_short_legs(),
        held.speeds_converge(),
    ]
}

impl Held<'_> {
    fn at(&self, method: Method, leg: LegScale, amplification: f64) -> Option<Mean> {
        let is = |c: &&Condition| {
            c.method == method && c.leg == leg && (c.amplification - amplification).abs() < 1e-9
        };
        self.conditions.iter().filter(|c| c.mostly_counts()).find(is)?.cost_of_transport
    }

    /// Whether a method was walked at half of the paper's amplifications or more: of fewer, the best
    /// is not the method's best.
    fn was_swept(&self, method: Method, leg: LegScale) -> bool {
        let own = self.conditions.iter().filter(|c| c.method == method && c.leg == leg);
        2 * own.filter(|c| c.speed_m_s.is_some()).count() >= paper::AMPLIFICATIONS.len()
    }

    /// Judges PSTO, the last of three costs, against the others.
    fn lowest(&self, text: String, [original, sinusoid, psto]: [Option<Mean>; 3]) -> Claim {
        let (Some(original), Some(sinusoid), Some(psto)) = (original, sinusoid, psto) else {
            return not_judged(text);
        };
        let evidence = format!(
            "PSTO {}: {}, {}",
            psto.text(3),
            against(psto, "original", original),
            against(psto, "sinusoid", sinusoid)
        );
        Claim { text, holds: Some(psto.mean < original.mean && psto.mean < sinusoid.mean), evidence }
    }
}

fn not_judged(text: String) -> Claim {
    Claim { text, holds: None, evidence: "what it needs was not run, or too little of it".into() }
}

/// How far a value lies from a rival's, and whether that is more than chance.
fn against(own: Mean, name: &str, rival: Mean) -> String {
    let comparison = Comparison::of(own, rival);
    let way = if comparison.is_lower() { "less" } else { "more" };
    let touching = match comparison.is_apart() {
        None => " (from one trial: no interval)",
        Some(true) => "",
        Some(false) => " (their intervals overlap)",
    };
    format!("{:.0} % {way} than {name}'s {}{touching}", comparison.percent(), rival.text(3))
}

fn listed(amplifications: &[f64]) -> String {
    amplifications.iter().map(|a| format!("{a:?}x")).collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests;
