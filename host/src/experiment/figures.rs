//! The paper's Figures 3 to 8 and its Table 2, from a study.
//!
//! Holds which figures there are, their captions and files. A figure is made of
//! what was walked; where there is nothing to draw, it says why. Computes no
//! result of its own but trends and the powers of Figure 5.

pub mod best;
pub mod points;
pub mod power;
pub mod sweeps;

use super::study::{LegStudy, Study};
use crate::learn::curves::{self, Band, RunCurves, TooManyRuns};
use crate::learn::record;
use crate::paper;
use crate::plot::{self, Figure, PlotError};
use crate::robot::LegScale;
use crate::run_folder::{self, FileError};
use points::Quantity;
use std::path::Path;
use thiserror::Error;

/// Of a panel in a column of its own.
const WIDTH_PX: u32 = 640;
/// Pixels of a PNG for one of the drawing.
pub const PNG_SCALE: f32 = 2.0;

/// Why a figure is not there.
#[derive(Debug, Error)]
pub enum Missing {
    /// Its legs' policy came without a learning curve.
    #[error("no learning curve came with the policies of this study")]
    NoLearning,
    /// More curves than colours.
    #[error(transparent)]
    TooManyRuns(#[from] TooManyRuns),
    /// Its legs' policy came without a recording.
    #[error("no averaged stride came with the policy of these legs")]
    NoStride,
    /// Nothing that walked counts.
    #[error("no trial that counts")]
    NoTrials,
    /// Figure 5 has one pair of legs and one speed.
    #[error(
        "no method walked at {} m/s on long legs, and no two of the paper's share a speed",
        paper::FIGURE_5_SPEED_M_S
    )]
    NoPower,
    /// The drawing's reason.
    #[error("the figure cannot be drawn: {0}")]
    Plot(#[from] PlotError),
}

/// A figure, or why there is none.
#[derive(Debug)]
pub struct Drawn {
    /// Of its files, and its place in the report: `figure-6`.
    pub name: String,
    /// As the paper numbers it.
    pub heading: String,
    /// What is seen.
    pub caption: String,
    /// The text of an SVG file.
    pub svg: Result<String, Missing>,
}

