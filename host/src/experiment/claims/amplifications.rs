//! Claims about costs at the same amplification: Figure 6.

use super::{Held, LONG, MID, SHORT, listed, not_judged};
use crate::experiment::method::Method;
use crate::experiment::study::Claim;
use crate::experiment::summary::{Condition, Mean};
use crate::paper;
use crate::robot::LegScale;

impl Held<'_> {
    pub(super) fn cheapest_at(&self, leg: LegScale, amplification: f64, printed: &str) -> Claim {
        let text = format!(
            "With legs of {leg} and {amplification:?}x, PSTO costs less than both others (by {printed})"
        );
        self.lowest(text, Method::PAPERS.map(|method| self.at(method, leg, amplification)))
    }

    pub(super) fn amplifications(&self, leg: LegScale) -> Vec<f64> {
        let psto = self.conditions.iter().filter(|c| c.method == Method::Psto && c.leg == leg);
        psto.map(|c| c.amplification).collect()
    }

    /// Amplifications at which a method costs less than both others, of those at which all were run.
    pub(super) fn won(
        &self,
        method: Method,
        leg: LegScale,
        among: impl Fn(f64) -> bool,
    ) -> (Vec<f64>, Vec<f64>) {
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

    pub(super) fn won_all(
        &self,
        text: String,
        method: Method,
        leg: LegScale,
        among: impl Fn(f64) -> bool,
    ) -> Claim {
        let papers = paper::AMPLIFICATIONS.into_iter().filter(|&a| among(a)).count();
        let (won, run) = self.won(method, leg, among);
        // One of many would say nothing of all.
        if run.is_empty() || 2 * run.len() < papers {
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

    pub(super) fn cheapest_everywhere(&self, leg: LegScale) -> Claim {
        let text =
            format!("With legs of {leg}, PSTO costs less than both others at every amplification (Figure 6)");
        self.won_all(text, Method::Psto, leg, |_| true)
    }

    pub(super) fn sinusoid_cheapest_at_low_amplification(&self) -> Claim {
        let text = "With short legs the sinusoid costs least at low amplifications (Figure 6)".to_owned();
        self.won_all(text, Method::Sinusoid, SHORT, |a| a < MID - 1e-9)
    }

    pub(super) fn psto_cheapest_from_mid_amplification(&self) -> Claim {
        let text = "With short legs PSTO costs least at mid to high amplifications (Figure 6)".to_owned();
        self.won_all(text, Method::Psto, SHORT, |a| a > MID - 1e-9)
    }

    pub(super) fn saves_at_2_2(&self) -> Claim {
        let text = "At 2.2x PSTO saves energy against the original and the sinusoid (up to 38 % and 26 %)"
            .to_owned();
        let claims = [LONG, SHORT].map(|leg| (leg, Method::PAPERS.map(|method| self.at(method, leg, 2.2))));
        let judged: Vec<(LegScale, Claim)> =
            claims.into_iter().map(|(leg, costs)| (leg, self.lowest(String::new(), costs))).collect();
        let known: Vec<&(LegScale, Claim)> =
            judged.iter().filter(|(_, claim)| claim.holds.is_some()).collect();
        if known.len() < judged.len() {
            return not_judged(text);
        }
        let words: Vec<String> =
            known.iter().map(|(leg, claim)| format!("{leg}: {}", claim.evidence)).collect();
        let holds = known.iter().all(|(_, claim)| claim.holds == Some(true));
        Claim { text, holds: Some(holds), evidence: words.join("; ") }
    }

    pub(super) fn original_leaves_its_range(&self) -> Claim {
        let text = "The original, and not PSTO, leaves the joints' range at high amplifications".to_owned();
        let own = |method: Method| {
            let walked = move |c: &&Condition| c.method == method && c.setpoint_speed_max_rad_s.is_some();
            self.conditions.iter().filter(walked)
        };
        let out = |method: Method| -> Vec<String> {
            let out = own(method).filter(|c| c.not_run.is_some());
            out.map(|c| format!("{:?}x with {}", c.amplification, c.leg)).collect()
        };
        if own(Method::Original).next().is_none() || own(Method::Psto).next().is_none() {
            return not_judged(text);
        }
        let (original, psto) = (out(Method::Original), out(Method::Psto));
        let words = |out: &[String]| if out.is_empty() { "at none".to_owned() } else { out.join(", ") };
        let evidence = format!("beyond it: the original {}; PSTO {}", words(&original), words(&psto));
        // The paper's reason is the original's own variance: PSTO must go further.
        let holds = original.iter().any(|place| !psto.contains(place))
            && psto.iter().all(|place| original.contains(place));
        Claim { text, holds: Some(holds), evidence }
    }
}
