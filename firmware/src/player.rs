//! Plays the active gait, or a stream of setpoints: frames in, eight angles out.
//!
//! Holds the phase, the pose and the pace. Every change of target, first pose, new
//! gait or stand, is approached at bounded joint speed; only the gait itself sets the
//! speed of walking. Does not depend on a clock, so tests step it, nor on what may
//! start when, which is in [`crate::app`]. Longer than most files: the modes and the
//! steps between them are one state.

use protocol::gait::{Encoded, Product, scaled_phase_step};
use protocol::{Amplitude, Angle, JOINT_COUNT, Joint, Speed};

use crate::limits::{AMPLITUDE_STEP_UNITS, ENTRY_STEP_UNITS, HOLD_FRAMES, RISING_FRAMES, SPEED_STEP_UNITS};
use crate::upload::Upload;

/// What the player is doing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mode {
    /// Servos off.
    Limp,
    /// Getting up, or on the way to the first pose.
    Entering,
    /// In the gait, or in the stream.
    Walking,
    /// On the way to the gait's centre.
    Stopping,
    /// Standing for this many more frames.
    Holding(u8),
}

/// One frame of the player.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Frame {
    /// Whether the servos get pulses.
    pub servos_on: bool,
    /// Whether it counts as played: neither entry, nor pause, nor standing.
    pub gait: bool,
    /// Whether a joint was held at its limit.
    pub clipped: bool,
    /// Position in the stride, in 1/65536.
    pub phase: u16,
}

impl Frame {
    /// A frame without pulses.
    pub const LIMP: Self = Self { servos_on: false, gait: false, clipped: false, phase: 0 };
}

/// Result of a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outcome {
    /// The walk goes on.
    Goes,
    /// The frames that were asked for are played.
    Finished,
    /// The next setpoint is not there.
    Dry,
}

