//! What a chip's fault costs on the two-wire bus, whenever it comes.
//!
//! A fault is put in at many moments of a frame, before and during the burst,
//! during and after the sensor's reading, and taken away before the firmware
//! calls the chip lost, so that the next one meets a walking robot again. Each
//! transfer is timed from its START to a bus that is free again, recovery by
//! hand included. In the end each fault stays, and is timed until the host hears
//! of it. Does not depend on the firmware's source, only on its image.

use super::memory::Stack;
use super::rig::{Firmware, Rig, RigError};
use crate::devices::Chip;
use crate::nano::trace::InterruptLog;
use crate::nano::{CLOCK_HZ, seconds};
use protocol::{Command, Event, FRAME_RATE_HZ, Message, State};

/// A fault of the bus or of a chip.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BusFault {
    /// The servo driver acknowledges nothing.
    NoServoDriver,
    /// The power sensor acknowledges nothing.
    NoSensor,
    /// The clock line is held low.
    ClockHeld,
    /// A chip holds the data line until so many clocks.
    DataHeld(u8),
}

impl BusFault {
    pub const ALL: [Self; 6] = [
        Self::NoServoDriver,
        Self::NoSensor,
        Self::ClockHeld,
        Self::DataHeld(1),
        Self::DataHeld(8),
        Self::DataHeld(9),
    ];

    #[must_use]
    pub fn name(self) -> String {
        match self {
            Self::NoServoDriver => format!("{} silent", Chip::ServoDriver.name()),
            Self::NoSensor => format!("{} silent", Chip::PowerSensor.name()),
            Self::ClockHeld => "SCL held low".into(),
            Self::DataHeld(clocks) => format!("SDA held low for {clocks} clocks"),
        }
    }

    fn begin(self, rig: &mut Rig) {
        match self {
            Self::NoServoDriver => rig.robot.nano_mut().bus_mut().unplug(Chip::ServoDriver),
            Self::NoSensor => rig.robot.nano_mut().bus_mut().unplug(Chip::PowerSensor),
            Self::ClockHeld => rig.robot.nano_mut().bus_mut().set_stuck(true),
            Self::DataHeld(clocks) => rig.robot.nano_mut().hold_data_line(clocks),
        }
    }

    fn end(self, rig: &mut Rig) {
        match self {
            Self::NoServoDriver => rig.robot.nano_mut().bus_mut().replug(Chip::ServoDriver),
            Self::NoSensor => rig.robot.nano_mut().bus_mut().replug(Chip::PowerSensor),
            Self::ClockHeld => rig.robot.nano_mut().bus_mut().set_stuck(false),
            Self::DataHeld(_) => rig.robot.nano_mut().hold_data_line(0),
        }
    }

    /// A silent chip is a fault for good; a held data line ends by itself.
    const fn lasts(self) -> bool {
        !matches!(self, Self::DataHeld(_))
    }
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FaultCost {
    pub fault: BusFault,
    /// Longest transfer, from its START to a free bus.
    pub transfer_ms: f64,
    /// Longest pass of the main loop meanwhile.
    pub pass_ms: f64,
    /// From a lasting fault to the event at the host; `None` for a passing one.
    pub told_ms: Option<f64>,
}

/// What all of them cost.
#[derive(Debug)]
pub struct BusFaults {
    pub costs: Vec<FaultCost>,
    /// Moments of a frame at which each was put in.
    pub moments: u64,
    pub interrupts: InterruptLog,
    pub stack: Stack,
}

impl BusFaults {
    /// The longest transfer of all.
    #[must_use]
    pub fn worst(&self) -> Option<FaultCost> {
        self.costs.iter().copied().max_by(|a, b| a.transfer_ms.total_cmp(&b.transfer_ms))
    }
}

/// Moments in a frame: burst and reading take its first 2 ms, so half of them
/// lie there.
const MOMENTS: u64 = 48;
const FRAME_CYCLES: u64 = CLOCK_HZ / FRAME_RATE_HZ as u64;
const BUSY_CYCLES: u64 = CLOCK_HZ / 500;
/// Shorter than the frames after which a chip counts as lost.
const FAULT_CYCLES: u64 = FRAME_CYCLES * 3 / 2;
/// A lasting fault is reported by then.
const PATIENCE_S: f64 = 1.0;

/// Puts every fault in at every moment.
///
/// # Errors
/// [`RigError`] if the robot does not walk, or does not tell of a lasting fault.
pub fn measure(firmware: &Firmware) -> Result<BusFaults, RigError> {
    let mut costs = Vec::new();
    let mut stack = Stack::default();
    let mut interrupts = InterruptLog::default();
    for fault in BusFault::ALL {
        let mut rig = Rig::started(firmware)?;
        rig.walk()?;
        rig.robot.nano_mut().start_trace(firmware.trace());
        for moment in 0..MOMENTS {
            wait_for_moment(&mut rig, moment)?;
            fault.begin(&mut rig);
            rig.robot.run_until(rig.robot.now() + FAULT_CYCLES)?;
            fault.end(&mut rig);
            // Good frames in between reset the firmware's own count of misses.
            rig.client.run_for(&mut rig.robot, 5.0 / f64::from(FRAME_RATE_HZ))?;
            keep_walking(&mut rig)?;
        }
        let told_ms = if fault.lasts() { Some(time_until_told(&mut rig, fault)?) } else { None };
        let trace = rig.take_trace()?;
        stack = stack.or(Stack::of(&rig, firmware, &trace));
        interrupts.merge(&trace.interrupts);
        let longest = trace.bus.transfers().iter().map(|transfer| transfer.cycles()).max();
        let passes = trace.passes.as_ref().ok_or(RigError::Unseen("main loop"))?;
        costs.push(FaultCost {
            fault,
            transfer_ms: seconds(longest.ok_or(RigError::Unseen("transfer"))?) * 1e3,
            pass_ms: seconds(passes.longest().0) * 1e3,
            told_ms,
        });
    }
    Ok(BusFaults { costs, moments: MOMENTS, interrupts, stack })
}

/// Runs to the moment `index` of the next frame, from a little before its burst.
fn wait_for_moment(rig: &mut Rig, index: u64) -> Result<(), RigError> {
    rig.robot.take_bursts();
    while rig.robot.take_bursts().is_empty() {
        rig.robot.run_until(rig.robot.now() + CLOCK_HZ / 20_000)?;
    }
    let half = MOMENTS / 2;
    let after_burst = if index < half {
        // Through the next frame's burst and reading.
        FRAME_CYCLES - BUSY_CYCLES / 2 + index * BUSY_CYCLES / half
    } else {
        (index - half) * FRAME_CYCLES / half
    };
    rig.robot.run_until(rig.robot.now() + after_burst)?;
    Ok(())
}

/// A moment may have cost one frame more than the firmware forgives.
fn keep_walking(rig: &mut Rig) -> Result<(), RigError> {
    if matches!(rig.status()?.0.state, State::Fault(_)) {
        rig.client.expect_done(&mut rig.robot, Command::ClearFault)?;
        rig.walk_on()?;
    }
    Ok(())
}

fn time_until_told(rig: &mut Rig, fault: BusFault) -> Result<f64, RigError> {
    rig.client.forget();
    let began = rig.robot.now();
    fault.begin(rig);
    rig.client.run_for(&mut rig.robot, PATIENCE_S)?;
    let told =
        rig.client.heard().iter().find_map(|(cycle, message)| {
            matches!(message, Message::Event(Event::Fault(_))).then_some(*cycle)
        });
    Ok(seconds(told.ok_or(RigError::Unseen("event of a lasting bus fault"))? - began) * 1e3)
}
