//! The robot's codes in words, for people and for scripts.
//!
//! Does not depend on a link.

use protocol::calibration::CalibrationError;
use protocol::command::{CalibrationSource, Record, Storage};
use protocol::{Command, Fault, Joint, Refusal, ResetCause, State, WalkEnd};

/// What a command asks for, as in "refused to ...".
#[must_use]
pub const fn command(command: &Command) -> &'static str {
    match command {
        Command::Hello { .. } => "say hello",
        Command::Status => "tell its status",
        Command::UploadBegin { .. } => "begin an upload",
        Command::UploadChunk { .. } => "take a piece of the upload",
        Command::UploadCommit { .. } => "activate the gait",
        Command::CalibrationCommit => "take over the calibration",
        Command::Read { record: Record::Gait, .. } => "read back its gait",
        Command::Read { record: Record::Calibration, .. } => "read back its calibration",
        Command::Read { record: Record::LastTrial, .. } => "read its last trial",
        Command::Walk { .. } => "walk",
        Command::Stop => "stop",
        Command::SetAmplitude(_) => "change the amplitude",
        Command::SetSpeed(_) => "change the speed",
        Command::StreamTelemetry { .. } => "send telemetry",
        Command::ClearFault => "leave the fault state",
        Command::Stream => "follow setpoints from this computer",
        Command::Setpoints { .. } => "take setpoints",
        Command::StoredGait { .. } => "tell which gaits it stores",
        Command::SelectGait { .. } => "select the stored gait",
        Command::EraseGait { .. } => "erase the stored gait",
        Command::Nudge { .. } => "move one servo",
    }
}

/// Why the robot refused.
#[must_use]
pub fn refusal(refusal: Refusal) -> String {
    match refusal {
        Refusal::ProtocolVersion { robot } => format!("it speaks protocol version {robot}"),
        Refusal::Unknown => "it does not know this command".into(),
        Refusal::UploadRange => "a piece lies beyond what was announced, or leaves a gap".into(),
        Refusal::UploadIncomplete => "pieces are missing".into(),
        Refusal::BadGait(error) => format!("the table: {}", crate::gait::gait_file::describe(error)),
        Refusal::Amplitude => "the amplitude is outside its limits".into(),
        Refusal::NoGait => "it has no gait".into(),
        Refusal::Faulted(cause) => format!("a fault is latched: {}", fault(cause)),
        Refusal::AlreadyWalking => "it is walking already".into(),
        Refusal::ChipMissing(cause) => fault(cause).into(),
        Refusal::StorageBusy => "an earlier save is still going on".into(),
        Refusal::SupplyTooLow { bus_mv } => {
            format!("its supply has {:.2} V at rest, too little to walk", f64::from(bus_mv) / 1e3)
        }
        Refusal::StorageFull => {
            "all its places for gaits are taken, and an upload needs a free one, even to replace \
             a gait of the same name"
                .into()
        }
        Refusal::NoSuchGait => "there is no gait in that place".into(),
        Refusal::BadCalibration(error) => format!("the calibration: {}", calibration_error(error)),
        Refusal::ServosOn => "its servos are on".into(),
        Refusal::StreamFull => "its buffer of setpoints is full".into(),
        Refusal::NoStream => "it is not following setpoints (any more)".into(),
        Refusal::Range => "a speed, an output or a pulse is outside its range".into(),
        Refusal::CalibrationDamaged => "its stored calibration is damaged".into(),
    }
}

