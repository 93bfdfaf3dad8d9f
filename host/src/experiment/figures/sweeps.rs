//! Figures 6 to 8: cost and speed over amplification, cost over speed.
//!
//! Holds their panels, one for each pair of legs that walked, and their axes.
//! Does not depend on how points are chosen: [`points`](super::points) has the data.

use super::points::{Quantity, Series, series};
use super::{WIDTH_PX, leg_text};
use crate::experiment::method::Method;
use crate::experiment::study::Study;
use crate::experiment::summary::Mean;
use crate::plot::{Axis, Colour, Entry, Figure, Layer, Mark, Note, Panel, Side};
use crate::robot::LegScale;

const BLACK: Colour = Colour(0, 0, 0);
const GREY: Colour = Colour(110, 110, 110);
const PANEL_PX: (u32, u32) = (WIDTH_PX, 330);
/// Pieces that a trend is drawn in.
const TREND_STEPS: usize = 60;
/// Between methods at the same amplification, so that their intervals do not hide each other.
const ASIDE: f64 = 0.016;
/// Of the range of the means, both ways: an interval that reaches further is cut.
const REACH: f64 = 0.6;

/// A figure, and whether an interval had to be cut in it.
pub struct Sweep {
    /// The picture.
    pub figure: Figure,
    /// Wider intervals than the panel.
    pub cut: bool,
}

/// A number of the paper.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Printed {
    /// Of which method.
    pub method: Method,
    /// In the units of the axes.
    pub at: (f64, f64),
}

/// What the paper prints as numbers; the rest of its points stand only in its figures.
#[must_use]
pub fn printed(leg: LegScale, x: Quantity, y: Quantity) -> Vec<Printed> {
    let long = leg == LegScale::LONG;
    let one = |at| vec![Printed { method: Method::Psto, at }];
    let psto = Method::Psto.table_2(leg);
    match (x, y, psto) {
        (Quantity::Speed, Quantity::Cost, _) => {
            let of = |method: Method| method.table_2(leg).map(|(cost, speed_m_s)| (method, cost, speed_m_s));
            let all = Method::PAPERS.into_iter().filter_map(of);
            all.map(|(method, cost, speed_m_s)| Printed { method, at: (speed_m_s, cost) }).collect()
        }
        // Section 3 says where these two lie, and where the short legs were fastest.
        (Quantity::Amplification, Quantity::Cost, Some((cost, _))) if long => one((2.0, cost)),
        (Quantity::Amplification, Quantity::Speed, Some((_, speed_m_s))) => {
            one((if long { 2.0 } else { 2.4 }, speed_m_s))
        }
        _ => vec![],
    }
}

/// The picture; `None` where nothing walked.
pub fn figure(study: &Study, title: &str, x: Quantity, y: Quantity) -> Option<Sweep> {
    let mut legs: Vec<LegScale> = Vec::new();
    for leg in study.conditions.iter().map(|condition| condition.leg) {
        if !legs.contains(&leg) {
            legs.push(leg);
        }
    }
    legs.sort_by(|a, b| b.cmp(a));
    let found = legs.into_iter().map(|leg| (leg, series(&study.conditions, leg, x, y)));
    let all: Vec<(LegScale, Vec<Series>)> = found.filter(|(_, series)| !series.is_empty()).collect();
    if all.is_empty() {
        return None;
    }
    let across = x_axis(&all, x, y);
    let mut cut = false;
    let panels: Vec<Panel> = all
        .iter()
        .map(|(leg, series)| {
            let printed = printed(*leg, x, y);
            let down = y_axis(series, &printed, y);
            let panel = panel(leg_text(&study.robot, *leg), series, &printed, &across, down, x);
            cut |= reaches_out(&panel);
            panel
        })
        .collect();
    let legend = legend(&all, x, y);
    Some(Sweep {
        figure: Figure { title: title.into(), legend, columns: 1, panel_px: PANEL_PX, panels },
        cut,
    })
}

fn x_axis(all: &[(LegScale, Vec<Series>)], x: Quantity, y: Quantity) -> Axis {
    let ours = || all.iter().flat_map(|(_, series)| series).flat_map(|series| &series.points);
    let mut shown: Vec<f64> = ours().map(|point| point.x.mean).collect();
    shown.extend(all.iter().flat_map(|(leg, _)| printed(*leg, x, y)).map(|printed| printed.at.0));
    let (least, most) = ends(&shown);
    if x == Quantity::Amplification {
        // Room for the points that stand aside.
        return Axis::exact(x.label(), [least - 0.1, most + 0.1], 9);
    }
    let reach = 0.5 * REACH * (most - least);
    shown.extend(ours().flat_map(|point| {
        let half = point.x.ci95.unwrap_or(0.0);
        [(point.x.mean - half).max(least - reach), (point.x.mean + half).min(most + reach)]
    }));
    Axis::round(x.label(), shown, 9)
}

