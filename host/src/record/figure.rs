//! The paper's Figure 4: eight joints, samples, spread and curve.
//!
//! Owns what is in it; how it looks is [`crate::plot`]'s. All panels have the
//! same axes, so that strokes can be compared.

use super::{ACTION_DEG, Recording};
use crate::plot::{Axis, BLUE, Entry, Figure, Layer, Mark, Panel, VERMILION};
use protocol::Joint;

/// Legs as they stand around the body, in the order of their numbers.
const LEGS: [&str; 4] = ["front left", "rear left", "rear right", "front right"];
/// Points that a curve is drawn through.
const CURVE_POINTS: usize = 240;
const PANEL_PX: (u32, u32) = (430, 220);

struct Curves {
    dots: Vec<(f64, f64)>,
    band: Vec<(f64, f64, f64)>,
    curve: Vec<(f64, f64)>,
}

pub fn of(recording: &Recording) -> Figure {
    let curves = Joint::ALL.map(|joint| curves(recording, joint));
    let heights = curves.iter().flat_map(|curves| {
        let edges = curves.band.iter().flat_map(|&(_, low, high)| [low, high]);
        edges.chain(curves.curve.iter().map(|&(_, angle)| angle))
    });
    let y = Axis::degrees("angle (degrees)", heights, 6);
    let x = Axis::exact("time (s)", [0.0, recording.period_s], 8);
    let panel = |leg: usize, joint: Joint| {
        let Curves { dots, band, curve } = &curves[joint.index()];
        let line = |mark, colour, points: &[(f64, f64)]| Layer { mark, colour, points: points.to_vec() };
        let r2 = recording.polynomial_r2[joint.index()];
        let kept = r2.map_or(String::new(), |r2| format!(", R\u{b2} {r2:.3}"));
        Panel {
            title: format!("{} ({}){kept}", joint.name(), LEGS[leg]),
            x: x.clone(),
            y: y.clone(),
            top: None,
            layers: vec![
                Layer::band(BLUE, band.iter().copied()),
                line(Mark::Dots, BLUE, dots),
                line(Mark::Line, VERMILION, curve),
            ],
        }
    };
    let panels = (0..4).flat_map(|leg| [panel(leg, Joint::ALL[leg]), panel(leg, Joint::ALL[leg + 4])]);
    Figure {
        title: title(recording),
        legend: legend(recording),
        columns: 2,
        panel_px: PANEL_PX,
        panels: panels.collect(),
    }
}

fn title(recording: &Recording) -> String {
    let Recording { period_s, strides_averaged, trials, .. } = recording;
    match recording.window_s {
        None => format!("Learned stride of {period_s:.3} s: {strides_averaged} strides of {trials} trials"),
        Some(_) => {
            format!("Learned gait, a window of {period_s:.3} s: {strides_averaged} of {trials} trials")
        }
    }
}

fn legend(recording: &Recording) -> Vec<Entry> {
    let entry = |label: &str, marks: &[_]| Entry { label: label.into(), marks: marks.to_vec() };
    let mut entries = vec![
        entry("mean setpoint", &[(Mark::Dots, BLUE)]),
        entry("\u{b1} 1 standard deviation", &[(Mark::Band, BLUE)]),
    ];
    if recording.fits.is_ok() {
        entries.push(entry("polynomial of degree 10", &[(Mark::Line, VERMILION)]));
    }
    entries
}

fn curves(recording: &Recording, joint: Joint) -> Curves {
    let time_s = |row: usize| row as f64 * recording.interval_s();
    let in_degrees = |sample: &[f64; 8]| sample[joint.index()] * ACTION_DEG;
    let angles: Vec<f64> = recording.samples.iter().map(in_degrees).collect();
    let spreads: Vec<f64> = recording.deviations.iter().map(in_degrees).collect();
    let dots = angles.iter().enumerate().map(|(row, &angle)| (time_s(row), angle)).collect();
    let pairs = angles.iter().zip(&spreads).enumerate();
    let mut band: Vec<_> =
        pairs.map(|(row, (angle, spread))| (time_s(row), angle - spread, angle + spread)).collect();
    // A stride closes on itself: where it ends, the next begins. A window does not.
    if recording.window_s.is_none()
        && let Some(&(_, low, high)) = band.first()
    {
        band.push((recording.period_s, low, high));
    }
    let curve = recording.fits.as_ref().map_or(Vec::new(), |fits| {
        let series = &fits[joint.index()].series;
        let phases = (0..=CURVE_POINTS).map(|point| point as f64 / CURVE_POINTS as f64);
        // A stride's curve ends where the next begins, a window's at its last sample.
        let last_s = match recording.window_s {
            None => recording.period_s,
            Some(_) => time_s(recording.samples.len().saturating_sub(1)),
        };
        phases.map(|phase| (phase * last_s, series.centre_deg + series.deviation_deg(phase))).collect()
    });
    Curves { dots, band, curve }
}

/// Where a joint's curve ends.
#[cfg(test)]
pub fn curve_end(recording: &Recording, joint: Joint) -> Option<(f64, f64)> {
    curves(recording, joint).curve.last().copied()
}
