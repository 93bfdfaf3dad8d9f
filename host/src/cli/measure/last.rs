//! The last walk as the robot remembers it, even through power-off.
//!
//! For a walk without a cable. Does not depend on a trials table: nothing is written.

use super::{Args, Failure, failure, failure_with_help, mass_kg, unreachable_robot};
use crate::cli::Cause;
use crate::device::link::words;
use crate::energy::{EnergyError, cost_of_transport};
use crate::gait::gait_file::limits::as_typed;
use crate::run_folder;
use protocol::command::Record;
use protocol::{FRAME_RATE_HZ, Name, TrialRecord, WalkEnd};
use serde_json::json;
use std::path::Path;
use thiserror::Error;

#[derive(Debug, Error)]
enum NoTrial {
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
    let cost = args.distance.map(|m| cost_of_transport(energy_j, figures.mass_kg, m)).transpose();
    let cost = cost.map_err(|e: EnergyError| failure(Cause::Input, e))?;
    if args.json {
        figures.print_json(args.distance, cost);
    } else {
        figures.print_words(args.distance, cost);
    }
    Ok(())
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
            println!("For its cost of transport: --distance M");
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
