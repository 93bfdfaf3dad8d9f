//! Transactions of the main loop, polled, each with a deadline.
//!
//! A write, a read, or a write and a read: the chips know no others, and the
//! general sequence of `embedded-hal` takes half a kilobyte more.
//!
//! Holds the bus from claim to release, and frees it where a transfer left it
//! stuck. Waits no longer than the burst's deadline for the bus, and no longer than
//! its own for a chip. Does not depend on which chip it is.

use avr_device::interrupt;
use embedded_hal::i2c::{self, ErrorKind, ErrorType, NoAcknowledgeSource, Operation};

use super::{
    ADDRESS_R_ACK, ADDRESS_R_NACK, ADDRESS_W_ACK, ADDRESS_W_NACK, BIT_RATE, BURST_TICKS, DATA_R_ACK,
    DATA_R_NACK, DATA_W_ACK, DATA_W_NACK, OWNER, REPEATED_START, START, chain, count_error, free, let_go,
    owner, registers, send_stop, status,
};
use crate::timer::{self, TICKS_PER_US};

/// Three register reads take 0.4 ms.
const TRANSACTION_TICKS: u16 = 1_000 * TICKS_PER_US;
/// The burst, and what it takes to free the bus after it.
const PATIENCE_TICKS: u16 = BURST_TICKS + 500 * TICKS_PER_US;

/// Why a transaction ended early.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TwiError {
    /// Nobody has this address.
    AddressNotAcknowledged,
    /// The chip took no more bytes.
    DataNotAcknowledged,
    /// Not over at its deadline: a line is stuck.
    Timeout,
    /// Something else drives the bus.
    Bus,
    /// Other than a write, a read, or one after the other.
    Unsupported,
}

impl i2c::Error for TwiError {
    fn kind(&self) -> ErrorKind {
        match self {
            Self::AddressNotAcknowledged => ErrorKind::NoAcknowledge(NoAcknowledgeSource::Address),
            Self::DataNotAcknowledged => ErrorKind::NoAcknowledge(NoAcknowledgeSource::Data),
            Self::Timeout | Self::Unsupported => ErrorKind::Other,
            Self::Bus => ErrorKind::Bus,
        }
    }
}

/// The bus, as the main loop sees it.
pub struct Twi {
    started_at: u16,
}

impl Twi {
    /// 400 kHz.
    pub fn start() -> Self {
        let twi = registers();
        let_go();
        twi.twsr().reset();
        twi.twbr().write(|w| w.set(BIT_RATE));
        Self { started_at: 0 }
    }

    fn restart_deadline(&mut self) {
        self.started_at = interrupt::free(timer::now);
    }

    fn is_late(&self, ticks: u16) -> bool {
        interrupt::free(timer::now).wrapping_sub(self.started_at) > ticks
    }

    /// Takes the bus once the transfer on it is over, which its own deadline bounds.
    fn claim(&mut self) -> Result<(), TwiError> {
        self.restart_deadline();
        loop {
            let is_ours = interrupt::free(|_| {
                let is_free = OWNER.get() == owner::NOBODY;
                if is_free {
                    OWNER.set(owner::MAIN);
                }
                is_free
            });
            if is_ours {
                self.restart_deadline();
                return Ok(());
            }
            if self.is_late(PATIENCE_TICKS) {
                return Err(TwiError::Timeout);
            }
        }
    }

    /// Frees a stuck bus; takes 0.2 ms.
    fn free(&self) {
        let_go();
        let mut step = Some(free::BEGIN);
        while let Some(next) = step {
            step = free::step(next);
            avr_device::asm::delay_cycles(5 * 16);
        }
    }

    fn wait(&self) -> Result<u8, TwiError> {
        while registers().twcr().read().twint().bit_is_clear() {
            if self.is_late(TRANSACTION_TICKS) {
                return Err(TwiError::Timeout);
            }
        }
        Ok(status())
    }

