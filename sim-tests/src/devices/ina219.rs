//! The INA219 power sensor, register by register, in emulated time.
//!
//! Holds conversions: each is the mean of its input over its own window, shunt
//! and bus alternately, as the chip's delta-sigma converter takes them. What the
//! current does in between goes unseen, as it does on the bench. Noise, offset and
//! gain errors, and the bus time-out after 28 ms, are left out: this is an ideal chip
//! with a real register file. Does not depend on the firmware. Longer than most
//! files: conversions and registers are one state. The data sheet leaves open how coarse
//! 9 to 11 bits are in the wider ranges of the shunt; here each bit less doubles
//! the registers' unit, in every range.
//!
//! # Source
//! TI SBOS448G, sections 7.5 and 8.3 to 8.6.

#[cfg(test)]
mod tests;

use super::Device;

/// Configuration after power-on: 32 V, 320 mV, 12 bits, both continuously.
pub const DEFAULT_CONFIGURATION: u16 = 0x399F;
/// Shunt voltage register's unit.
pub const SHUNT_LSB_V: f64 = 10e-6;
/// Bus voltage register's unit.
pub const BUS_LSB_V: f64 = 4e-3;

const CONFIGURATION: u8 = 0;
const SHUNT: u8 = 1;
const BUS: u8 = 2;
const POWER: u8 = 3;
const CURRENT: u8 = 4;
const CALIBRATION: u8 = 5;

const RESET: u16 = 0x8000;
/// Bit 14 is not there.
const WRITABLE: u16 = 0x3FFF;
const CONVERSION_READY: u16 = 0x0002;
const OVERFLOW: u16 = 0x0001;
/// The byte after the general call address that resets the chip (8.5.6.2).
const GENERAL_RESET: u8 = 0x06;
/// From a power-down to the first conversion (8.3).
const RECOVERY_S: f64 = 40e-6;

/// Conversion times of settings 0 to 3 (9 to 12 bits) in seconds.
const SINGLE_S: [f64; 4] = [84e-6, 148e-6, 276e-6, 532e-6];
/// Conversion times of settings 8 to 15 (1 to 128 samples) in seconds.
const AVERAGED_S: [f64; 8] = [532e-6, 1.06e-3, 2.13e-3, 4.26e-3, 8.51e-3, 17.02e-3, 34.05e-3, 68.10e-3];

/// Which input a conversion measures.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Input {
    Shunt,
    Bus,
}

#[derive(Debug, Clone, Copy)]
struct Conversion {
    input: Input,
    started_s: f64,
    ends_s: f64,
    /// Volt-seconds so far.
    integral: f64,
}

#[derive(Debug)]
pub struct Ina219 {
    address: u8,
    configuration: u16,
    calibration: u16,
    shunt: i16,
    bus: u16,
    power: u16,
    current: i16,
    ready: bool,
    overflow: bool,
    conversion: Option<Conversion>,
    /// Conversion times of this chip over the typical ones.
    pace: f64,
    shunt_v: f64,
    bus_v: f64,
    now_s: f64,
    pointer: u8,
    general_call: bool,
    /// Bytes since the START, and the first data byte of a word.
    written: u8,
    high_byte: u8,
    /// Bytes sent since the START, and the word being sent.
    sent: u8,
    word: u16,
}

impl Ina219 {
    /// A chip just powered on at this 7-bit address, with nothing at its inputs.
    #[must_use]
    pub fn new(address: u8) -> Self {
        let mut chip = Self {
            address,
            configuration: DEFAULT_CONFIGURATION,
            calibration: 0,
            shunt: 0,
            bus: 0,
            power: 0,
            current: 0,
            ready: false,
            overflow: false,
            conversion: None,
            pace: 1.0,
            shunt_v: 0.0,
            bus_v: 0.0,
            now_s: 0.0,
            pointer: 0,
            general_call: false,
            written: 0,
            high_byte: 0,
            sent: 0,
            word: 0,
        };
        chip.restart(0.0);
        chip
    }

    /// A chip whose conversions take so many times the typical time; the data
    /// sheet allows 1.1.
    #[must_use]
    pub fn with_pace(address: u8, pace: f64) -> Self {
        let mut chip = Self { pace, ..Self::new(address) };
        chip.restart(0.0);
        chip
    }

    /// Sets the voltages at the inputs from `now_s` on.
    pub fn set_inputs(&mut self, shunt_v: f64, bus_v: f64, now_s: f64) {
        self.advance(now_s);
        self.shunt_v = shunt_v;
        self.bus_v = bus_v;
    }

    /// The supply sagged so far that the chip started anew.
    pub fn brown_out(&mut self, now_s: f64) {
        self.advance(now_s);
        let (shunt_v, bus_v, pace) = (self.shunt_v, self.bus_v, self.pace);
        *self = Self { shunt_v, bus_v, pace, now_s, ..Self::new(self.address) };
        self.restart(0.0);
    }

    /// The configuration register, for tests.
    #[must_use]
    pub fn configuration(&self) -> u16 {
        self.configuration
    }

    /// Integrates the inputs and finishes conversions up to `now_s`.
    fn advance(&mut self, now_s: f64) {
        while let Some(conversion) = &mut self.conversion {
            let until_s = conversion.ends_s.min(now_s);
            let volts = match conversion.input {
                Input::Shunt => self.shunt_v,
                Input::Bus => self.bus_v,
            };
            let from_s = self.now_s.max(conversion.started_s);
            conversion.integral += volts * (until_s - from_s).max(0.0);
            self.now_s = self.now_s.max(until_s);
            if conversion.ends_s > now_s {
                break;
            }
            let finished = *conversion;
            self.finish(finished);
        }
        self.now_s = self.now_s.max(now_s);
    }

