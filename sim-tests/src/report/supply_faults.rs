//! From a supply that goes wrong to the last pulse.
//!
//! The load jumps while the robot walks, at several moments of a frame, and
//! stays: the voltage drops below the limit, or the current rises above it, or
//! beyond the sensor's range. Counted is the time to the end of the last pulse
//! on a servo's wire, in frames; a pulse that has begun is not cut off. Then the
//! load jumps for ever longer, to see what the debounce forgives: that is found
//! by trying, and printed beside what the firmware's source calls it.

use super::rig::{Firmware, Rig, RigError};
use crate::nano::{CLOCK_HZ, seconds};
use firmware::limits::SUPPLY_FAULT_FRAMES;
use host::robot::Supply;
use protocol::{Command, Event, FRAME_RATE_HZ, Fault, Message, State};

const FRAME_CYCLES: u64 = CLOCK_HZ / FRAME_RATE_HZ as u64;
/// Looks at the pulses this often: 50 us.
const STEP_CYCLES: u64 = CLOCK_HZ / 20_000;
/// Servos that go on for so long go on for ever.
const PATIENCE_CYCLES: u64 = CLOCK_HZ;
/// The longest jump of the load that is tried.
const LONGEST_JUMP_FRAMES: f64 = 12.0;
/// Each jump is so much longer than the one before.
const JUMP_STEP_FRAMES: f64 = 0.5;
/// The load of a robot that walks on a good supply.
const GOOD_W: f64 = 0.6;
/// The debounce that the bar allows.
pub const MAX_DEBOUNCE_FRAMES: u8 = 5;

/// What goes wrong.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Trouble {
    /// 3.9 V behind the shunt, of 5 V.
    Undervoltage,
    /// 3.1 A.
    Overcurrent,
    /// 3.7 A, more than the sensor can tell.
    BeyondRange,
}

impl Trouble {
    pub const ALL: [Self; 3] = [Self::Undervoltage, Self::Overcurrent, Self::BeyondRange];

    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Undervoltage => "undervoltage",
            Self::Overcurrent => "overcurrent",
            Self::BeyondRange => "current beyond the sensor's range",
        }
    }

    /// What the robot should call it.
    #[must_use]
    pub const fn fault(self) -> Fault {
        match self {
            Self::Undervoltage => Fault::Undervoltage,
            Self::Overcurrent | Self::BeyondRange => Fault::Overcurrent,
        }
    }

    /// The shunt's 0.1 ohm come on top.
    const fn supply(self) -> Supply {
        match self {
            Self::Undervoltage => Supply { nominal_v: 5.0, resistance_ohm: 0.5 },
            Self::Overcurrent | Self::BeyondRange => Supply { nominal_v: 6.0, resistance_ohm: 0.05 },
        }
    }

    const fn bad_w(self) -> f64 {
        match self {
            Self::Undervoltage => 7.0,
            Self::Overcurrent => 17.2,
            Self::BeyondRange => 20.0,
        }
    }
}

/// One jump of the load that stayed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stop {
    pub trouble: Trouble,
    /// When within a frame, 0 to 1.
    pub phase: f64,
    /// To the end of the last pulse, in frames; `None`: pulses after a second.
    pub frames: Option<f64>,
    /// To the event at the host.
    pub told_ms: Option<f64>,
    /// Whether the robot is in that fault afterwards.
    pub latched: bool,
}

/// What all of them showed.
#[derive(Debug, Clone, PartialEq)]
pub struct SupplyFaults {
    /// Each jump that stayed.
    pub stops: Vec<Stop>,
    /// Samples in a row that the firmware's source asks for.
    pub debounce_frames: u8,
    /// Jumps as long as this were forgiven at every phase.
    pub forgiven_frames: f64,
    /// Jumps as long as this were forgiven at none; `None` if some were for ever.
    pub tripping_frames: Option<f64>,
}

impl SupplyFaults {
    /// Frames from the first bad one to the last pulse, at worst.
    ///
    /// # Errors
    /// What was not stopped, not told, or not latched.
    pub fn worst_frames(&self) -> Result<f64, String> {
        let mut worst = 0.0_f64;
        for stop in &self.stops {
            let name = stop.trouble.name();
            match (stop.frames, stop.told_ms, stop.latched) {
                (Some(frames), Some(_), true) => worst = worst.max(frames),
                (None, ..) => return Err(format!("{name} does not stop the servos")),
                (_, None, _) => return Err(format!("{name} is not told")),
                (.., false) => return Err(format!("{name} is not latched")),
            }
        }
        Ok(worst)
    }

    /// Frames from the end of the debounce to the last pulse, at worst. A
    /// debounce longer than the bar allows counts as part of the stop.
    ///
    /// # Errors
    /// As [`Self::worst_frames`].
    pub fn stop_frames(&self) -> Result<f64, String> {
        let debounce = f64::from(self.debounce_frames.min(MAX_DEBOUNCE_FRAMES));
        // The first bad sample may have seen only the end of its frame.
        Ok((self.worst_frames()? - debounce).max(0.0))
    }
}

