//! The PCA9685: outputs off, configured and checked, and eight pulses in one burst.
//!
//! Owns the chip's registers as this robot uses them. Refuses to trust it: the
//! chip keeps pulsing through a reset of the Nano, and after a brown-out of its
//! own it answers happily with none of its configuration left.

use embedded_hal::delay::DelayNs;
use embedded_hal::i2c::I2c;
use protocol::{Angle, Calibration, JOINT_COUNT, Joint};
use pwm_pca9685::{Channel, Error, OutputDriver, Pca9685, ProgrammableAddress};

/// Bus address with all address pins low.
pub const ADDRESS: u8 = 0x40;

/// Register of the first output, and four bytes for each of eight outputs.
pub type ServoBurst = [u8; 1 + 4 * JOINT_COUNT];

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

/// Why the chip cannot be used.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ServoFault {
    /// No acknowledge, or a stuck bus.
    NoAnswer,
    /// It answers, but what was written does not read back.
    WrongConfiguration,
}

impl<E> From<Error<E>> for ServoFault {
    fn from(_: Error<E>) -> Self {
        Self::NoAnswer
    }
}

/// Takes the pulses from all 16 outputs, in one write and in any state of the chip.
///
/// # Errors
/// [`ServoFault::NoAnswer`] if the chip did not take it.
pub fn switch_off(bus: &mut impl I2c) -> Result<(), ServoFault> {
    bus.write(ADDRESS, &[ALL_LED_OFF_H, FULL_OFF]).map_err(|_| ServoFault::NoAnswer)
}

/// Configures the chip from whatever state it is in, outputs off, and checks it.
///
/// # Errors
/// What is wrong with the chip.
pub fn configure(bus: &mut impl I2c, delay: &mut impl DelayNs, prescale: u8) -> Result<(), ServoFault> {
    let mut chip = Pca9685::new(&mut *bus, ADDRESS)?;
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
    check(bus, prescale)
}

/// Whether the chip still has its configuration.
///
/// # Errors
/// What is wrong with the chip.
pub fn check(bus: &mut impl I2c, prescale: u8) -> Result<(), ServoFault> {
    let mode1 = read(bus, MODE1)? & MODE1_MASK;
    let is_ours = read(bus, PRE_SCALE)? == prescale;
    if mode1 == MODE1_RUNNING && is_ours { Ok(()) } else { Err(ServoFault::WrongConfiguration) }
}

fn read(bus: &mut impl I2c, register: u8) -> Result<u8, ServoFault> {
    let mut value = [0];
    bus.write_read(ADDRESS, &[register], &mut value).map_err(|_| ServoFault::NoAnswer)?;
    Ok(value[0])
}

/// Gives each joint its pulse in a burst that starts as [`limp_burst`], if the
/// servos are to be on; tells whether one would be at its servo's limit.
pub fn set_pulses(
    burst: &mut ServoBurst,
    pose: &[Angle; JOINT_COUNT],
    calibration: &Calibration,
    servos_on: bool,
) -> bool {
    let mut held = false;
    for joint in Joint::ALL {
        let servo = calibration.joint(joint);
        let counts = servo.counts(pose[joint.index()].units());
        held |= counts == servo.min_counts || counts == servo.max_counts;
        if servos_on {
            set_pulse(burst, servo.channel, counts);
        }
    }
    held
}

/// Gives one output its pulse; others stay as they are.
pub fn set_pulse(burst: &mut ServoBurst, channel: u8, counts: u16) {
    let [low, high] = counts.to_le_bytes();
    // On at count 0, off at the pulse's end.
    if let Some(output) = burst.get_mut(1 + 4 * usize::from(channel)..).and_then(<[u8]>::first_chunk_mut) {
        *output = [0, 0, low, high];
    }
}

/// The burst that takes the pulses from all eight outputs.
#[must_use]
pub fn limp_burst() -> ServoBurst {
    let mut burst = [0; 1 + 4 * JOINT_COUNT];
    burst[0] = LED0_ON_L;
    for off_high in burst.iter_mut().skip(4).step_by(4) {
        *off_high = FULL_OFF;
    }
    burst
}