/// What the user can do about a refusal.
#[must_use]
pub fn refusal_help(refusal: Refusal) -> Option<String> {
    let help = match refusal {
        Refusal::NoGait => "upload one first: host upload-gait --amp 2.2",
        Refusal::Faulted(cause) => return Some(format!("{}, {CLEAR_FAULT}", fault_help(cause))),
        Refusal::ChipMissing(cause) => return Some(format!("{}, then repeat", fault_help(cause))),
        Refusal::SupplyTooLow { .. } => {
            return Some(format!("{}, then repeat", fault_help(Fault::Undervoltage)));
        }
        Refusal::Unknown | Refusal::ProtocolVersion { .. } => {
            "flash this checkout's firmware: cargo run --release in firmware/"
        }
        Refusal::AlreadyWalking => "stop it first: host stop",
        Refusal::ServosOn => "stop it first, and wait two seconds until its servos are limp: host stop",
        Refusal::UploadRange | Refusal::UploadIncomplete | Refusal::StorageBusy => "repeat the command",
        Refusal::StorageFull => "list them with `host gaits`, and erase one: host gaits --erase NAME",
        Refusal::NoSuchGait => "list the stored gaits: host gaits",
        Refusal::CalibrationDamaged => {
            "send it again: host calibrate --write FILE, or run the wizard: host calibrate"
        }
        Refusal::NoStream => "see its state with `host status`, and start again",
        Refusal::BadCalibration(_) => {
            "correct the value in the file, or run the wizard again: host calibrate"
        }
        Refusal::BadGait(_) | Refusal::Amplitude | Refusal::StreamFull | Refusal::Range => return None,
    };
    Some(help.to_owned())
}

/// How a latched fault is cleared, to follow [`fault_help`].
pub const CLEAR_FAULT: &str = "then clear the fault: host status --clear-fault";

/// What is wrong with a calibration.
#[must_use]
pub fn calibration_error(error: CalibrationError) -> String {
    let joint = |index: u8| Joint::ALL.get(usize::from(index)).map_or("a joint", |joint| joint.name());
    match error {
        CalibrationError::Length => "it is too short or too long".into(),
        CalibrationError::Channel(index) => {
            format!("{}'s output is not 0 to 7, or another joint has it", joint(index))
        }
        CalibrationError::Pulse(index) => {
            format!("{}'s pulses are not in order: 0 < shortest <= neutral <= longest", joint(index))
        }
        CalibrationError::Board => "a number of the board is out of its range".into(),
    }
}

/// A fault's code, as printed: `F1` to `F5`.
#[must_use]
pub fn fault_code(fault: Fault) -> String {
    format!("F{}", fault as u8)
}

/// A fault in words.
#[must_use]
pub const fn fault(fault: Fault) -> &'static str {
    match fault {
        Fault::ServoDriverLost => "the servo driver (PCA9685) does not answer, or lost its configuration",
        Fault::SensorLost => "the power sensor (INA219) does not answer, or lost its configuration",
        Fault::Watchdog => "its program hung and the watchdog reset it",
        Fault::Undervoltage => {
            "the supply voltage dropped while servos were on, below 4.2 V unless calibrated otherwise"
        }
        Fault::Overcurrent => {
            "the supply current was too high while servos were on, above 3 A unless calibrated otherwise"
        }
    }
}

/// What the user can do about a fault; the caller adds how to continue.
#[must_use]
pub const fn fault_help(fault: Fault) -> &'static str {
    match fault {
        Fault::ServoDriverLost => "check SDA, SCL, 5 V and ground of the PCA9685 (address 0x40)",
        Fault::SensorLost => "check SDA, SCL, 5 V and ground of the INA219 (address 0x41: A0 bridged)",
        Fault::Watchdog => {
            "check the supply for voltage drops (if it happens again, report it with the telemetry)"
        }
        Fault::Undervoltage => {
            "check that the servos' supply is on, has 5 to 6 V, a charged battery, and short thick leads"
        }
        Fault::Overcurrent => "look for a caught leg, a stalled servo, or a short-circuited wire",
    }
}

/// Why a walk ended, as in "it ended because ...".
#[must_use]
pub const fn walk_end(end: WalkEnd) -> &'static str {
    match end {
        WalkEnd::Finished => "its time was over",
        WalkEnd::Asked => "it was ordered to stop",
        WalkEnd::LinkLost => "it heard nothing from its computer for a second",
        WalkEnd::StopByte => "a stop byte arrived",
        WalkEnd::Button => "its button was pressed",
        WalkEnd::StreamDry => "the next setpoint did not arrive in time",
        WalkEnd::Fault(cause) => fault(cause),
    }
}

