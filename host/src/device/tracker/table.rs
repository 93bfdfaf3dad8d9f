//! Tracks as tables: one row a sighting, columns found by their names.
//!
//! Holds the names and units of columns, and the exports of motion capture programs
//! that are recognised in order to be refused. Does not depend on the trial.

use super::Point;
use super::error::TrackerError;
use crate::gait::csv_text::{is_blank, lines, number, separator, shortened, split};
use std::path::Path;

/// Beginnings of exports with several tracks or other axes, and whose they are.
const EXPORTS: [(&str, &str); 10] = [
    ("format version", "Motive (OptiTrack)"),
    ("no_of_frames", "Qualisys Track Manager"),
    ("trajectories", "Vicon Nexus"),
    ("model outputs", "Vicon Nexus"),
    ("segments", "Vicon Nexus"),
    ("joints", "Vicon Nexus"),
    ("devices", "Vicon Nexus"),
    ("objects", "Vicon Tracker"),
    ("pathfiletype", "Cortex or OpenSim (TRC)"),
    ("scorer", "DeepLabCut"),
];
const TIME_NAMES: [&str; 5] = ["time", "t", "timestamp", "unix_time", "unix_timestamp"];
/// Seconds or metres in one of each unit.
const TIME_UNITS: [(&str, f64); 8] = [
    ("s", 1.0),
    ("sec", 1.0),
    ("seconds", 1.0),
    ("", 1.0),
    ("ms", 1e-3),
    ("milliseconds", 1e-3),
    ("us", 1e-6),
    ("ns", 1e-9),
];
const LENGTH_UNITS: [(&str, f64); 9] = [
    ("m", 1.0),
    ("metres", 1.0),
    ("meters", 1.0),
    ("cm", 1e-2),
    ("mm", 1e-3),
    ("millimetres", 1e-3),
    ("millimeters", 1e-3),
    ("in", 0.0254),
    ("inches", 0.0254),
];

/// A column, and what its numbers are multiplied by.
#[derive(Debug, Clone, Copy)]
struct Column {
    place: usize,
    unit: f64,
}

impl Column {
    fn value(self, fields: &[&str], separator: char) -> Option<f64> {
        let value = number(fields.get(self.place)?, separator)?;
        // Metres and seconds stay as they are, to the bit.
        Some(if self.unit == 1.0 { value } else { value * self.unit })
    }
}

struct Columns {
    time: Column,
    x: Column,
    y: Column,
    z: Option<Column>,
}

/// Reads the sightings, rows without one left out.
pub(super) fn read(path: &Path, text: &str) -> Result<Vec<Point>, TrackerError> {
    let all = lines(text);
    let is_note = |line: &str| line.starts_with('#') || line.to_ascii_lowercase().starts_with("sep=");
    let has_data = |line: &str| !line.trim().is_empty() && !is_note(line);
    let Some(head) = all.iter().position(|line| has_data(line)) else { return Ok(Vec::new()) };
    let header = all[head];
    recognise(path, header)?;
    let separator = separator(header);
    let names = split(header, separator);
    let columns = Columns::of(path, &names)?;
    let ends_open = !text.ends_with(['\n', '\r']);
    let mut points = Vec::new();
    for (i, line) in all.iter().enumerate().skip(head + 1).filter(|(_, line)| has_data(line)) {
        let fields = split(line, separator);
        let is_whole =
            |field: &&str| !field.is_empty() && field.bytes().all(|b| b.is_ascii_digit() || b == b'-');
        if separator == ',' && fields.len() == 2 * names.len() && fields.iter().all(is_whole) {
            let (found, expected) = (fields.len(), names.len());
            return Err(TrackerError::DecimalCommas { path: path.to_owned(), line: i + 1, found, expected });
        }
        let value = |column: Column| column.value(&fields, separator);
        match [value(columns.time), value(columns.x), value(columns.y)] {
            [Some(time_s), Some(x_m), Some(y_m)] => {
                let z_m = columns.z.and_then(value);
                points.push(Point {
                    time_s,
                    x_m,
                    y_m,
                    z_m,
                    tilt_rad: None,
                    true_energy_j: None,
                    line: i + 1,
                });
            }
            // The tracker did not see the robot.
            [Some(_), _, _] if columns.is_lost(&fields, separator) => {}
            _ if fields.iter().all(|field| field.is_empty()) => {}
            // Its writer is not done with it.
            _ if ends_open && i + 1 == all.len() && fields.len() < names.len() => {}
            _ => {
                return Err(TrackerError::row(
                    path,
                    i + 1,
                    line,
                    "finite time_s, x_m and y_m, nor empty where the robot was not seen",
                ));
            }
        }
    }
    Ok(points)
}

