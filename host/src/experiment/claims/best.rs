//! Claims about the best of each method, and about learning: Figures 3 and 7, Table 2.

use super::{Held, LONG, SHORT, against, not_judged};
use crate::experiment::method::Method;
use crate::experiment::study::Claim;
use crate::experiment::summary::{Best, Condition, Mean, mean_of};
use crate::paper;
use crate::robot::LegScale;

/// The paper's "later stages": from this share of learning on.
const LATER: (usize, usize) = (4, 5);

impl Held<'_> {
    pub(super) fn best(&self, method: Method, leg: LegScale) -> Option<&Best> {
        self.best.iter().find(|best| best.method == method && best.leg == leg)
    }

    pub(super) fn best_speed(&self, method: Method, leg: LegScale) -> Option<Mean> {
        self.best(method, leg).filter(|_| self.was_swept(method, leg))?.speed_m_s
    }

    pub(super) fn longer_legs_learn_more(&self) -> Claim {
        let late = |leg: LegScale| {
            let learning = self.legs.iter().find(|study| study.leg == leg)?.learning.as_ref()?;
            // A single evaluation is noise.
            let rewards: Vec<f64> = learning
                .seeds
                .iter()
                .filter_map(|seed| {
                    let later = seed.points.iter().skip(seed.points.len() * LATER.0 / LATER.1);
                    mean_of(&later.map(|point| point.reward).collect::<Vec<f64>>())
                })
                .map(|mean| mean.mean)
                .collect();
            mean_of(&rewards)
        };
        let text = "Learning: longer legs reach higher rewards in the later stages (Figure 3)".to_owned();
        let (Some(long), Some(short)) = (late(LONG), late(SHORT)) else { return not_judged(text) };
        let evidence = format!(
            "mean reward of an evaluation in the last fifth of learning, over seeds: {} with long legs, {} with short \
             ones",
            long.text(0),
            short.text(0)
        );
        Claim { text, holds: Some(long.mean > short.mean), evidence }
    }

    pub(super) fn fastest(&self, leg: LegScale, printed: &str) -> Claim {
        let text = format!(
            "With legs of {leg}, PSTO reaches the highest speed of the three ({} m/s, {printed} more)",
            paper::TOP_SPEED_M_S
        );
        let [Some(original), Some(sinusoid), Some(psto)] =
            Method::PAPERS.map(|method| self.best_speed(method, leg))
        else {
            return not_judged(text);
        };
        let evidence = format!(
            "PSTO {} m/s: {}, {}",
            psto.text(3),
            against(psto, "original", original),
            against(psto, "sinusoid", sinusoid)
        );
        Claim { text, holds: Some(psto.mean > original.mean && psto.mean > sinusoid.mean), evidence }
    }

    pub(super) fn fastest_at(&self, leg: LegScale, amplification: f64) -> Claim {
        let text = format!("With legs of {leg}, PSTO is fastest at {amplification:?}x (Figure 7)");
        let found =
            self.best(Method::Psto, leg).and_then(|best| Some((best.speed_amplification?, best.speed_m_s?)));
        // The last amplification that was walked may be the fastest only because it is the last.
        let own = || self.conditions.iter().filter(|c| c.method == Method::Psto && c.leg == leg);
        let beyond = |c: &Condition| c.amplification > amplification + 1e-9;
        let is_last_of_paper = paper::AMPLIFICATIONS.iter().all(|&a| a <= amplification + 1e-9);
        let walked = self.at(Method::Psto, leg, amplification).is_some()
            && own().filter(|c| c.speed_m_s.is_some()).count() > 2
            && (is_last_of_paper || own().any(|c| beyond(c) && c.speed_m_s.is_some()));
        let Some((at, speed)) = found.filter(|_| walked) else { return not_judged(text) };
        let evidence = format!("fastest at {at:?}x with {} m/s", speed.text(3));
        Claim { text, holds: Some((at - amplification).abs() < 1e-9), evidence }
    }

    pub(super) fn legs_equally_fast(&self) -> Claim {
        let text = "PSTO's highest speed is the same with both legs, within 5 %".to_owned();
        let [Some(long), Some(short)] = [LONG, SHORT].map(|leg| self.best_speed(Method::Psto, leg)) else {
            return not_judged(text);
        };
        let evidence = format!("{} and {} m/s", long.text(3), short.text(3));
        Claim { text, holds: Some((long.mean / short.mean - 1.0).abs() <= 0.05), evidence }
    }

    pub(super) fn best_of_table_2(&self, leg: LegScale, printed: &str) -> Claim {
        let text = format!(
            "With legs of {leg}, PSTO's best cost is lower and its best speed higher than both others' ({printed}; \
             Table 2)"
        );
        let costs = Method::PAPERS
            .map(|method| self.best(method, leg).filter(|_| self.was_swept(method, leg))?.cost_of_transport);
        let cost = self.lowest(String::new(), costs);
        let speed = self.fastest(leg, "");
        let (Some(cheaper), Some(faster)) = (cost.holds, speed.holds) else { return not_judged(text) };
        let evidence = format!("cost: {}; speed: {}", cost.evidence, speed.evidence);
        Claim { text, holds: Some(cheaper && faster), evidence }
    }

    pub(super) fn speeds_converge(&self) -> Claim {
        let text = format!(
            "The robot's own limit is about {} m/s: no method goes beyond (Figure 8)",
            paper::TOP_SPEED_M_S
        );
        let best: Vec<(Method, LegScale, Mean)> = self
            .best
            .iter()
            .filter(|best| Method::PAPERS.contains(&best.method) && self.was_swept(best.method, best.leg))
            .filter_map(|best| Some((best.method, best.leg, best.speed_m_s?)))
            .collect();
        if best.len() < Method::PAPERS.len() * paper::LEGS.len() {
            return not_judged(text);
        }
        let words: Vec<String> = best
            .iter()
            .map(|(method, leg, speed)| format!("{} {leg} {:.3}", method.label(), speed.mean))
            .collect();
        let holds = best.iter().all(|(.., speed)| speed.mean <= 1.05 * paper::TOP_SPEED_M_S);
        Claim { text, holds: Some(holds), evidence: format!("highest speeds in m/s: {}", words.join(", ")) }
    }
}
