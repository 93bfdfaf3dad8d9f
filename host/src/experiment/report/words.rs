//! The result in sentences: what is best, by how much, and how certain that is.
//!
//! Holds the wording. A difference whose intervals overlap is called that; where
//! PSTO does not beat the sinusoid, the sentence begins with it. Does not depend
//! on the page, and compares nothing that did not walk. Longer than
//! most files: all sentences of the report in one place.

use crate::experiment::comparison::{Comparison, percent};
use crate::experiment::energy_balance::{EnergyBalance, differences};
use crate::experiment::figures::leg_text;
use crate::experiment::figures::points::in_order;
use crate::experiment::method::Method;
use crate::experiment::study::{Study, Venue};
use crate::experiment::summary::{Best, Mean};
use crate::paper;
use crate::robot::LegScale;

/// The result for one pair of legs.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Verdict {
    /// Its length, in words.
    pub leg: String,
    /// The outcome in one sentence.
    pub headline: String,
    /// What is behind it.
    pub sentences: Vec<String>,
}

/// Which way is better.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Figure {
    Cost,
    Speed,
}

impl Figure {
    const fn name(self) -> &'static str {
        match self {
            Self::Cost => "cost of transport",
            Self::Speed => "speed",
        }
    }

    fn of(self, best: &Best) -> Option<(Mean, f64)> {
        match self {
            Self::Cost => best.cost_of_transport.zip(best.cost_amplification),
            Self::Speed => best.speed_m_s.zip(best.speed_amplification),
        }
    }

    fn papers(self, method: Method, leg: LegScale) -> Option<f64> {
        let (cost, speed_m_s) = method.table_2(leg)?;
        Some(if self == Self::Cost { cost } else { speed_m_s })
    }

    /// Whether the first is better than the second.
    fn is_better(self, first: f64, second: f64) -> bool {
        if self == Self::Cost { first < second } else { first > second }
    }

    fn shown(self, mean: Mean, amplification: f64) -> String {
        let unit = if self == Self::Speed { " m/s" } else { "" };
        format!("{}{unit} at {amplification:?}\u{d7}", mean.text(3))
    }
}

/// By how much `first` differs from `second`, in percent of the latter, and which way.
fn difference(first: f64, second: f64) -> String {
    let way = if first < second { "lower" } else { "higher" };
    format!("{:.1}\u{a0}% {way}", percent(first, second))
}

/// Whether chance explains a difference.
#[must_use]
pub fn sure(first: Mean, second: Mean) -> &'static str {
    match Comparison::of(first, second).is_apart() {
        None => "there is no interval for one of them, so chance is not excluded",
        Some(true) => "the 95\u{a0}% intervals do not overlap",
        Some(false) => "the 95\u{a0}% intervals overlap, so this may be chance",
    }
}

/// Smaller parts of a cost of transport are left out.
const LEAST_SHOWN: f64 = 0.0005;

/// Why PSTO and the sinusoid differ, leg by leg.
#[must_use]
pub fn reasons(robot: &str, balances: &[EnergyBalance]) -> Vec<String> {
    let of = |method: Method, leg: LegScale| balances.iter().find(|of| of.method == method && of.leg == leg);
    let mut legs: Vec<LegScale> = balances.iter().map(|of| of.leg).collect();
    legs.dedup();
    let reason = |leg: LegScale| {
        let (psto, sinusoid) = (of(Method::Psto, leg)?, of(Method::Sinusoid, leg)?);
        let (dearer, cheaper, names) = if psto.total() > sinusoid.total() {
            (psto, sinusoid, ("PSTO", "the sinusoid"))
        } else {
            (sinusoid, psto, ("the sinusoid", "PSTO"))
        };
        let told = |(part, more): (&'static str, f64)| {
            let sign = if more < 0.0 { '\u{2212}' } else { '+' };
            format!("{part} {sign}{:.3}", more.abs())
        };
        let parts: Vec<String> = differences(dearer, cheaper)
            .into_iter()
            .filter(|(_, more)| more.abs() >= LEAST_SHOWN)
            .map(told)
            .collect();
        Some(format!(
            "With legs of {}, {} pays {:.3} more than {}, each where it is cheapest: {}.",
            leg_text(robot, leg),
            names.0,
            dearer.total() - cheaper.total(),
            names.1,
            if parts.is_empty() { "no part stands out".to_owned() } else { parts.join(", ") }
        ))
    };
    legs.into_iter().filter_map(reason).collect()
}

