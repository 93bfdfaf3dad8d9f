//! The paper's Figure 3: evaluation reward and speed over updates.
//!
//! Holds its contents; [`crate::plot`] draws them. Does not depend on the learner. Where
//! a seed has fewer evaluations, the mean over the others is dashed, because it is not
//! the mean over all; where one seed is left, nothing is shaded.

use super::{Row, RunCurves, Score, Spread};
use crate::plot::{Axis, Entry, Figure, Layer, Mark, PALETTE, Panel};
use thiserror::Error;

const PANEL_PX: (u32, u32) = (820, 320);
/// Maximum deviation of the control steps from a straight line over updates, as a share of all.
const STRAIGHT: f64 = 0.005;

/// More runs than the palette has colours.
#[derive(Debug, PartialEq, Eq, Error)]
#[error("{runs} runs in one figure are too many: there are {} colours", PALETTE.len())]
pub struct TooManyRuns {
    /// Number of runs.
    pub runs: usize,
}

/// What is shaded around a mean.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Band {
    /// One standard deviation either way.
    Deviation,
    /// From minimum to maximum.
    Range,
}

impl Band {
    fn edges(self, spread: &Spread) -> (f64, f64) {
        match self {
            Self::Deviation => (spread.mean - spread.deviation, spread.mean + spread.deviation),
            Self::Range => (spread.min, spread.max),
        }
    }
}

/// The figure, a panel for reward and one for speed.
///
/// # Errors
/// [`TooManyRuns`] if there are more runs than colours.
pub fn of(runs: &[RunCurves], band: Band) -> Result<Figure, TooManyRuns> {
    if runs.len() > PALETTE.len() {
        return Err(TooManyRuns { runs: runs.len() });
    }
    let rows: Vec<Vec<Row>> = runs.iter().map(RunCurves::rows).collect();
    let updates = || rows.iter().flatten().map(|row| row.updates as f64);
    let x = Axis::exact("updates", std::iter::once(0.0).chain(updates()), 6);
    let panel = |title: &str, label: &str, top: Option<Axis>, of: fn(&Score) -> &Spread| {
        let mut layers = Vec::new();
        for (rows, colour) in rows.iter().zip(PALETTE) {
            // One seed has no spread; a band of no width would suggest certainty.
            let spread = rows.iter().take_while(|row| row.seeds > 1);
            if spread.clone().nth(1).is_none() {
                continue;
            }
            let edges = spread.map(|row| {
                let (low, high) = band.edges(of(&row.score));
                (row.updates as f64, low, high)
            });
            layers.push(Layer::band(colour, edges));
        }
        for ((run, rows), colour) in runs.iter().zip(&rows).zip(PALETTE) {
            let points: Vec<_> = rows.iter().map(|row| (row.updates as f64, of(&row.score).mean)).collect();
            let whole = rows.iter().take_while(|row| row.seeds == run.seeds.len()).count();
            layers.push(Layer { mark: Mark::Line, colour, points: points[..whole].to_vec() });
            if whole < points.len() {
                layers.push(Layer { mark: Mark::Dashes, colour, points: points[whole - 1..].to_vec() });
            }
        }
        let heights = layers.iter().flat_map(|layer| &layer.points).map(|&(_, y)| y);
        let y = Axis::round(label, heights.collect::<Vec<_>>(), 6);
        Panel { title: title.into(), x: x.clone(), y, top, layers, notes: vec![] }
    };
    let panels = vec![
        panel("Evaluation reward", "reward of an episode", steps_axis(&rows, &x), |score| &score.reward),
        panel("Evaluation speed", "forward speed (m/s)", None, |score| &score.speed_m_s),
    ];
    Ok(Figure {
        title: "Learning curves".into(),
        legend: legend(runs, &rows, band),
        columns: 1,
        panel_px: PANEL_PX,
        panels,
    })
}

fn legend(runs: &[RunCurves], rows: &[Vec<Row>], band: Band) -> Vec<Entry> {
    let mut entries: Vec<Entry> = runs
        .iter()
        .zip(PALETTE)
        .map(|(run, colour)| {
            let count = run.seeds.len();
            let label = format!("{}, {count} seed{}", run.label, if count == 1 { "" } else { "s" });
            let marks = if count == 1 { vec![] } else { vec![(Mark::Band, colour)] };
            Entry { label, marks: [marks, vec![(Mark::Line, colour)]].concat() }
        })
        .collect();
    let grey = crate::plot::Colour(110, 110, 110);
    if runs.iter().any(|run| run.seeds.len() > 1) {
        let label = match band {
            Band::Deviation => "shaded: \u{b1} 1 standard deviation over seeds",
            Band::Range => "shaded: minimum to maximum over seeds",
        };
        entries.push(Entry { label: label.into(), marks: vec![(Mark::Band, grey)] });
    }
    let behind = |(run, rows): (&RunCurves, &Vec<Row>)| rows.iter().any(|row| row.seeds < run.seeds.len());
    if runs.iter().zip(rows).any(behind) {
        let label = "dashed: mean over the seeds with this evaluation";
        entries.push(Entry { label: label.into(), marks: vec![(Mark::Dashes, grey)] });
    }
    entries
}

/// Control steps along the top, if they are the same linear function of the updates in all runs.
fn steps_axis(rows: &[Vec<Row>], x: &Axis) -> Option<Axis> {
    // The first row is before or at the end of the warm-up, which has steps but no updates.
    let learned = || rows.iter().flatten().filter(|row| row.updates > 0);
    let first = learned().min_by_key(|row| row.updates)?;
    let last = learned().max_by_key(|row| row.updates).filter(|last| last.updates > first.updates)?;
    let slope = (last.env_steps as f64 - first.env_steps as f64) / (last.updates - first.updates) as f64;
    let steps = |updates: f64| first.env_steps as f64 + (updates - first.updates as f64) * slope;
    let off = |row: &Row| (row.env_steps as f64 - steps(row.updates as f64)).abs();
    if slope <= 0.0 || learned().any(|row| off(row) > STRAIGHT * last.env_steps as f64) {
        return None;
    }
    Some(Axis::exact("control steps", [steps(x.least), steps(x.most)], 6))
}