    fn finish(&mut self, conversion: Conversion) {
        let mean_v = conversion.integral / (conversion.ends_s - conversion.started_s);
        match conversion.input {
            Input::Shunt => {
                let full_scale = 4000_i16 << ((self.configuration >> 11) & 3);
                let step = coarseness(self.configuration >> 3);
                let counts = (mean_v / SHUNT_LSB_V / step).round() * step;
                self.shunt = counts.clamp(f64::from(-full_scale), f64::from(full_scale)) as i16;
            }
            Input::Bus => {
                let full_scale = if self.configuration & 0x2000 == 0 { 4000.0 } else { 8000.0 };
                let step = coarseness(self.configuration >> 7);
                self.bus = ((mean_v / BUS_LSB_V / step).round() * step).clamp(0.0, full_scale) as u16;
            }
        }
        let both = self.mode() & 3 == 3;
        if both && conversion.input == Input::Shunt {
            self.begin(Input::Bus, conversion.ends_s);
            return;
        }
        self.multiply();
        self.ready = true;
        // Bit 2 of the mode makes it continuous.
        match self.first_input().filter(|_| self.mode() & 4 != 0) {
            Some(input) => self.begin(input, conversion.ends_s),
            None => self.conversion = None,
        }
    }

    /// Current and power from the calibration (equations 4 and 5).
    fn multiply(&mut self) {
        let current = i32::from(self.shunt) * i32::from(self.calibration) / 4096;
        let power = current.unsigned_abs() * u32::from(self.bus) / 5000;
        self.overflow = i16::try_from(current).is_err() || u16::try_from(power).is_err();
        self.current = current as i16;
        self.power = power as u16;
    }

    fn begin(&mut self, input: Input, at_s: f64) {
        let setting = match input {
            Input::Shunt => self.configuration >> 3,
            Input::Bus => self.configuration >> 7,
        };
        let ends_s = at_s + conversion_time_s(setting) * self.pace;
        self.conversion = Some(Conversion { input, started_s: at_s, ends_s, integral: 0.0 });
    }

    fn mode(&self) -> u16 {
        self.configuration & 7
    }

    fn first_input(&self) -> Option<Input> {
        match self.mode() & 3 {
            0 => None,
            2 => Some(Input::Bus),
            _ => Some(Input::Shunt),
        }
    }

    /// A write to the configuration ends the conversion under way, and begins
    /// a new round of them in so many seconds.
    fn restart(&mut self, delay_s: f64) {
        match self.first_input() {
            Some(input) => self.begin(input, self.now_s + delay_s),
            None => self.conversion = None,
        }
    }

    fn write_word(&mut self, value: u16, now_s: f64) {
        match self.pointer {
            CONFIGURATION if value & RESET != 0 => self.brown_out(now_s),
            CONFIGURATION => {
                let delay_s = if self.mode() == 0 { RECOVERY_S } else { 0.0 };
                self.configuration = value & WRITABLE;
                // Power-down and "ADC off" leave the flag.
                if self.mode() & 3 != 0 {
                    self.ready = false;
                }
                self.restart(delay_s);
            }
            // Bit 0 is not implemented and reads as zero.
            CALIBRATION => self.calibration = value & 0xFFFE,
            _ => {}
        }
    }

    fn read_word(&mut self) -> u16 {
        match self.pointer {
            CONFIGURATION => self.configuration,
            SHUNT => self.shunt as u16,
            BUS => {
                let flag = |set, bit| if set { bit } else { 0 };
                self.bus << 3 | flag(self.ready, CONVERSION_READY) | flag(self.overflow, OVERFLOW)
            }
            POWER => {
                self.ready = false;
                self.power
            }
            CURRENT => self.current as u16,
            CALIBRATION => self.calibration,
            _ => 0,
        }
    }
}

impl Device for Ina219 {
    fn select(&mut self, address: u8, read: bool, now_s: f64) -> bool {
        self.advance(now_s);
        self.written = 0;
        self.sent = 0;
        self.general_call = address == 0 && !read;
        address == self.address || self.general_call
    }

    fn write(&mut self, byte: u8, now_s: f64) -> bool {
        self.advance(now_s);
        if self.general_call {
            if byte == GENERAL_RESET {
                self.brown_out(now_s);
            }
            return byte == GENERAL_RESET;
        }
        match self.written {
            0 => self.pointer = byte,
            1 => self.high_byte = byte,
            2 => self.write_word(u16::from_be_bytes([self.high_byte, byte]), now_s),
            _ => {}
        }
        self.written = self.written.saturating_add(1);
        true
    }

    fn read(&mut self, now_s: f64) -> u8 {
        self.advance(now_s);
        // The word is taken at its first byte: a conversion that ends between
        // the bytes must not tear it.
        if self.sent.is_multiple_of(2) {
            self.word = self.read_word();
        }
        let byte = self.word.to_be_bytes()[usize::from(self.sent % 2)];
        self.sent = self.sent.wrapping_add(1);
        byte
    }

    fn stop(&mut self, now_s: f64) {
        self.advance(now_s);
    }
}

/// Time of a conversion by its 4-bit setting (table 5).
fn conversion_time_s(setting: u16) -> f64 {
    let setting = usize::from(setting & 0xF);
    if setting < 8 { SINGLE_S[setting & 3] } else { AVERAGED_S[setting - 8] }
}

/// Registers' units per step of the converter: 9 bits leave out three.
fn coarseness(setting: u16) -> f64 {
    let setting = setting & 0xF;
    if setting < 8 { f64::from(8_u8 >> (setting & 3)) } else { 1.0 }
}
