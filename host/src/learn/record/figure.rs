//! The paper's Figure 4: eight joints, samples, spread and curve.
//!
//! Holds its contents; [`crate::plot`] draws them. Does not depend on the simulation.
//! All panels have the same axes, so that strokes can be compared.

use super::{ACTION_DEG, Recording, fit_with};
use crate::gait::fit::{JointFit, Seam};
use crate::gait::policy_record::RecordSummary;
use crate::gait::stride::Sample;
use crate::plot::{Axis, BLUE, Colour, Entry, Figure, Layer, Mark, PALETTE, Panel, VERMILION};
use protocol::{JOINT_COUNT, Joint, LEG_COUNT};

/// Places of legs 1 to 4.
const LEGS: [&str; LEG_COUNT] = ["front left", "rear left", "rear right", "front right"];
/// Points that a curve is drawn through.
const CURVE_POINTS: usize = 240;
const PANEL_PX: (u32, u32) = (430, 220);
/// Colour of the curve whose ends are free.
const FREE: Colour = PALETTE[6];

/// What is drawn: a recording, or a stride alone.
struct Shown<'a> {
    title: String,
    period_s: f64,
    /// Whether it is a window, whose ends need not meet.
    is_window: bool,
    samples: &'a [Sample],
    deviations: &'a [Sample],
    fits: Option<&'a [JointFit; JOINT_COUNT]>,
    /// The curves whose ends need not meet.
    free: Option<&'a [JointFit; JOINT_COUNT]>,
    r2: [Option<f64>; JOINT_COUNT],
}

struct Curves {
    dots: Vec<(f64, f64)>,
    band: Vec<(f64, f64, f64)>,
    curve: Vec<(f64, f64)>,
    free: Vec<(f64, f64)>,
}

pub fn of(recording: &Recording) -> Figure {
    draw(&shown(recording))
}

fn shown(recording: &Recording) -> Shown<'_> {
    Shown {
        title: title(recording),
        period_s: recording.summary.period_s,
        is_window: recording.summary.window_s.is_some(),
        samples: &recording.samples,
        deviations: &recording.deviations,
        fits: recording.fits.as_ref().ok(),
        free: None,
        r2: recording.summary.polynomial_r2,
    }
}

/// A stride alone, with the continuous curve and PSTO's free one.
pub fn of_stride(title: String, period_s: f64, samples: &[Sample], deviations: &[Sample]) -> Figure {
    let fits = fit_with(samples, Seam::usual(false)).ok();
    let free = fit_with(samples, Seam::Free).ok();
    let r2 = fits.as_ref().map_or([None; JOINT_COUNT], |fits| fits.each_ref().map(|fit| fit.series.r2));
    draw(&Shown {
        title,
        period_s,
        is_window: false,
        samples,
        deviations,
        fits: fits.as_ref(),
        free: free.as_ref(),
        r2,
    })
}

fn draw(shown: &Shown) -> Figure {
    let curves = Joint::ALL.map(|joint| curves(shown, joint));
    let heights = curves.iter().flat_map(|curves| {
        let edges = curves.band.iter().flat_map(|&(_, low, high)| [low, high]);
        edges.chain(curves.curve.iter().chain(&curves.free).map(|&(_, angle)| angle))
    });
    let y = Axis::degrees("angle (degrees)", heights, 6);
    let x = Axis::exact("time (s)", [0.0, shown.period_s], 8);
    let panel = |leg: usize, joint: Joint| {
        let Curves { dots, band, curve, free } = &curves[joint.index()];
        let line = |mark, colour, points: &[(f64, f64)]| Layer { mark, colour, points: points.to_vec() };
        let r2 = shown.r2[joint.index()];
        let kept = r2.map_or(String::new(), |r2| format!(", R\u{b2} {r2:.3}"));
        let mut layers = vec![
            Layer::band(BLUE, band.iter().copied()),
            line(Mark::Dots, BLUE, dots),
            line(Mark::Line, VERMILION, curve),
        ];
        if shown.free.is_some() {
            layers.push(line(Mark::Dashes, FREE, free));
        }
        Panel {
            title: format!("{} ({}){kept}", joint.name(), LEGS[leg]),
            x: x.clone(),
            y: y.clone(),
            top: None,
            layers,
            notes: vec![],
        }
    };
    let panels =
        (0..LEG_COUNT).flat_map(|leg| [panel(leg, Joint::ALL[leg]), panel(leg, Joint::ALL[leg + LEG_COUNT])]);
    Figure {
        title: shown.title.clone(),
        legend: legend(shown),
        columns: 2,
        panel_px: PANEL_PX,
        panels: panels.collect(),
    }
}

