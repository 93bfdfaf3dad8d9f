//! Claims about methods at the same speed: Figures 5 and 8.

use super::{Held, LONG, SHORT, not_judged};
use crate::experiment::at_speed::{self, COST, POWER_W};
use crate::experiment::method::Method;
use crate::experiment::study::Claim;
use crate::paper;
use crate::robot::LegScale;

/// Speeds at which methods are compared.
const SPEEDS: usize = 20;

impl Held<'_> {
    pub(super) fn points(&self, method: Method, leg: LegScale) -> Vec<(f64, f64)> {
        at_speed::points(self.conditions, method, leg, COST)
    }

    pub(super) fn least_power_at_a_speed(&self) -> Claim {
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
            "at {speed_m_s:.3} m/s: PSTO {psto:.3} W, original {original:.3} W, sinusoid {sinusoid:.3} W"
        );
        // At another speed it is another claim; its numbers are of interest all the same.
        if (speed_m_s - paper::FIGURE_5_SPEED_M_S).abs() > 1e-9 {
            let evidence = format!("not all three walk at that speed; {evidence}");
            return Claim { text, holds: None, evidence };
        }
        Claim { text, holds: Some(psto < original && psto < sinusoid), evidence }
    }

    /// At how many of the speeds that both walk, and that are asked for, a method costs less than another.
    pub(super) fn cheaper_at_speeds(
        &self,
        method: Method,
        rival: Method,
        leg: LegScale,
        among: impl Fn(f64) -> bool,
    ) -> Option<(usize, usize)> {
        let points = [self.points(method, leg), self.points(rival, leg)];
        let speeds: Vec<f64> =
            at_speed::common_m_s(&points, SPEEDS).into_iter().filter(|&v| among(v)).collect();
        let costs = |points: &[(f64, f64)], v| at_speed::at(points, v).unwrap_or(f64::INFINITY);
        let cheaper = speeds.iter().filter(|&&v| costs(&points[0], v) < costs(&points[1], v)).count();
        (!speeds.is_empty()).then_some((cheaper, speeds.len()))
    }

    pub(super) fn sinusoid_cheapest_when_slow(&self) -> Claim {
        let text =
            "At low speeds the sinusoid costs less than the two others at the same speed, with both legs (Figure 8)"
                .to_owned();
        // The slower half of what both walk.
        let slow = |leg: LegScale, rival: Method| {
            let both = [self.points(Method::Sinusoid, leg), self.points(rival, leg)];
            let common = at_speed::common_m_s(&both, SPEEDS);
            let middle = common.get(SPEEDS / 2).copied()?;
            self.cheaper_at_speeds(Method::Sinusoid, rival, leg, |v| v <= middle)
        };
        let counts = |leg: LegScale| {
            let (psto, original) = (slow(leg, Method::Psto)?, slow(leg, Method::Original)?);
            Some((psto.0 + original.0, psto.1 + original.1))
        };
        self.both_legs(text, "the sinusoid is cheaper than its rival", counts)
    }

    pub(super) fn psto_cheapest_when_fast(&self) -> Claim {
        let text = format!(
            "Above {} m/s PSTO costs less than the sinusoid (by 20 %) and the original (by 30 %) at the same speed \
             (Figure 8)",
            paper::FIGURE_5_SPEED_M_S
        );
        let fast = |v: f64| v > paper::FIGURE_5_SPEED_M_S;
        let counts = |leg: LegScale| {
            let sinusoid = self.cheaper_at_speeds(Method::Psto, Method::Sinusoid, leg, fast)?;
            let original = self.cheaper_at_speeds(Method::Psto, Method::Original, leg, fast)?;
            Some((sinusoid.0 + original.0, sinusoid.1 + original.1))
        };
        self.both_legs(text, "PSTO is cheaper than its rival", counts)
    }

    pub(super) fn both_legs(
        &self,
        text: String,
        what: &str,
        counts: impl Fn(LegScale) -> Option<(usize, usize)>,
    ) -> Claim {
        let known: Vec<(LegScale, (usize, usize))> =
            [LONG, SHORT].into_iter().filter_map(|leg| Some((leg, counts(leg)?))).collect();
        if known.len() < paper::LEGS.len() {
            return not_judged(text);
        }
        let words: Vec<String> = known
            .iter()
            .map(|(leg, (cheaper, all))| {
                format!("{leg}: {what} at {cheaper} of {all} such speeds that both walk")
            })
            .collect();
        let holds = known.iter().all(|(_, (cheaper, all))| cheaper == all);
        Claim { text, holds: Some(holds), evidence: words.join("; ") }
    }

    pub(super) fn crossing_earlier_with_short_legs(&self) -> Claim {
        let text =
            "PSTO becomes cheaper than the sinusoid at a lower speed with short legs (Figure 8)".to_owned();
        // The speed from which on PSTO stays cheaper.
        let crossing = |leg: LegScale| {
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
}