/// Refuses the exports that are known not to be read.
fn recognise(path: &Path, header: &str) -> Result<(), TrackerError> {
    let begin = header.trim_start_matches('"').trim().to_ascii_lowercase();
    let known = EXPORTS.into_iter().find(|(text, _)| {
        let rest = begin.strip_prefix(text);
        rest.is_some_and(|rest| rest.is_empty() || rest.starts_with([',', ';', '\t', '"', ' ']))
    });
    known.map_or(Ok(()), |(_, program)| Err(TrackerError::Export { path: path.to_owned(), program }))
}

impl Columns {
    fn of(path: &Path, names: &[&str]) -> Result<Self, TrackerError> {
        let plain: Vec<String> = names.iter().map(|name| plain(name)).collect();
        let columns = || shortened(&names.join(", "));
        let missing =
            |column| TrackerError::MissingColumn { path: path.to_owned(), column, columns: columns() };
        let time =
            named(names, &plain, "time_s", &TIME_NAMES, &TIME_UNITS).ok_or_else(|| missing("time_s"))?;
        let length = |exact, base| named(names, &plain, exact, &[base], &LENGTH_UNITS);
        let position = |exact, base: &'static str| {
            length(exact, base).ok_or_else(|| match plain.iter().position(|name| name == base) {
                Some(place) => {
                    let column = names[place].to_owned();
                    TrackerError::NoUnit { path: path.to_owned(), column, columns: columns() }
                }
                None => missing(exact),
            })
        };
        Ok(Self { time, x: position("x_m", "x")?, y: position("y_m", "y")?, z: length("z_m", "z") })
    }

    /// Whether a row says that there is no position: blank cells, or none after the time.
    fn is_lost(&self, fields: &[&str], separator: char) -> bool {
        let is_blank_at = |column: Column| fields.get(column.place).is_none_or(|text| is_blank(text));
        let is_number_at = |column: Column| column.value(fields, separator).is_some();
        let is_cut = fields.len() <= self.x.place.max(self.y.place);
        let [x, y] = [self.x, self.y];
        (is_blank_at(x) || is_blank_at(y))
            && (is_blank_at(x) || is_number_at(x))
            && (is_blank_at(y) || is_number_at(y))
            // A row that ends after x was cut off; one that ends after the time was exported so.
            && !(is_cut && is_number_at(x))
    }
}

/// The column of exactly that name, else the first one of such a name and unit.
fn named(
    names: &[&str],
    plain: &[String],
    exact: &str,
    bases: &[&str],
    units: &[(&str, f64)],
) -> Option<Column> {
    if let Some(place) = names.iter().position(|name| *name == exact) {
        return Some(Column { place, unit: 1.0 });
    }
    plain.iter().enumerate().find_map(|(place, name)| {
        let rest = bases
            .iter()
            .find_map(|base| name.strip_prefix(base).filter(|r| r.is_empty() || r.starts_with('_')))?;
        let unit = rest.trim_start_matches('_');
        units.iter().find(|(of, _)| *of == unit).map(|(_, unit)| Column { place, unit: *unit })
    })
}

/// `X [mm]` and `x_mm` alike.
fn plain(name: &str) -> String {
    let parts = name.split(|c: char| !c.is_ascii_alphanumeric()).filter(|part| !part.is_empty());
    parts.collect::<Vec<_>>().join("_").to_ascii_lowercase()
}
