//! The trials table and the telemetry files of a run.
//!
//! Holds their columns. A table with other columns is an error, which [`load`] finds
//! before the robot walks. Does not depend on how a trial was walked.

use crate::device::link::words;
use crate::device::session::Sample;
use crate::run_folder::{self, FileError};
use protocol::{State, Telemetry};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Columns of `trials.csv`.
pub const TRIAL_COLUMNS: &str = "time,gait_name,gait_sha256,gait_crc32,amplitude,frames,duration_s,energy_j,\
mean_power_w,distance_m,speed_m_s,mass_kg,cost_of_transport,distance_source,clipped_frames,missed_samples,\
lost_telemetry_frames,telemetry,valid,reason,remark";
/// Columns without `remark`, which tables of an older release have.
const OLDER_COLUMNS: &str = "time,gait_name,gait_sha256,gait_crc32,amplitude,frames,duration_s,energy_j,\
mean_power_w,distance_m,speed_m_s,mass_kg,cost_of_transport,distance_source,clipped_frames,missed_samples,\
lost_telemetry_frames,telemetry,valid,reason";
/// Columns of `telemetry-<n>.csv`.
const TELEMETRY_COLUMNS: &str = "unix_time_s,uptime_frames,state,trial_frames,trial_energy_j,phase,bus_v,current_a,\
clipped_frames,missed_samples";

/// One trial; an unknown value stays empty.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Row {
    /// Local time of the end of the trial.
    pub time: String,
    /// The gait's name on the robot.
    pub gait_name: String,
    /// SHA-256 of the table that the robot read back.
    pub gait_sha256: String,
    /// CRC-32 of the same table.
    pub gait_crc32: String,
    /// Amplitude played.
    pub amplitude: f64,
    /// Gait frames played.
    pub frames: u32,
    /// Of those frames, by the robot's clock.
    pub duration_s: f64,
    /// From the battery, by the robot's own sensor.
    pub energy_j: f64,
    /// Energy divided by duration.
    pub mean_power_w: Option<f64>,
    /// Net horizontal displacement.
    pub distance_m: Option<f64>,
    /// Distance divided by duration.
    pub speed_m_s: Option<f64>,
    /// Of the robot.
    pub mass_kg: f64,
    /// Energy by weight and distance.
    pub cost_of_transport: Option<f64>,
    /// `flag`, `prompt`, or the tracker's file.
    pub distance_source: String,
    /// Gait frames with a joint held at its limit.
    pub clipped_frames: u32,
    /// Sensor conversions that failed or saturated.
    pub missed_samples: u16,
    /// Telemetry that did not arrive.
    pub lost_telemetry_frames: u32,
    /// Name of the file in the same folder.
    pub telemetry: String,
    /// Why the trial does not count, if it does not.
    pub reason: Option<String>,
    /// What to know of the trial, such as that the robot's calibration was another.
    pub remark: Option<String>,
}

