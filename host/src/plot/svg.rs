//! Draws a figure as SVG.
//!
//! Holds where the panels, the legend and the axes lie. Does not depend on what a
//! figure shows.

use super::canvas::{
    Area, Chart, FINE, FRAME, GRID, INK, LETTER_WIDTH, MARGIN_PX, TEXT_PX, TICK_PX, TITLE_PX, fine,
    printable, text_width_px,
};
use super::{Axis, Colour, Entry, Figure, Panel, PlotError, Side, marks, notes};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

/// Of a line of the legend.
const LEGEND_ROW_PX: u32 = 22;
const TITLE_ROW_PX: u32 = 30;
/// What stands before a label of the legend.
const SWATCH_PX: u32 = 28;
/// Between entries of the legend.
const GAP_PX: u32 = 26;
fn font(px: f64, colour: Colour, horizontal: HPos, vertical: VPos) -> TextStyle<'static> {
    // plotters writes the size divided by 1.24.
    let size = px * 1.24 * f64::from(FINE);
    ("sans-serif", size).into_font().color(&colour).pos(Pos::new(horizontal, vertical))
}

pub fn draw(figure: &Figure) -> Result<String, PlotError> {
    let columns = figure.columns.max(1);
    let rows = figure.panels.len().div_ceil(columns);
    let width_px = figure.panel_px.0 * columns as u32 + 2 * MARGIN_PX;
    let legend = legend_rows(&figure.legend, width_px - 2 * MARGIN_PX);
    let header_px = MARGIN_PX + TITLE_ROW_PX + LEGEND_ROW_PX * legend.len() as u32;
    let height_px = header_px + figure.panel_px.1 * rows as u32 + MARGIN_PX;
    let mut svg = String::new();
    {
        let root = SVGBackend::with_string(&mut svg, (width_px * FINE, height_px * FINE)).into_drawing_area();
        root.fill(&WHITE)?;
        let title = font(TITLE_PX, INK, HPos::Left, VPos::Center);
        let middle = fine(MARGIN_PX + TITLE_ROW_PX / 2 - 3);
        root.draw(&Text::new(printable(&figure.title), (fine(MARGIN_PX), middle), title))?;
        for (row, entries) in legend.iter().enumerate() {
            let top_px = MARGIN_PX + TITLE_ROW_PX + LEGEND_ROW_PX * row as u32;
            draw_legend(&root, entries, fine(top_px + LEGEND_ROW_PX / 2 - 3))?;
        }
        let (_, body) = root.split_vertically(fine(header_px));
        let body = body.margin(0, fine(MARGIN_PX), fine(MARGIN_PX), fine(MARGIN_PX));
        let left = fine(figure.panels.iter().map(widest_number_px).max().unwrap_or(0) + 34);
        for (area, panel) in body.split_evenly((rows.max(1), columns)).iter().zip(&figure.panels) {
            draw_panel(area, panel, left)?;
        }
        root.present()?;
    }
    Ok(shown_smaller(&svg, (width_px, height_px)))
}

/// The drawing's own size stays in its `viewBox`.
fn shown_smaller(svg: &str, (width_px, height_px): (u32, u32)) -> String {
    let (wide, high) = (width_px * FINE, height_px * FINE);
    let drawn = format!("width=\"{wide}\" height=\"{high}\" viewBox");
    svg.replacen(&drawn, &format!("width=\"{width_px}\" height=\"{height_px}\" viewBox"), 1)
}

/// As much of a text as fits, and a mark where it does not.
fn shortened(text: &str, px: f64, width_px: u32) -> String {
    if text_width_px(text, px) <= width_px {
        return text.to_owned();
    }
    let fits = (f64::from(width_px) / (px * LETTER_WIDTH)).floor() as usize;
    // The end tells runs apart as often as the beginning does.
    let (head, tail) = (fits.saturating_sub(1).div_ceil(2), fits.saturating_sub(1) / 2);
    let count = text.chars().count();
    text.chars().take(head).chain(['\u{2026}']).chain(text.chars().skip(count - tail)).collect()
}

/// Entries with their places, wrapped into lines that fit.
fn legend_rows(entries: &[Entry], width_px: u32) -> Vec<Vec<(u32, Entry)>> {
    let mut rows: Vec<Vec<(u32, Entry)>> = Vec::new();
    let mut used_px = u32::MAX;
    for entry in entries {
        let label = shortened(&entry.label, TEXT_PX, width_px.saturating_sub(SWATCH_PX));
        let entry = Entry { label, marks: entry.marks.clone() };
        let wide_px = SWATCH_PX + text_width_px(&entry.label, TEXT_PX) + GAP_PX;
        if used_px.saturating_add(wide_px) > width_px + GAP_PX {
            rows.push(Vec::new());
            used_px = 0;
        }
        if let Some(row) = rows.last_mut() {
            row.push((used_px, entry));
        }
        used_px += wide_px;
    }
    rows
}

fn draw_legend(root: &Area, entries: &[(u32, Entry)], middle: i32) -> Result<(), PlotError> {
    for (left_px, entry) in entries {
        let left = fine(MARGIN_PX + left_px);
        let right = left + fine(SWATCH_PX - 6);
        for &(mark, colour) in &entry.marks {
            marks::draw_swatch(root, mark, colour, (left, right), middle)?;
        }
        let style = font(TEXT_PX, INK, HPos::Left, VPos::Center);
        root.draw(&Text::new(printable(&entry.label), (left + fine(SWATCH_PX), middle), style))?;
    }
    Ok(())
}

