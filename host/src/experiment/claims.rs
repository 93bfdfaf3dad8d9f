//! The claims of the paper's section 3, held to the conditions at hand.
//!
//! Owns what each claim means in numbers. A claim of order ("lower than both")
//! holds if the means are in that order; by how much, and whether the intervals
//! touch, stands in its evidence beside the paper's number. Refuses a verdict
//! where a condition that it needs was not run.

use super::at_speed::{self, COST, POWER_W};
use super::method::Method;
use super::paper;
use super::study::{Claim, LegStudy};
use super::summary::{Best, Condition, Mean};

const LONG: f64 = paper::LEGS[0];
const SHORT: f64 = paper::LEGS[1];
/// From this amplification on, the paper's "mid to high".
const MID: f64 = 1.6;
/// Speeds at which two methods are compared.
const SPEEDS: usize = 20;

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
        self.conditions.iter().find(is)?.cost_of_transport
    }

    fn best(&self, method: Method, leg: f64) -> Option<&Best> {
        self.best.iter().find(|best| best.method == method && best.leg == leg)
    }

    fn best_speed(&self, method: Method, leg: f64) -> Option<Mean> {
        self.best(method, leg)?.speed_m_s
    }

    fn points(&self, method: Method, leg: f64) -> Vec<(f64, f64)> {
        at_speed::points(self.conditions, method, leg, COST)
    }

    fn longer_legs_learn_more(&self) -> Claim {
        let last = |leg: f64| {
            let learning = self.legs.iter().find(|study| study.leg == leg)?.learning.as_ref()?;
            let rewards: Vec<f64> = learning.seeds.iter().map(|seed| seed.last().reward).collect();
            super::summary::mean_of(&rewards)
        };
        let text = "Learning: longer legs reach higher rewards in the later stages (Figure 3)".to_owned();
        let (Some(long), Some(short)) = (last(LONG), last(SHORT)) else { return not_judged(text) };
        let evidence = format!(
            "reward of the last evaluation {:.0} with long legs, {:.0} with short ones",
            long.mean, short.mean
        );
        Claim { text, holds: Some(long.mean > short.mean), evidence }
    }

    fn least_power_at_a_speed(&self) -> Claim {
        let text = format!(
            "At {} m/s and with long legs, PSTO takes the least power of the three (0.776, 0.802 and 0.837 W, 7 % less; \
             Figure 5)",
            paper::FIGURE_5_SPEED_M_S
        );
        let points = Method::PAPERS.map(|method| at_speed::points(self.conditions, method, LONG, POWER_W));
        // The paper's speed if all walk it, else the nearest that they share.
        let common = at_speed::common_m_s(&points, SPEEDS);
        let Some((&slowest, &fastest)) = common.first().zip(common.last()) else { return not_judged(text) };
        let speed_m_s = paper::FIGURE_5_SPEED_M_S.clamp(slowest, fastest);
        let [Some(original), Some(sinusoid), Some(psto)] =
            points.map(|points| at_speed::at(&points, speed_m_s))
        else {
            return not_judged(text);
        };
        let evidence = format!(
            "at {speed_m_s:.3} m/s{}: PSTO {psto:.3} W, original {original:.3} W, sinusoid {sinusoid:.3} W",
            if speed_m_s > paper::FIGURE_5_SPEED_M_S { ", the slowest that all three walk" } else { "" }
        );
        Claim { text, holds: Some(psto < original && psto < sinusoid), evidence }
    }

    fn cheapest_at(&self, leg: f64, amplification: f64, printed: &str) -> Claim {
        let text = format!(
            "With legs of {leg} L and {amplification:.1}x, PSTO costs less than both others (by {printed})"
        );
        self.lowest(text, Method::PAPERS.map(|method| self.at(method, leg, amplification)))
    }

    /// Judges PSTO, the last of three costs, against the others.
    fn lowest(&self, text: String, [original, sinusoid, psto]: [Option<Mean>; 3]) -> Claim {
        let rivals = [("original", original), ("sinusoid", sinusoid)];
        let known: Vec<(&str, Mean)> =
            rivals.into_iter().filter_map(|(name, mean)| Some((name, mean?))).collect();
        let Some(psto) = psto.filter(|_| !known.is_empty()) else { return not_judged(text) };
        let words: Vec<String> = known.iter().map(|(name, rival)| against(psto, name, *rival)).collect();
        let mut evidence = format!("PSTO {}: {}", shown(psto, 3), words.join(", "));
        if known.len() < rivals.len() {
            evidence += "; the other was not run";
        }
        Claim { text, holds: Some(known.iter().all(|(_, rival)| psto.mean < rival.mean)), evidence }
    }

    fn amplifications(&self, leg: f64) -> Vec<f64> {
        let psto = self.conditions.iter().filter(|c| c.method == Method::Psto && c.leg == leg);
        psto.map(|c| c.amplification).collect()
    }

    /// Amplifications at which a method costs less than both others, of those at which all were run.
    fn won(&self, method: Method, leg: f64, among: impl Fn(f64) -> bool) -> (Vec<f64>, Vec<f64>) {
        let run: Vec<(f64, [Mean; 3])> = self
            .amplifications(leg)
            .into_iter()
            .filter(|&a| among(a))
            .filter_map(|a| {
                let [original, sinusoid, psto] = Method::PAPERS.map(|method| self.at(method, leg, a));
                Some((a, [original?, sinusoid?, psto?]))
            })
            .collect();
        let place = Method::PAPERS.iter().position(|&paper| paper == method).unwrap_or(0);
        let wins = |costs: &[Mean; 3]| {
            costs.iter().enumerate().all(|(k, cost)| k == place || costs[place].mean < cost.mean)
        };
        let won = run.iter().filter(|(_, costs)| wins(costs)).map(|(a, _)| *a).collect();
        (won, run.into_iter().map(|(a, _)| a).collect())
    }

    fn won_all(&self, text: String, method: Method, leg: f64, among: impl Fn(f64) -> bool) -> Claim {
        let (won, run) = self.won(method, leg, among);
        if run.is_empty() {
            return not_judged(text);
        }
        let evidence = format!(
            "{} costs least at {} of the {} amplifications at which all three were run ({})",
            method.label(),
            won.len(),
            run.len(),
            listed(&run)
        );
        Claim { text, holds: Some(won.len() == run.len()), evidence }
    }

    fn cheapest_everywhere(&self, leg: f64) -> Claim {
        let text = format!(
            "With legs of {leg} L, PSTO costs less than both others at every amplification (Figure 6)"
        );
        self.won_all(text, Method::Psto, leg, |_| true)
    }

    fn sinusoid_cheapest_at_low_amplification(&self) -> Claim {
        let text = "With short legs the sinusoid costs least at low amplifications (Figure 6)".to_owned();
        self.won_all(text, Method::Sinusoid, SHORT, |a| a < MID - 1e-9)
    }

    fn psto_cheapest_from_mid_amplification(&self) -> Claim {
        let text = "With short legs PSTO costs least at mid to high amplifications (Figure 6)".to_owned();
        self.won_all(text, Method::Psto, SHORT, |a| a > MID - 1e-9)
    }

    fn saves_at_2_2(&self) -> Claim {
        let text = "At 2.2x PSTO saves energy against the original and the sinusoid (up to 38 % and 26 %)"
            .to_owned();
        let claims = [LONG, SHORT].map(|leg| (leg, Method::PAPERS.map(|method| self.at(method, leg, 2.2))));
        let judged: Vec<(f64, Claim)> =
            claims.into_iter().map(|(leg, costs)| (leg, self.lowest(String::new(), costs))).collect();
        let known: Vec<&(f64, Claim)> = judged.iter().filter(|(_, claim)| claim.holds.is_some()).collect();
        if known.is_empty() {
            return not_judged(text);
        }
        let words: Vec<String> =
            known.iter().map(|(leg, claim)| format!("{leg} L: {}", claim.evidence)).collect();
        let holds = known.iter().all(|(_, claim)| claim.holds == Some(true));
        Claim { text, holds: Some(holds), evidence: words.join("; ") }
    }

    fn fastest(&self, leg: f64, printed: &str) -> Claim {
        let text = format!(
            "With legs of {leg} L, PSTO reaches the highest speed of the three ({} m/s, {printed} more)",
            paper::TOP_SPEED_M_S
        );
        let [Some(original), Some(sinusoid), Some(psto)] =
            Method::PAPERS.map(|method| self.best_speed(method, leg))
        else {
            return not_judged(text);
        };
        let evidence = format!(
            "PSTO {} m/s: {}, {}",
            shown(psto, 3),
            against(psto, "original", original),
            against(psto, "sinusoid", sinusoid)
        );
        Claim { text, holds: Some(psto.mean > original.mean && psto.mean > sinusoid.mean), evidence }
    }

    fn fastest_at(&self, leg: f64, amplification: f64) -> Claim {
        let text = format!("With legs of {leg} L, PSTO is fastest at {amplification:.1}x (Figure 7)");
        let found =
            self.best(Method::Psto, leg).and_then(|best| Some((best.speed_amplification?, best.speed_m_s?)));
        let Some((at, speed)) = found else { return not_judged(text) };
        let evidence = format!("fastest at {at:.1}x with {} m/s", shown(speed, 3));
        Claim { text, holds: Some((at - amplification).abs() < 1e-9), evidence }
    }

    fn legs_equally_fast(&self) -> Claim {
        let text = "PSTO's highest speed is the same with both legs, within 5 %".to_owned();
        let [Some(long), Some(short)] = [LONG, SHORT].map(|leg| self.best_speed(Method::Psto, leg)) else {
            return not_judged(text);
        };
        let evidence = format!("{} and {} m/s", shown(long, 3), shown(short, 3));
        Claim { text, holds: Some((long.mean / short.mean - 1.0).abs() <= 0.05), evidence }
    }

    fn original_leaves_its_range(&self) -> Claim {
        let text =
            "The original leaves the joints' range at high amplifications and cannot be run there".to_owned();
        let own = || {
            self.conditions
                .iter()
                .filter(|c| c.method == Method::Original && c.setpoint_speed_max_rad_s.is_some())
        };
        if own().next().is_none() {
            return not_judged(text);
        }
        let out: Vec<String> = own()
            .filter(|c| c.not_run.is_some())
            .map(|c| format!("{:.1}x with {} L", c.amplification, c.leg))
            .collect();
        let evidence = if out.is_empty() {
            "every amplification of the plan stays within the joints' range".to_owned()
        } else {
            format!("not run: {}", out.join(", "))
        };
        Claim { text, holds: Some(!out.is_empty()), evidence }
    }

    fn best_of_table_2(&self, leg: f64, printed: &str) -> Claim {
        let text = format!(
            "With legs of {leg} L, PSTO's best cost is lower and its best speed higher than both others' ({printed}; \
             Table 2)"
        );
        let costs =
            Method::PAPERS.map(|method| self.best(method, leg).and_then(|best| best.cost_of_transport));
        let cost = self.lowest(String::new(), costs);
        let speed = self.fastest(leg, "");
        let (Some(cheaper), Some(faster)) = (cost.holds, speed.holds) else { return not_judged(text) };
        let evidence = format!("cost: {}; speed: {}", cost.evidence, speed.evidence);
        Claim { text, holds: Some(cheaper && faster), evidence }
    }

    /// At how many of the speeds that both walk, and that are asked for, a method costs less than another.
    fn cheaper_at_speeds(
        &self,
        method: Method,
        rival: Method,
        leg: f64,
        among: impl Fn(f64) -> bool,
    ) -> Option<(usize, usize)> {
        let points = [self.points(method, leg), self.points(rival, leg)];
        let speeds: Vec<f64> =
            at_speed::common_m_s(&points, SPEEDS).into_iter().filter(|&v| among(v)).collect();
        let costs = |points: &[(f64, f64)], v| at_speed::at(points, v).unwrap_or(f64::INFINITY);
        let cheaper = speeds.iter().filter(|&&v| costs(&points[0], v) < costs(&points[1], v)).count();
        (!speeds.is_empty()).then_some((cheaper, speeds.len()))
    }

    fn sinusoid_cheapest_when_slow(&self) -> Claim {
        let text =
            "At low speeds the sinusoid costs less than PSTO at the same speed, with both legs (Figure 8)"
                .to_owned();
        // The slower half of what both walk.
        let slow = |leg: f64| {
            let both = [self.points(Method::Sinusoid, leg), self.points(Method::Psto, leg)];
            let common = at_speed::common_m_s(&both, SPEEDS);
            let middle = common.get(SPEEDS / 2).copied()?;
            self.cheaper_at_speeds(Method::Sinusoid, Method::Psto, leg, |v| v <= middle)
        };
        self.both_legs(text, "the sinusoid is cheaper", slow)
    }

    fn psto_cheapest_when_fast(&self) -> Claim {
        let text = format!(
            "Above {} m/s PSTO costs less than the sinusoid (by 20 %) and the original (by 30 %) at the same speed \
             (Figure 8)",
            paper::FIGURE_5_SPEED_M_S
        );
        let fast = |v: f64| v > paper::FIGURE_5_SPEED_M_S;
        let counts = |leg: f64| {
            let sinusoid = self.cheaper_at_speeds(Method::Psto, Method::Sinusoid, leg, fast)?;
            let original = self.cheaper_at_speeds(Method::Psto, Method::Original, leg, fast)?;
            Some((sinusoid.0 + original.0, sinusoid.1 + original.1))
        };
        self.both_legs(text, "PSTO is cheaper than its rival", counts)
    }

    fn both_legs(&self, text: String, what: &str, counts: impl Fn(f64) -> Option<(usize, usize)>) -> Claim {
        let known: Vec<(f64, (usize, usize))> =
            [LONG, SHORT].into_iter().filter_map(|leg| Some((leg, counts(leg)?))).collect();
        if known.is_empty() {
            return not_judged(text);
        }
        let words: Vec<String> = known
            .iter()
            .map(|(leg, (cheaper, all))| {
                format!("{leg} L: {what} at {cheaper} of {all} speeds that both walk")
            })
            .collect();
        let holds = known.iter().all(|(_, (cheaper, all))| cheaper == all);
        Claim { text, holds: Some(holds), evidence: words.join("; ") }
    }

    fn crossing_earlier_with_short_legs(&self) -> Claim {
        let text =
            "PSTO becomes cheaper than the sinusoid at a lower speed with short legs (Figure 8)".to_owned();
        // The speed from which on PSTO stays cheaper.
        let crossing = |leg: f64| {
            let points = [self.points(Method::Psto, leg), self.points(Method::Sinusoid, leg)];
            let speeds = at_speed::common_m_s(&points, SPEEDS);
            let dearer = |&&v: &&f64| {
                let [psto, sinusoid] = points.each_ref().map(|points| at_speed::at(points, v));
                psto.zip(sinusoid).is_some_and(|(psto, sinusoid)| psto >= sinusoid)
            };
            let last_dearer = speeds.iter().rposition(|v| dearer(&v));
            let from = last_dearer.map_or(0, |k| k + 1);
            (!speeds.is_empty()).then(|| speeds.get(from).copied())
        };
        let (Some(long), Some(short)) = (crossing(LONG), crossing(SHORT)) else { return not_judged(text) };
        let words = |at: Option<f64>| at.map_or("never".to_owned(), |v| format!("from {v:.3} m/s"));
        let holds = match (long, short) {
            (Some(long), Some(short)) => short < long,
            (None, Some(_)) => true,
            (_, None) => false,
        };
        let evidence = format!("cheaper with long legs {}, with short legs {}", words(long), words(short));
        Claim { text, holds: Some(holds), evidence }
    }

    fn speeds_converge(&self) -> Claim {
        let text = format!(
            "The robot's own limit is about {} m/s: no method goes beyond, and most come near it (Figure 8)",
            paper::TOP_SPEED_M_S
        );
        let best: Vec<(Method, f64, Mean)> = self
            .best
            .iter()
            .filter(|best| Method::PAPERS.contains(&best.method))
            .filter_map(|best| Some((best.method, best.leg, best.speed_m_s?)))
            .collect();
        if best.is_empty() {
            return not_judged(text);
        }
        let words: Vec<String> = best
            .iter()
            .map(|(method, leg, speed)| format!("{} {leg} L {:.3}", method.label(), speed.mean))
            .collect();
        let holds = best.iter().all(|(.., speed)| speed.mean <= 1.05 * paper::TOP_SPEED_M_S);
        Claim { text, holds: Some(holds), evidence: format!("highest speeds in m/s: {}", words.join(", ")) }
    }
}

fn not_judged(text: String) -> Claim {
    Claim { text, holds: None, evidence: "a condition that it needs was not run".into() }
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
    let apart = (own.mean - rival.mean).abs() > own.ci95.unwrap_or(0.0) + rival.ci95.unwrap_or(0.0);
    let touching = if apart { "" } else { " (their intervals touch)" };
    format!("{:.0} % {way} than {name}'s {}{touching}", percent.abs(), shown(rival, 3))
}

fn listed(amplifications: &[f64]) -> String {
    amplifications.iter().map(|a| format!("{a:.1}x")).collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests;
