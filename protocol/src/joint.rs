//! The eight joints, their order and names.
//!
//! The paper calls the lower joint of a leg "ankle"; field usage and this
//! project call it the knee. This is the only place that says so.

/// Legs of a robot.
pub const LEG_COUNT: usize = 4;

/// Joints of a robot: a hip and a knee on each leg.
///
/// "Four legs of two servos" is a decision, not a parameter:
/// - A gait travels and is stored as eight curves of fixed length (264 bytes with
///   its CRC), so that a robot finds each without decoding the others; three
///   gaits, a calibration and a trial take most of the ATmega328P's 1,024 bytes of
///   EEPROM.
/// - The firmware sends eight of the PCA9685's sixteen channels in one burst of 33
///   bytes a frame, 0.77 ms at 400 kHz.
/// - The paper's policy has 27 observations and 8 actions, its tables 8 columns.
///
/// Another number of joints changes these two constants, [`Joint`], the layout in
/// `gait/layout.rs` and [`crate::PROTOCOL_VERSION`]; in the firmware the EEPROM
/// map, the burst and the memory limits; in the host `robot::Model`, the
/// observation of `sim::ant_env` and every trained policy.
pub const JOINT_COUNT: usize = 2 * LEG_COUNT;

/// A joint, in table and channel order: hips of legs 1 to 4, then knees.
///
/// Legs 1 to 4 stand at azimuth 45, 135, 225 and 315 degrees: counter-clockwise,
/// seen from above, from the body's x axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[repr(u8)]
#[allow(missing_docs)]
pub enum Joint {
    Hip1,
    Hip2,
    Hip3,
    Hip4,
    Knee1,
    Knee2,
    Knee3,
    Knee4,
}

impl Joint {
    /// All joints, in order: `ALL[j.index()] == j`.
    pub const ALL: [Self; JOINT_COUNT] =
        [Self::Hip1, Self::Hip2, Self::Hip3, Self::Hip4, Self::Knee1, Self::Knee2, Self::Knee3, Self::Knee4];

    /// Position in every table, and the default PCA9685 channel.
    #[must_use]
    pub const fn index(self) -> usize {
        self as usize
    }

    /// Leg number, 1 to 4.
    #[must_use]
    pub const fn leg(self) -> u8 {
        (self as u8) % LEG_COUNT as u8 + 1
    }

    /// Whether the joint moves the whole leg in the horizontal plane.
    #[must_use]
    pub const fn is_hip(self) -> bool {
        (self as u8) < LEG_COUNT as u8
    }

    /// Lower-case name, as in files and messages: `hip1`, `knee4`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Hip1 => "hip1",
            Self::Hip2 => "hip2",
            Self::Hip3 => "hip3",
            Self::Hip4 => "hip4",
            Self::Knee1 => "knee1",
            Self::Knee2 => "knee2",
            Self::Knee3 => "knee3",
            Self::Knee4 => "knee4",
        }
    }

    /// The joint of that name; the paper's `ank1` to `ank4` are accepted too.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        let paper = ["ank1", "ank2", "ank3", "ank4"];
        if let Some(leg) = paper.iter().position(|&p| p == name) {
            return Some(Self::ALL[LEG_COUNT + leg]);
        }
        Self::ALL.into_iter().find(|j| j.name() == name)
    }
}
