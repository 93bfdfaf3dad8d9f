//! What the master did on the two-wire bus, from the chip's own registers.
//!
//! A transfer runs from the request of its START to the end of the unit's
//! business: a STOP, or the unit switched off. What the program then does with
//! the lines by hand, to free the bus, belongs to the transfer before. Does not
//! depend on the chips.

use super::Step;

/// PC4 and PC5, SDA and SCL.
const LINES: u8 = 0x30;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Transfer {
    /// When its START was asked for.
    pub began: u64,
    /// When the unit was done with it.
    pub ended: u64,
    /// When the program last moved a line by hand after it.
    pub freed: Option<u64>,
}

impl Transfer {
    /// From its START to a bus that is free again.
    #[must_use]
    pub fn cycles(&self) -> u64 {
        self.freed.unwrap_or(self.ended) - self.began
    }
}

/// The transfers of a run.
#[derive(Debug, Default)]
pub struct BusLog {
    transfers: Vec<Transfer>,
    open: Option<u64>,
    directions: Option<u8>,
}

impl BusLog {
    /// Every transfer that ended, in order.
    #[must_use]
    pub fn transfers(&self) -> &[Transfer] {
        &self.transfers
    }

    pub(super) fn note(&mut self, step: &Step<'_>) {
        match (self.open, step.bus_busy) {
            (None, true) => self.open = Some(step.ended),
            (Some(began), false) => {
                self.open = None;
                self.transfers.push(Transfer { began, ended: step.ended, freed: None });
            }
            _ => {}
        }
        let directions = step.directions & LINES;
        if self.directions.replace(directions).is_some_and(|before| before != directions)
            && let Some(last) = self.transfers.last_mut()
        {
            last.freed = Some(step.ended);
        }
    }

    pub(super) fn cut(&mut self) {
        self.open = None;
        self.directions = None;
    }
}