/// Why a table was not written.
#[derive(Debug, Error)]
// The messages say what each field is.
#[allow(missing_docs)]
pub enum TableError {
    /// Reading or writing failed.
    #[error(transparent)]
    File(#[from] FileError),
    /// The file is another table.
    #[error("{path} has other columns: it begins with {found:?}")]
    Columns { path: PathBuf, found: String },
}

/// The table as it is, or its header if there is none yet.
///
/// # Errors
/// [`TableError`] if no row could be added.
pub fn load(folder: &Path) -> Result<String, TableError> {
    let path = folder.join(run_folder::TRIALS);
    match std::fs::read_to_string(&path) {
        Ok(text) => {
            let found = text.lines().next().unwrap_or("");
            if found == TRIAL_COLUMNS {
                return Ok(text);
            }
            if found == OLDER_COLUMNS {
                return Ok(with_remarks(&text));
            }
            Err(TableError::Columns { path, found: found.chars().take(60).collect() })
        }
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(format!("{TRIAL_COLUMNS}\n")),
        Err(error) => Err(FileError::on("read", &path)(error).into()),
    }
}

/// A table of an older release, with an empty remark in each row.
fn with_remarks(text: &str) -> String {
    let rows = text.trim_end_matches(['\n', '\r']).get(OLDER_COLUMNS.len()..).unwrap_or_default();
    let mut table = TRIAL_COLUMNS.to_owned();
    let (mut is_quoted, mut is_header) = (false, true);
    for c in rows.chars().chain(['\n']) {
        is_quoted ^= c == '"';
        if c == '\n' && !is_quoted {
            // The header has its new column already.
            table += if is_header { "" } else { "," };
            is_header = false;
        }
        if c != '\r' || is_quoted {
            table.push(c);
        }
    }
    table
}

/// Adds a row to the folder's table.
///
/// # Errors
/// [`TableError`], the table being as it was.
pub fn append(folder: &Path, row: &Row) -> Result<PathBuf, TableError> {
    let mut text = load(folder)?;
    if !text.ends_with('\n') {
        text.push('\n');
    }
    let known = |value: Option<f64>| value.map_or(String::new(), |v| format!("{v:.6}"));
    let fields = [
        row.time.clone(),
        quoted(&row.gait_name),
        row.gait_sha256.clone(),
        row.gait_crc32.clone(),
        format!("{}", row.amplitude),
        row.frames.to_string(),
        format!("{:.4}", row.duration_s),
        format!("{:.6}", row.energy_j),
        known(row.mean_power_w),
        known(row.distance_m),
        known(row.speed_m_s),
        format!("{}", row.mass_kg),
        known(row.cost_of_transport),
        quoted(&row.distance_source),
        row.clipped_frames.to_string(),
        row.missed_samples.to_string(),
        row.lost_telemetry_frames.to_string(),
        quoted(&row.telemetry),
        row.reason.is_none().to_string(),
        quoted(row.reason.as_deref().unwrap_or("")),
        quoted(row.remark.as_deref().unwrap_or("")),
    ];
    text.push_str(&fields.join(","));
    text.push('\n');
    let path = folder.join(run_folder::TRIALS);
    run_folder::write(&path, text.as_bytes())?;
    Ok(path)
}

/// CSV's quoting, where a value needs it.
fn quoted(text: &str) -> String {
    if text.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", text.replace('"', "\"\""))
    } else {
        text.into()
    }
}

/// Writes the samples to the first free `telemetry-<n>.csv`.
///
/// # Errors
/// [`FileError`].
pub fn write_telemetry(folder: &Path, samples: &[Sample]) -> Result<PathBuf, FileError> {
    let mut text = format!("{TELEMETRY_COLUMNS}\n");
    for Sample { unix_time_s, telemetry: t } in samples {
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "{unix_time_s:.6},{},{},{},{:.6},{:.6},{:.3},{:.6},{},{}",
            t.uptime_frames,
            words::state(t.state),
            t.trial_frames,
            t.trial_energy_uj as f64 / 1e6,
            f64::from(t.phase) / 65536.0,
            f64::from(t.bus_mv) / 1e3,
            f64::from(t.current_ua) / 1e6,
            t.clipped_frames,
            t.missed_samples
        );
    }
    let mut number = 1;
    let path = loop {
        let path = folder.join(format!("telemetry-{number}.csv"));
        if !path.exists() {
            break path;
        }
        number += 1;
    };
    run_folder::write(&path, text.as_bytes())?;
    Ok(path)
}