/// Along the y axis; panels below each other begin at the same place.
fn widest_number_px(panel: &Panel) -> u32 {
    let y = &panel.y;
    y.ticks.iter().map(|&tick| text_width_px(&y.text(tick), TICK_PX)).max().unwrap_or(0)
}

fn draw_panel(area: &Area, panel: &Panel, left: i32) -> Result<(), PlotError> {
    let (x, y) = (&panel.x, &panel.y);
    let above_px = if panel.top.is_some() { 46 } else { 26 };
    let (above, below) = (fine(above_px), fine(46));
    let title = font(TEXT_PX + 1.0, INK, HPos::Left, VPos::Center);
    area.draw(&Text::new(printable(&panel.title), (left, fine(10)), title))?;
    let mut chart = ChartBuilder::on(area)
        .margin_right(fine(18))
        .margin_top(above)
        .margin_left(left)
        .margin_bottom(below)
        .build_cartesian_2d(x.least..x.most, y.least..y.most)?;
    for &tick in &x.ticks {
        chart.draw_series([PathElement::new([(tick, y.least), (tick, y.most)], GRID.stroke_width(FINE))])?;
    }
    for &tick in &y.ticks {
        chart.draw_series([PathElement::new([(x.least, tick), (x.most, tick)], GRID.stroke_width(FINE))])?;
    }
    clear_notes(area, panel, &chart)?;
    marks::draw_layers(&mut chart, panel)?;
    let frame = [(x.least, y.least), (x.most, y.most)];
    chart.draw_series([Rectangle::new(frame, FRAME.stroke_width(FINE))])?;
    label_axes(area, panel, &chart)?;
    write_notes(area, panel, &chart)
}

/// Grounds for notes: the grid would strike them through. What is drawn lies above
/// them, so that no note hides a result.
fn clear_notes(area: &Area, panel: &Panel, chart: &Chart) -> Result<(), PlotError> {
    for (note, (near, middle)) in panel.notes.iter().zip(notes::places(area, panel, chart)) {
        let width = fine(text_width_px(&note.text, TICK_PX));
        let far = if note.side == Side::Left { near - width } else { near + width };
        let half = fine(8);
        let corners = [(near.min(far), middle - half), (near.max(far), middle + half)];
        area.draw(&Rectangle::new(corners, WHITE.filled()))?;
    }
    Ok(())
}

/// Beside their places, clear of the marks there.
fn write_notes(area: &Area, panel: &Panel, chart: &Chart) -> Result<(), PlotError> {
    for (note, at) in panel.notes.iter().zip(notes::places(area, panel, chart)) {
        let side = if note.side == Side::Left { HPos::Right } else { HPos::Left };
        area.draw(&Text::new(printable(&note.text), at, font(TICK_PX, INK, side, VPos::Center)))?;
    }
    Ok(())
}

/// Numbers and names along the axes, in the panel's own pixels.
fn label_axes(area: &Area, panel: &Panel, chart: &Chart) -> Result<(), PlotError> {
    let (x, y) = (&panel.x, &panel.y);
    let (origin_x, origin_y) = area.get_base_pixel();
    let place = |at: (f64, f64)| {
        let (across, down) = chart.backend_coord(&at);
        (across - origin_x, down - origin_y)
    };
    let mark = |from: (i32, i32), to: (i32, i32)| PathElement::new([from, to], FRAME.stroke_width(FINE));
    for &tick in &x.ticks {
        let (across, down) = place((tick, y.least));
        area.draw(&mark((across, down), (across, down + fine(4))))?;
        let style = font(TICK_PX, INK, HPos::Center, VPos::Top);
        area.draw(&Text::new(x.text(tick), (across, down + fine(7)), style))?;
    }
    for &tick in &y.ticks {
        let (across, down) = place((x.least, tick));
        area.draw(&mark((across - fine(4), down), (across, down)))?;
        let style = font(TICK_PX, INK, HPos::Right, VPos::Center);
        area.draw(&Text::new(y.text(tick), (across - fine(7), down), style))?;
    }
    let (first, bottom) = place((x.least, y.least));
    let (last, top) = place((x.most, y.most));
    let centre = (first + last) / 2;
    let style = font(TICK_PX, INK, HPos::Center, VPos::Top);
    area.draw(&Text::new(printable(&x.label), (centre, bottom + fine(24)), style.clone()))?;
    let turned = font(TICK_PX, INK, HPos::Center, VPos::Top).transform(FontTransform::Rotate270);
    area.draw(&Text::new(printable(&y.label), (fine(2), (top + bottom) / 2), turned))?;
    if let Some(other) = &panel.top {
        for &tick in &other.ticks {
            let across = first + share(other, tick, last - first);
            area.draw(&mark((across, top - fine(4)), (across, top)))?;
            let style = font(TICK_PX, INK, HPos::Center, VPos::Bottom);
            area.draw(&Text::new(other.text(tick), (across, top - fine(5)), style))?;
        }
        let style = font(TICK_PX, INK, HPos::Center, VPos::Bottom);
        area.draw(&Text::new(printable(&other.label), (centre, top - fine(23)), style))?;
    }
    Ok(())
}

/// How far along an axis of `length` a value lies.
fn share(axis: &Axis, value: f64, length: i32) -> i32 {
    ((value - axis.least) / (axis.most - axis.least) * f64::from(length)).round() as i32
}
