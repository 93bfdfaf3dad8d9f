//! What the robot's codes mean, for people.

use protocol::{Command, Fault, Refusal, ResetCause, State};

/// What a command asks for, as in "refused to ...".
#[must_use]
pub const fn command(command: &Command) -> &'static str {
    match command {
        Command::Hello { .. } => "say hello",
        Command::Status => "tell its status",
        Command::UploadBegin { .. } => "begin an upload",
        Command::UploadChunk { .. } => "take a piece of the gait",
        Command::UploadCommit { .. } => "activate the gait",
        Command::ReadGait { .. } => "read back its gait",
        Command::Walk { .. } => "walk",
        Command::Stop => "stop",
        Command::SetAmplitude(_) => "change the amplitude",
        Command::StreamTelemetry { .. } => "send telemetry",
        Command::ClearFault => "leave the fault state",
    }
}

/// Why the robot refused.
#[must_use]
pub fn refusal(refusal: Refusal) -> String {
    match refusal {
        Refusal::ProtocolVersion { robot } => format!("it speaks protocol version {robot}"),
        Refusal::Unknown => "it does not know this command".into(),
        Refusal::UploadRange => "a piece lies beyond the announced table".into(),
        Refusal::UploadIncomplete => "pieces of the gait are missing".into(),
        Refusal::BadGait(error) => format!("the table: {}", crate::gait_file::describe(error)),
        Refusal::Amplitude => "the amplitude is outside its limits".into(),
        Refusal::NoGait => "it has no gait".into(),
        Refusal::Faulted(cause) => format!("it stopped before and latched: {}", fault(cause)),
        Refusal::AlreadyWalking => "it is walking already".into(),
        Refusal::ChipMissing(cause) => fault(cause).into(),
        Refusal::StorageBusy => "an earlier save is still going on".into(),
        Refusal::SupplyTooLow { bus_mv } => {
            format!("its supply has {:.2} V at rest, too little to walk", f64::from(bus_mv) / 1e3)
        }
    }
}

/// The user's next move after a refusal.
#[must_use]
pub const fn refusal_help(refusal: Refusal) -> Option<&'static str> {
    match refusal {
        Refusal::NoGait => Some("upload one first: host upload-gait --amp 2.2"),
        Refusal::Faulted(cause) | Refusal::ChipMissing(cause) => Some(fault_help(cause)),
        Refusal::Unknown | Refusal::ProtocolVersion { .. } => {
            Some("flash this checkout's firmware: cargo run --release in firmware/")
        }
        Refusal::UploadRange | Refusal::UploadIncomplete | Refusal::AlreadyWalking | Refusal::StorageBusy => {
            Some("repeat the command")
        }
        Refusal::SupplyTooLow { .. } => Some(fault_help(Fault::Undervoltage)),
        Refusal::BadGait(_) | Refusal::Amplitude => None,
    }
}

/// What a fault is.
#[must_use]
pub const fn fault(fault: Fault) -> &'static str {
    match fault {
        Fault::ServoDriverLost => "the servo driver (PCA9685) does not answer",
        Fault::SensorLost => "the power sensor (INA219) does not answer, or lost its configuration",
        Fault::Watchdog => "its program hung and the watchdog reset it",
        Fault::Undervoltage => "its supply sagged below 4.2 V while servos were on",
        Fault::Overcurrent => "its supply gave 3 A or more while servos were on",
    }
}

/// The user's next move after a fault.
#[must_use]
pub const fn fault_help(fault: Fault) -> &'static str {
    match fault {
        Fault::ServoDriverLost => "check SDA, SCL, 5 V and ground of the PCA9685 (address 0x40), then repeat",
        Fault::SensorLost => {
            "check SDA, SCL, 5 V and ground of the INA219 (address 0x41: A0 bridged), then repeat"
        }
        Fault::Watchdog => "check the supply for sags; if it happens again, report it with the telemetry",
        Fault::Undervoltage => {
            "is the servos' supply on, 5 to 6 V, its battery charged, its leads short and thick? Then repeat"
        }
        Fault::Overcurrent => "is a leg caught, a servo stalled, or a wire short-circuited? Then repeat",
    }
}

/// Why a robot started.
#[must_use]
pub const fn reset_cause(cause: ResetCause) -> &'static str {
    match cause {
        ResetCause::PowerOn => "its supply was switched on",
        ResetCause::External => "by its reset pin: the button, or another program that opened the port",
        ResetCause::BrownOut => "its supply sagged (brown-out)",
        ResetCause::Watchdog => "its program hung and the watchdog reset it",
        ResetCause::Unknown => "the cause is unknown",
    }
}

/// What a robot is doing, in one word; faults have a word each.
#[must_use]
pub const fn state(state: State) -> &'static str {
    match state {
        State::Booting => "booting",
        State::Idle => "idle",
        State::Entering => "entering",
        State::Walking => "walking",
        State::Holding => "holding",
        State::Fault(Fault::ServoDriverLost) => "fault-servo-driver-lost",
        State::Fault(Fault::SensorLost) => "fault-sensor-lost",
        State::Fault(Fault::Watchdog) => "fault-watchdog",
        State::Fault(Fault::Undervoltage) => "fault-undervoltage",
        State::Fault(Fault::Overcurrent) => "fault-overcurrent",
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
        0 => "nor a single byte".into(),
        bytes => format!("but {bytes} bytes that mean nothing"),
    }
}
