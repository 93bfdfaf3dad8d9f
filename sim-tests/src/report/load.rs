//! How busy the processor is while the robot walks.
//!
//! Busy is every cycle that is not in an idle pass of the main loop, as
//! [`crate::nano::trace`] tells them: handlers, work, and waiting for the bus
//! inside a transfer. A pass that finds the servo burst still under way and
//! goes on is idle: the processor could have done anything else. Floods keep
//! the line to the robot full, byte on byte.

use super::memory::Stack;
use super::rig::{Firmware, Rig, RigError};
use crate::nano::trace::{InterruptLog, Trace};
use crate::nano::{CLOCK_HZ, ENTRY_CYCLES, seconds};
use protocol::command::{Chunk, MAX_CHUNK_LEN};
use protocol::frame::{self, MAX_FRAME_LEN, Request, STOP_BYTE};
use protocol::{Command, FRAME_RATE_HZ};

/// What fills the line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Flood {
    /// Requests that want long answers.
    Status,
    /// The longest frames there are.
    Chunks,
    /// Bytes that mean nothing.
    Noise,
    /// All of them, in turn.
    Mixed,
}

impl Flood {
    pub const ALL: [Self; 4] = [Self::Status, Self::Chunks, Self::Noise, Self::Mixed];

    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Status => "status requests",
            Self::Chunks => "upload chunks",
            Self::Noise => "noise",
            Self::Mixed => "all of these",
        }
    }
}

/// Bytes for the line, without end.
struct Source {
    flood: Flood,
    seq: u8,
    noise: u64,
}

impl Source {
    fn next(&mut self) -> Vec<u8> {
        self.seq = self.seq.wrapping_add(1);
        let kind = match self.flood {
            Flood::Mixed => Flood::ALL[usize::from(self.seq % 3)],
            other => other,
        };
        let command = match kind {
            Flood::Chunks if self.seq.is_multiple_of(4) => Command::UploadBegin { len: 256 },
            Flood::Chunks => Command::UploadChunk {
                offset: u16::from(self.seq % 4 - 1) * 64,
                data: Chunk::of(&[self.seq; MAX_CHUNK_LEN]),
            },
            Flood::Noise | Flood::Mixed => return (0..64).map(|_| self.noise_byte()).collect(),
            Flood::Status => Command::Status,
        };
        let mut buffer = [0; MAX_FRAME_LEN];
        let request = Request { seq: self.seq, command };
        frame::encode(&request, &mut buffer).map(|bytes| bytes.to_vec()).unwrap_or_default()
    }

    /// Never the byte that stops the robot: it shall walk on, to be measured.
    fn noise_byte(&mut self) -> u8 {
        loop {
            // Knuth's MMIX generator; its high bits are the good ones.
            self.noise =
                self.noise.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            let byte = (self.noise >> 56) as u8;
            if byte != STOP_BYTE {
                return byte;
            }
        }
    }
}

/// How busy the two-wire bus is, in a frame.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct BusLoad {
    pub transfers: f64,
    /// From a START to the end of its transfer, summed up.
    pub busy_ms: f64,
}

impl BusLoad {
    fn of(trace: &Trace) -> Self {
        let frames = seconds(trace.cycles()) * f64::from(FRAME_RATE_HZ);
        let transfers = trace.bus.transfers();
        let cycles: u64 = transfers.iter().map(|transfer| transfer.ended - transfer.began).sum();
        Self { transfers: transfers.len() as f64 / frames, busy_ms: seconds(cycles) * 1e3 / frames }
    }
}

/// How busy it is, and what these runs showed beside that.
#[derive(Debug)]
pub struct Load {
    /// Walking with telemetry, in per cent.
    pub busy_percent: f64,
    /// With each flood too.
    pub flooded_percent: Vec<(Flood, f64)>,
    /// Cycles of the shortest and the longest idle pass.
    pub idle_pass_cycles: (u64, u64),
    /// Cycles of the main loop's longest pass.
    pub longest_pass_cycles: u64,
    /// Entering handlers, walking with telemetry, in per cent: a part of it that
    /// simavr alone leaves out.
    pub entries_percent: f64,
    /// The bus, walking with telemetry.
    pub bus: BusLoad,
    /// Bytes lost in the receiver.
    pub receiver_overruns: u32,
    pub interrupts: InterruptLog,
    pub stack: Stack,
}