/// Why a walk ended, in one word for scripts.
#[must_use]
pub const fn walk_end_code(end: WalkEnd) -> &'static str {
    match end {
        WalkEnd::Finished => "finished",
        WalkEnd::Asked => "asked",
        WalkEnd::LinkLost => "link-lost",
        WalkEnd::StopByte => "stop-byte",
        WalkEnd::Button => "button",
        WalkEnd::StreamDry => "stream-dry",
        WalkEnd::Fault(cause) => state(State::Fault(cause)),
    }
}

/// Why a robot started.
#[must_use]
pub const fn reset_cause(cause: ResetCause) -> &'static str {
    match cause {
        ResetCause::PowerOn => "its supply was switched on",
        ResetCause::External => "by its reset pin: the button, or a program that opened the port",
        ResetCause::BrownOut => "its supply voltage dropped (brown-out)",
        ResetCause::Watchdog => "its program hung and the watchdog reset it",
        ResetCause::Unknown => "the cause is unknown",
    }
}

/// What a robot is doing, in one word for scripts; faults have a word each.
#[must_use]
pub const fn state(state: State) -> &'static str {
    match state {
        State::Booting => "booting",
        State::Idle => "idle",
        State::Entering => "entering",
        State::Walking => "walking",
        State::Stopping => "stopping",
        State::Holding => "holding",
        State::Fault(Fault::ServoDriverLost) => "fault-servo-driver-lost",
        State::Fault(Fault::SensorLost) => "fault-sensor-lost",
        State::Fault(Fault::Watchdog) => "fault-watchdog",
        State::Fault(Fault::Undervoltage) => "fault-undervoltage",
        State::Fault(Fault::Overcurrent) => "fault-overcurrent",
    }
}

/// What a robot is doing, for people.
#[must_use]
pub const fn state_in_full(state: State) -> &'static str {
    match state {
        State::Booting => "starting up, servos limp",
        State::Idle => "idle, servos limp",
        State::Entering => "moving slowly into the first pose",
        State::Walking => "walking",
        State::Stopping => "coming to a stand",
        State::Holding => "standing still, servos on",
        State::Fault(_) => "stopped by a fault, servos limp",
    }
}

/// Where the active gait lives.
#[must_use]
pub const fn storage(storage: Storage) -> &'static str {
    match storage {
        Storage::RamOnly => "in RAM only: gone at the next reset",
        Storage::Saving => "being saved",
        Storage::Saved => "saved",
        Storage::Failed => "not saved: the EEPROM did not take it",
    }
}

/// Where the calibration comes from.
#[must_use]
pub const fn calibration_source(source: CalibrationSource) -> &'static str {
    match source {
        CalibrationSource::Default => "default, the authors' robot: none is stored",
        CalibrationSource::Stored => "stored",
        CalibrationSource::Damaged => "damaged in the EEPROM; to send it again: host calibrate --write FILE",
        CalibrationSource::NotSaved => "in use until the next reset: the EEPROM did not take it",
    }
}

pub(super) fn others(others: &[String]) -> String {
    if others.is_empty() {
        "there is no serial port at all".into()
    } else {
        format!("none of the serial ports is a Nano's ({})", others.join(", "))
    }
}

pub(super) fn silence(bytes_heard: u64) -> String {
    match bytes_heard {
        0 => "and not a single byte".into(),
        bytes => format!("but {bytes} bytes that are no message of a robot"),
    }
}

pub(super) fn other_reader(port: &str, other: Option<&str>) -> String {
    match other {
        Some(name) => format!("; another program reads this port: fuser -v {port} ({name})"),
        None => String::new(),
    }
}