/// The times of the latest noted trial of a gait with so many frames: for a tracker's
/// file that is read later. `None` if the folder has no such trial, or not its telemetry.
#[must_use]
pub fn telemetry_of(folder: &Path, gait_crc32: &str, frames: u32) -> Option<Vec<Sample>> {
    let field = |row: &csv::StringRecord, columns: &str, name: &str| {
        columns
            .split(',')
            .position(|column| column == name)
            .and_then(|place| row.get(place).map(str::to_owned))
    };
    let rows = |path: PathBuf| -> Option<Vec<csv::StringRecord>> {
        csv::Reader::from_path(path).ok()?.into_records().collect::<Result<_, _>>().ok()
    };
    let is_it = |row: &csv::StringRecord| {
        field(row, TRIAL_COLUMNS, "gait_crc32").as_deref() == Some(gait_crc32)
            && field(row, TRIAL_COLUMNS, "frames") == Some(frames.to_string())
    };
    let trial = rows(folder.join(run_folder::TRIALS))?.into_iter().rev().find(is_it)?;
    let telemetry = rows(folder.join(field(&trial, TRIAL_COLUMNS, "telemetry")?))?;
    let sample = |row: &csv::StringRecord| {
        let number = |name: &str| field(row, TELEMETRY_COLUMNS, name)?.parse::<u32>().ok();
        let telemetry = Telemetry {
            uptime_frames: number("uptime_frames")?,
            state: State::Walking,
            trial_frames: number("trial_frames")?,
            trial_energy_uj: 0,
            clipped_frames: 0,
            phase: 0,
            bus_mv: 0,
            current_ua: 0,
            missed_samples: 0,
        };
        Some(Sample { unix_time_s: field(row, TELEMETRY_COLUMNS, "unix_time_s")?.parse().ok()?, telemetry })
    };
    telemetry.iter().map(sample).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_added_below_one_header() {
        let folder = tempfile::tempdir().unwrap();
        let row = Row { gait_name: "a,b".into(), frames: 720, distance_m: Some(1.5), ..Default::default() };

        append(folder.path(), &row).unwrap();
        append(folder.path(), &Row { reason: Some("fault".into()), ..row }).unwrap();

        let text = std::fs::read_to_string(folder.path().join("trials.csv")).unwrap();
        let mut reader = csv::Reader::from_reader(text.as_bytes());
        let headers = reader.headers().unwrap().clone();
        let rows: Vec<_> = reader.records().map(Result::unwrap).collect();
        let place = |name: &str| headers.iter().position(|h| h == name).unwrap();
        assert_eq!(rows.len(), 2);
        assert_eq!(&rows[0][place("gait_name")], "a,b");
        assert_eq!(&rows[0][place("distance_m")], "1.500000");
        assert_eq!((&rows[0][place("valid")], &rows[1][place("valid")]), ("true", "false"));
        assert_eq!(&rows[1][place("reason")], "fault");
    }

    #[test]
    fn a_table_of_an_older_release_gets_the_column_that_it_lacks() {
        let folder = tempfile::tempdir().unwrap();
        let old = format!("{OLDER_COLUMNS}\n{}\"two\nlines\"\n{}\n", "1,".repeat(19), "2,".repeat(19));
        std::fs::write(folder.path().join("trials.csv"), old).unwrap();

        append(folder.path(), &Row { remark: Some("calibrated otherwise".into()), ..Row::default() })
            .unwrap();

        let text = std::fs::read_to_string(folder.path().join("trials.csv")).unwrap();
        let rows: Vec<_> = csv::Reader::from_reader(text.as_bytes()).records().map(Result::unwrap).collect();
        assert_eq!(rows.len(), 3);
        assert_eq!((&rows[0][19], &rows[0][20], &rows[2][20]), ("two\nlines", "", "calibrated otherwise"));
    }

    #[test]
    fn a_table_with_other_columns_is_left_alone() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("trials.csv"), "a,b\n1,2\n").unwrap();

        let error = append(folder.path(), &Row::default()).unwrap_err().to_string();

        assert!(error.contains("has other columns: it begins with \"a,b\""), "{error}");
        assert_eq!(std::fs::read_to_string(folder.path().join("trials.csv")).unwrap(), "a,b\n1,2\n");
    }

    #[test]
    fn telemetry_files_are_never_overwritten() {
        let folder = tempfile::tempdir().unwrap();

        let first = write_telemetry(folder.path(), &[]).unwrap();
        let second = write_telemetry(folder.path(), &[]).unwrap();

        assert_ne!(first, second);
    }
}