/// Every pair of legs, the long first.
#[must_use]
pub fn verdicts(study: &Study) -> Vec<Verdict> {
    let mut legs: Vec<LegScale> = Vec::new();
    for best in &study.best {
        if !legs.contains(&best.leg) {
            legs.push(best.leg);
        }
    }
    legs.sort_by(|a, b| b.cmp(a));
    legs.into_iter().map(|leg| verdict(study, leg)).collect()
}

fn verdict(study: &Study, leg: LegScale) -> Verdict {
    let of = |figure: Figure| {
        let own = study.best.iter().filter(|best| best.leg == leg);
        let mut found: Vec<(Method, Mean, f64)> =
            own.filter_map(|best| figure.of(best).map(|(mean, times)| (best.method, mean, times))).collect();
        let sign = if figure == Figure::Cost { 1.0 } else { -1.0 };
        found.sort_by(|a, b| (sign * a.1.mean).total_cmp(&(sign * b.1.mean)));
        found
    };
    let (costs, speeds) = (of(Figure::Cost), of(Figure::Speed));
    let headline = match costs.first() {
        None => "No trial on these legs counts: there is nothing to compare.".into(),
        Some(&(winner, mean, times)) => {
            let papers = against(Figure::Cost, &costs, Method::Sinusoid, leg);
            let shown = Figure::Cost.shown(mean, times);
            let first = format!("{} has the lowest cost of transport, {shown}.", capital(winner.spec().gait));
            papers.map_or(first.clone(), |papers| format!("{first} {papers}"))
        }
    };
    let mut sentences: Vec<String> = Vec::new();
    sentences.extend(against(Figure::Cost, &costs, Method::Original, leg));
    sentences.extend(runner_up(Figure::Cost, &costs));
    sentences.extend(where_psto_leads(study, leg));
    sentences.extend(speeds.first().map(|&(winner, mean, times)| {
        format!("{} is the fastest, {}.", capital(winner.spec().gait), Figure::Speed.shown(mean, times))
    }));
    sentences.extend(against(Figure::Speed, &speeds, Method::Sinusoid, leg));
    sentences.extend(against(Figure::Speed, &speeds, Method::Original, leg));
    sentences.extend(runner_up(Figure::Speed, &speeds));
    Verdict { leg: leg_text(&study.robot, leg), headline, sentences }
}

/// PSTO and a rival at their best, the paper's difference beside ours.
fn against(figure: Figure, found: &[(Method, Mean, f64)], rival: Method, leg: LegScale) -> Option<String> {
    let get = |method: Method| found.iter().find(|(other, ..)| *other == method);
    let (&(_, ours, our_times), &(_, theirs, their_times)) = (get(Method::Psto)?, get(rival)?);
    let verb = match (figure.is_better(ours.mean, theirs.mean), Comparison::of(ours, theirs).is_apart()) {
        (true, Some(true)) => "beats",
        (true, _) => "is ahead of",
        (false, _) => "does not beat",
    };
    let papers = figure.papers(Method::Psto, leg).zip(figure.papers(rival, leg));
    let in_paper = papers
        .map_or(String::new(), |(psto, other)| format!(" In the paper it is {}.", difference(psto, other)));
    let (name, rival) = (figure.name(), rival.label());
    Some(format!(
        "PSTO {verb} the {rival} in {name}: {} against {}, {}; {}.{in_paper}",
        figure.shown(ours, our_times),
        figure.shown(theirs, their_times),
        difference(ours.mean, theirs.mean),
        sure(ours, theirs)
    ))
}

/// The best and the second best, unless they are PSTO and the sinusoid or the original: these are compared above.
fn runner_up(figure: Figure, found: &[(Method, Mean, f64)]) -> Option<String> {
    let [(winner, best, _), (next, second, times), ..] = found else { return None };
    let is_compared =
        |a: Method, b: Method| a == Method::Psto && matches!(b, Method::Sinusoid | Method::Original);
    if is_compared(*winner, *next) || is_compared(*next, *winner) {
        return None;
    }
    Some(format!(
        "{} has the second best {}, {}: that of {} is {}; {}.",
        capital(next.spec().gait),
        figure.name(),
        figure.shown(*second, *times),
        winner.spec().gait,
        difference(best.mean, second.mean),
        sure(*best, *second)
    ))
}

