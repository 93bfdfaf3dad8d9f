//! Figure 5: the power of each method at the same speed, on long legs.
//!
//! The paper's speed is 0.12 m/s; if its three methods do not all walk so slowly,
//! the slowest speed that they share is beside it. No trial has exactly such a
//! speed. Holds the interpolation: a straight line between the two neighbouring
//! amplifications whose speeds are on either side. Nothing is extrapolated: a
//! method that is never so slow or so fast has words in place of a point. Does
//! not depend on the other figures.

use super::points::in_order;
use crate::experiment::at_speed;
use crate::experiment::method::Method;
use crate::experiment::summary::{Condition, Mean};
use crate::paper;
use crate::plot::{Axis, Colour, Entry, Figure, Layer, Mark, Note, Panel, Side};
use crate::robot::LegScale;

/// A method's power at a speed, or why there is none.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PowerAt {
    /// Between two amplifications, or at one that has just that speed.
    Interpolated {
        /// The interval is that of the two powers; the speeds count as exact.
        power_w: Mean,
        /// Between which amplifications.
        between: (f64, f64),
    },
    /// Its slowest walk is faster.
    NeverSoSlow {
        /// The slowest.
        slowest_m_s: f64,
    },
    /// Its fastest walk is slower.
    NeverSoFast {
        /// The fastest.
        fastest_m_s: f64,
    },
}

/// A row of the figure.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Row {
    /// Which method.
    pub method: Method,
    /// Ours.
    pub power: PowerAt,
    /// What the paper prints, at its own speed.
    pub paper_w: Option<f64>,
}

impl Row {
    const fn power_w(&self) -> Option<Mean> {
        match self.power {
            PowerAt::Interpolated { power_w, .. } => Some(power_w),
            PowerAt::NeverSoSlow { .. } | PowerAt::NeverSoFast { .. } => None,
        }
    }
}

/// All methods at one speed.
#[derive(Debug, Clone, PartialEq)]
pub struct AtSpeed {
    /// Which.
    pub speed_m_s: f64,
    /// Every method that walked on long legs.
    pub rows: Vec<Row>,
}

impl AtSpeed {
    fn of(conditions: &[Condition], speed_m_s: f64) -> Self {
        let is_papers = speed_m_s == paper::FIGURE_5_SPEED_M_S;
        let row = |method: Method| {
            let power = power_at(conditions, method, paper::LEGS[0], speed_m_s)?;
            Some(Row { method, power, paper_w: method.figure_5_w().filter(|_| is_papers) })
        };
        Self { speed_m_s, rows: Method::all().filter_map(row).collect() }
    }

    /// How many of some methods have a power there.
    fn known(&self, methods: &[Method]) -> usize {
        self.rows.iter().filter(|row| methods.contains(&row.method) && row.power_w().is_some()).count()
    }
}

/// The paper's speed, if any method walks it, and, unless all three of the paper do, the slowest that they share.
#[must_use]
pub fn at_speeds(conditions: &[Condition]) -> Vec<AtSpeed> {
    let points = Method::PAPERS
        .map(|method| at_speed::points(conditions, method, paper::LEGS[0], at_speed::POWER_W))
        .into_iter()
        .filter(|points| !points.is_empty())
        .collect::<Vec<_>>();
    let papers = AtSpeed::of(conditions, paper::FIGURE_5_SPEED_M_S);
    let shared = (points.len() > 1 && papers.known(&Method::PAPERS) < points.len())
        .then(|| at_speed::common_m_s(&points, 1).first().copied().filter(|speed| speed.is_finite()))
        .flatten()
        .map(|speed_m_s| AtSpeed::of(conditions, speed_m_s));
    let mut speeds = vec![papers];
    speeds.extend(shared);
    speeds.retain(|at| at.rows.iter().any(|row| row.power_w().is_some()));
    speeds
}

/// Power at a speed; `None` of a method that did not walk. Where several pairs of
/// neighbours enclose the speed, that of the least amplification counts.
#[must_use]
pub fn power_at(conditions: &[Condition], method: Method, leg: LegScale, speed_m_s: f64) -> Option<PowerAt> {
    let walked: Vec<(f64, f64, Mean)> = in_order(conditions, method, leg)
        .into_iter()
        .filter_map(|c| Some((c.amplification, c.speed_m_s?.mean, c.power_w?)))
        .collect();
    if let Some(&(amplification, _, power_w)) = walked.iter().find(|(_, speed, _)| *speed == speed_m_s) {
        return Some(PowerAt::Interpolated { power_w, between: (amplification, amplification) });
    }
    let around = walked.windows(2).find(|pair| (pair[0].1 - speed_m_s) * (pair[1].1 - speed_m_s) < 0.0);
    if let Some([(first, slow, a), (second, fast, b)]) = around {
        let share = (speed_m_s - slow) / (fast - slow);
        let mix = |a: f64, b: f64| a + share * (b - a);
        let ci95 = a.ci95.zip(b.ci95).map(|(a, b)| ((1.0 - share) * a).hypot(share * b));
        let power_w = Mean { mean: mix(a.mean, b.mean), ci95 };
        return Some(PowerAt::Interpolated { power_w, between: (*first, *second) });
    }
    let speeds = || walked.iter().map(|&(_, speed, _)| speed);
    let slowest_m_s = speeds().min_by(f64::total_cmp)?;
    let fastest_m_s = speeds().max_by(f64::total_cmp)?;
    Some(if slowest_m_s > speed_m_s {
        PowerAt::NeverSoSlow { slowest_m_s }
    } else {
        PowerAt::NeverSoFast { fastest_m_s }
    })
}

