//! The last walk as the robot remembers it, even through power-off.
//!
//! For a walk without a cable. Does not depend on a trials table: nothing is written.

use super::distance::{self, Source};
use super::{Args, Failure, failure, failure_with_help, mass_kg, report, unreachable_robot};
use crate::cli::Cause;
use crate::device::link::words;
use crate::device::tracker::{Epoch, Track};
use crate::device::trial::clock::{self, Interval};
use crate::device::trial::table;
use crate::energy::{EnergyError, cost_of_transport};
use crate::gait::gait_file::limits::as_typed;
use crate::run_folder;
use protocol::command::Record;
use protocol::{FRAME_RATE_HZ, Name, TrialRecord, WalkEnd};
use serde_json::json;
use std::path::{Path, PathBuf};
use thiserror::Error;

#[derive(Debug, Error)]
enum NoTrial {
    #[error("{} has no telemetry of the robot's last walk, so its Unix time is unknown", .folder.display())]
    UnknownTime { folder: PathBuf },
    #[error("the robot remembers no walk")]
    Nothing,
    #[error("the robot's record of its last walk is damaged ({len} bytes)")]
    Damaged { len: usize },
}

/// The walk, and what follows from it.
struct Figures {
    trial: TrialRecord,
    gait: String,
    duration_s: f64,
    energy_j: f64,
    mean_power_w: Option<f64>,
    mass_kg: f64,
}

pub fn run(args: &Args) -> Result<(), Failure> {
    let mut link = args.port.connect()?;
    let bytes = link.read(Record::LastTrial).map_err(unreachable_robot)?;
    let active = link.status().map_err(unreachable_robot)?.gait;
    drop(link);
    if bytes.is_empty() {
        let help = "let it walk first: host walk --detached --for 60";
        return Err(failure_with_help(Cause::Robot, NoTrial::Nothing, help));
    }
    let trial = TrialRecord::from_bytes(&bytes)
        .ok_or_else(|| failure(Cause::Robot, NoTrial::Damaged { len: bytes.len() }))?;
    let name = active.filter(|gait| gait.crc32 == trial.gait_crc32).map(|gait| gait.name);
    let folder = args.out.as_deref().unwrap_or(Path::new(run_folder::LATEST));
    let duration_s = f64::from(trial.frames) / f64::from(FRAME_RATE_HZ);
    let energy_j = trial.energy_uj as f64 / 1e6;
    let figures = Figures {
        gait: gait_words(&trial, name),
        duration_s,
        energy_j,
        mean_power_w: (trial.frames > 0).then(|| energy_j / duration_s),
        mass_kg: mass_kg(args, folder)?,
        trial,
    };
    let distance_m = figures.distance_m(args, folder)?;
    let wrong = report::wrong_leads(energy_j, None, figures.trial.frames);
    let cost = distance_m.filter(|_| wrong.is_none());
    let cost = cost.map(|m| cost_of_transport(energy_j, figures.mass_kg, m)).transpose();
    let cost = cost.map_err(|e: EnergyError| failure(Cause::Input, e))?;
    if args.json {
        figures.print_json(distance_m, cost);
    } else {
        figures.print_words(distance_m, cost);
    }
    wrong.map_or(Ok(()), |wrong| Err(failure(Cause::Robot, wrong)))
}

fn gait_words(trial: &TrialRecord, name: Option<Name>) -> String {
    let amplitude = as_typed(trial.amplitude);
    match (trial.gait_crc32, name) {
        (0, _) => "setpoints from a computer".into(),
        (crc32, Some(name)) => format!("gait \"{}\" (CRC {crc32:08x}) at {amplitude}x", name.as_str()),
        (crc32, None) => {
            format!("a gait that is not active any more (CRC {crc32:08x}) at {amplitude}x")
        }
    }
}

impl Figures {
    /// As typed, or by a tracker.
    fn distance_m(&self, args: &Args, folder: &Path) -> Result<Option<f64>, Failure> {
        let top = super::top_speed(args, folder);
        if let Some(path) = &args.tracker {
            let found =
                table::telemetry_of(folder, &format!("{:08x}", self.trial.gait_crc32), self.trial.frames);
            let interval = found.and_then(|samples| clock::interval(&samples));
            let is_unix = Track::check(path).is_ok_and(|epoch| epoch == Some(Epoch::Unix));
            let interval = match interval {
                None if is_unix => {
                    let error = NoTrial::UnknownTime { folder: folder.to_owned() };
                    let help = "name the folder with its telemetry: --out DIR; or write times that count from \
                                the first gait frame";
                    return Err(failure_with_help(Cause::Input, error, help));
                }
                // Counted from the first gait frame.
                None => Interval {
                    start_unix_s: 0.0,
                    end_unix_s: self.duration_s,
                    frame_rate_hz: f64::from(FRAME_RATE_HZ),
                },
                Some(interval) => interval,
            };
            return distance::look_up(path, interval, top).map(|walked| Some(walked.distance_m));
        }
        match args.distance {
            Some(distance_m) => {
                let walked = Source::Flag(distance_m).walked(None, self.duration_s, top)?;
                Ok(Some(walked.distance_m))
            }
            None => Ok(None),
        }
    }

    fn speed_m_s(&self, distance_m: Option<f64>) -> Option<f64> {
        distance_m.filter(|_| self.duration_s > 0.0).map(|m| m / self.duration_s)
    }

    fn print_words(&self, distance_m: Option<f64>, cost: Option<f64>) {
        let trial = &self.trial;
        println!("{}, {} frames in {:.2} s", self.gait, trial.frames, self.duration_s);
        println!("it ended because {}", words::walk_end(trial.end));
        let figures = [
            ("energy", Some(self.energy_j), "J"),
            ("mean power", self.mean_power_w, "W"),
            ("distance", distance_m, "m"),
            ("speed", self.speed_m_s(distance_m), "m/s"),
            ("mass", distance_m.map(|_| self.mass_kg), "kg"),
            ("cost of transport", cost, ""),
        ];
        for (name, value, unit) in figures {
            if let Some(value) = value {
                println!("{name:18} {value:8.3} {unit}");
            }
        }
        if trial.clipped_frames > 0 {
            println!("a joint was held at its limit in {} frames", trial.clipped_frames);
        }
        if trial.missed_samples > 0 {
            println!("{} power samples failed; the preceding one was used instead", trial.missed_samples);
        }
        if distance_m.is_none() && trial.frames > 0 {
            println!("For its cost of transport: --distance M, or --tracker FILE");
        }
    }

    fn print_json(&self, distance_m: Option<f64>, cost: Option<f64>) {
        let trial = &self.trial;
        let fault = match trial.end {
            WalkEnd::Fault(fault) => Some(words::fault_code(fault)),
            _ => None,
        };
        let result = json!({
            "gait": self.gait,
            "gait_crc32": format!("{:08x}", trial.gait_crc32),
            "amplitude": as_typed(trial.amplitude),
            "ended": words::walk_end_code(trial.end),
            "fault": fault,
            "frames_played": trial.frames,
            "duration_s": self.duration_s,
            "energy_j": self.energy_j,
            "mean_power_w": self.mean_power_w,
            "distance_m": distance_m,
            "speed_m_s": self.speed_m_s(distance_m),
            "mass_kg": self.mass_kg,
            "cost_of_transport": cost,
            "clipped_frames": trial.clipped_frames,
            "missed_samples": trial.missed_samples,
        });
        println!("{result:#}");
    }
}
