//! What the program did, instruction by instruction.
//!
//! Holds what is noted of each instruction: how long interrupts were off, how
//! long each handler took, which passes of the main loop did nothing, what
//! happened on the two-wire bus, and how deep the stack went. Changes nothing
//! about the run. Does not depend on the bars, which are in [`crate::report`].

mod bus;
mod interrupts;
mod main_loop;
#[cfg(test)]
mod tests;

pub use bus::{BusLog, Transfer};
pub use interrupts::{InterruptLog, Stretch};
pub use main_loop::{LoopFinder, PassLog};

/// One instruction, and the interrupt that was entered after it.
pub(super) struct Step<'a> {
    /// Where it stood, in bytes.
    pub pc: u32,
    /// Where the program went on, before any interrupt.
    pub next_pc: u32,
    pub opcode: u16,
    /// When it began and ended, in cycles since power-on.
    pub began: u64,
    pub ended: u64,
    pub stack_before: u16,
    pub stack_after: u16,
    pub interrupts_before: bool,
    pub interrupts_after: bool,
    /// The handler entered, and when it had been.
    pub entered: Option<(u8, u64)>,
    /// Cycles asleep after it.
    pub slept: u64,
    /// The two-wire unit is in the middle of something.
    pub bus_busy: bool,
    /// Directions of port C: the program's own hold on the bus lines.
    pub directions: u8,
    /// Data space.
    pub data: &'a [u8],
}

impl Step<'_> {
    const RETI: u16 = 0x9518;
    /// Ends of the opcodes for I/O addresses 0x3D and 0x3E.
    const STACK_LOW: u16 = 0x0D;
    const STACK_HIGH: u16 = 0x0E;

    /// `out` to this half of the stack pointer.
    fn writes_stack(&self, half: u16) -> bool {
        const OUT_MASK: u16 = 0xFE0F;
        self.opcode & OUT_MASK == 0xBE00 | half
    }

    fn is_return_from_interrupt(&self) -> bool {
        self.opcode == Self::RETI
    }
}

/// Notes of a stretch of time.
#[derive(Debug, Default)]
pub struct Trace {
    /// When the first instruction began and the last one ended.
    pub span: Option<(u64, u64)>,
    pub interrupts: InterruptLog,
    /// The main loop's passes, if it is known where the loop begins.
    pub passes: Option<PassLog>,
    /// Looks for the main loop.
    pub finder: LoopFinder,
    pub bus: BusLog,
    /// The lowest stack pointer, above data space's end if none was seen.
    pub lowest_stack: Option<u16>,
    /// How many handlers are open.
    depth: u32,
    /// The stack pointer's high half is new and its low half still old.
    stack_is_torn: bool,
}

impl Trace {
    /// Notes everything but passes of the main loop, whose address is not known yet.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Notes the passes of the main loop that begins at `head`, in bytes;
    /// static memory ends before data address `statics_end`.
    #[must_use]
    pub fn of_loop(head: u32, statics_end: u16) -> Self {
        Self { passes: Some(PassLog::new(head, statics_end)), ..Self::default() }
    }

    /// Cycles from the first to the last instruction noted.
    #[must_use]
    pub fn cycles(&self) -> u64 {
        self.span.map_or(0, |(began, ended)| ended - began)
    }

    pub(super) fn note(&mut self, step: &Step<'_>) {
        let (began, _) = self.span.unwrap_or((step.began, step.ended));
        self.span = Some((began, step.entered.map_or(step.ended, |(_, at)| at) + step.slept));
        // Compilers write the high half first; with half a pointer nothing is pushed.
        let was_torn = self.stack_is_torn;
        if step.writes_stack(Step::STACK_HIGH) {
            self.stack_is_torn = true;
        } else if step.writes_stack(Step::STACK_LOW) {
            self.stack_is_torn = false;
        }
        if !self.stack_is_torn {
            let lowest = self.lowest_stack.unwrap_or(u16::MAX).min(step.stack_after);
            self.lowest_stack = Some(lowest);
        }

        self.interrupts.note(step);
        self.bus.note(step);
        if self.depth == 0 {
            if !was_torn {
                self.finder.note(step);
            }
            if let Some(passes) = &mut self.passes {
                passes.note(step);
            }
        } else if step.is_return_from_interrupt() {
            self.depth -= 1;
        }
        if step.entered.is_some() {
            self.depth += 1;
        }
    }

    /// The chip was reset: whatever was open is not closed any more.
    pub(super) fn cut(&mut self) {
        self.depth = 0;
        self.stack_is_torn = false;
        self.interrupts.cut();
        self.bus.cut();
        if let Some(passes) = &mut self.passes {
            passes.cut();
        }
    }
}