    fn address(&self, byte: u8) -> Result<(), TwiError> {
        let twi = registers();
        twi.twcr().write(|w| w.twint().set_bit().twsta().set_bit().twen().set_bit());
        match self.wait()? {
            START | REPEATED_START => {}
            _ => return Err(TwiError::Bus),
        }
        self.put(byte)
    }

    fn put(&self, byte: u8) -> Result<(), TwiError> {
        let twi = registers();
        twi.twdr().write(|w| w.set(byte));
        twi.twcr().write(|w| w.twint().set_bit().twen().set_bit());
        match self.wait()? {
            ADDRESS_W_ACK | ADDRESS_R_ACK | DATA_W_ACK => Ok(()),
            ADDRESS_W_NACK | ADDRESS_R_NACK => Err(TwiError::AddressNotAcknowledged),
            DATA_W_NACK => Err(TwiError::DataNotAcknowledged),
            _ => Err(TwiError::Bus),
        }
    }

    fn get(&self, acknowledge: bool) -> Result<u8, TwiError> {
        let twi = registers();
        twi.twcr().write(|w| w.twint().set_bit().twen().set_bit().twea().bit(acknowledge));
        match self.wait()? {
            DATA_R_ACK | DATA_R_NACK => Ok(twi.twdr().read().bits()),
            _ => Err(TwiError::Bus),
        }
    }

    fn stop(&self) -> Result<(), TwiError> {
        send_stop();
        self.wait_for_stop()
    }

    fn wait_for_stop(&self) -> Result<(), TwiError> {
        while registers().twcr().read().twsto().bit_is_set() {
            if self.is_late(TRANSACTION_TICKS) {
                return Err(TwiError::Timeout);
            }
        }
        Ok(())
    }

    fn run(&self, address: u8, written: &[u8], read: &mut [u8]) -> Result<(), TwiError> {
        // The STOP before may still be on the wire.
        self.wait_for_stop()?;
        if !written.is_empty() || read.is_empty() {
            self.address(address << 1)?;
            for &byte in written {
                self.put(byte)?;
            }
        }
        if let Some((last, others)) = read.split_last_mut() {
            self.address(address << 1 | 1)?;
            for byte in others {
                *byte = self.get(true)?;
            }
            // The last byte is not acknowledged: the chip lets go of the line.
            *last = self.get(false)?;
        }
        self.stop()
    }

    #[inline(never)]
    fn exchange(&mut self, address: u8, written: &[u8], read: &mut [u8]) -> Result<(), TwiError> {
        self.claim()?;
        let mut result = self.run(address, written, read);
        if matches!(result, Err(TwiError::AddressNotAcknowledged | TwiError::DataNotAcknowledged)) {
            result = self.stop().and(result);
        }
        if matches!(result, Err(TwiError::Timeout | TwiError::Bus)) {
            self.free();
        }
        interrupt::free(|cs| {
            if result.is_err() {
                count_error(cs);
            }
            chain::hand_over(cs);
        });
        result
    }
}

impl ErrorType for Twi {
    type Error = TwiError;
}

impl i2c::I2c for Twi {
    fn write(&mut self, address: u8, bytes: &[u8]) -> Result<(), TwiError> {
        self.exchange(address, bytes, &mut [])
    }

    fn read(&mut self, address: u8, bytes: &mut [u8]) -> Result<(), TwiError> {
        self.exchange(address, &[], bytes)
    }

    fn write_read(&mut self, address: u8, written: &[u8], read: &mut [u8]) -> Result<(), TwiError> {
        self.exchange(address, written, read)
    }

    fn transaction(&mut self, address: u8, operations: &mut [Operation<'_>]) -> Result<(), TwiError> {
        match operations {
            [] => Ok(()),
            [Operation::Write(bytes)] => self.exchange(address, bytes, &mut []),
            [Operation::Read(bytes)] => self.exchange(address, &[], bytes),
            [Operation::Write(written), Operation::Read(read)] => self.exchange(address, written, read),
            _ => Err(TwiError::Unsupported),
        }
    }
}
