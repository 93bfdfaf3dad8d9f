//! What host and robot say to each other, and the one function that turns a
//! gait into joint angles.
//!
//! Holds the wire messages ([`command`], [`message`], [`telemetry`]), their framing
//! ([`frame`]), the gait table and its integer evaluation ([`gait`]), the
//! records that a robot keeps ([`calibration`], [`trial`]), and the order of the
//! joints ([`joint`]). Does not depend on ports,
//! clocks or an allocator, nor on floating point outside [`gait`]'s quantisation,
//! which only the host calls.
#![no_std]
#![forbid(unsafe_code)]

pub mod calibration;
pub mod command;
pub mod crc;
pub mod frame;
pub mod gait;
pub mod joint;
pub mod message;
pub mod telemetry;
pub mod trial;
pub mod wire;

pub use calibration::Calibration;
pub use command::{Chunk, Command, HelloReply, Limits, Refusal, Reply, Status};
pub use gait::{Amplitude, Angle, GaitTable, JointCurve, Name, Speed};
pub use joint::{JOINT_COUNT, Joint, LEG_COUNT};
pub use message::Message;
pub use telemetry::{Event, Fault, ResetCause, State, Telemetry, WalkEnd};
pub use trial::TrialRecord;

/// Version of the messages in this crate; host and robot must agree exactly.
///
/// [`Command::Hello`] and [`Refusal::ProtocolVersion`] keep their encoding in
/// every version, so that any two versions can tell each other why they disagree.
pub const PROTOCOL_VERSION: u8 = 3;

/// Gait frames a second: one setpoint per joint and one energy sample each.
pub const FRAME_RATE_HZ: u32 = 60;

/// Frames without a command after which an attached walk stops: 0.9 s, so that
/// it stands still within 1 s.
pub const LINK_TIMEOUT_FRAMES: u8 = 54;

/// Setpoints that a robot buffers: 50 ms of a late host. A stream that ends has
/// its servos still 83 ms later, the PWM's own period included.
pub const STREAM_CAPACITY: u8 = 3;

/// Gaits that a robot stores.
pub const GAIT_SLOTS: u8 = 3;
