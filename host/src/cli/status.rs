//! `host status`: shows the robot's state in plain words, and clears a fault.
//!
//! Holds the layout and the codes for scripts. Does not depend on how the robot came
//! into its state.

use super::Failure;
use super::reach::{Port, unreachable_robot};
use crate::device::link::words;
use crate::gait::gait_file::limits::as_typed;
use protocol::command::{ActiveGait, CalibrationSource, Storage};
use protocol::{Command, FRAME_RATE_HZ, Fault, HelloReply, ResetCause, State, Status};
use serde_json::{Value, json};

/// Show the robot's state; clear a fault.
///
/// A fault stays latched, with the servos limp, until --clear-fault is given
/// and its cause is gone.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    port: Port,
    /// Clear a fault, if its cause is gone
    #[arg(long)]
    clear_fault: bool,
    /// Print the status as JSON
    #[arg(long)]
    json: bool,
}

/// The robot's status, and what this side of the link adds to it.
struct StatusReport<'a> {
    port: &'a str,
    hello: Option<&'a HelloReply>,
    status: Status,
    link_bad_frames: u64,
}

pub fn run(args: Args) -> Result<(), Failure> {
    let mut link = args.port.connect()?;
    if args.clear_fault {
        link.order(Command::ClearFault).map_err(unreachable_robot)?;
    }
    let status = link.status().map_err(unreachable_robot)?;
    let report =
        StatusReport { port: link.name(), hello: link.hello(), status, link_bad_frames: link.bad_frames() };
    if args.json {
        println!("{:#}", report.to_json());
    } else {
        report.print();
    }
    Ok(())
}

const fn fault_of(state: State) -> Option<Fault> {
    match state {
        State::Fault(fault) => Some(fault),
        _ => None,
    }
}

fn gait_words(gait: &ActiveGait, storage: Storage) -> String {
    let name = gait.name.as_str();
    let amplitude = as_typed(gait.amplitude);
    format!("\"{name}\" (CRC {:08x}) at {amplitude}x, {}", gait.crc32, words::storage(storage))
}

fn plural(count: u64, one: &str, many: &str) -> String {
    format!("{count} {}", if count == 1 { one } else { many })
}

impl StatusReport<'_> {
    fn uptime_s(&self) -> f64 {
        f64::from(self.status.uptime_frames) / f64::from(FRAME_RATE_HZ)
    }

    fn firmware(&self) -> String {
        let [major, minor, patch] = self.hello.map_or([0; 3], |hello| hello.firmware_version);
        format!("{major}.{minor}.{patch}")
    }

    fn print(&self) {
        let status = &self.status;
        println!("the robot on {}, firmware {}", self.port, self.firmware());
        let line = |name: &str, text: &str| println!("{name:12} {text}");
        line("state", words::state_in_full(status.state));
        if let Some(fault) = fault_of(status.state) {
            line("fault", &format!("{}: {}", words::fault_code(fault), words::fault(fault)));
            line("what to do", &format!("{}, {}", words::fault_help(fault), words::CLEAR_FAULT));
        }
        match &status.gait {
            Some(gait) => line("gait", &gait_words(gait, status.storage)),
            None => line("gait", "none; upload one: host upload-gait --amp 2.2"),
        }
        line("calibration", words::calibration_source(status.calibration));
        line("supply", &format!("{:.2} V", f64::from(status.bus_mv) / 1e3));
        line("running for", &format!("{:.1} s", self.uptime_s()));
        line("started", words::reset_cause(status.reset_cause));
        line("memory", &format!("{} bytes of stack were never used", status.stack_left));
        let errors = plural(status.bus_errors.into(), "failed transfer", "failed transfers");
        line("I2C bus", &errors);
        let damaged = |count| plural(count, "damaged frame", "damaged frames");
        line(
            "link",
            &format!(
                "the robot got {} and lost {}, this computer got {}",
                damaged(status.bad_frames.into()),
                plural(status.dropped_bytes.into(), "byte", "bytes"),
                damaged(self.link_bad_frames),
            ),
        );
    }

    fn to_json(&self) -> Value {
        let status = &self.status;
        let fault = fault_of(status.state).map(|fault| {
            json!({
                "code": words::fault_code(fault),
                "text": words::fault(fault),
                "help": words::fault_help(fault),
            })
        });
        let gait = status.gait.map(|gait| {
            json!({
                "name": gait.name.as_str(),
                "crc32": format!("{:08x}", gait.crc32),
                "amplitude": as_typed(gait.amplitude),
                "storage": storage_code(status.storage),
            })
        });
        json!({
            "port": self.port,
            "firmware_version": self.firmware(),
            "protocol_version": protocol::PROTOCOL_VERSION,
            "state": words::state(status.state),
            "fault": fault,
            "gait": gait,
            "calibration": calibration_code(status.calibration),
            "supply_v": f64::from(status.bus_mv) / 1e3,
            "uptime_s": self.uptime_s(),
            "reset_cause": reset_code(status.reset_cause),
            "stack_left_bytes": status.stack_left,
            "bus_errors": status.bus_errors,
            "bad_frames": status.bad_frames,
            "dropped_bytes": status.dropped_bytes,
            "link_bad_frames": self.link_bad_frames,
        })
    }
}

const fn storage_code(storage: Storage) -> &'static str {
    match storage {
        Storage::RamOnly => "ram-only",
        Storage::Saving => "saving",
        Storage::Saved => "saved",
        Storage::Failed => "failed",
    }
}

const fn calibration_code(source: CalibrationSource) -> &'static str {
    match source {
        CalibrationSource::Default => "default",
        CalibrationSource::Stored => "stored",
        CalibrationSource::NotSaved => "not-saved",
        CalibrationSource::Damaged => "damaged",
    }
}

const fn reset_code(cause: ResetCause) -> &'static str {
    match cause {
        ResetCause::PowerOn => "power-on",
        ResetCause::External => "external",
        ResetCause::BrownOut => "brown-out",
        ResetCause::Watchdog => "watchdog",
        ResetCause::Unknown => "unknown",
    }
}
