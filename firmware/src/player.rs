//! Plays the active gait: frames in, eight angles out.
//!
//! Owns the phase, the pose and the pace, and nothing else, so tests step it
//! without a clock. Every change of target, first pose, new gait or stop, is
//! approached at bounded joint speed; only the gait itself sets the speed of
//! walking. Refuses nothing: what may start when is for [`crate::app`] to say.

use protocol::{Amplitude, Angle, GaitTable, JOINT_COUNT, Joint};

use crate::limits::{AMPLITUDE_STEP_UNITS, ENTRY_STEP_UNITS, HOLD_FRAMES};

/// What the player is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mode {
    /// Servos off.
    Limp,
    /// On the way to the gait's first pose.
    Entering,
    /// In the gait.
    Walking,
    /// Standing for this many more frames.
    Holding(u8),
}

/// One frame of the player.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Frame {
    /// Whether the servos get pulses.
    pub servos_on: bool,
    /// Whether it counts as played: neither entry nor standing.
    pub gait: bool,
    /// Whether a joint was held at its limit.
    pub clipped: bool,
    /// Whether the walk that was asked for ends with it.
    pub last: bool,
    /// Position in the stride, in 1/65536.
    pub phase: u16,
}

impl Frame {
    /// A frame without pulses.
    pub const LIMP: Self = Self { servos_on: false, gait: false, clipped: false, last: false, phase: 0 };
}

/// Position in time and space.
#[derive(Debug)]
pub struct Player {
    mode: Mode,
    pose: [Angle; JOINT_COUNT],
    phase_q32: u32,
    phase_step_q32: u32,
    amplitude_units: u16,
    target_units: u16,
    frames_left: Option<u32>,
}

impl Default for Player {
    fn default() -> Self {
        Self::new()
    }
}

impl Player {
    /// Limp, at neutral.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            mode: Mode::Limp,
            pose: [Angle::NEUTRAL; JOINT_COUNT],
            phase_q32: 0,
            phase_step_q32: 0,
            amplitude_units: 0,
            target_units: 0,
            frames_left: None,
        }
    }

    /// What the player is about.
    #[must_use]
    pub const fn mode(&self) -> Mode {
        self.mode
    }

    /// The pose of the last frame, in [`Joint::ALL`] order.
    #[must_use]
    pub const fn pose(&self) -> &[Angle; JOINT_COUNT] {
        &self.pose
    }

    /// Enters `gait` from wherever the robot stands, then plays it.
    pub fn walk(&mut self, gait: &GaitTable, amplitude: Amplitude, frames: Option<u32>) {
        self.frames_left = frames;
        self.enter(gait, amplitude);
    }

    /// Goes over to another gait, if moving; the frames left stay the same.
    pub fn replace(&mut self, gait: &GaitTable, amplitude: Amplitude) {
        if matches!(self.mode, Mode::Entering | Mode::Walking) {
            self.enter(gait, amplitude);
        }
    }

    fn enter(&mut self, gait: &GaitTable, amplitude: Amplitude) {
        self.mode = Mode::Entering;
        self.phase_q32 = 0;
        self.phase_step_q32 = gait.phase_step();
        self.amplitude_units = amplitude.units();
        self.target_units = self.amplitude_units;
    }

    /// Scales the gait from now on; walking, the amplitude slides there.
    pub fn set_amplitude(&mut self, amplitude: Amplitude) {
        self.target_units = amplitude.units();
        if self.mode != Mode::Walking {
            self.amplitude_units = self.target_units;
        }
    }

    /// Stands still where it is, then goes limp.
    pub fn stop(&mut self) {
        if matches!(self.mode, Mode::Entering | Mode::Walking) {
            self.mode = Mode::Holding(HOLD_FRAMES);
        }
    }

    /// Servos off, now.
    pub const fn go_limp(&mut self) {
        self.mode = Mode::Limp;
    }

    /// Moves on by one frame.
    pub fn step(&mut self, gait: &GaitTable) -> Frame {
        match self.mode {
            Mode::Limp => Frame::LIMP,
            Mode::Holding(0) => {
                self.mode = Mode::Limp;
                Frame::LIMP
            }
            Mode::Holding(left) => {
                self.mode = Mode::Holding(left - 1);
                self.still(false)
            }
            Mode::Entering => self.step_entry(gait),
            Mode::Walking => self.step_gait(gait),
        }
    }

    const fn still(&self, last: bool) -> Frame {
        Frame { servos_on: true, gait: false, clipped: false, last, phase: (self.phase_q32 >> 16) as u16 }
    }

    fn step_entry(&mut self, gait: &GaitTable) -> Frame {
        let amplitude = self.amplitude();
        let mut arrived = true;
        for joint in Joint::ALL {
            let curve = &gait.joints[joint.index()];
            let target = curve.limited(curve.setpoint(0, amplitude));
            let pose = &mut self.pose[joint.index()];
            *pose = approach(*pose, target);
            arrived &= *pose == target;
        }
        let nothing_to_play = arrived && self.frames_left == Some(0);
        if nothing_to_play {
            self.mode = Mode::Holding(HOLD_FRAMES);
        } else if arrived {
            self.mode = Mode::Walking;
        }
        self.still(nothing_to_play)
    }

    fn step_gait(&mut self, gait: &GaitTable) -> Frame {
        let amplitude = self.amplitude();
        let phase = (self.phase_q32 >> 16) as u16;
        let mut clipped = false;
        for joint in Joint::ALL {
            let curve = &gait.joints[joint.index()];
            let asked = curve.setpoint(phase, amplitude);
            let limited = curve.limited(asked);
            clipped |= limited != asked;
            self.pose[joint.index()] = limited;
        }
        self.phase_q32 = self.phase_q32.wrapping_add(self.phase_step_q32);
        self.slide_amplitude();
        let mut last = false;
        if let Some(left) = &mut self.frames_left {
            *left = left.saturating_sub(1);
            last = *left == 0;
        }
        if last {
            self.mode = Mode::Holding(HOLD_FRAMES);
        }
        Frame { servos_on: true, gait: true, clipped, last, phase }
    }

    fn amplitude(&self) -> Amplitude {
        // Sliding between two valid amplitudes never leaves the valid range.
        Amplitude::from_units(self.amplitude_units).unwrap_or(Amplitude::MIN)
    }

    fn slide_amplitude(&mut self) {
        let (now, target) = (self.amplitude_units, self.target_units);
        self.amplitude_units = if now < target {
            target.min(now + AMPLITUDE_STEP_UNITS)
        } else {
            target.max(now.saturating_sub(AMPLITUDE_STEP_UNITS))
        };
    }
}

/// One entry step from `from` towards `to`.
fn approach(from: Angle, to: Angle) -> Angle {
    // Limits lie within +-90 degrees: the difference fits.
    let difference = to.units().saturating_sub(from.units());
    let step = difference.clamp(-ENTRY_STEP_UNITS, ENTRY_STEP_UNITS);
    Angle::from_units(from.units().saturating_add(step))
}
