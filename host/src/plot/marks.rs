//! How points look: dots, lines, bands, diamonds, whiskers.
//!
//! Holds their shapes and sizes, in a panel and in a legend.

use super::canvas::{Area, Chart, FINE, fine};
use super::{Colour, Layer, Mark, Panel, PlotError};
use plotters::prelude::*;

/// Bands let the grid, and each other, through.
const BAND_OPACITY: f64 = 0.25;
/// Of a large dot.
const POINT_PX: u32 = 4;
/// From the middle of a diamond to its corners.
const DIAMOND_PX: u32 = 6;
/// Half the stroke across a whisker's end.
const CAP_PX: u32 = 4;

/// As large as lets many dots be dots, within reason.
fn dot_radius(count: usize, width: u32) -> u32 {
    let apart = width / (count as u32).max(1);
    (apart / 2).clamp(FINE * 7 / 8, 2 * FINE)
}

fn stroke(colour: Colour) -> ShapeStyle {
    colour.stroke_width(2 * FINE)
}

/// Thinner than a line, so that the dot on it stays the first thing seen.
fn whisker(colour: Colour) -> ShapeStyle {
    colour.stroke_width(FINE * 3 / 2)
}

fn diamond() -> Vec<(i32, i32)> {
    let reach = fine(DIAMOND_PX);
    vec![(0, -reach), (reach, 0), (0, reach), (-reach, 0)]
}

/// What is between the axes, first to last.
pub fn draw_layers(chart: &mut Chart, panel: &Panel) -> Result<(), PlotError> {
    for layer in &panel.layers {
        match layer.mark {
            Mark::Dots => {
                let radius = dot_radius(layer.points.len(), chart.plotting_area().dim_in_pixel().0);
                let dot = |&at: &(f64, f64)| Circle::new(at, radius, layer.colour.filled());
                chart.draw_series(layer.points.iter().map(dot))?;
            }
            Mark::Points => {
                let dot = |&at: &(f64, f64)| Circle::new(at, fine(POINT_PX), layer.colour.filled());
                chart.draw_series(layer.points.iter().map(dot))?;
            }
            Mark::Diamonds => {
                let shape =
                    |&at: &(f64, f64)| EmptyElement::at(at) + Polygon::new(diamond(), layer.colour.filled());
                chart.draw_series(layer.points.iter().map(shape))?;
            }
            Mark::Band => {
                let style = layer.colour.mix(BAND_OPACITY).filled();
                chart.draw_series([Polygon::new(layer.points.clone(), style)])?;
            }
            Mark::Line => {
                chart.draw_series([PathElement::new(layer.points.clone(), stroke(layer.colour))])?;
            }
            Mark::Dashes => {
                let style = stroke(layer.colour);
                let points = layer.points.clone();
                chart.draw_series(DashedLineSeries::new(points, fine(7), fine(5), style))?;
            }
            Mark::Whiskers => draw_whiskers(chart, panel, layer)?,
        }
    }
    Ok(())
}

fn draw_whiskers(chart: &mut Chart, panel: &Panel, layer: &Layer) -> Result<(), PlotError> {
    let style = whisker(layer.colour);
    let within =
        |(x, y): (f64, f64)| (x.clamp(panel.x.least, panel.x.most), y.clamp(panel.y.least, panel.y.most));
    for ends in layer.points.chunks_exact(2) {
        let (from, to) = (within(ends[0]), within(ends[1]));
        chart.draw_series([PathElement::new([from, to], style)])?;
        let lies = from.1 == to.1;
        let cap = if lies { (0, fine(CAP_PX)) } else { (fine(CAP_PX), 0) };
        // A cut whisker has no end to mark.
        let whole = [(from, ends[0]), (to, ends[1])].into_iter().filter(|(shown, end)| shown == end);
        let cross = |(at, _): ((f64, f64), (f64, f64))| {
            EmptyElement::at(at) + PathElement::new(vec![(-cap.0, -cap.1), cap], style)
        };
        chart.draw_series(whole.map(cross))?;
    }
    Ok(())
}

/// The same in the legend, between `left` and `right`.
pub fn draw_swatch(
    root: &Area,
    mark: Mark,
    colour: Colour,
    (left, right): (i32, i32),
    middle: i32,
) -> Result<(), PlotError> {
    let centre = (left + right) / 2;
    match mark {
        Mark::Dots => root.draw(&Circle::new((centre, middle), fine(3), colour.filled()))?,
        Mark::Points => root.draw(&Circle::new((centre, middle), fine(POINT_PX), colour.filled()))?,
        Mark::Diamonds => {
            let corners: Vec<_> = diamond().iter().map(|(x, y)| (centre + x, middle + y)).collect();
            root.draw(&Polygon::new(corners, colour.filled()))?;
        }
        Mark::Band => {
            let corners = [(left, middle - fine(6)), (right, middle + fine(6))];
            root.draw(&Rectangle::new(corners, colour.mix(BAND_OPACITY).filled()))?;
        }
        Mark::Line => root.draw(&PathElement::new([(left, middle), (right, middle)], stroke(colour)))?,
        Mark::Dashes => {
            let dash = (right - left) * 2 / 5;
            for (from, to) in [(left, left + dash), (right - dash, right)] {
                root.draw(&PathElement::new([(from, middle), (to, middle)], stroke(colour)))?;
            }
        }
        Mark::Whiskers => {
            let reach = fine(8);
            let ends = [middle - reach, middle + reach];
            root.draw(&PathElement::new(ends.map(|end| (centre, end)), whisker(colour)))?;
            for end in ends {
                let cap = [(centre - fine(CAP_PX), end), (centre + fine(CAP_PX), end)];
                root.draw(&PathElement::new(cap, whisker(colour)))?;
            }
        }
    }
    Ok(())
}
