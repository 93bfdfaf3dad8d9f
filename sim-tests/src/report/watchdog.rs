//! From a hung program to servos without pulses.
//!
//! The program is hung by writing `rjmp .` over an instruction of the running
//! chip's flash: at the main loop's head, where interrupts and so the servo
//! bursts go on, or at a handler's vector, with interrupts off. After the reset
//! the instruction is as before, so the program starts as it always does. Each
//! hang is tried without and with each bootloader, and, if the firmware drives
//! the servo driver's OE, with that wired so that a reset alone takes the pulses
//! away.

use super::bootloader::{self, Bootloader};
use super::rig::{Firmware, Rig, RigError};
use crate::nano::{CLOCK_HZ, OutputEnable, seconds};
use protocol::{Event, FRAME_RATE_HZ, Message, ResetCause, State};

/// `rjmp .`
const HANG: u16 = 0xCFFF;
/// The frame timer's handler, at vector 11.
const FRAME_VECTOR: u32 = 11 * 4;
/// The old bootloader takes seconds before it starts the program.
const PATIENCE_CYCLES: u64 = 5 * CLOCK_HZ;
const STEP_CYCLES: u64 = CLOCK_HZ / 20_000;
const FRAME_CYCLES: u64 = CLOCK_HZ / FRAME_RATE_HZ as u64;

/// Where the program hangs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Hang {
    /// In the main loop, interrupts on.
    MainLoop,
    /// In the frame timer's handler.
    Handler,
}

impl Hang {
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::MainLoop => "main loop hung",
            Self::Handler => "frame handler hung",
        }
    }
}

#[derive(Debug, Clone, PartialEq)]
pub struct Bite {
    pub hang: Hang,
    /// With which bootloader; `None` without.
    pub bootloader: Option<&'static str>,
    /// How the servo driver's OE is wired.
    pub wiring: OutputEnable,
    /// Until no servo gets pulses; `None`: longer than five seconds.
    pub stop_ms: Option<f64>,
    /// What the robot says why it started; `None`: nothing within two seconds.
    pub cause: Option<ResetCause>,
    /// Whether it is then in a latched fault.
    pub latched: bool,
}

#[derive(Debug, Clone, PartialEq)]
pub struct Bites {
    pub bites: Vec<Bite>,
    /// What is left out, and why.
    pub not_covered: Vec<String>,
}

/// Hangs the program in each way, without and with each bootloader there is.
///
/// # Errors
/// [`RigError`] if the robot does not walk before it is hung.
pub fn measure(firmware: &Firmware) -> Result<Bites, RigError> {
    let (mut bootloaders, mut not_covered) = (Vec::new(), Vec::new());
    for bootloader in bootloader::installed() {
        match bootloader {
            Ok(bootloader) => bootloaders.push(bootloader),
            Err(why) => not_covered.push(format!("a bootloader: {why}")),
        }
    }
    bootloaders.push(bootloader::stand_in());
    let mut wirings = vec![OutputEnable::Unwired];
    if drives_output_enable(firmware)? {
        wirings.push(OutputEnable::PulledUp);
    } else {
        not_covered.push("OE on D4: this firmware leaves that pin alone".to_owned());
    }
    let mut bites = Vec::new();
    for wiring in wirings {
        for bootloader in [None].into_iter().chain(bootloaders.iter().map(Some)) {
            for hang in [Hang::MainLoop, Hang::Handler] {
                bites.push(bite(firmware, hang, bootloader, wiring)?);
            }
        }
    }
    Ok(Bites { bites, not_covered })
}

/// Whether a walking robot pulls OE down against a resistor.
fn drives_output_enable(firmware: &Firmware) -> Result<bool, RigError> {
    let mut rig = Rig::started(firmware)?;
    rig.robot.nano_mut().wire_output_enable(OutputEnable::PulledUp);
    rig.walk()?;
    rig.client.run_for(&mut rig.robot, 0.1)?;
    Ok(rig.robot.nano().bus().servo_driver.drives_any())
}

fn bite(
    firmware: &Firmware,
    hang: Hang,
    bootloader: Option<&Bootloader>,
    wiring: OutputEnable,
) -> Result<Bite, RigError> {
    let mut rig = match bootloader {
        None => Rig::started(firmware)?,
        // The old one looks for a programmer for a second or two first.
        Some(bootloader) => Rig::started_with(&bootloader.with(&firmware.image)?, 4.0)?,
    };
    rig.robot.nano_mut().wire_output_enable(wiring);
    rig.walk()?;
    rig.client.forget();
    let resets = rig.robot.nano().counters().watchdog_resets;
    let address = match hang {
        Hang::MainLoop => firmware.head,
        Hang::Handler => FRAME_VECTOR,
    };
    // Just before a frame, for only then its handler hangs.
    rig.robot.take_bursts();
    let frame = loop {
        rig.robot.run_until(rig.robot.now() + STEP_CYCLES)?;
        if let Some(burst) = rig.robot.take_bursts().first() {
            break (burst.start_s * CLOCK_HZ as f64) as u64;
        }
    };
    rig.robot.run_until(frame + FRAME_CYCLES - 2 * STEP_CYCLES)?;
    let began = rig.robot.now();
    let before = rig.robot.nano_mut().patch(address, HANG).ok_or(RigError::Unseen("main loop"))?;

    let mut stopped = None;
    let mut hung = true;
    while stopped.is_none() && rig.robot.now() < began + PATIENCE_CYCLES {
        rig.robot.run_until(rig.robot.now() + STEP_CYCLES)?;
        let is_off = !rig.robot.nano().bus().servo_driver.drives_any();
        stopped = is_off.then(|| seconds(rig.robot.now() - began) * 1e3);
        if hung && (is_off || rig.robot.nano().counters().watchdog_resets > resets) {
            rig.robot.nano_mut().patch(address, before);
            hung = false;
        }
    }
    let mut bite = Bite {
        hang,
        bootloader: bootloader.map(|bootloader| bootloader.name),
        wiring,
        stop_ms: stopped,
        cause: None,
        latched: false,
    };
    if hung {
        return Ok(bite);
    }
    rig.client.run_for(&mut rig.robot, 2.0)?;
    bite.cause = rig.client.heard().iter().rev().find_map(|(_, message)| match message {
        Message::Event(Event::Started(cause)) => Some(*cause),
        _ => None,
    });
    bite.latched = bite.cause.is_some() && matches!(rig.status()?.0.state, State::Fault(_));
    Ok(bite)
}