fn ends(values: &[f64]) -> (f64, f64) {
    let least = values.iter().copied().fold(f64::INFINITY, f64::min);
    (least, values.iter().copied().fold(f64::NEG_INFINITY, f64::max))
}

fn y_axis(series: &[Series], printed: &[Printed], y: Quantity) -> Axis {
    let points = || series.iter().flat_map(|series| &series.points);
    let mut shown: Vec<f64> = points().map(|point| point.y.mean).collect();
    shown.extend(printed.iter().map(|printed| printed.at.1));
    let trends = series.iter().filter_map(|series| series.trend);
    shown.extend(trends.flat_map(|trend| trend.drawn(TREND_STEPS)).map(|(_, height)| height));
    let (least, most) = ends(&shown);
    let reach = REACH * (most - least).max(0.1 * most.abs());
    for Mean { mean, ci95 } in points().map(|point| point.y) {
        let half = ci95.unwrap_or(0.0);
        shown.extend([(mean - half).max(least - reach), (mean + half).min(most + reach)]);
    }
    Axis::round(y.label(), shown, 7)
}

/// Whether an interval ends outside.
fn reaches_out(panel: &Panel) -> bool {
    let out = |value: f64, axis: &Axis| value < axis.least || value > axis.most;
    let whiskers = panel.layers.iter().filter(|layer| layer.mark == Mark::Whiskers);
    whiskers.flat_map(|layer| &layer.points).any(|&(x, y)| out(x, &panel.x) || out(y, &panel.y))
}

fn panel(
    title: String,
    series: &[Series],
    printed: &[Printed],
    across: &Axis,
    down: Axis,
    x: Quantity,
) -> Panel {
    let mut layers = Vec::new();
    for series in series {
        if let Some(trend) = series.trend {
            let points = trend.drawn(TREND_STEPS);
            layers.push(Layer { mark: Mark::Line, colour: series.method.spec().colour, points });
        }
    }
    let mut dots = Vec::new();
    let middle = (series.len() as f64 - 1.0) / 2.0;
    for (index, series) in series.iter().enumerate() {
        let colour = series.method.spec().colour;
        let aside = match x {
            Quantity::Amplification => ASIDE * (index as f64 - middle),
            Quantity::Speed | Quantity::Cost => 0.0,
        };
        let mut whiskers = Vec::new();
        for point in &series.points {
            let at = (point.x.mean + aside, point.y.mean);
            if let Some(half) = point.y.ci95 {
                whiskers.extend([(at.0, at.1 - half), (at.0, at.1 + half)]);
            }
            if let Some(half) = point.x.ci95 {
                whiskers.extend([(at.0 - half, at.1), (at.0 + half, at.1)]);
            }
        }
        layers.push(Layer { mark: Mark::Whiskers, colour: pale(colour), points: whiskers });
        let points = series.points.iter().map(|point| (point.x.mean + aside, point.y.mean)).collect();
        dots.push(Layer { mark: Mark::Points, colour, points });
    }
    layers.append(&mut dots);
    let points = printed.iter().map(|printed| printed.at).collect();
    layers.push(Layer { mark: Mark::Diamonds, colour: BLACK, points });
    let notes = printed.iter().map(|printed| {
        let far = printed.at.0 > across.least + 0.8 * (across.most - across.least);
        let side = if far { Side::Left } else { Side::Right };
        Note { at: printed.at, side, text: printed.method.label().into() }
    });
    Panel { title, x: across.clone(), y: down, top: None, notes: notes.collect(), layers }
}

/// Intervals stand behind their means.
fn pale(Colour(red, green, blue): Colour) -> Colour {
    let half = |part: u8| part / 2 + 127;
    Colour(half(red), half(green), half(blue))
}

fn legend(all: &[(LegScale, Vec<Series>)], x: Quantity, y: Quantity) -> Vec<Entry> {
    let shown = |method: &Method| all.iter().any(|(_, series)| series.iter().any(|s| s.method == *method));
    let mut entries: Vec<Entry> = Method::all()
        .filter(shown)
        .map(|method| {
            let colour = method.spec().colour;
            Entry { label: method.label().into(), marks: vec![(Mark::Line, colour), (Mark::Points, colour)] }
        })
        .collect();
    entries.push(Entry { label: "95 % interval".into(), marks: vec![(Mark::Whiskers, GREY)] });
    if all.iter().any(|(leg, _)| !printed(*leg, x, y).is_empty()) {
        let label = "measured by the authors".into();
        entries.push(Entry { label, marks: vec![(Mark::Diamonds, BLACK)] });
    }
    entries
}
