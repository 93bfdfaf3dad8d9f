//! The result of a trial, for people, for scripts and for the table.
//!
//! Does not depend on how the trial was walked.

use super::distance::Source;
use super::{Args, Failure, Gait, MeasureError, as_typed, failure, failure_with_help};
use crate::cli::Cause;
use crate::cli::explain::path_text;
use crate::cli::output;
use crate::device::tracker::Walked;
use crate::device::tracker::top_speed::TopSpeed;
use crate::device::trial::Trial;
use crate::device::trial::clock::Interval;
use crate::device::trial::measure_result::MeasureResult;
use crate::device::trial::table::Row;
use crate::energy::cost_of_transport;
use crate::run_folder;
use protocol::FRAME_RATE_HZ;
use std::path::Path;

/// A robot's clock this far from the host's scales energy and speed alike.
const CLOCK_WARNING: f64 = 0.01;

/// What is wrong with the sensor's leads, by an energy and a mean current that no supply gives.
pub fn wrong_leads(energy_j: f64, mean_current_a: Option<f64>, frames: u32) -> Option<MeasureError> {
    if frames == 0 {
        return None;
    }
    match mean_current_a {
        Some(current_a) if current_a < 0.0 => Some(MeasureError::Backwards),
        _ if energy_j <= 0.0 => Some(MeasureError::NoEnergy),
        _ => None,
    }
}

fn mean_current_a(trial: &Trial) -> Option<f64> {
    let walking = trial.samples.iter().map(|sample| sample.telemetry).filter(|t| t.trial_frames > 0);
    let currents: Vec<f64> = walking.map(|t| f64::from(t.current_ua) / 1e6).collect();
    (!currents.is_empty()).then(|| currents.iter().sum::<f64>() / currents.len() as f64)
}

/// A trial's row, and what the row does not hold.
pub struct Outcome<'a> {
    /// Goes into the table.
    pub row: Row,
    gait: &'a Gait,
    walked: Walked,
    frame_rate_hz: Option<f64>,
    /// Mean over the gait frames, by telemetry.
    mean_current_a: Option<f64>,
}

impl<'a> Outcome<'a> {
    /// From the robot's own counters, without a distance.
    pub fn of(trial: &Trial, gait: &'a Gait, mass_kg: f64) -> Self {
        let (energy_j, duration_s) = (trial.energy_j(), trial.duration_s());
        let row = Row {
            gait_name: gait.active.name.as_str().into(),
            gait_sha256: gait.sha256.clone(),
            gait_crc32: format!("{:08x}", gait.active.crc32),
            amplitude: as_typed(gait.amplitude),
            frames: trial.frames(),
            duration_s,
            energy_j,
            mean_power_w: (duration_s > 0.0).then(|| energy_j / duration_s),
            mass_kg,
            clipped_frames: trial.last().map_or(0, |t| t.clipped_frames),
            missed_samples: trial.last().map_or(0, |t| t.missed_samples),
            lost_telemetry_frames: trial.lost_frames(),
            ..Row::default()
        };
        let mean_current_a = mean_current_a(trial);
        Self { row, gait, walked: Walked::default(), frame_rate_hz: None, mean_current_a }
    }

    /// Adds the distance, the speed and the cost of transport; an error becomes the row's reason.
    pub fn add_distance(
        &mut self,
        source: &Source,
        interval: Option<Interval>,
        top: TopSpeed,
    ) -> Result<(), Failure> {
        self.frame_rate_hz = interval.map(|i| i.frame_rate_hz);
        self.row.distance_source = source.name();
        let walked = source.walked(interval, self.row.duration_s, top).inspect_err(|failure| {
            self.row.reason = Some(failure.report.to_string());
        })?;
        self.row.distance_m = Some(walked.distance_m);
        self.row.speed_m_s = Some(walked.distance_m / self.row.duration_s);
        self.walked = walked;
        if let Some(wrong) = wrong_leads(self.row.energy_j, self.mean_current_a, self.row.frames) {
            self.row.reason = Some(wrong.to_string());
            let help = "no other number of this trial is wrong; correct the leads and repeat it";
            return Err(failure_with_help(Cause::Robot, wrong, help));
        }
        let cost =
            cost_of_transport(self.row.energy_j, self.row.mass_kg, walked.distance_m).map_err(|e| {
                self.row.reason = Some(e.to_string());
                failure(Cause::Input, e)
            })?;
        self.row.cost_of_transport = Some(cost);
        Ok(())
    }

