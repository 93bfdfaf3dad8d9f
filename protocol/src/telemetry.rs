//! What a robot reports of itself: its state, its samples, its events.
//!
//! Does not depend on the commands that it answers; see [`crate::message`].

use serde::{Deserialize, Serialize};

/// What the robot is doing.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum State {
    /// Starting up; servos off.
    Booting,
    /// Servos limp.
    Idle,
    /// Getting up on the gait's centre, then moving slowly to its first pose.
    Entering,
    /// Playing the gait, or setpoints from the host.
    Walking,
    /// On the way to a stand, at bounded joint speed.
    Stopping,
    /// Standing still with servos on: paused, or shortly before going limp.
    Holding,
    /// Servos off until [`crate::Command::ClearFault`].
    Fault(Fault),
}

/// Why the robot stopped by itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Fault {
    /// The PCA9685 does not answer or lost its configuration, or the bus is stuck.
    // In memory, not on the wire: no fault is then the 0 of a robot that starts.
    ServoDriverLost = 1,
    /// The INA219 does not answer, or lost its configuration.
    SensorLost,
    /// The program hung and the watchdog reset it while servos were on.
    Watchdog,
    /// The supply sagged below what servos and boards are made for.
    Undervoltage,
    /// The supply gave more current than its wires and the sensor are made for.
    Overcurrent,
}

impl Fault {
    /// All faults.
    pub const ALL: [Self; 5] =
        [Self::ServoDriverLost, Self::SensorLost, Self::Watchdog, Self::Undervoltage, Self::Overcurrent];
}

/// Why a walk ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[repr(u8)]
pub enum WalkEnd {
    /// The frames that it was asked for are played.
    // In memory, not on the wire: no end is then the 0 of a robot that starts.
    Finished = 1,
    /// [`crate::Command::Stop`].
    Asked,
    /// It depended on its host, and no command came any more.
    LinkLost,
    /// The byte [`crate::frame::STOP_BYTE`].
    StopByte,
    /// The button on the robot.
    Button,
    /// The host streamed setpoints, and the next one was not there in time.
    StreamDry,
    /// Something broke; latched.
    Fault(Fault),
}

/// Why the robot last started.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum ResetCause {
    /// Supply switched on.
    PowerOn,
    /// Reset pin: a port was opened, or the button pressed.
    External,
    /// Supply sagged below the brown-out level.
    BrownOut,
    /// The program hung.
    Watchdog,
    /// The flags were gone, as old bootloaders leave them.
    Unknown,
}

/// One sample, taken at the start of a frame.
///
/// Trial figures count from the first gait frame of the last walk and freeze
/// with its last one, so a sample after the end still tells the whole trial.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Telemetry {
    /// Frames since start-up: the robot's clock, 1/60 s each.
    pub uptime_frames: u32,
    /// What it is doing.
    pub state: State,
    /// Gait frames played in this trial.
    pub trial_frames: u32,
    /// Battery energy over those frames, as the INA219 saw it.
    #[serde(with = "postcard::fixint::le")]
    pub trial_energy_uj: u64,
    /// Gait frames of this trial in which a joint was held at its limit.
    pub clipped_frames: u32,
    /// Position in the stride, in 1/65536.
    pub phase: u16,
    /// Supply voltage.
    pub bus_mv: u16,
    /// Supply current.
    pub current_ua: i32,
    /// Sensor conversions in this trial that failed, or saturated; the sample
    /// before stood in for them.
    pub missed_samples: u16,
}

/// What the robot says unasked.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Event {
    /// Just started: whoever was connected has lost its session.
    Started(ResetCause),
    /// Stopped by itself and latched.
    Fault(Fault),
    /// A walk ended for another reason than a fault.
    WalkEnded(WalkEnd),
}
