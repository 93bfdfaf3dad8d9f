//! The claims of the paper's section 3, held to the conditions at hand.
//!
//! Owns what each claim means in numbers. A claim of order ("lower than both")
//! holds if the means are in that order; by how much, and whether the intervals
//! touch, stands in its evidence beside the paper's number. Refuses a verdict
//! where a condition that it needs was not run.

mod amplifications;
mod best;
mod same_speed;

use super::method::Method;
use super::paper;
use super::study::{Claim, LegStudy};
use super::summary::{Best, Condition, Mean};

const LONG: f64 = paper::LEGS[0];
const SHORT: f64 = paper::LEGS[1];
/// From this amplification on, the paper's "mid to high".
const MID: f64 = 1.6;

/// The conditions and what was made of them.
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
    fn at(&self, method: Method, leg: f64, amplification: f64) -> Option<Mean> {
        let is = |c: &&Condition| {
            c.method == method && c.leg == leg && (c.amplification - amplification).abs() < 1e-9
        };
        self.conditions.iter().filter(|c| c.mostly_counts()).find(is)?.cost_of_transport
    }

    /// Whether a method was walked at half of the paper's amplifications or more: of fewer, the best
    /// is not the method's best.
    fn was_swept(&self, method: Method, leg: f64) -> bool {
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
            shown(psto, 3),
            against(psto, "original", original),
            against(psto, "sinusoid", sinusoid)
        );
        Claim { text, holds: Some(psto.mean < original.mean && psto.mean < sinusoid.mean), evidence }
    }
}

fn not_judged(text: String) -> Claim {
    Claim { text, holds: None, evidence: "what it needs was not run, or too little of it".into() }
}

fn shown(mean: Mean, digits: usize) -> String {
    match mean.ci95 {
        Some(ci95) => format!("{:.digits$} \u{b1} {ci95:.digits$}", mean.mean),
        None => format!("{:.digits$}", mean.mean),
    }
}

/// How far a value lies from a rival's, and whether that is more than chance.
fn against(own: Mean, name: &str, rival: Mean) -> String {
    let percent = 100.0 * (own.mean / rival.mean - 1.0);
    let way = if percent < 0.0 { "less" } else { "more" };
    let halves = own.ci95.zip(rival.ci95).map(|(own, rival)| own + rival);
    let touching = match halves {
        None => " (from one trial: no interval)",
        Some(halves) if (own.mean - rival.mean).abs() > halves => "",
        Some(_) => " (their intervals touch)",
    };
    format!("{:.0} % {way} than {name}'s {}{touching}", percent.abs(), shown(rival, 3))
}

fn listed(amplifications: &[f64]) -> String {
    amplifications.iter().map(|a| format!("{a:?}x")).collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests;
