//! Flash, static memory, and the deepest stack.
//!
//! The stack is measured twice: by the paint that the firmware lays over its
//! free memory at start-up, and by the lowest stack pointer of the traced runs.
//! Paint sees the run from start-up on, the pointer every instruction of the
//! traced part, even one that leaves a painted byte as it was. The deeper one
//! counts.

use super::rig::{Firmware, Rig};
use crate::nano::trace::Trace;

/// Last data address of an ATmega328P.
const RAM_END: u16 = 0x08FF;
const SRAM_START: u16 = 0x100;
/// So many equal bytes in a row behind static memory are paint.
const LEAST_PAINT: usize = 32;

/// The deepest stack of one run, or of several.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Stack {
    /// By the stack pointer.
    pub by_pointer: u16,
    /// By the paint; `None` without any.
    pub by_paint: Option<u16>,
}

impl Stack {
    /// Of a robot whose run was traced.
    #[must_use]
    pub fn of(rig: &Rig, firmware: &Firmware, trace: &Trace) -> Self {
        Self {
            by_pointer: trace.lowest_stack.map_or(0, |lowest| RAM_END.saturating_sub(lowest)),
            by_paint: painted(rig.robot.nano().sram(), firmware.statics_end),
        }
    }

    /// The deeper of two, each in its own way of measuring.
    #[must_use]
    pub fn or(self, other: Self) -> Self {
        Self {
            by_pointer: self.by_pointer.max(other.by_pointer),
            by_paint: self.by_paint.max(other.by_paint),
        }
    }

    /// In bytes.
    #[must_use]
    pub fn bytes(self) -> u16 {
        self.by_pointer.max(self.by_paint.unwrap_or(0))
    }
}

/// Bytes behind the paint, which lies over the free memory from `statics_end`.
fn painted(sram: &[u8], statics_end: u16) -> Option<u16> {
    let free = sram.get(usize::from(statics_end.checked_sub(SRAM_START)?)..)?;
    let paint = free.first()?;
    let untouched = free.iter().take_while(|byte| *byte == paint).count();
    (untouched >= LEAST_PAINT).then(|| (free.len() - untouched) as u16)
}

/// What the program takes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Memory {
    /// Code and start values.
    pub flash_bytes: u32,
    pub static_bytes: u32,
    /// The deepest stack of all runs.
    pub stack: Stack,
}

impl Memory {
    /// Of an image whose runs had this stack.
    #[must_use]
    pub fn of(firmware: &Firmware, stack: Stack) -> Self {
        Self {
            flash_bytes: firmware.image.flash().len() as u32,
            static_bytes: u32::from(firmware.statics_end.saturating_sub(SRAM_START)),
            stack,
        }
    }

    /// Static memory and the deepest stack.
    #[must_use]
    pub fn ram_peak_bytes(&self) -> u32 {
        self.static_bytes + u32::from(self.stack.bytes())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_stack_is_what_lies_behind_the_paint() {
        let mut sram = [0xC5; 2048];
        sram[..100].fill(1);
        sram[2000..].fill(2);

        assert_eq!(painted(&sram, SRAM_START + 100), Some(48));
    }

    #[test]
    fn one_touched_byte_far_below_the_rest_is_seen() {
        let mut sram = [0xC5; 2048];
        sram[1200] = 0;

        assert_eq!(painted(&sram, SRAM_START + 100), Some(848));
    }

    #[test]
    fn memory_without_paint_is_no_measurement() {
        let sram: Vec<u8> = (0..2048_u16).map(|i| i as u8).collect();

        assert_eq!(painted(&sram, SRAM_START + 100), None);
    }
}
