//! What can go wrong between host and robot.

use super::words;
use protocol::{PROTOCOL_VERSION, Refusal, ResetCause};
use thiserror::Error;

/// Why the robot could not be talked to.
#[derive(Debug, Error)]
// The messages say what each field is.
#[allow(missing_docs)]
pub enum LinkError {
    /// No serial port is a Nano's.
    #[error("no robot found: {}", words::others(.others))]
    NoPort {
        /// Serial ports of other devices.
        others: Vec<String>,
        /// The one USB adapter among them, with its USB ID, if there is exactly one.
        likely: Option<(String, String)>,
    },
    /// More than one serial port could be the robot's.
    #[error("{} ports could be the robot: {}", .ports.len(), .ports.join(", "))]
    SeveralPorts {
        /// Each with its adapter.
        ports: Vec<String>,
    },
    /// The ports could not be listed.
    #[error("cannot list the serial ports")]
    List { source: serialport::Error },
    /// Another program has locked the port.
    #[error("another program is using the robot on {port}: most likely another host command")]
    Busy { port: String },
    /// The port could not be opened.
    #[error("cannot open {port}")]
    Open { port: String, source: serialport::Error },
    /// The robot did not say hello.
    #[error(
        "no robot answers on {port}: no hello within {waited_s} s, {}{}",
        words::silence(*.bytes_heard), words::other_reader(.port, .other.as_deref())
    )]
    NoAnswer {
        port: String,
        waited_s: f64,
        /// Bytes that arrived meanwhile and were no message.
        bytes_heard: u64,
        /// Another program that reads the port.
        other: Option<String>,
    },
    /// The robot's firmware has another version of the protocol.
    #[error(
        "the robot on {port} speaks protocol version {robot}, this program version {PROTOCOL_VERSION}; \
         nothing was sent to it"
    )]
    ProtocolVersion { port: String, robot: u8 },
    /// The cable was pulled, or the adapter failed.
    #[error("the link broke: cannot {action} {port} any more")]
    Broken { port: String, action: &'static str, source: std::io::Error },
    /// A command was never answered.
    #[error(
        "the robot on {port} does not answer any more: no reply to \"{command}\", sent {attempts} times{}",
        words::other_reader(.port, .other.as_deref())
    )]
    NoReply {
        port: String,
        command: &'static str,
        attempts: u32,
        /// Another program that reads the port.
        other: Option<String>,
    },
    /// The robot restarted in mid-session.
    #[error("the robot on {port} was reset: {}", words::reset_cause(*.cause))]
    Reset { port: String, cause: ResetCause },
    /// The robot refused the command.
    #[error("the robot refused to {command}: {}", words::refusal(*.refusal))]
    Refused { command: &'static str, refusal: Refusal },
    /// An answer that belongs to another command.
    #[error("the robot's answer to \"{command}\" belongs to another command: its firmware is at fault")]
    WrongReply { command: &'static str },
}

impl LinkError {
    /// Whether the link works: the robot refused, or stopped by itself.
    #[must_use]
    pub const fn is_from_robot(&self) -> bool {
        matches!(
            self,
            Self::ProtocolVersion { .. }
                | Self::Refused { .. }
                | Self::Reset { .. }
                | Self::WrongReply { .. }
        )
    }

    /// What the user can do about it.
    #[must_use]
    pub fn help(&self) -> Option<String> {
        let help = match self {
            Self::NoPort { likely: Some((port, id)), .. } => {
                return Some(format!(
                    "{port} (USB {id}) is the only USB adapter here and probably the robot: --port {port}"
                ));
            }
            Self::NoPort { .. } => {
                return Some(format!(
                    "plug the robot in; or name its port: --port /dev/ttyUSB0. {GONE}. \
                     Without a robot, start target/debug/virtual-robot and pass the port that it prints"
                ));
            }
            Self::SeveralPorts { ports } => {
                let first = ports.first().map_or("PORT", |p| p.split(' ').next().unwrap_or("PORT"));
                return Some(format!("say which one: --port {first}"));
            }
            Self::Busy { port } => {
                return Some(format!(
                    "end it with Ctrl-C in its terminal, which also stops the robot; \
                     `lsof {port}` names the program"
                ));
            }
            Self::Open { port, source } => return Some(open_help(port, source)),
            Self::NoAnswer { port, other: Some(_), .. } | Self::NoReply { port, other: Some(_), .. } => {
                return Some(format!(
                    "end the other program, and repeat the command: fuser -v {port} names it; ModemManager \
                     tries every new port: sudo systemctl stop ModemManager"
                ));
            }
            Self::NoAnswer { bytes_heard: 0, .. } => {
                "check that this is the robot's port, that it is powered, and that its firmware is flashed (cargo run --release in firmware/)"
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

/// For a port that should be there.
const GONE: &str = "If it was plugged in: dmesg | tail; brltty takes such adapters on Ubuntu: sudo apt remove \
                    brltty; ModemManager may hold a new port for half a minute";

fn open_help(port: &str, source: &serialport::Error) -> String {
    use serialport::ErrorKind;
    use std::io::ErrorKind as Io;
    match source.kind() {
        ErrorKind::Io(Io::PermissionDenied) => {
            "your user may not use serial ports: sudo usermod -aG dialout $USER, then log in again".to_owned()
        }
        ErrorKind::Io(Io::NotFound) => {
            format!(
                "see what is there: ls /dev/ttyUSB* /dev/ttyACM*; without --port the robot is looked for. {GONE}"
            )
        }
        _ => format!("is {port} a serial port?"),
    }
}