/// Lets each thing go wrong at so many moments of a frame.
///
/// # Errors
/// [`RigError`] if the robot does not walk on a good supply.
pub fn measure(firmware: &Firmware, phases: u32) -> Result<SupplyFaults, RigError> {
    let mut stops = Vec::new();
    let (mut forgiven_frames, mut tripping_frames) = (f64::INFINITY, Some(0.0_f64));
    for trouble in Trouble::ALL {
        let mut rig = Rig::supplied(firmware, trouble.supply())?;
        rig.robot.set_load(|_| GOOD_W);
        rig.walk()?;
        for index in 0..phases {
            let phase = f64::from(index) / f64::from(phases);
            stops.push(stop(&mut rig, trouble, phase)?);
            if trouble != Trouble::Undervoltage {
                continue;
            }
            let (forgiven, tripping) = try_jumps(&mut rig, trouble, phase)?;
            forgiven_frames = forgiven_frames.min(forgiven);
            tripping_frames = tripping_frames.zip(tripping).map(|(a, b)| a.max(b));
        }
    }
    Ok(SupplyFaults { stops, debounce_frames: SUPPLY_FAULT_FRAMES, forgiven_frames, tripping_frames })
}

fn stop(rig: &mut Rig, trouble: Trouble, phase: f64) -> Result<Stop, RigError> {
    rig.client.forget();
    let began = next_moment(rig, phase)?;
    jump(rig, trouble, began, None);
    rig.robot.run_until(began)?;
    let deadline = began + PATIENCE_CYCLES;
    while rig.robot.nano().bus().servo_driver.drives_any() && rig.robot.now() < deadline {
        rig.robot.run_until(rig.robot.now() + STEP_CYCLES)?;
    }
    let has_stopped = !rig.robot.nano().bus().servo_driver.drives_any();
    let now_s = rig.robot.now_s();
    let last_s = rig.robot.nano_mut().bus_mut().servo_driver.last_pulse_ends_s(now_s);
    let frames = last_s.filter(|_| has_stopped).map(|s| (s - seconds(began)) * f64::from(FRAME_RATE_HZ));
    rig.client.run_for(&mut rig.robot, 0.3)?;
    let is_told = |(_, message): &&(u64, Message)| *message == Message::Event(Event::Fault(trouble.fault()));
    let told_ms = rig.client.heard().iter().find(is_told).map(|(cycle, _)| seconds(cycle - began) * 1e3);
    let latched = rig.status()?.0.state == State::Fault(trouble.fault());
    recover(rig)?;
    Ok(Stop { trouble, phase, frames, told_ms, latched })
}

/// The longest jump that is forgiven, and the shortest that is not, in frames.
fn try_jumps(rig: &mut Rig, trouble: Trouble, phase: f64) -> Result<(f64, Option<f64>), RigError> {
    let mut forgiven = 0.0;
    loop {
        let frames = forgiven + JUMP_STEP_FRAMES;
        if frames > LONGEST_JUMP_FRAMES {
            return Ok((forgiven, None));
        }
        let began = next_moment(rig, phase)?;
        let ends = began + (frames * FRAME_CYCLES as f64) as u64;
        jump(rig, trouble, began, Some(ends));
        // Whatever the jump has set going has happened by then.
        rig.robot.run_until(ends + 4 * FRAME_CYCLES)?;
        if !matches!(rig.status()?.0.state, State::Walking) {
            recover(rig)?;
            return Ok((forgiven, Some(frames)));
        }
        forgiven = frames;
    }
}

/// The cycle of this phase in the frame after the next one.
fn next_moment(rig: &mut Rig, phase: f64) -> Result<u64, RigError> {
    rig.robot.take_bursts();
    let frame = loop {
        rig.robot.run_until(rig.robot.now() + STEP_CYCLES)?;
        if let Some(burst) = rig.robot.take_bursts().first() {
            break (burst.start_s * CLOCK_HZ as f64) as u64;
        }
    };
    Ok(frame + 2 * FRAME_CYCLES + (phase * FRAME_CYCLES as f64) as u64)
}

/// The load jumps at `began`, and back again at `ends`.
fn jump(rig: &mut Rig, trouble: Trouble, began: u64, ends: Option<u64>) {
    let bad_s = seconds(began)..ends.map_or(f64::INFINITY, seconds);
    rig.robot.set_load(move |time_s| if bad_s.contains(&time_s) { trouble.bad_w() } else { GOOD_W });
}

fn recover(rig: &mut Rig) -> Result<(), RigError> {
    rig.robot.set_load(|_| GOOD_W);
    rig.client.run_for(&mut rig.robot, 0.1)?;
    rig.client.expect_done(&mut rig.robot, Command::ClearFault)?;
    rig.walk_on()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn faults(stops: &[Stop], debounce_frames: u8) -> SupplyFaults {
        let (forgiven_frames, tripping_frames) = (3.5, Some(5.0));
        SupplyFaults { stops: stops.to_vec(), debounce_frames, forgiven_frames, tripping_frames }
    }

    const GOOD: Stop = Stop {
        trouble: Trouble::Overcurrent,
        phase: 0.5,
        frames: Some(7.0),
        told_ms: Some(100.0),
        latched: true,
    };

    #[test]
    fn the_slowest_stop_counts_from_the_end_of_the_debounce() {
        let slow = Stop { frames: Some(7.5), ..GOOD };

        assert_eq!(faults(&[GOOD, slow, GOOD], 5).stop_frames(), Ok(2.5));
        assert_eq!(faults(&[slow], 4).stop_frames(), Ok(3.5), "a shorter debounce leaves less time");
        assert_eq!(faults(&[slow], 20).stop_frames(), Ok(2.5), "a longer one excuses nothing");
    }

    #[test]
    fn a_stop_that_did_not_come_or_was_not_told_or_not_latched_is_no_figure() {
        for bad in
            [Stop { frames: None, ..GOOD }, Stop { told_ms: None, ..GOOD }, Stop { latched: false, ..GOOD }]
        {
            assert!(faults(&[GOOD, bad], 5).stop_frames().is_err(), "{bad:?}");
        }
    }
}