fn title(recording: &Recording) -> String {
    let RecordSummary { period_s, strides_averaged, trials, window_s, .. } = &recording.summary;
    match window_s {
        None => format!("Learned stride of {period_s:.3} s: {strides_averaged} strides of {trials} trials"),
        Some(_) => {
            format!("Learned gait, a window of {period_s:.3} s: {strides_averaged} of {trials} trials")
        }
    }
}

fn legend(shown: &Shown) -> Vec<Entry> {
    let entry = |label: &str, marks: &[_]| Entry { label: label.into(), marks: marks.to_vec() };
    let mut entries = vec![
        entry("mean setpoint", &[(Mark::Dots, BLUE)]),
        entry("\u{b1} 1 standard deviation", &[(Mark::Band, BLUE)]),
    ];
    if shown.fits.is_some() {
        let closes = if shown.free.is_some() { ", closing over the seam" } else { "" };
        entries.push(entry(&format!("polynomial of degree 10{closes}"), &[(Mark::Line, VERMILION)]));
    }
    if shown.free.is_some() {
        entries.push(entry("PSTO: the same, its ends free", &[(Mark::Dashes, FREE)]));
    }
    entries
}

fn curves(shown: &Shown, joint: Joint) -> Curves {
    let interval_s = shown.period_s / shown.samples.len().max(1) as f64;
    let time_s = |row: usize| row as f64 * interval_s;
    let in_degrees = |sample: &Sample| sample[joint.index()] * ACTION_DEG;
    let angles: Vec<f64> = shown.samples.iter().map(in_degrees).collect();
    let spreads: Vec<f64> = shown.deviations.iter().map(in_degrees).collect();
    let dots = angles.iter().enumerate().map(|(row, &angle)| (time_s(row), angle)).collect();
    let pairs = angles.iter().zip(&spreads).enumerate();
    let mut band: Vec<_> =
        pairs.map(|(row, (angle, spread))| (time_s(row), angle - spread, angle + spread)).collect();
    // A stride is periodic: the next begins where it ends. A window is not.
    if !shown.is_window
        && let Some(&(_, low, high)) = band.first()
    {
        band.push((shown.period_s, low, high));
    }
    let last_sample_s = time_s(shown.samples.len().saturating_sub(1));
    let curve = |fits: Option<&[JointFit; JOINT_COUNT]>, last_s: f64| {
        fits.map_or(Vec::new(), |fits| {
            let series = &fits[joint.index()].series;
            let phases = (0..=CURVE_POINTS).map(|point| point as f64 / CURVE_POINTS as f64);
            phases.map(|phase| (phase * last_s, series.centre_deg + series.deviation_deg(phase))).collect()
        })
    };
    // A stride's curve ends where the next stride begins, that of a window or a free one at the last sample.
    let last_s = if shown.is_window { last_sample_s } else { shown.period_s };
    Curves { dots, band, curve: curve(shown.fits, last_s), free: curve(shown.free, last_sample_s) }
}

/// Last point of a joint's curve: time and angle.
#[cfg(test)]
pub fn curve_end(recording: &Recording, joint: Joint) -> Option<(f64, f64)> {
    curves(&shown(recording), joint).curve.last().copied()
}
