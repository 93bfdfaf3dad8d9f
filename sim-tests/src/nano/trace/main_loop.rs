//! Where the main loop begins, and which of its passes did nothing.
//!
//! A pass is idle if it changed nothing: static memory and the loop's own
//! stack frame were afterwards what they were before. Interrupts change memory
//! too, so that is decided on passes that none fell into, and carries over to
//! every pass that took the same way through the program. A way that was ever
//! seen to change something is not idle. Waiting for the bus in a loop is a different
//! way, and ends in a change. Does not depend on what the program does.

use super::Step;
use std::collections::HashMap;

/// First data address behind the registers.
const SRAM_START: usize = 0x100;

/// Finds the main loop's head: where its outermost backward jump leads.
///
/// The main function never returns, so its instructions are those that run
/// with the highest stack pointer.
#[derive(Debug, Default)]
pub struct LoopFinder {
    stack: u16,
    widest: Option<(u32, u32)>,
}

impl LoopFinder {
    /// The first instruction of the loop, in bytes.
    #[must_use]
    pub fn head(&self) -> Option<u32> {
        self.widest.map(|(_, head)| head)
    }

    pub(super) fn note(&mut self, step: &Step<'_>) {
        if step.stack_before > self.stack {
            *self = Self { stack: step.stack_before, widest: None };
        }
        let stays = step.stack_before == self.stack && step.stack_after == self.stack;
        if !stays || step.next_pc > step.pc {
            return;
        }
        let span = step.pc - step.next_pc;
        if self.widest.is_none_or(|(widest, _)| span > widest) {
            self.widest = Some((span, step.next_pc));
        }
    }
}

/// Passes that took the same way through the program.
#[derive(Debug, Clone, Copy, Default)]
struct Way {
    passes: u64,
    /// Cycles of the main program, interrupts left out.
    cycles: u64,
    /// Undisturbed passes after which everything was as before, and others.
    unchanged: u64,
    changed: u64,
}

/// The passes of a main loop.
#[derive(Debug)]
pub struct PassLog {
    head: u32,
    statics_end: usize,
    ways: HashMap<u64, Way>,
    open: Option<Open>,
    memory: Vec<u8>,
    /// From the first pass's beginning to the last one's end.
    span: Option<(u64, u64)>,
    longest: (u64, u64),
    slept: u64,
}

#[derive(Debug)]
struct Open {
    began: u64,
    way: u64,
    cycles: u64,
    disturbed: bool,
}

impl PassLog {
    /// No pass yet of the loop that begins at `head`.
    #[must_use]
    pub fn new(head: u32, statics_end: u16) -> Self {
        Self {
            head,
            statics_end: usize::from(statics_end),
            ways: HashMap::new(),
            open: None,
            memory: Vec::new(),
            span: None,
            longest: (0, 0),
            slept: 0,
        }
    }

    /// Share of cycles, 0 to 1, that were not spent in idle passes or asleep.
    #[must_use]
    pub fn busy(&self) -> Option<f64> {
        let (began, ended) = self.span?;
        let idle: u64 = self.ways.values().filter(|way| way.is_idle()).map(|way| way.cycles).sum();
        (ended > began).then(|| 1.0 - (idle + self.slept) as f64 / (ended - began) as f64)
    }

    /// Cycles of the shortest and the longest way that is idle.
    #[must_use]
    pub fn idle_pass_cycles(&self) -> Option<(u64, u64)> {
        let lengths = || self.ways.values().filter(|way| way.is_idle()).map(|way| way.cycles / way.passes);
        Some((lengths().min()?, lengths().max()?))
    }

    /// The longest pass in cycles, interrupts included, and when it began.
    #[must_use]
    pub fn longest(&self) -> (u64, u64) {
        self.longest
    }

    pub(super) fn note(&mut self, step: &Step<'_>) {
        if step.pc == self.head {
            self.close(step);
            self.open = Some(Open { began: step.began, way: 0, cycles: 0, disturbed: false });
        }
        if let Some(open) = &mut self.open {
            // FNV-1a over the instructions' addresses.
            open.way = (open.way ^ u64::from(step.pc)).wrapping_mul(0x0100_0000_01B3);
            open.cycles += step.ended - step.began;
            open.disturbed |= step.entered.is_some();
            self.slept += step.slept;
        }
    }

    pub(super) fn cut(&mut self) {
        self.open = None;
    }

    fn close(&mut self, step: &Step<'_>) {
        let frame = usize::from(step.stack_before) + 1;
        let statics = step.data.get(SRAM_START..self.statics_end).unwrap_or_default();
        let locals = step.data.get(frame..).unwrap_or_default();
        let (old_statics, old_locals) = self.memory.split_at(statics.len().min(self.memory.len()));
        let is_unchanged = statics == old_statics && locals == old_locals;
        if let Some(open) = self.open.take() {
            let way = self.ways.entry(open.way).or_default();
            way.passes += 1;
            way.cycles += open.cycles;
            if !open.disturbed {
                *(if is_unchanged { &mut way.unchanged } else { &mut way.changed }) += 1;
            }
            let (first, _) = self.span.unwrap_or((open.began, 0));
            self.span = Some((first, step.began));
            let length = step.began - open.began;
            if length > self.longest.0 {
                self.longest = (length, open.began);
            }
        }
        if !is_unchanged {
            self.memory.clear();
            self.memory.extend_from_slice(statics);
            self.memory.extend_from_slice(locals);
        }
    }
}

impl Way {
    const fn is_idle(&self) -> bool {
        self.unchanged > 0 && self.changed == 0
    }
}
