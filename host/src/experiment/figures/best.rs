//! Table 2: the best of each method, with the paper's numbers beside ours.
//!
//! Holds the text of its cells, for the picture and for the report. Does not
//! depend on how the best is found.

use super::leg_text;
use crate::experiment::summary::{Best, Mean};
use crate::plot::Table;
use crate::robot::LegScale;

/// Where there is nothing to say.
pub const NOTHING: &str = "\u{2013}";

/// A row in words.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Row {
    /// Its legs.
    pub leg: String,
    /// Its method.
    pub method: &'static str,
    /// Ours, with interval and amplification.
    pub cost: String,
    /// Theirs.
    pub paper_cost: String,
    /// Ours, with interval and amplification.
    pub speed: String,
    /// Theirs.
    pub paper_speed: String,
    /// Whether it is the first of its legs.
    pub first: bool,
    /// Whether nothing on these legs costs less.
    pub is_least: bool,
    /// Whether nothing on these legs is faster.
    pub is_fastest: bool,
}

/// Long legs first, methods in the order of legends.
#[must_use]
pub fn rows(robot: &str, best: &[Best]) -> Vec<Row> {
    let mut sorted: Vec<&Best> = best.iter().collect();
    sorted.sort_by(|a, b| b.leg.cmp(&a.leg).then(a.method.cmp(&b.method)));
    let winner = |leg: LegScale, of: fn(&Best) -> Option<Mean>, sign: f64| {
        let own = best.iter().filter(|best| best.leg == leg);
        own.filter_map(|best| of(best).map(|mean| (best.method, sign * mean.mean)))
            .min_by(|a, b| a.1.total_cmp(&b.1))
            .map(|(method, _)| method)
    };
    let mut before: Option<LegScale> = None;
    let row = |best: &Best| {
        let first = before.replace(best.leg).is_none_or(|leg| leg != best.leg);
        Row {
            leg: leg_text(robot, best.leg),
            method: best.method.label(),
            cost: reached(best.cost_of_transport, best.cost_amplification),
            paper_cost: number(best.paper_cost_of_transport),
            speed: reached(best.speed_m_s, best.speed_amplification),
            paper_speed: number(best.paper_speed_m_s),
            first,
            is_least: winner(best.leg, |best| best.cost_of_transport, 1.0) == Some(best.method),
            is_fastest: winner(best.leg, |best| best.speed_m_s, -1.0) == Some(best.method),
        }
    };
    sorted.into_iter().map(row).collect()
}

fn reached(mean: Option<Mean>, amplification: Option<f64>) -> String {
    let Some(mean) = mean else { return NOTHING.into() };
    let at = amplification.map_or(String::new(), |times| format!(" at {times:?}\u{d7}"));
    mean.text(3) + &at
}

fn number(value: Option<f64>) -> String {
    value.map_or(NOTHING.into(), |value| format!("{value:.3}"))
}

/// The columns of it.
pub const HEADER: [&str; 6] =
    ["legs", "method", "least cost of transport", "paper\u{2019}s", "highest speed (m/s)", "paper\u{2019}s"];

/// The picture; `None` where nothing walked.
#[must_use]
pub fn table(robot: &str, best: &[Best]) -> Option<Table> {
    let rows = rows(robot, best);
    let any = best.iter().any(|best| best.cost_of_transport.is_some() || best.speed_m_s.is_some());
    any.then(|| Table {
        title: "Best of each method".into(),
        header: HEADER.map(str::to_owned).to_vec(),
        words: 2,
        parts: (0..rows.len()).filter(|&index| index > 0 && rows[index].first).collect(),
        rows: rows
            .into_iter()
            .map(|row| {
                let leg = if row.first { row.leg } else { String::new() };
                vec![leg, row.method.into(), row.cost, row.paper_cost, row.speed, row.paper_speed]
            })
            .collect(),
    })
}
