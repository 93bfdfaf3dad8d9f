//! What a robot remembers of its last walk, through power-off.
//!
//! Holds the record's layout: postcard with fixed lengths, so that a robot
//! writes it byte by byte and a host reads it whole.

use crate::gait::Amplitude;
use crate::telemetry::{Fault, WalkEnd};

/// Bytes of a record.
pub const TRIAL_LEN: usize = 23;

/// The figures of one walk.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TrialRecord {
    /// Gait frames played, 1/60 s each.
    pub frames: u32,
    /// Battery energy over them; 8.9 years of a watt fit its 48 bits.
    pub energy_uj: u64,
    /// Frames of these in which a joint was held at its limit.
    pub clipped_frames: u32,
    /// Frames of these whose sample was missed.
    pub missed_samples: u16,
    /// The gait's identity; 0 for streamed setpoints.
    pub gait_crc32: u32,
    /// How far it was scaled at the end; of no meaning for streamed setpoints.
    pub amplitude: Amplitude,
    /// Why it ended.
    pub end: WalkEnd,
}

impl TrialRecord {
    /// The record in bytes.
    #[must_use]
    pub fn bytes(&self) -> [u8; TRIAL_LEN] {
        let mut bytes = [0; TRIAL_LEN];
        put::<0, 4>(&mut bytes, self.frames);
        put::<4, 4>(&mut bytes, self.energy_uj as u32);
        put::<8, 2>(&mut bytes, (self.energy_uj >> 32) as u32);
        put::<10, 4>(&mut bytes, self.clipped_frames);
        put::<14, 2>(&mut bytes, u32::from(self.missed_samples));
        put::<16, 4>(&mut bytes, self.gait_crc32);
        put::<20, 2>(&mut bytes, u32::from(self.amplitude.units()));
        put::<22, 1>(&mut bytes, u32::from(end_code(self.end)));
        bytes
    }

    /// The record in `bytes`; `None` if they are none.
    #[must_use]
    pub fn from_bytes(bytes: &[u8]) -> Option<Self> {
        let bytes: &[u8; TRIAL_LEN] = bytes.try_into().ok()?;
        let number = |at: usize, len: usize| {
            bytes[at..at + len].iter().rev().fold(0_u64, |number, &byte| number << 8 | u64::from(byte))
        };
        Some(Self {
            frames: number(0, 4) as u32,
            energy_uj: number(4, 6),
            clipped_frames: number(10, 4) as u32,
            missed_samples: number(14, 2) as u16,
            gait_crc32: number(16, 4) as u32,
            amplitude: Amplitude::from_units(number(20, 2) as u16)?,
            end: end_of(bytes[22])?,
        })
    }
}

/// Puts the lowest `LEN` bytes of `number` at `AT`, least first.
#[inline(always)]
fn put<const AT: usize, const LEN: usize>(bytes: &mut [u8; TRIAL_LEN], number: u32) {
    let number = number.to_le_bytes();
    bytes[AT..AT + LEN].copy_from_slice(&number[..LEN]);
}

/// Faults follow the other ends, in their own order.
const FIRST_FAULT: u8 = 16;

const fn end_code(end: WalkEnd) -> u8 {
    match end {
        WalkEnd::Finished => 0,
        WalkEnd::Asked => 1,
        WalkEnd::LinkLost => 2,
        WalkEnd::StopByte => 3,
        WalkEnd::Button => 4,
        WalkEnd::StreamDry => 5,
        WalkEnd::Fault(fault) => FIRST_FAULT + fault as u8,
    }
}

fn end_of(code: u8) -> Option<WalkEnd> {
    let plain = [
        WalkEnd::Finished,
        WalkEnd::Asked,
        WalkEnd::LinkLost,
        WalkEnd::StopByte,
        WalkEnd::Button,
        WalkEnd::StreamDry,
    ];
    let faults = Fault::ALL.into_iter().map(WalkEnd::Fault);
    plain.into_iter().chain(faults).find(|&end| end_code(end) == code)
}
