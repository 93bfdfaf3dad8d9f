//! What everything in a figure is drawn on, and in which sizes and colours.
//!
//! plotters has whole pixels only, so a figure is drawn [`FINE`] times as large
//! and shown that much smaller. Does not depend on what is drawn.

use super::Colour;
use plotters::coord::Shift;
use plotters::prelude::*;

/// Units of the drawing in a pixel of the picture.
pub const FINE: u32 = 8;
pub const TITLE_PX: f64 = 17.0;
pub const TEXT_PX: f64 = 13.0;
pub const TICK_PX: f64 = 12.0;
/// Around everything.
pub const MARGIN_PX: u32 = 12;
/// Widest a letter is on average in the fonts that browsers take for sans-serif, in heights.
pub const LETTER_WIDTH: f64 = 0.58;

pub const INK: Colour = Colour(38, 38, 38);
pub const GRID: Colour = Colour(228, 228, 228);
pub const FRAME: Colour = Colour(150, 150, 150);

/// What a part of a figure is drawn on.
pub type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

/// Pixels of the picture in units of the drawing.
pub const fn fine(px: u32) -> i32 {
    (px * FINE) as i32
}

/// A panel's area with its axes' coordinates.
pub type Chart<'a, 'b> = ChartContext<
    'a,
    SVGBackend<'b>,
    Cartesian2d<plotters::coord::types::RangedCoordf64, plotters::coord::types::RangedCoordf64>,
>;

/// How wide a text is at most, drawn `px` high.
pub fn text_width_px(text: &str, px: f64) -> u32 {
    (text.chars().count() as f64 * px * LETTER_WIDTH).ceil() as u32
}

/// XML has no place for control characters and for two others, not even escaped.
pub fn printable(text: &str) -> String {
    let has_place = |c: char| !c.is_control() && !matches!(c, '\u{fffe}' | '\u{ffff}');
    text.chars().map(|c| if has_place(c) { c } else { '?' }).collect()
}