    /// Prints the trial; warnings go to standard error.
    pub fn print(&self, args: &Args, folder: &Path) {
        for warning in self.warnings() {
            eprintln!("warning: {warning}");
        }
        if args.json {
            output::print_json(&self.result(folder));
        } else {
            self.print_words(folder);
        }
    }

    fn warnings(&self) -> Vec<String> {
        let row = &self.row;
        let mut warnings = Vec::new();
        let percent = |count: f64| 100.0 * count / f64::from(row.frames.max(1));
        if row.missed_samples > 0 {
            warnings.push(format!(
                "{} of {} power samples failed or saturated ({:.1} %); the preceding sample was used instead",
                row.missed_samples,
                row.frames,
                percent(row.missed_samples.into())
            ));
        }
        if row.clipped_frames > 0 {
            warnings.push(format!(
                "a joint was held at its limit in {} of {} frames ({:.1} %)",
                row.clipped_frames,
                row.frames,
                percent(row.clipped_frames.into())
            ));
        }
        let rate = f64::from(FRAME_RATE_HZ);
        if let Some(measured) = self.frame_rate_hz.filter(|hz| (hz / rate - 1.0).abs() > CLOCK_WARNING) {
            warnings.push(format!(
                "the robot plays {measured:.2} frames a second by this computer's clock, not {FRAME_RATE_HZ}: \
                 energy, power and speed go by the robot's"
            ));
        }
        warnings
    }

    fn print_words(&self, folder: &Path) {
        let row = &self.row;
        println!(
            "gait \"{}\" (CRC {}) at {}x, {} frames in {:.2} s",
            row.gait_name, row.gait_crc32, row.amplitude, row.frames, row.duration_s
        );
        println!("energy             {:8.3} J", row.energy_j);
        if let Some(true_energy_j) = self.walked.true_energy_j {
            println!("  by the battery   {true_energy_j:8.3} J");
        }
        let figures = [
            ("mean power", row.mean_power_w, "W"),
            ("distance", row.distance_m, "m"),
            ("speed", row.speed_m_s, "m/s"),
            ("mass", Some(row.mass_kg), "kg"),
            ("cost of transport", row.cost_of_transport, ""),
        ];
        for (name, value, unit) in figures {
            match value {
                Some(value) => println!("{name:18} {value:8.3} {unit}"),
                None => println!("{name:18}  unknown"),
            }
        }
        if let Some(reason) = &row.reason {
            println!("not valid: {reason}");
        }
        if let Some(remark) = &row.remark {
            println!("remark: the robot was {remark}");
        }
        if row.lost_telemetry_frames > 0 {
            println!(
                "telemetry of {} frames was lost; the robot's own sums are whole",
                row.lost_telemetry_frames
            );
        }
        println!(
            "noted in {} and {}",
            folder.join(run_folder::TRIALS).display(),
            folder.join(&row.telemetry).display()
        );
    }

    fn result(&self, folder: &Path) -> MeasureResult {
        let row = self.row.clone();
        MeasureResult {
            valid: row.reason.is_none(),
            reason: row.reason,
            remark: row.remark,
            gait_name: row.gait_name,
            gait_sha256: row.gait_sha256,
            gait_crc32: row.gait_crc32,
            gait_source: self.gait.source(folder).map(str::to_owned),
            amplitude: row.amplitude,
            frames_played: row.frames,
            duration_s: row.duration_s,
            energy_j: row.energy_j,
            true_energy_j: self.walked.true_energy_j,
            displacement_m: self.walked.displacement_m,
            max_tilt_rad: self.walked.max_tilt_rad,
            mean_power_w: row.mean_power_w,
            distance_m: row.distance_m,
            distance_source: row.distance_source,
            speed_m_s: row.speed_m_s,
            mass_kg: row.mass_kg,
            cost_of_transport: row.cost_of_transport,
            clipped_frames: row.clipped_frames,
            missed_samples: row.missed_samples,
            lost_telemetry_frames: row.lost_telemetry_frames,
            frame_rate_hz: self.frame_rate_hz,
            trials: path_text(&folder.join(run_folder::TRIALS)),
            telemetry: path_text(&folder.join(&row.telemetry)),
        }
    }
}