/// At which amplifications PSTO costs less than the sinusoid, and at which not.
fn where_psto_leads(study: &Study, leg: LegScale) -> Option<String> {
    let sinusoid = in_order(&study.conditions, Method::Sinusoid, leg);
    let mut sides: [Vec<String>; 3] = [vec![], vec![], vec![]];
    for condition in in_order(&study.conditions, Method::Psto, leg) {
        let rival = sinusoid.iter().find(|c| (c.amplification - condition.amplification).abs() < 1e-9);
        let Some((ours, theirs)) =
            condition.cost_of_transport.zip(rival.and_then(|rival| rival.cost_of_transport))
        else {
            continue;
        };
        let apart = Comparison::of(ours, theirs).is_apart() == Some(true);
        let side = if apart { usize::from(ours.mean > theirs.mean) } else { 2 };
        sides[side].push(format!("{:?}\u{d7}", condition.amplification));
    }
    let said: Vec<String> = ["less", "more", "neither more nor less beyond the intervals"]
        .iter()
        .zip(&sides)
        .filter(|(_, at)| !at.is_empty())
        .map(|(what, at)| format!("{what} at {}", at.join(", ")))
        .collect();
    (!said.is_empty())
        .then(|| format!("At the same amplification PSTO costs, beside the sinusoid, {}.", said.join("; ")))
}

/// With a capital letter.
fn capital(sentence: &str) -> String {
    let mut letters = sentence.chars();
    letters.next().map_or(String::new(), |first| first.to_uppercase().collect::<String>() + letters.as_str())
}

/// Where trials were walked.
#[must_use]
pub fn place(study: &Study) -> String {
    match study.venue {
        Venue::Twin if study.is_ants() => "in the twin, a simulation of the authors\u{2019} robot".into(),
        Venue::Twin => format!("in a simulation of {}", study.robot),
        Venue::VirtualRobot => {
            "on the virtual robot: the robot\u{2019}s real firmware in an emulator, in a simulated body"
                .into()
        }
        Venue::Robot => "on a robot".into(),
    }
}

/// What has to be kept in mind about predictions.
#[must_use]
pub fn caveat(study: &Study) -> Option<String> {
    if study.venue == Venue::Robot {
        return None;
    }
    if !study.is_ants() {
        return Some(format!(
            "These are predictions, not measurements: no robot walked. The simulated body is {} as its \
             description says. An interval tells how much the trials\u{2019} perturbations matter, not how far \
             the simulation is from a robot.",
            study.robot
        ));
    }
    let top = paper::TOP_SPEED_M_S;
    let faster = study.best.iter().filter_map(|best| best.speed_m_s).any(|speed| speed.mean > top);
    let beyond = if faster { " Some gaits here are faster than that: for them it extrapolates." } else { "" };
    Some(format!(
        "These are predictions, not measurements: no robot walked. The simulated body was fitted to walks of \
         the authors\u{2019} robot of up to {top} m/s.{beyond} An interval tells how much the trials\u{2019} \
         perturbations matter, not how far the simulation is from a robot."
    ))
}

/// Amplifications that the study covers.
#[must_use]
pub fn amplifications(study: &Study) -> String {
    let mut all: Vec<f64> = study.conditions.iter().map(|condition| condition.amplification).collect();
    all.sort_by(f64::total_cmp);
    all.dedup_by(|a, b| (*a - *b).abs() < 1e-9);
    match all.as_slice() {
        [] => "no amplification".into(),
        [one] => format!("an amplification of {one:.1}"),
        [first, .., last] => format!("{} amplifications from {first:.1} to {last:.1}", all.len()),
    }
}

/// "a, b and c".
#[must_use]
pub fn listed(items: &[String]) -> String {
    match items {
        [] => "none".into(),
        [one] => one.clone(),
        [first @ .., last] => format!("{} and {last}", first.join(", ")),
    }
}

/// Methods that the study planned, in the order of legends.
#[must_use]
pub fn methods(study: &Study) -> Vec<Method> {
    let planned = |method: &Method| study.conditions.iter().any(|condition| condition.method == *method);
    Method::all().filter(planned).collect()
}

/// Legs that the study planned, the long first.
#[must_use]
pub fn legs(study: &Study) -> Vec<String> {
    let mut all: Vec<LegScale> = study.conditions.iter().map(|condition| condition.leg).collect();
    all.sort_by(|a, b| b.cmp(a));
    all.dedup();
    all.into_iter().map(|leg| leg_text(&study.robot, leg)).collect()
}
