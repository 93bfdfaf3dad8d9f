//! The PCA9685 as servo driver: outputs off, configured and checked, eight pulses in one burst.
//!
//! Holds the chip's registers as this robot uses them. Does not depend on what
//! the chip was last told: it keeps pulsing through a reset of the Nano, and after
//! a brown-out of its own it answers with none of its configuration left.

use embedded_hal::delay::DelayNs;
use embedded_hal::i2c::I2c;
use protocol::JOINT_COUNT;
use pwm_pca9685::{Channel, Error, OutputDriver, ProgrammableAddress};

use super::{ChipFault, ServoDriver};

const MODE1: u8 = 0x00;
const LED0_ON_L: u8 = 0x06;
const ALL_LED_OFF_H: u8 = 0xFD;
const PRE_SCALE: u8 = 0xFE;
/// Bit 4 of LEDn_OFF_H: the output is off, whatever else is written.
const FULL_OFF: u8 = 0x10;
/// RESTART reads as 0 or 1 by history; the rest is ours: awake, internal
/// oscillator, auto-increment, no sub-addresses, no all-call.
const MODE1_MASK: u8 = 0x7F;
const MODE1_RUNNING: u8 = 0x20;

/// The chip with all address pins low.
pub struct Pca9685;

impl ServoDriver for Pca9685 {
    const ADDRESS: u8 = 0x40;
    /// Register of the first output, and four bytes for each of eight outputs.
    type Burst = [u8; 1 + 4 * JOINT_COUNT];

    fn limp_burst() -> Self::Burst {
        let mut burst = [0; 1 + 4 * JOINT_COUNT];
        burst[0] = LED0_ON_L;
        for off_high in burst.iter_mut().skip(4).step_by(4) {
            *off_high = FULL_OFF;
        }
        burst
    }

    fn set_pulse(burst: &mut Self::Burst, channel: u8, counts: u16) {
        let [low, high] = counts.to_le_bytes();
        // On at count 0, off at the pulse's end.
        if let Some(output) = burst.get_mut(1 + 4 * usize::from(channel)..).and_then(<[u8]>::first_chunk_mut)
        {
            *output = [0, 0, low, high];
        }
    }

    fn switch_off(bus: &mut impl I2c) -> Result<(), ChipFault> {
        bus.write(Self::ADDRESS, &[ALL_LED_OFF_H, FULL_OFF]).map_err(|_| ChipFault::NoAnswer)
    }

    fn configure(bus: &mut impl I2c, delay: &mut impl DelayNs, prescale: u8) -> Result<(), ChipFault> {
        let mut chip = pwm_pca9685::Pca9685::new(&mut *bus, Self::ADDRESS)?;
        // The prescaler is writable only in sleep (data sheet 7.3.5), and after a
        // warm reset of the Nano the chip is awake.
        chip.disable()?;
        chip.set_prescale(prescale)?;
        chip.disable_programmable_address(ProgrammableAddress::AllCall)?;
        chip.set_output_driver(OutputDriver::TotemPole)?;
        chip.set_channel_full_off(Channel::All)?;
        // Falling asleep with outputs running has set RESTART; that write has cleared
        // it (7.3.1.1). All outputs are off: nothing moves.
        chip.enable()?;
        // The oscillator's start, within which no output may be written.
        delay.delay_us(500);
        Self::check(bus, prescale)
    }

    fn check(bus: &mut impl I2c, prescale: u8) -> Result<(), ChipFault> {
        let mode1 = read(bus, MODE1)? & MODE1_MASK;
        let is_ours = read(bus, PRE_SCALE)? == prescale;
        if mode1 == MODE1_RUNNING && is_ours { Ok(()) } else { Err(ChipFault::WrongConfiguration) }
    }
}

impl<E> From<Error<E>> for ChipFault {
    fn from(_: Error<E>) -> Self {
        Self::NoAnswer
    }
}

fn read(bus: &mut impl I2c, register: u8) -> Result<u8, ChipFault> {
    let mut value = [0];
    bus.write_read(Pca9685::ADDRESS, &[register], &mut value).map_err(|_| ChipFault::NoAnswer)?;
    Ok(value[0])
}
