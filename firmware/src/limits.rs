//! Board data: joint calibration, angles to pulses, and every bound the robot keeps.
//!
//! Owns the numbers; the code around it holds none. Gait limits travel with the
//! gait; what stands here is the servo's own reach and the pace of the program.

use protocol::{Amplitude, Angle, JOINT_COUNT, Joint};

/// Joint speed while moving to a first pose: 1 degree a frame, 60 degrees a second.
pub const ENTRY_STEP_UNITS: i16 = Angle::UNITS_PER_DEG;
/// Amplitude change per frame: at most half a degree on a deviation of 64 degrees.
pub const AMPLITUDE_STEP_UNITS: u16 = Amplitude::UNITS_PER_ONE / 128;
/// Frames that a stopped robot stands before its servos go limp: 1 s.
pub const HOLD_FRAMES: u8 = 60;
/// Bursts in a row that may fail before the servo driver counts as lost: 50 ms.
pub const SERVO_DRIVER_LOST_FRAMES: u8 = 3;
/// Samples in a row that may be missed before the sensor counts as lost: 0.1 s.
pub const SENSOR_LOST_FRAMES: u8 = 6;
/// Supply voltage under load below which the robot stops. It leaves a supply of
/// 5 V 0.8 V for its leads and for stalls, and stays above the 3.8 V that the
/// Nano needs at 16 MHz (data sheet 29.3).
pub const UNDERVOLTAGE_MV: u16 = 4_200;
/// Supply voltage at rest that a walk needs: 5 V less 8 %. A limp robot draws
/// next to nothing, so what is lower is another supply, an empty battery, or none.
pub const START_MV: u16 = 4_600;
/// Supply current at which the robot stops, just short of the 3.2 A where the
/// sensor's range ends: beyond it, energy is not measured either.
pub const OVERCURRENT_MA: u16 = 3_000;
/// Samples in a row that the supply must be wrong for: 83 ms. Servos that start
/// together draw their stall current for a few frames; each sample is a mean
/// over half a frame already.
pub const SUPPLY_FAULT_FRAMES: u8 = 5;
/// Frames between two looks at the chips' configuration: 0.27 s.
pub const CHECK_EVERY_FRAMES: u8 = 16;
/// What a bus transfer in the main loop needs to end before the next frame:
/// three register reads take 0.4 ms, and the next burst wants a quiet bus.
pub const BUS_SLOT_US: u16 = 1_000;

/// How one servo is mounted and wired.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct JointCalibration {
    /// PCA9685 output, 0 to 7.
    pub channel: u8,
    /// Whether the servo turns against its joint.
    pub reversed: bool,
    /// Pulse length at the joint's neutral, in PWM counts.
    pub neutral_counts: u16,
    /// PWM counts per 1/256 degree, in 2^-23.
    ///
    /// 23 bits so that no angle within +-90 degrees is rounded to the wrong
    /// count: the error of the factor is below 1/1000 count there, and a count
    /// is never nearer than 1/768 to a rounding boundary without lying on it.
    pub scale_q23: u16,
}

/// The servos of one robot.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Calibration {
    /// In [`Joint::ALL`] order.
    pub joints: [JointCalibration; JOINT_COUNT],
    /// Shortest pulse that any servo is sent.
    pub min_counts: u16,
    /// Longest pulse that any servo is sent.
    pub max_counts: u16,
}

impl JointCalibration {
    const NONE: Self = Self { channel: 0, reversed: false, neutral_counts: 0, scale_q23: 0 };
}

/// 5/3 counts a degree, as the authors' servos: round(5 / 3 / 256 * 2^23).
const FIVE_THIRDS_COUNT_PER_DEG: u16 = (5 * (1_u32 << 24) / (3 * 256)).div_ceil(2) as u16;

impl Calibration {
    /// No servo at all: zeros, which cost a start value no flash.
    pub const NONE: Self =
        Self { joints: [JointCalibration::NONE; JOINT_COUNT], min_counts: 0, max_counts: 0 };

    /// The authors' robot: joint n on channel n, 330 counts at neutral, 5/3
    /// counts a degree, and pulses held within 0.6 to 2.1 ms.
    pub fn set_default(&mut self) {
        for (channel, joint) in (0..).zip(&mut self.joints) {
            *joint = JointCalibration {
                channel,
                reversed: false,
                neutral_counts: 330,
                scale_q23: FIVE_THIRDS_COUNT_PER_DEG,
            };
        }
        // 147 and 515 counts of 4.08 us.
        (self.min_counts, self.max_counts) = (147, 515);
    }

    /// Pulse of `joint` at `angle`, in PWM counts, to the nearest.
    #[must_use]
    pub fn counts(&self, joint: Joint, angle: Angle) -> u16 {
        let joint = &self.joints[joint.index()];
        // 32767 * 65535 is below 2^31.
        let product = i32::from(angle.units()) * i32::from(joint.scale_q23);
        let offset = (((product >> 6) + (1 << 16)) >> 17) as i16;
        let offset = if joint.reversed { -offset } else { offset };
        // Not `clamp`: it panics where a calibration has its bounds reversed.
        joint.neutral_counts.saturating_add_signed(offset).min(self.max_counts).max(self.min_counts)
    }
}
