//! What can go wrong between host and robot.

use super::words;
use protocol::{PROTOCOL_VERSION, Refusal, ResetCause};
use thiserror::Error;

/// Why the robot could not be talked to.
#[derive(Debug, Error)]
pub enum LinkError {
    /// There is no robot's port.
    #[error("no robot found: {}", words::others(.others))]
    NoPort {
        /// Serial ports that are there, but are no robot's.
        others: Vec<String>,
    },
    /// There is more than one.
    #[error("{} ports could be the robot: {}", .ports.len(), .ports.join(", "))]
    SeveralPorts {
        /// All of them.
        ports: Vec<String>,
    },
    /// The ports could not be listed.
    #[error("cannot list the serial ports")]
    List {
        /// Why.
        source: serialport::Error,
    },
    /// The port could not be opened.
    #[error("cannot open {port}")]
    Open {
        /// Which.
        port: String,
        /// Why.
        source: serialport::Error,
    },
    /// Nobody said hello.
    #[error(
        "no robot answers on {port}: no hello within {waited_s} s, {}",
        words::silence(*.bytes_heard)
    )]
    NoAnswer {
        /// Which.
        port: String,
        /// How long.
        waited_s: f64,
        /// Bytes that arrived meanwhile and meant nothing.
        bytes_heard: u64,
    },
    /// The robot speaks another version.
    #[error(
        "the robot on {port} speaks protocol version {robot}, this program version {PROTOCOL_VERSION}; \
         nothing was sent to it"
    )]
    ProtocolVersion {
        /// Which.
        port: String,
        /// The robot's version.
        robot: u8,
    },
    /// The cable was pulled, or the adapter failed.
    #[error("the link broke: cannot {action} {port} any more")]
    Broken {
        /// Which.
        port: String,
        /// What was being done.
        action: &'static str,
        /// Why it could not be.
        source: std::io::Error,
    },
    /// A command was never answered.
    #[error("the robot on {port} fell silent: no answer to \"{command}\", sent {attempts} times")]
    NoReply {
        /// Which.
        port: String,
        /// Which command.
        command: &'static str,
        /// How often it was sent.
        attempts: u32,
    },
    /// The robot started anew in mid-session.
    #[error("the robot on {port} was reset: {}", words::reset_cause(*.cause))]
    Reset {
        /// Which.
        port: String,
        /// Why.
        cause: ResetCause,
    },
    /// The robot said no.
    #[error("the robot refused to {command}: {}", words::refusal(*.refusal))]
    Refused {
        /// Which command.
        command: &'static str,
        /// Why.
        refusal: Refusal,
    },
    /// An answer that belongs to another command.
    #[error("the robot's answer to \"{command}\" belongs to another command: its firmware is at fault")]
    WrongReply {
        /// Which command.
        command: &'static str,
    },
}

impl LinkError {
    /// Whether the robot spoke: it refused or stopped, the link is fine.
    #[must_use]
    pub const fn is_robots_word(&self) -> bool {
        matches!(
            self,
            Self::ProtocolVersion { .. }
                | Self::Refused { .. }
                | Self::Reset { .. }
                | Self::WrongReply { .. }
        )
    }

    /// The user's next move.
    #[must_use]
    pub fn help(&self) -> Option<String> {
        let help = match self {
            Self::NoPort { .. } => {
                "plug the robot in; or name its port: --port /dev/ttyUSB0. \
                 Without a robot, start target/debug/virtual-robot and pass the port that it prints"
            }
            Self::SeveralPorts { ports } => {
                let first = ports.first().map_or("PORT", |p| p.split(' ').next().unwrap_or("PORT"));
                return Some(format!("say which one: --port {first}"));
            }
            Self::Open { port, source } => return Some(open_help(port, source)),
            Self::NoAnswer { bytes_heard: 0, .. } => {
                "is this the robot's port, is it powered, and was its firmware flashed (cargo run --release in firmware/)?"
            }
            Self::NoAnswer { .. } => {
                "another program runs on this board, or it is another device: flash the firmware \
                 (cargo run --release in firmware/), or see --port"
            }
            Self::ProtocolVersion { robot, .. } if *robot < PROTOCOL_VERSION => {
                "flash this checkout's firmware: cargo run --release in firmware/"
            }
            Self::ProtocolVersion { .. } => "update this program to the version of the robot's firmware",
            Self::Broken { .. } => "check the cable and repeat the command",
            Self::NoReply { .. } => "check cable and supply, and repeat the command",
            Self::Reset { .. } => {
                "servo power must not come through the Nano: check supply and common ground, then repeat"
            }
            Self::Refused { refusal, .. } => return words::refusal_help(*refusal),
            Self::List { .. } | Self::WrongReply { .. } => return None,
        };
        Some(help.to_owned())
    }
}

fn open_help(port: &str, source: &serialport::Error) -> String {
    use serialport::ErrorKind;
    use std::io::ErrorKind as Io;
    match source.kind() {
        ErrorKind::Io(Io::PermissionDenied) => {
            "your user may not use serial ports: sudo usermod -aG dialout $USER, then log in again".to_owned()
        }
        ErrorKind::Io(Io::NotFound) => {
            "see what is there: ls /dev/ttyUSB* /dev/ttyACM*; without --port the robot is looked for"
                .to_owned()
        }
        ErrorKind::NoDevice => format!("does another program hold it? lsof {port} tells"),
        _ => format!("is {port} a serial port?"),
    }
}
