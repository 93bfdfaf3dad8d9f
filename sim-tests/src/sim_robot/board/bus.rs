//! The board's side of the two-wire bus, on the chips of [`crate::devices`].
//!
//! Owns how long a transfer takes and how it fails. Refuses overlap: a
//! transaction waits for the burst, as on the real board.

use super::{BUS_BYTE_NS, BUS_TIMEOUT_NS, SimBoard};
use embedded_hal::i2c::{self, ErrorKind, ErrorType, I2c, NoAcknowledgeSource, Operation};
use firmware::hal::{BurstState, Bus, Reading};
use firmware::servos::ServoBurst;

/// A transfer ended early.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SimBusError {
    /// No chip took the byte.
    NoAcknowledge,
    /// The bus is stuck.
    Timeout,
}

impl i2c::Error for SimBusError {
    fn kind(&self) -> ErrorKind {
        match self {
            Self::NoAcknowledge => ErrorKind::NoAcknowledge(NoAcknowledgeSource::Unknown),
            Self::Timeout => ErrorKind::Other,
        }
    }
}

impl SimBoard {
    /// Does a transfer at once; returns how long it would have kept the bus.
    pub(super) fn transfer(
        &mut self,
        address: u8,
        operations: &mut [Operation<'_>],
    ) -> (Result<(), SimBusError>, u64) {
        if self.chips.is_stuck() {
            self.bus_errors = self.bus_errors.saturating_add(1);
            return (Err(SimBusError::Timeout), BUS_TIMEOUT_NS);
        }
        let now_s = self.now_s();
        let mut bytes = 0;
        let mut result = Ok(());
        let mut direction = None;
        'transfer: for operation in operations {
            let reads = matches!(operation, Operation::Read(_));
            if direction != Some(reads) {
                direction = Some(reads);
                bytes += 1;
                if !self.chips.start(address, reads, now_s) {
                    result = Err(SimBusError::NoAcknowledge);
                    break;
                }
            }
            match operation {
                Operation::Write(data) => {
                    for &byte in *data {
                        bytes += 1;
                        if !self.chips.write(byte, now_s) {
                            result = Err(SimBusError::NoAcknowledge);
                            break 'transfer;
                        }
                    }
                }
                Operation::Read(data) => {
                    for byte in data.iter_mut() {
                        bytes += 1;
                        *byte = self.chips.read(now_s);
                    }
                }
            }
        }
        self.chips.stop(now_s);
        self.bus_errors = self.bus_errors.saturating_add(u16::from(result.is_err()));
        (result, bytes * BUS_BYTE_NS)
    }
}

impl ErrorType for SimBoard {
    type Error = SimBusError;
}

impl I2c for SimBoard {
    fn transaction(&mut self, address: u8, operations: &mut [Operation<'_>]) -> Result<(), SimBusError> {
        if self.now_ns < self.burst_ends_ns {
            self.advance(self.burst_ends_ns - self.now_ns);
        }
        let waited_ns = self.waited_ns.take();
        self.advance(waited_ns);
        let (result, busy_ns) = self.transfer(address, operations);
        self.advance(busy_ns);
        result
    }
}

impl Bus for SimBoard {
    fn stage(&mut self, burst: &ServoBurst) {
        self.staged = *burst;
    }

    fn burst(&mut self) -> BurstState {
        match (self.now_ns < self.burst_ends_ns, self.burst_failed) {
            (true, _) => BurstState::Running,
            (false, false) => BurstState::Done,
            (false, true) => BurstState::Failed,
        }
    }

    fn recover(&mut self) {
        for _ in 0..9 {
            self.chips.clock();
        }
        self.advance(200_000);
    }

    fn take_reading(&mut self) -> Option<Reading> {
        None
    }

    fn errors(&self) -> u16 {
        self.bus_errors
    }
}