/// In words.
#[must_use]
pub fn said(row: &Row) -> String {
    let ours = match row.power {
        PowerAt::Interpolated { power_w: Mean { mean, ci95: Some(ci95) }, .. } => {
            format!("{mean:.3} \u{b1} {ci95:.3} W")
        }
        PowerAt::Interpolated { power_w: Mean { mean, ci95: None }, .. } => format!("{mean:.3} W"),
        PowerAt::NeverSoSlow { slowest_m_s } => format!("never below {slowest_m_s:.3} m/s"),
        PowerAt::NeverSoFast { fastest_m_s } => format!("never above {fastest_m_s:.3} m/s"),
    };
    row.paper_w.map_or(ours.clone(), |paper_w| format!("{ours} (paper {paper_w:.3} W)"))
}

const BLACK: Colour = Colour(0, 0, 0);
const ROW_PX: u32 = 46;
/// Of the power axis, for the values in words.
const ROOM: f64 = 1.5;

/// The picture; `None` where no method has a power to show.
pub fn figure(robot: &str, speeds: &[AtSpeed]) -> Option<Figure> {
    let most_rows = speeds.iter().map(|at| at.rows.len()).max()?;
    let grey = Colour(110, 110, 110);
    let entry = |label: &str, marks: &[_]| Entry { label: label.into(), marks: marks.to_vec() };
    let mut legend =
        vec![entry("here, with its 95 % interval", &[(Mark::Whiskers, grey), (Mark::Points, grey)])];
    if speeds.iter().flat_map(|at| &at.rows).any(|row| row.paper_w.is_some()) {
        legend.push(entry("measured by the authors", &[(Mark::Diamonds, BLACK)]));
    }
    Some(Figure {
        title: "Power at the same speed".into(),
        legend,
        columns: 1,
        panel_px: (super::WIDTH_PX, 90 + ROW_PX * most_rows as u32),
        panels: speeds.iter().map(|at| panel(robot, at)).collect(),
    })
}

fn panel(robot: &str, at: &AtSpeed) -> Panel {
    let AtSpeed { speed_m_s, rows } = at;
    let count = rows.len();
    // The first row stands at the top.
    let height = |index: usize| (count - index) as f64;
    let mut powers: Vec<f64> = rows.iter().filter_map(|row| row.paper_w).collect();
    powers.extend(rows.iter().filter_map(Row::power_w).flat_map(|Mean { mean, ci95 }| {
        let half = ci95.unwrap_or(0.0);
        [mean - half, mean + half]
    }));
    let exact = Axis::round("", powers, 5);
    let most = exact.most + ROOM * (exact.most - exact.least);
    let x = Axis::round("power from the battery (W)", [exact.least, most], 8);
    let mut layers = Vec::new();
    let mut notes = Vec::new();
    for (index, row) in rows.iter().enumerate() {
        let y = height(index);
        if let Some(paper_w) = row.paper_w {
            layers.push(Layer { mark: Mark::Diamonds, colour: BLACK, points: vec![(paper_w, y)] });
        }
        if let Some(Mean { mean, ci95 }) = row.power_w() {
            let colour = row.method.spec().colour;
            if let Some(half) = ci95 {
                let points = vec![(mean - half, y), (mean + half, y)];
                layers.push(Layer { mark: Mark::Whiskers, colour, points });
            }
            layers.push(Layer { mark: Mark::Points, colour, points: vec![(mean, y)] });
        }
        notes.push(Note { at: (x.most, y), side: Side::Left, text: said(row) });
    }
    let names = rows.iter().rev().map(|row| row.method.label().to_owned());
    let whose = if *speed_m_s == paper::FIGURE_5_SPEED_M_S {
        "the paper's speed"
    } else {
        "the slowest that all three share"
    };
    Panel {
        title: format!(
            "{} at {} m/s, {whose}",
            super::leg_text(robot, paper::LEGS[0]),
            (1000.0 * speed_m_s).round() / 1000.0
        ),
        x,
        y: Axis::named(names),
        top: None,
        layers,
        notes,
    }
}