/// Position in time and space.
#[derive(Debug)]
pub struct Player {
    mode: Mode,
    /// Whether setpoints come from the host.
    streams: bool,
    /// Frames still to stand on the gait's centre before going to its first pose.
    rising_frames: u8,
    pose: [Angle; JOINT_COUNT],
    phase_q32: u32,
    phase_step_q32: u32,
    amplitude_units: u16,
    amplitude_target: u16,
    speed_units: u16,
    speed_target: u16,
    /// `u32::MAX`: no end.
    frames_left: u32,
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
            streams: false,
            rising_frames: 0,
            pose: [Angle::NEUTRAL; JOINT_COUNT],
            phase_q32: 0,
            phase_step_q32: 0,
            amplitude_units: 0,
            amplitude_target: 0,
            speed_units: 0,
            speed_target: 0,
            frames_left: 0,
        }
    }

    /// What the player is doing.
    #[must_use]
    pub const fn mode(&self) -> Mode {
        self.mode
    }

    /// Whether it is on its way into a gait or a stream, or in it.
    #[must_use]
    pub const fn is_walking(&self) -> bool {
        matches!(self.mode, Mode::Entering | Mode::Walking)
    }

    /// Whether the last walk's setpoints came from the host.
    #[must_use]
    pub const fn streams(&self) -> bool {
        self.streams
    }

    /// Whether setpoints come from the host.
    #[must_use]
    pub const fn is_streaming(&self) -> bool {
        self.is_walking() && self.streams
    }

    /// Whether it stands in mid stride at speed 0.
    #[must_use]
    pub const fn is_paused(&self) -> bool {
        matches!(self.mode, Mode::Walking) && !self.streams && self.speed_units == 0
    }

    /// The pose of the last frame, in [`Joint::ALL`] order.
    #[must_use]
    pub const fn pose(&self) -> &[Angle; JOINT_COUNT] {
        &self.pose
    }

    /// How far the gait is scaled now.
    #[must_use]
    pub fn amplitude(&self) -> Amplitude {
        // Sliding between two valid amplitudes never leaves the valid range.
        Amplitude::from_units(self.amplitude_units).unwrap_or(Amplitude::MIN)
    }

    /// Stands on the centre of `gait` for a moment, from wherever the robot stood
    /// or lay; then enters and plays it.
    pub fn walk(&mut self, gait: &Encoded, amplitude: Amplitude, frames: Option<u32>) {
        self.streams = false;
        self.rising_frames = RISING_FRAMES;
        self.frames_left = frames.unwrap_or(u32::MAX);
        (self.speed_units, self.speed_target) = (Speed::UNITS_PER_ONE, Speed::UNITS_PER_ONE);
        self.enter(gait, amplitude);
    }

    /// Waits for the first setpoint, goes there, then takes one a frame.
    pub const fn stream(&mut self) {
        self.streams = true;
        self.rising_frames = 0;
        self.frames_left = u32::MAX;
        self.phase_q32 = 0;
        self.mode = Mode::Entering;
    }

    /// Goes over to another gait, if in one; the frames left stay the same.
    pub fn replace(&mut self, gait: &Encoded, amplitude: Amplitude) {
        if self.is_walking() && !self.streams {
            self.enter(gait, amplitude);
        }
    }

    fn enter(&mut self, gait: &Encoded, amplitude: Amplitude) {
        self.mode = Mode::Entering;
        self.phase_q32 = 0;
        self.phase_step_q32 = protocol::gait::phase_step(gait.period_us());
        self.amplitude_units = amplitude.units();
        self.amplitude_target = self.amplitude_units;
    }

    /// Scales the gait from now on; walking, the amplitude slides there.
    pub fn set_amplitude(&mut self, amplitude: Amplitude) {
        self.amplitude_target = amplitude.units();
        if self.mode != Mode::Walking {
            self.amplitude_units = self.amplitude_target;
        }
    }

    /// Plays the gait at another speed from now on; the speed slides there.
    pub const fn set_speed(&mut self, speed: Speed) {
        self.speed_target = speed.units();
    }

    /// Goes to the gait's centre, stands, then goes limp. A stream has no centre.
    pub const fn stop(&mut self) {
        if self.is_walking() {
            self.mode = if self.streams { Mode::Holding(HOLD_FRAMES) } else { Mode::Stopping };
        }
    }

    /// Stands where it is, then goes limp.
    pub const fn freeze(&mut self) {
        if self.is_walking() || matches!(self.mode, Mode::Stopping) {
            self.mode = Mode::Holding(HOLD_FRAMES);
        }
    }

    /// Servos off from the next frame on.
    pub const fn go_limp(&mut self) {
        self.mode = Mode::Limp;
    }

    /// Moves on by one frame; `is_on` tells whether the last one had pulses.
    pub fn step<P: Product>(&mut self, gait: &Encoded, stream: &mut Upload, is_on: bool) -> (Frame, Outcome) {
        match self.mode {
            Mode::Limp => (Frame::LIMP, Outcome::Goes),
            Mode::Holding(0) => {
                self.mode = Mode::Limp;
                (Frame::LIMP, Outcome::Goes)
            }
            Mode::Holding(left) => {
                self.mode = Mode::Holding(left - 1);
                (self.still(), Outcome::Goes)
            }
            Mode::Entering if self.streams && stream.waiting() == 0 => {
                // Wherever it stands, it waits for the first setpoint there.
                (Frame { servos_on: is_on, ..self.still() }, Outcome::Goes)
            }
            Mode::Entering | Mode::Stopping => self.approach::<P>(gait, stream),
            Mode::Walking if self.streams => self.step_stream(stream),
            Mode::Walking => self.step_gait::<P>(gait),
        }
    }

    const fn still(&self) -> Frame {
        Frame { servos_on: true, gait: false, clipped: false, phase: (self.phase_q32 >> 16) as u16 }
    }

    /// One step towards where the mode leads. A stance of the gait on few legs
    /// would not get up a robot that lies: its centre does, which is on all.
    fn approach<P: Product>(&mut self, gait: &Encoded, stream: &Upload) -> (Frame, Outcome) {
        let amplitude = self.amplitude();
        let mut arrived = true;
        for joint in Joint::ALL {
            let target = if self.mode == Mode::Stopping || self.rising_frames > 0 {
                gait.centre(joint)
            } else if self.streams {
                stream.next_setpoint(joint.index())
            } else {
                gait.limited(joint, gait.setpoint_by::<P>(joint, 0, amplitude))
            };
            let pose = &mut self.pose[joint.index()];
            *pose = step_towards(*pose, target);
            arrived &= *pose == target;
        }
        let mut outcome = Outcome::Goes;
        if arrived {
            if self.mode == Mode::Stopping {
                self.mode = Mode::Holding(HOLD_FRAMES);
            } else if self.rising_frames > 0 {
                self.rising_frames -= 1;
            } else if self.frames_left == 0 {
                self.mode = Mode::Stopping;
                outcome = Outcome::Finished;
            } else {
                self.mode = Mode::Walking;
            }
        }
        (self.still(), outcome)
    }

    fn step_stream(&mut self, stream: &mut Upload) -> (Frame, Outcome) {
        if stream.waiting() == 0 {
            self.mode = Mode::Holding(HOLD_FRAMES);
            return (self.still(), Outcome::Dry);
        }
        for (joint, pose) in self.pose.iter_mut().enumerate() {
            *pose = stream.next_setpoint(joint);
        }
        stream.drop_pose();
        (Frame { gait: true, ..self.still() }, Outcome::Goes)
    }

    fn step_gait<P: Product>(&mut self, gait: &Encoded) -> (Frame, Outcome) {
        self.speed_units = slide(self.speed_units, self.speed_target, SPEED_STEP_UNITS);
        if self.speed_units == 0 {
            return (self.still(), Outcome::Goes);
        }
        let amplitude = self.amplitude();
        let phase = (self.phase_q32 >> 16) as u16;
        let mut clipped = false;
        for joint in Joint::ALL {
            let asked = gait.setpoint_by::<P>(joint, phase, amplitude);
            let limited = gait.limited(joint, asked);
            clipped |= limited != asked;
            self.pose[joint.index()] = limited;
        }
        let step = scaled_phase_step(self.phase_step_q32, self.speed_units);
        self.phase_q32 = self.phase_q32.wrapping_add(step);
        self.amplitude_units = slide(self.amplitude_units, self.amplitude_target, AMPLITUDE_STEP_UNITS);
        let mut outcome = Outcome::Goes;
        if self.frames_left < u32::MAX {
            self.frames_left = self.frames_left.saturating_sub(1);
            if self.frames_left == 0 {
                self.mode = Mode::Stopping;
                outcome = Outcome::Finished;
            }
        }
        (Frame { servos_on: true, gait: true, clipped, phase }, outcome)
    }
}

/// One step of at most `step` from `now` to `target`.
fn slide(now: u16, target: u16, step: u16) -> u16 {
    if now < target { target.min(now + step) } else { target.max(now.saturating_sub(step)) }
}

/// One entry step from `from` towards `to`.
fn step_towards(from: Angle, to: Angle) -> Angle {
    // Streamed angles may be anything; the difference saturates.
    let difference = to.units().saturating_sub(from.units());
    let step = difference.clamp(-ENTRY_STEP_UNITS, ENTRY_STEP_UNITS);
    Angle::from_units(from.units().saturating_add(step))
}
