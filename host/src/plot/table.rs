//! A table as a picture, in the look of the figures.
//!
//! Holds the widths of its columns. The first columns hold words and stand
//! left, the others numbers and stand right.

use super::canvas::{FRAME, GRID, INK, MARGIN_PX, TEXT_PX, TITLE_PX, printable, text_width_px};
use super::{Colour, PlotError};
use quick_xml::escape::escape;
use std::fmt::Write as _;

const ROW_PX: u32 = 28;
const TITLE_ROW_PX: u32 = 34;
/// Between columns.
const GAP_PX: u32 = 22;
/// Of bold letters beside plain ones.
const BOLD: f64 = 1.08;

/// Words and numbers in rows.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Table {
    /// Above it.
    pub title: String,
    /// Of each column.
    pub header: Vec<String>,
    /// Columns that hold words.
    pub words: usize,
    /// As many cells as the header has.
    pub rows: Vec<Vec<String>>,
    /// Rows that a line stands above.
    pub parts: Vec<usize>,
}

impl Table {
    /// The picture as the text of an SVG file.
    ///
    /// # Errors
    /// [`PlotError::Size`] if there are more rows than a picture can hold.
    pub fn to_svg(&self) -> Result<String, PlotError> {
        let widths: Vec<u32> = (0..self.header.len()).map(|column| self.width_px(column)).collect();
        let gaps = GAP_PX * (widths.len() as u32).saturating_sub(1);
        let title_px = text_width_px(&self.title, TITLE_PX);
        let width_px = (widths.iter().sum::<u32>() + gaps).max(title_px) + 2 * MARGIN_PX;
        let rows = u32::try_from(self.rows.len()).ok().and_then(|rows| ROW_PX.checked_mul(rows + 1));
        let Some(rows_px) = rows else {
            return Err(PlotError::Size { width_px, height_px: u32::MAX });
        };
        let height_px = rows_px + TITLE_ROW_PX + 2 * MARGIN_PX;
        let mut svg = format!(
            "<svg width=\"{width_px}\" height=\"{height_px}\" viewBox=\"0 0 {width_px} {height_px}\" \
             xmlns=\"http://www.w3.org/2000/svg\" font-family=\"sans-serif\">\n\
             <rect width=\"{width_px}\" height=\"{height_px}\" fill=\"#FFFFFF\"/>\n"
        );
        let title = Cell { x: MARGIN_PX, y: MARGIN_PX + TITLE_ROW_PX / 2, right: false, bold: false };
        title.write(&mut svg, &self.title, TITLE_PX);
        let top = MARGIN_PX + TITLE_ROW_PX;
        line(&mut svg, top, width_px, FRAME);
        for (row, cells) in std::iter::once(&self.header).chain(&self.rows).enumerate() {
            let y = top + ROW_PX * row as u32;
            if row > 0 {
                let begins = row == 1 || self.parts.contains(&(row - 1));
                line(&mut svg, y, width_px, if begins { FRAME } else { GRID });
            }
            let mut left = MARGIN_PX;
            for (column, (text, width)) in cells.iter().zip(&widths).enumerate() {
                let right = column >= self.words;
                let x = if right { left + width } else { left };
                Cell { x, y: y + ROW_PX / 2, right, bold: row == 0 }.write(&mut svg, text, TEXT_PX);
                left += width + GAP_PX;
            }
        }
        line(&mut svg, top + rows_px, width_px, FRAME);
        svg += "</svg>\n";
        Ok(svg)
    }

    fn width_px(&self, column: usize) -> u32 {
        let cells = self.rows.iter().filter_map(|row| row.get(column));
        let widest = cells.map(|text| text_width_px(text, TEXT_PX)).max().unwrap_or(0);
        widest.max(text_width_px(&self.header[column], TEXT_PX * BOLD))
    }
}

struct Cell {
    x: u32,
    y: u32,
    right: bool,
    bold: bool,
}

impl Cell {
    fn write(&self, svg: &mut String, text: &str, px: f64) {
        let Self { x, y, right, bold } = self;
        let anchor = if *right { " text-anchor=\"end\"" } else { "" };
        let weight = if *bold { " font-weight=\"bold\"" } else { "" };
        let text = printable(text);
        // A third of the letters' height below the middle: where their feet stand.
        let y = f64::from(*y) + px * 0.36;
        let _ = writeln!(
            svg,
            "<text x=\"{x}\" y=\"{y:.1}\" font-size=\"{px}\" fill=\"{}\"{anchor}{weight}>{}</text>",
            hex(INK),
            escape(&text)
        );
    }
}

fn line(svg: &mut String, y: u32, width_px: u32, colour: Colour) {
    let end = width_px - MARGIN_PX;
    let _ = writeln!(
        svg,
        "<line x1=\"{MARGIN_PX}\" y1=\"{y}\" x2=\"{end}\" y2=\"{y}\" stroke=\"{}\"/>",
        hex(colour)
    );
}

fn hex(Colour(red, green, blue): Colour) -> String {
    format!("#{red:02X}{green:02X}{blue:02X}")
}
