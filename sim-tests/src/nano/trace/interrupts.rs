//! How long each handler took, and how long interrupts were off.
//!
//! A handler's time runs from its entry, with the 4 cycles of the entry
//! itself, to the end of its `reti`. Interrupts are off from the end of the
//! instruction that cleared SREG's I, or from a handler's entry, to the end of
//! the instruction that set it again. A received byte waits from its last bit
//! to the program's reading of it. Does not depend on what a handler does.

use super::Step;

/// A stretch of time, and where it began.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Stretch {
    pub cycles: u64,
    /// The program address at which it began, in bytes; a handler's own vector.
    pub pc: u32,
    /// When, in cycles since power-on.
    pub at: u64,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Handler {
    /// Vector number, 1 is the first after reset.
    pub vector: u8,
    pub count: u64,
    /// Cycles of all its runs.
    pub cycles: u64,
    pub longest: Stretch,
}

/// What is known of interrupts.
#[derive(Debug, Default)]
pub struct InterruptLog {
    handlers: Vec<Handler>,
    /// Open handlers, and when each was entered.
    open: Vec<(u8, u64)>,
    /// Where and when interrupts went off.
    off_since: Option<(u32, u64)>,
    longest_off: Option<Stretch>,
    longest_off_in_main: Option<Stretch>,
    longest_receive_wait: Option<u64>,
}

impl InterruptLog {
    /// Every handler that ran, by vector.
    #[must_use]
    pub fn handlers(&self) -> Vec<Handler> {
        let mut handlers = self.handlers.clone();
        handlers.sort_by_key(|handler| handler.vector);
        handlers
    }

    /// The longest run of any handler.
    #[must_use]
    pub fn longest_handler(&self) -> Option<Handler> {
        self.handlers.iter().copied().max_by_key(|handler| handler.longest.cycles)
    }

    /// The longest time with interrupts off, handlers included.
    #[must_use]
    pub fn longest_off(&self) -> Option<Stretch> {
        self.longest_off
    }

    /// The longest time that the main program had them off.
    #[must_use]
    pub fn longest_off_in_main(&self) -> Option<Stretch> {
        self.longest_off_in_main
    }

    /// The longest time in cycles that a received byte waited to be read.
    #[must_use]
    pub fn longest_receive_wait(&self) -> Option<u64> {
        self.longest_receive_wait
    }

    /// Takes over what another run showed.
    pub fn merge(&mut self, other: &Self) {
        for handler in &other.handlers {
            match self.handlers.iter_mut().find(|known| known.vector == handler.vector) {
                Some(known) => {
                    known.count += handler.count;
                    known.cycles += handler.cycles;
                    keep(&mut known.longest, handler.longest);
                }
                None => self.handlers.push(*handler),
            }
        }
        self.longest_receive_wait = self.longest_receive_wait.max(other.longest_receive_wait);
        for (ours, theirs) in [
            (&mut self.longest_off, other.longest_off),
            (&mut self.longest_off_in_main, other.longest_off_in_main),
        ] {
            if let Some(theirs) = theirs {
                keep(ours.get_or_insert(theirs), theirs);
            }
        }
    }

    pub(in crate::nano) fn note_receive_wait(&mut self, cycles: u64) {
        self.longest_receive_wait = self.longest_receive_wait.max(Some(cycles));
    }

    pub(super) fn note(&mut self, step: &Step<'_>) {
        if step.is_return_from_interrupt()
            && let Some((vector, at)) = self.open.pop()
        {
            self.close(vector, at, step.ended);
        }
        match (step.interrupts_before, step.interrupts_after) {
            (true, false) => self.off_since = Some((step.pc, step.ended)),
            (false, true) => self.on_again(step.ended),
            _ => {}
        }
        if let Some((vector, _)) = step.entered {
            self.open.push((vector, step.ended + step.slept));
            self.off_since = Some((u32::from(vector) * 4, step.ended + step.slept));
        }
    }

    pub(super) fn cut(&mut self) {
        self.open.clear();
        self.off_since = None;
    }

    fn close(&mut self, vector: u8, at: u64, ended: u64) {
        let run = Stretch { cycles: ended - at, pc: u32::from(vector) * 4, at };
        match self.handlers.iter_mut().find(|handler| handler.vector == vector) {
            Some(handler) => {
                handler.count += 1;
                handler.cycles += run.cycles;
                keep(&mut handler.longest, run);
            }
            None => self.handlers.push(Handler { vector, count: 1, cycles: run.cycles, longest: run }),
        }
    }

    fn on_again(&mut self, ended: u64) {
        let Some((pc, at)) = self.off_since.take() else { return };
        let stretch = Stretch { cycles: ended - at, pc, at };
        keep(self.longest_off.get_or_insert(stretch), stretch);
        // Handlers' vectors lie below the program.
        if pc >= VECTORS_END {
            keep(self.longest_off_in_main.get_or_insert(stretch), stretch);
        }
    }
}

fn keep(longest: &mut Stretch, other: Stretch) {
    if other.cycles > longest.cycles {
        *longest = other;
    }
}

/// 26 vectors of 4 bytes.
const VECTORS_END: u32 = 26 * 4;