impl Load {
    /// The flood that costs most.
    #[must_use]
    pub fn worst_flood(&self) -> Option<(Flood, f64)> {
        self.flooded_percent.iter().copied().max_by(|a, b| a.1.total_cmp(&b.1))
    }
}

/// Walks alone, then through each flood.
///
/// # Errors
/// [`RigError`] if the robot does not walk.
pub fn measure(firmware: &Firmware, duration_s: f64) -> Result<Load, RigError> {
    let mut load = Load {
        busy_percent: 0.0,
        flooded_percent: Vec::new(),
        idle_pass_cycles: (0, 0),
        longest_pass_cycles: 0,
        entries_percent: 0.0,
        bus: BusLoad::default(),
        receiver_overruns: 0,
        interrupts: InterruptLog::default(),
        stack: Stack::default(),
    };
    for flood in [None].into_iter().chain(Flood::ALL.map(Some)) {
        let mut rig = Rig::started(firmware)?;
        rig.walk()?;
        rig.robot.nano_mut().start_trace(firmware.trace());
        match flood {
            None => rig.client.run_for(&mut rig.robot, duration_s)?,
            Some(flood) => run_flooded(&mut rig, flood, duration_s)?,
        }
        let trace = rig.take_trace()?;
        if !rig.robot.nano().bus().servo_driver.drives_any() {
            return Err(RigError::Unseen("walk through a flood"));
        }
        let passes = trace.passes.as_ref().ok_or(RigError::Unseen("main loop"))?;
        let percent = 100.0 * passes.busy().ok_or(RigError::Unseen("pass of the main loop"))?;
        match flood {
            None => {
                load.busy_percent = percent;
                let entries: u64 = trace.interrupts.handlers().iter().map(|handler| handler.count).sum();
                load.entries_percent = 100.0 * (entries * ENTRY_CYCLES) as f64 / trace.cycles() as f64;
                load.bus = BusLoad::of(&trace);
                load.idle_pass_cycles = passes.idle_pass_cycles().ok_or(RigError::Unseen("idle pass"))?;
            }
            Some(flood) => load.flooded_percent.push((flood, percent)),
        }
        load.longest_pass_cycles = load.longest_pass_cycles.max(passes.longest().0);
        load.receiver_overruns += rig.robot.nano().counters().receiver_overruns;
        load.stack = load.stack.or(Stack::of(&rig, firmware, &trace));
        load.interrupts.merge(&trace.interrupts);
    }
    Ok(load)
}

fn run_flooded(rig: &mut Rig, flood: Flood, duration_s: f64) -> Result<(), RigError> {
    /// More than the line carries between two looks at it.
    const FULL: usize = 64;
    let mut source = Source { flood, seq: 0, noise: 1 };
    let end = rig.robot.now() + (duration_s * CLOCK_HZ as f64) as u64;
    while rig.robot.now() < end {
        while rig.robot.nano().unsent() < FULL {
            rig.robot.nano_mut().send(&source.next());
        }
        rig.client.run_for(&mut rig.robot, 1e-3)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_flood_gives_bytes_for_ever_and_none_of_them_but_noise_is_broken() {
        for flood in Flood::ALL {
            let mut source = Source { flood, seq: 0, noise: 1 };
            let bytes: Vec<u8> = (0..300).flat_map(|_| source.next()).collect();
            assert!(bytes.len() > 1_000, "{}", flood.name());
            assert!(!bytes.contains(&STOP_BYTE), "{}", flood.name());
            if matches!(flood, Flood::Status | Flood::Chunks) {
                let mut decoder = frame::Decoder::new();
                let bodies: Vec<_> =
                    bytes.iter().filter_map(|&b| decoder.push(b).map(|f| f.is_ok())).collect();
                assert_eq!(bodies, [true; 300], "{}", flood.name());
            }
        }
    }
}
