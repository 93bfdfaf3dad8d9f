//! What won, by how much, and how sure that is: in sentences, from the numbers.
//!
//! Owns the wording. A difference whose intervals overlap is called that; where
//! PSTO does not beat the sinusoid, the sentence begins with it. Refuses to
//! compare what did not walk.

use crate::experiment::books::{Books, differences};
use crate::experiment::figures::best::mean_text;
use crate::experiment::figures::points::{in_order, same_leg};
use crate::experiment::figures::{leg_text, points};
use crate::experiment::method::Method;
use crate::experiment::paper;
use crate::experiment::study::{Study, Venue};
use crate::experiment::summary::{Best, Mean};

/// What one pair of legs came to.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Verdict {
    /// Which.
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

    fn papers(self, method: Method, leg: f64) -> Option<f64> {
        let (cost, speed_m_s) = paper::table_2(method, leg)?;
        Some(if self == Self::Cost { cost } else { speed_m_s })
    }

    /// Whether the first is better than the second.
    fn is_better(self, first: f64, second: f64) -> bool {
        if self == Self::Cost { first < second } else { first > second }
    }

    fn shown(self, mean: Mean, amplification: f64) -> String {
        let unit = if self == Self::Speed { " m/s" } else { "" };
        format!("{}{unit} at {amplification:?}\u{d7}", mean_text(mean))
    }
}

/// By how much `first` differs from `second`, in percent of the latter, and which way.
fn difference(first: f64, second: f64) -> String {
    let percent = 100.0 * (first - second).abs() / second.abs();
    format!("{percent:.1}\u{a0}% {}", if first < second { "lower" } else { "higher" })
}

/// Whether two intervals lie apart; `None` without intervals.
fn is_sure(first: Mean, second: Mean) -> Option<bool> {
    let (a, b) = first.ci95.zip(second.ci95)?;
    Some((first.mean - second.mean).abs() > a + b)
}

/// Whether chance explains a difference.
#[must_use]
pub fn sure(first: Mean, second: Mean) -> &'static str {
    let Some(sure) = is_sure(first, second) else {
        return "there is no interval for one of them, so chance is not excluded";
    };
    if sure {
        "the 95\u{a0}% intervals do not overlap"
    } else {
        "the 95\u{a0}% intervals overlap, so this may be chance"
    }
}

/// Of a cost of transport: less is not told.
const LEAST_TOLD: f64 = 0.0005;

/// Why PSTO and the sinusoid differ, leg by leg.
#[must_use]
pub fn reasons(books: &[Books]) -> Vec<String> {
    let of = |method: Method, leg: f64| books.iter().find(|books| books.method == method && books.leg == leg);
    let mut legs: Vec<f64> = books.iter().map(|books| books.leg).collect();
    legs.dedup();
    let reason = |leg: f64| {
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
            .filter(|(_, more)| more.abs() >= LEAST_TOLD)
            .map(told)
            .collect();
        Some(format!(
            "With legs of {}, {} pays {:.3} more than {}, each where it is cheapest: {}.",
            leg_text(leg),
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
    let mut legs: Vec<f64> = Vec::new();
    for best in &study.best {
        if !legs.iter().any(|&leg| same_leg(leg, best.leg)) {
            legs.push(best.leg);
        }
    }
    legs.sort_by(|a, b| b.total_cmp(a));
    legs.into_iter().map(|leg| verdict(study, leg)).collect()
}

fn verdict(study: &Study, leg: f64) -> Verdict {
    let of = |figure: Figure| {
        let own = study.best.iter().filter(|best| same_leg(best.leg, leg));
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
            let first = format!("The {} gait has the least cost of transport, {shown}.", winner.label());
            papers.map_or(first.clone(), |papers| format!("{first} {papers}"))
        }
    };
    let mut sentences: Vec<String> = Vec::new();
    sentences.extend(against(Figure::Cost, &costs, Method::Original, leg));
    sentences.extend(runner_up(Figure::Cost, &costs));
    sentences.extend(where_psto_leads(study, leg));
    sentences.extend(speeds.first().map(|&(winner, mean, times)| {
        format!("The {} gait is the fastest, {}.", winner.label(), Figure::Speed.shown(mean, times))
    }));
    sentences.extend(against(Figure::Speed, &speeds, Method::Sinusoid, leg));
    sentences.extend(against(Figure::Speed, &speeds, Method::Original, leg));
    sentences.extend(runner_up(Figure::Speed, &speeds));
    Verdict { leg: leg_text(leg), headline, sentences }
}

/// PSTO and a rival at their best, the paper's difference beside ours.
fn against(figure: Figure, found: &[(Method, Mean, f64)], rival: Method, leg: f64) -> Option<String> {
    let get = |method: Method| found.iter().find(|(other, ..)| *other == method);
    let (&(_, ours, our_times), &(_, theirs, their_times)) = (get(Method::Psto)?, get(rival)?);
    let verb = match (figure.is_better(ours.mean, theirs.mean), is_sure(ours, theirs)) {
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

/// The best and the next, where that is not told already: PSTO beside the sinusoid or the original is.
fn runner_up(figure: Figure, found: &[(Method, Mean, f64)]) -> Option<String> {
    let [(winner, best, _), (next, second, times), ..] = found else { return None };
    let is_told =
        |a: Method, b: Method| a == Method::Psto && matches!(b, Method::Sinusoid | Method::Original);
    if is_told(*winner, *next) || is_told(*next, *winner) {
        return None;
    }
    Some(format!(
        "Next to the {} gait in {} comes the {} gait, {}: that of the best is {}; {}.",
        winner.label(),
        figure.name(),
        next.label(),
        figure.shown(*second, *times),
        difference(best.mean, second.mean),
        sure(*best, *second)
    ))
}

/// At which amplifications PSTO costs less than the sinusoid, and at which not.
fn where_psto_leads(study: &Study, leg: f64) -> Option<String> {
    let sinusoid = in_order(&study.conditions, Method::Sinusoid, leg);
    let mut sides: [Vec<String>; 3] = [vec![], vec![], vec![]];
    for condition in in_order(&study.conditions, Method::Psto, leg) {
        let rival = sinusoid.iter().find(|c| (c.amplification - condition.amplification).abs() < 1e-9);
        let Some((ours, theirs)) =
            condition.cost_of_transport.zip(rival.and_then(|rival| rival.cost_of_transport))
        else {
            continue;
        };
        let apart = is_sure(ours, theirs) == Some(true);
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

/// Where it was walked.
#[must_use]
pub const fn place(venue: Venue) -> &'static str {
    match venue {
        Venue::Twin => "in the twin, a simulation of the authors\u{2019} robot",
        Venue::VirtualRobot => {
            "on the virtual robot: the robot\u{2019}s real firmware in an emulator, in a simulated body"
        }
        Venue::Robot => "on a robot",
    }
}

/// What the numbers are not.
#[must_use]
pub fn caveat(study: &Study) -> Option<String> {
    if study.venue == Venue::Robot {
        return None;
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
    Method::ALL.into_iter().filter(planned).collect()
}

/// Legs that the study planned, the long first.
#[must_use]
pub fn legs(study: &Study) -> Vec<String> {
    let mut all: Vec<f64> = study.conditions.iter().map(|condition| condition.leg).collect();
    all.sort_by(|a, b| b.total_cmp(a));
    all.dedup_by(|a, b| points::same_leg(*a, *b));
    all.into_iter().map(leg_text).collect()
}
