//! Every bound that the program itself keeps.
//!
//! Holds the numbers; the code around it has none. Gait limits travel with the
//! gait, those of servos, board and supply with the calibration. Does not depend on
//! the code that keeps them.

use protocol::{Amplitude, Angle, Speed};

/// Joint speed while moving to a first pose: 1 degree a frame, 60 degrees a second.
pub const ENTRY_STEP_UNITS: i16 = Angle::UNITS_PER_DEG;
/// Frames that the robot stands on a gait's centre before it goes to the first pose:
/// 0.5 s. One that was limp lies on its belly, and rises later than its setpoints do.
pub const RISING_FRAMES: u8 = 30;
/// Amplitude change per frame: at most half a degree on a deviation of 64 degrees.
pub const AMPLITUDE_STEP_UNITS: u16 = Amplitude::UNITS_PER_ONE / 128;
/// Speed change per frame: half a second from the gait's own speed to a stand.
pub const SPEED_STEP_UNITS: u16 = Speed::UNITS_PER_ONE / 32;
/// Frames that the button must be pressed, or let go: 50 ms, longer than it bounces.
pub const BUTTON_FRAMES: u8 = 3;
/// Frames that a stopped robot stands before its servos go limp: 1 s.
pub const HOLD_FRAMES: u8 = 60;
/// Bursts in a row that may fail before the servo driver counts as lost: 50 ms.
pub const SERVO_DRIVER_LOST_FRAMES: u8 = 3;
/// Samples in a row that may be missed before the sensor counts as lost: 0.1 s.
pub const SENSOR_LOST_FRAMES: u8 = 6;
/// Samples in a row that the supply must be wrong for: 83 ms. Servos that start
/// together draw their stall current for a few frames; each sample is a mean
/// over a whole frame already.
pub const SUPPLY_FAULT_FRAMES: u8 = 5;
/// Frames between two looks at the chips' configuration: 0.27 s.
pub const CHECK_EVERY_FRAMES: u8 = 16;
/// What a bus transfer in the main loop needs to end before the next frame:
/// three register reads take 0.4 ms, and the next burst wants a quiet bus.
pub const BUS_SLOT_US: u16 = 1_000;