/// Why figures were not written.
#[derive(Debug, Error)]
pub enum WriteError {
    /// A picture in pixels could not be made.
    #[error("{name} as PNG")]
    Png {
        /// Which figure.
        name: String,
        /// Why.
        source: PlotError,
    },
    /// The disk's reason.
    #[error(transparent)]
    File(#[from] FileError),
}

/// Legs as the paper names those of its robot; another robot's by its own name.
#[must_use]
pub fn leg_text(robot: &str, leg: LegScale) -> String {
    if robot != "Ant" {
        let drawn = format!("{robot}\u{2019}s drawn length");
        return if leg == LegScale::LONG { drawn } else { format!("{} of {drawn}", leg.value()) };
    }
    // Tenths of a centimetre, and no `.0`.
    let cm = (leg.value() * 230.0).round() / 10.0;
    format!("{leg} ({cm} cm)")
}

/// All figures in the paper's order.
#[must_use]
pub fn all(study: &Study) -> Vec<Drawn> {
    let mut drawn = vec![learning(&study.legs)];
    drawn.extend(study.legs.iter().map(|leg| stride(&study.robot, leg)));
    drawn.push(power(study));
    let sweep = |number: u32, what: &str, x, y| sweep(study, number, what, x, y);
    drawn.push(sweep(6, "Cost of transport over amplification", Quantity::Amplification, Quantity::Cost));
    drawn.push(sweep(7, "Speed over amplification", Quantity::Amplification, Quantity::Speed));
    drawn.push(sweep(8, "Cost of transport over speed", Quantity::Speed, Quantity::Cost));
    drawn.push(Drawn {
        name: "table-2".into(),
        heading: "Table 2".into(),
        caption: "Least cost of transport and highest speed of each method, with 95 % intervals, and the \
                  amplification that they were reached at; beside them what the authors measured."
            .into(),
        svg: best::table(&study.robot, &study.best)
            .ok_or(Missing::NoTrials)
            .and_then(|table| Ok(table.to_svg()?)),
    });
    drawn
}

/// Writes every figure there is as SVG and PNG; names the files.
///
/// # Errors
/// [`WriteError`] naming the figure.
pub fn write(folder: &Path, figures: &[Drawn]) -> Result<Vec<String>, WriteError> {
    let mut files = Vec::new();
    for Drawn { name, svg, .. } in figures {
        let Ok(svg) = svg else { continue };
        let png =
            plot::to_png(svg, PNG_SCALE).map_err(|source| WriteError::Png { name: name.clone(), source })?;
        for (ending, contents) in [("svg", svg.as_bytes()), ("png", &png)] {
            let file = format!("{name}.{ending}");
            run_folder::write(&folder.join(&file), contents)?;
            files.push(file);
        }
    }
    Ok(files)
}

fn learning(legs: &[LegStudy]) -> Drawn {
    let runs: Vec<RunCurves> = legs.iter().filter_map(|leg| leg.learning.clone()).collect();
    let svg = match runs.as_slice() {
        [] => Err(Missing::NoLearning),
        runs => curves::figure(runs, Band::Deviation).map_err(Missing::from).and_then(svg_of),
    };
    Drawn {
        name: "figure-3".into(),
        heading: "Figure 3".into(),
        caption: "How the policies of PSTO learned: reward and speed of evaluation episodes over updates of \
                  the networks."
            .into(),
        svg,
    }
}

fn stride(robot: &str, leg: &LegStudy) -> Drawn {
    let legs = leg_text(robot, leg.leg);
    let svg = leg.stride.as_ref().filter(|stride| !stride.samples.is_empty()).map_or(
        Err(Missing::NoStride),
        |stride| {
            let title = format!("Learned stride of {:.3} s, {legs}", stride.period_s);
            svg_of(record::of_stride(title, stride.period_s, &stride.samples, &stride.deviations))
        },
    );
    Drawn {
        name: format!("figure-4-{}L", leg.leg.value()),
        heading: format!("Figure 4, {legs}"),
        caption: "The eight joints over one stride. Dots: the mean setpoint, which \u{201c}original\u{201d} \
                  plays; shaded: its standard deviation over strides and trials; dashed: the polynomial of \
                  PSTO; line: the polynomial that closes where one stride ends and the next begins, and how \
                  much of the movement it keeps (R\u{b2})."
            .into(),
        svg,
    }
}

fn power(study: &Study) -> Drawn {
    let walked = study.conditions.iter().any(|c| c.leg == paper::LEGS[0] && c.speed_m_s.is_some());
    let svg = match power::figure(&study.robot, &power::at_speeds(&study.conditions)) {
        Some(figure) => svg_of(figure),
        None if walked => Err(Missing::NoPower),
        None => Err(Missing::NoTrials),
    };
    Drawn {
        name: "figure-5".into(),
        heading: "Figure 5".into(),
        caption: format!(
            "Power at the same speed on long legs: at {} m/s as in the paper, if any method walks so slowly here, \
             and at the slowest speed that original, sinusoid and PSTO share. It lies on the straight line \
             between the two neighbouring amplifications whose mean speeds enclose that speed; its interval is \
             that of their powers alone. Methods that never walk so slowly, or so fast, have no point: nothing \
             is extrapolated.",
            paper::FIGURE_5_SPEED_M_S
        ),
        svg,
    }
}

fn sweep(study: &Study, number: u32, what: &str, x: Quantity, y: Quantity) -> Drawn {
    let found = sweeps::figure(study, what, x, y);
    let aside = match x {
        Quantity::Amplification => " Methods at the same amplification stand side by side.",
        Quantity::Speed | Quantity::Cost => {
            " The authors\u{2019} points pair the least cost and the highest speed of Table 2, which need not \
             have the same amplification."
        }
    };
    let cut = match found {
        Some(sweeps::Sweep { cut: true, .. }) => " Intervals that reach out of the panel are cut.",
        _ => "",
    };
    Drawn {
        name: format!("figure-{number}"),
        heading: format!("Figure {number}"),
        caption: format!(
            "{what}: means of the trials that count, with 95 % intervals. Curves are polynomials of second \
             order, fitted to the means, where there are three or more.{aside} Black: what the paper prints in \
             numbers.{cut}"
        ),
        svg: found.ok_or(Missing::NoTrials).and_then(|found| svg_of(found.figure)),
    }
}

fn svg_of(figure: Figure) -> Result<String, Missing> {
    Ok(figure.to_svg()?)
}

#[cfg(test)]
mod tests;
