//! Figures for papers and pages: panels of dots, lines and bands, as SVG.
//!
//! Holds the look: palette, sizes, axes, legend. The ground is white, so that a
//! figure reads on a dark page too, and the colours are Okabe and Ito's, which
//! the colour-blind tell apart. No font of this machine is asked for anything:
//! the same figure is the same bytes everywhere. Does not depend on what
//! is drawn. NaN and infinite numbers are refused.

mod axis;
mod canvas;
mod marks;
mod notes;
mod raster;
mod svg;
mod table;

pub use axis::Axis;
pub use plotters::style::RGBColor as Colour;
pub use raster::to_png;
pub use table::Table;

use plotters::drawing::DrawingAreaErrorKind;
use thiserror::Error;

/// Of the first curve.
pub const BLUE: Colour = Colour(0, 114, 178);
/// Of the second curve.
pub const VERMILION: Colour = Colour(213, 94, 0);
/// What curves of equal rank are drawn in, in this order. Okabe and Ito's
/// without their yellow, which white drowns.
pub const PALETTE: [Colour; 7] = [
    BLUE,
    VERMILION,
    Colour(0, 158, 115),
    Colour(204, 121, 167),
    Colour(86, 180, 233),
    Colour(230, 159, 0),
    Colour(0, 0, 0),
];

/// Why a figure cannot be drawn.
#[derive(Debug, Error)]
pub enum PlotError {
    /// A NaN or infinite coordinate.
    #[error("{panel}: a point at ({x}, {y}) cannot be drawn")]
    NotFinite {
        /// Title of the panel.
        panel: String,
        /// In the unit of the x axis.
        x: f64,
        /// In the unit of the y axis.
        y: f64,
    },
    /// The drawing library's error.
    #[error("cannot draw the figure")]
    Drawing(#[from] DrawingAreaErrorKind<std::io::Error>),
    /// The text is not SVG.
    #[error("cannot read the drawing back")]
    Svg(#[from] resvg::usvg::Error),
    /// Too many pixels, or none.
    #[error("a picture of {width_px} x {height_px} pixels cannot be made")]
    Size {
        /// Across.
        width_px: u32,
        /// Down.
        height_px: u32,
    },
    /// The PNG encoder's error.
    #[error("cannot write the picture as PNG: {reason}")]
    Png {
        /// The encoder's reason.
        reason: String,
    },
}

/// Style in which points are drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mark {
    /// One dot a point.
    Dots,
    /// Joined.
    Line,
    /// Joined, for what is less sure.
    Dashes,
    /// The area between the first half of the points and the second, which runs back.
    Band,
    /// A large dot a point: few of them, each a result.
    Points,
    /// A large diamond a point: somebody else's results.
    Diamonds,
    /// From the first point to the second, the third to the fourth and so on, with a
    /// cross-stroke at both ends; where one leaves the panel, it is cut and has none there.
    Whiskers,
}

/// Points of one kind.
#[derive(Debug, Clone)]
pub struct Layer {
    /// Style of the points.
    pub mark: Mark,
    /// Of all points.
    pub colour: Colour,
    /// Where, in the units of the axes.
    pub points: Vec<(f64, f64)>,
}

impl Layer {
    /// The area between `low` and `high`, over x.
    pub fn band(colour: Colour, edges: impl Iterator<Item = (f64, f64, f64)> + Clone) -> Self {
        let mut points: Vec<(f64, f64)> = edges.clone().map(|(x, _, high)| (x, high)).collect();
        let mut low: Vec<(f64, f64)> = edges.map(|(x, low, _)| (x, low)).collect();
        low.reverse();
        points.append(&mut low);
        Self { mark: Mark::Band, colour, points }
    }
}

/// On which side of its place a text stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// It ends there.
    Left,
    /// It begins there.
    Right,
}

/// A text in a panel.
#[derive(Debug, Clone, PartialEq)]
pub struct Note {
    /// Where, in the units of the axes.
    pub at: (f64, f64),
    /// On which side of that.
    pub side: Side,
    /// A single line.
    pub text: String,
}

/// Axes and what is drawn between them, first to last.
#[derive(Debug, Clone)]
pub struct Panel {
    /// Above it, at the left.
    pub title: String,
    /// Left to right.
    pub x: Axis,
    /// Bottom to top.
    pub y: Axis,
    /// The same range in another unit, along the top.
    pub top: Option<Axis>,
    /// The later hides the earlier.
    pub layers: Vec<Layer>,
    /// Above all layers.
    pub notes: Vec<Note>,
}

/// A line of the legend.
#[derive(Debug, Clone)]
pub struct Entry {
    /// A single line, shortened to the figure's width.
    pub label: String,
    /// How it is shown; several lie on each other.
    pub marks: Vec<(Mark, Colour)>,
}

/// Panels under one title and legend.
#[derive(Debug, Clone)]
pub struct Figure {
    /// Above everything.
    pub title: String,
    /// Below the title, in as many lines as it takes.
    pub legend: Vec<Entry>,
    /// Panels in a row.
    pub columns: usize,
    /// Width and height of a panel, its labels included.
    pub panel_px: (u32, u32),
    /// Row by row.
    pub panels: Vec<Panel>,
}

impl Figure {
    /// The picture as the text of an SVG file.
    ///
    /// # Errors
    /// [`PlotError`]
    pub fn to_svg(&self) -> Result<String, PlotError> {
        for panel in &self.panels {
            let drawn = panel.layers.iter().flat_map(|layer| &layer.points);
            let mut points = drawn.chain(panel.notes.iter().map(|note| &note.at));
            if let Some(&(x, y)) = points.find(|(x, y)| !(x.is_finite() && y.is_finite())) {
                return Err(PlotError::NotFinite { panel: panel.title.clone(), x, y });
            }
        }
        svg::draw(self)
    }
}

#[cfg(test)]
mod tests;
