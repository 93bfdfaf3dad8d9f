//! The board's side of the two-wire bus, on the chips of [`crate::devices`].
//!
//! Holds how long a transfer takes and how it fails, and the readings that the
//! board takes by itself. Transfers never overlap: a transaction waits for the burst,
//! as on the real board, and a reading that falls into one is left out. Does not
//! depend on the chips' registers but for the two of a reading.

use super::{BUS_BYTE_NS, BUS_TIMEOUT_NS, NS_PER_S, SimBoard};
use embedded_hal::i2c::{self, ErrorKind, ErrorType, I2c, NoAcknowledgeSource, Operation};
use firmware::chips::{PowerSensor, Reading, SensorChip, ServoBurst};
use firmware::hal::{BurstState, PowerReadings, ServoOutput};
use firmware::power::READINGS_PER_FRAME;
use protocol::FRAME_RATE_HZ;

/// A transfer ended early.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SimBusError {
    /// No chip took the byte.
    NoAcknowledge,
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
            for _ in 0..9 {
                self.chips.clock();
            }
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

/// From the frame's beginning to its first reading.
const FIRST_READING_NS: u64 = 1_200_000;
/// Readings that wait for the program.
const READINGS_CAPACITY: usize = 7;

impl SimBoard {
    /// Takes the readings of this frame that are due.
    pub(super) fn read_sensor(&mut self) {
        let frame_ns = NS_PER_S / u64::from(FRAME_RATE_HZ);
        let began_ns = self.frames * NS_PER_S / u64::from(FRAME_RATE_HZ);
        while self.frames > 0 && self.readings_taken < READINGS_PER_FRAME {
            let spacing_ns = u64::from(self.readings_taken) * frame_ns / u64::from(READINGS_PER_FRAME);
            if self.now_ns < began_ns + FIRST_READING_NS + spacing_ns {
                break;
            }
            self.readings_taken += 1;
            if self.chips.is_stuck() || self.readings.len() == READINGS_CAPACITY {
                continue;
            }
            let mut words = [[0; 2]; 2];
            let mut read = |register: u8, word: &mut [u8; 2]| {
                let operations = &mut [Operation::Write(&[register]), Operation::Read(word)];
                self.transfer(SensorChip::ADDRESS, operations).0
            };
            let [voltage, current] = &mut words;
            let first = read(SensorChip::VOLTAGE_REGISTER, voltage);
            if first.and_then(|()| read(SensorChip::CURRENT_REGISTER, current)).is_ok() {
                let [voltage, current] = words.map(u16::from_be_bytes);
                self.readings.push_back(Reading { voltage, current });
            }
        }
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

impl ServoOutput for SimBoard {
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
}

impl PowerReadings for SimBoard {
    fn readings(&self) -> u8 {
        self.readings.len() as u8
    }

    fn take_reading(&mut self) -> Option<Reading> {
        self.readings.pop_front()
    }
}
