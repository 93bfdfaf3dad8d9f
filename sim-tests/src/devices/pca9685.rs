//! The PCA9685 servo driver, register by register.
//!
//! Owns the chip's registers, its free-running oscillator and the pulses on
//! its pins. It knows nothing of the Nano: pulses go on through a reset of the
//! master, as they do on the bench. Refuses external clocks, the 0xFF test
//! register and the OE pin, none of which the robot wires. One chip, one file:
//! registers and pulses are of no use to each other apart.
//!
//! # Source
//! NXP PCA9685 product data sheet, revision 4, sections 7.1 to 7.6.

#[cfg(test)]
mod tests;

use super::{Device, PCA9685_ADDRESS};

/// Oscillator of a typical chip; single chips differ by several per cent.
pub const NOMINAL_OSCILLATOR_HZ: f64 = 25.0e6;
/// Channels of the chip.
pub const CHANNEL_COUNT: usize = 16;
/// Counts of one PWM cycle.
pub const COUNTS_PER_CYCLE: u16 = 4096;

const MODE1: u8 = 0x00;
const MODE2: u8 = 0x01;
const SUBADR1: u8 = 0x02;
const ALLCALLADR: u8 = 0x05;
const LED0_ON_L: u8 = 0x06;
const LED15_OFF_H: u8 = 0x45;
const ALL_LED_ON_L: u8 = 0xFA;
const ALL_LED_OFF_H: u8 = 0xFD;
const PRE_SCALE: u8 = 0xFE;

const RESTART: u8 = 0x80;
const AUTO_INCREMENT: u8 = 0x20;
const SLEEP: u8 = 0x10;
const ALLCALL: u8 = 0x01;
const INVERT: u8 = 0x10;
const CHANGE_ON_ACK: u8 = 0x08;

/// Full-on in an ON register, full-off in an OFF register.
const FULL: u16 = 0x1000;
/// Second byte of a software reset, after the general call address.
const SOFTWARE_RESET: u8 = 0x06;
/// Hardware forces at least this prescaler.
const MIN_PRESCALE: u8 = 3;

/// The ON and OFF registers of a channel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Led {
    on: u16,
    off: u16,
}

/// Full-off, as after power-on.
const LED_AT_POWER_ON: Led = Led { on: 0, off: FULL };

/// What the outputs changed to at one STOP.
#[derive(Debug, Clone, PartialEq)]
pub struct Burst {
    /// When the transaction's START came.
    pub start_s: f64,
    /// When its STOP came and the outputs changed.
    pub stop_s: f64,
    /// Pulse width of each channel in counts; `None` is no pulse.
    pub counts: [Option<u16>; CHANNEL_COUNT],
}

/// One chip.
#[derive(Debug)]
pub struct Pca9685 {
    oscillator_hz: f64,
    mode1: u8,
    mode2: u8,
    /// SUBADR1 to SUBADR3, then ALLCALLADR.
    addresses: [u8; 4],
    prescale: u8,
    leds: [Led; CHANNEL_COUNT],
    /// What the outputs follow: the registers as of the last STOP.
    latched: [Led; CHANNEL_COUNT],
    /// When the counters started; `None` while the oscillator sleeps.
    running_since_s: Option<f64>,
    /// Woken after a sleep with channels on: stopped until RESTART or a write.
    halted: bool,
    /// Number of the PWM cycle that `on_pins_us` belongs to.
    cycle: f64,
    on_pins_us: [Option<f64>; CHANNEL_COUNT],
    control: Option<u8>,
    general_call: bool,
    leds_written: bool,
    start_s: f64,
    bursts: Vec<Burst>,
}

impl Pca9685 {
    /// A chip just powered on, with this oscillator.
    #[must_use]
    pub fn new(oscillator_hz: f64) -> Self {
        Self {
            oscillator_hz,
            mode1: SLEEP | ALLCALL,
            mode2: 0x04,
            addresses: [0xE2, 0xE4, 0xE8, 0xE0],
            prescale: 0x1E,
            leds: [LED_AT_POWER_ON; CHANNEL_COUNT],
            latched: [LED_AT_POWER_ON; CHANNEL_COUNT],
            running_since_s: None,
            halted: false,
            cycle: -1.0,
            on_pins_us: [None; CHANNEL_COUNT],
            control: None,
            general_call: false,
            leds_written: false,
            start_s: 0.0,
            bursts: Vec::new(),
        }
    }

    /// One count in microseconds: `(prescale + 1) / oscillator`.
    #[must_use]
    pub fn count_us(&self) -> f64 {
        (f64::from(self.prescale) + 1.0) / self.oscillator_hz * 1e6
    }

    /// PWM cycles a second.
    #[must_use]
    pub fn frequency_hz(&self) -> f64 {
        1e6 / (self.count_us() * f64::from(COUNTS_PER_CYCLE))
    }

    /// Whether the oscillator is off.
    #[must_use]
    pub fn is_asleep(&self) -> bool {
        self.mode1 & SLEEP != 0
    }

    /// The pulse that each servo got last; `None` where no pulses come.
    ///
    /// A servo sees a new width only when the chip's next PWM cycle begins,
    /// up to 16.7 ms after the registers changed.
    pub fn pulses_us(&mut self, now_s: f64) -> [Option<f64>; CHANNEL_COUNT] {
        self.run_counters(now_s);
        self.on_pins_us
    }

    /// Pulse widths in counts as the registers ask, whatever the oscillator does.
    #[must_use]
    pub fn counts(&self) -> [Option<u16>; CHANNEL_COUNT] {
        self.latched.map(|led| width(led, self.mode2 & INVERT != 0))
    }

    /// Whether any servo gets pulses, now or as soon as a PWM cycle begins.
    #[must_use]
    pub fn drives_any(&self) -> bool {
        self.running_since_s.is_some() && !self.halted && self.counts().iter().any(Option::is_some)
    }

    /// Every change of the outputs since the last call, in order.
    pub fn take_bursts(&mut self) -> Vec<Burst> {
        std::mem::take(&mut self.bursts)
    }

    /// Brings `on_pins_us` up to date; registers were constant since last time.
    fn run_counters(&mut self, now_s: f64) {
        let Some(since_s) = self.running_since_s.filter(|_| !self.halted) else {
            self.on_pins_us = [None; CHANNEL_COUNT];
            self.cycle = -1.0;
            return;
        };
        let cycle = ((now_s - since_s) * self.frequency_hz()).floor();
        if cycle > self.cycle {
            self.cycle = cycle;
            let count_us = self.count_us();
            self.on_pins_us = self.counts().map(|counts| counts.map(|c| f64::from(c) * count_us));
        }
    }

    fn write_register(&mut self, register: u8, value: u8, now_s: f64) {
        match register {
            MODE1 => self.write_mode1(value, now_s),
            MODE2 => self.mode2 = value & 0x1F,
            SUBADR1..=ALLCALLADR => self.addresses[usize::from(register - SUBADR1)] = value & 0xFE,
            LED0_ON_L..=LED15_OFF_H => {
                let index = usize::from(register - LED0_ON_L);
                write_led(&mut self.leds[index / 4], index % 4, value);
                self.leds_written = true;
            }
            ALL_LED_ON_L..=ALL_LED_OFF_H => {
                for led in &mut self.leds {
                    write_led(led, usize::from(register - ALL_LED_ON_L), value);
                }
                self.leds_written = true;
            }
            // Blocked unless the oscillator sleeps (table 5, remark 1).
            PRE_SCALE if self.is_asleep() => self.prescale = value.max(MIN_PRESCALE),
            _ => {}
        }
        if self.mode2 & CHANGE_ON_ACK != 0 && self.leds_written {
            self.latch(now_s);
        }
    }

    fn write_mode1(&mut self, value: u8, now_s: f64) {
        let was_asleep = self.is_asleep();
        let was_restart = self.mode1 & RESTART;
        self.run_counters(now_s);
        self.mode1 = (value & 0x7F) | was_restart;
        match (was_asleep, self.is_asleep()) {
            (false, true) => {
                // Sleeping with channels on is noted in RESTART.
                if self.drives_any() {
                    self.mode1 |= RESTART;
                }
                self.running_since_s = None;
                self.run_counters(now_s);
            }
            (true, false) => {
                self.running_since_s = Some(now_s);
                self.halted = was_restart != 0;
                self.cycle = -1.0;
            }
            _ => {}
        }
        // Writing 1 restarts the channels and clears the bit; 0 leaves it.
        if value & RESTART != 0 && !self.is_asleep() {
            self.mode1 &= !RESTART;
            self.halted = false;
        }
    }

    fn read_register(&self, register: u8) -> u8 {
        match register {
            MODE1 => self.mode1,
            MODE2 => self.mode2,
            SUBADR1..=ALLCALLADR => self.addresses[usize::from(register - SUBADR1)],
            LED0_ON_L..=LED15_OFF_H => {
                let index = usize::from(register - LED0_ON_L);
                let led = self.leds[index / 4];
                let word = if index % 4 < 2 { led.on } else { led.off };
                word.to_le_bytes()[index % 2]
            }
            PRE_SCALE => self.prescale,
            // ALL_LED registers read as zero.
            _ => 0,
        }
    }

    /// Outputs follow the registers from here on.
    fn latch(&mut self, now_s: f64) {
        self.run_counters(now_s);
        self.leds_written = false;
        self.latched = self.leds;
        if !self.is_asleep() {
            // Section 7.3.1.1: a write to a PWM register clears RESTART.
            self.mode1 &= !RESTART;
            self.halted = false;
        }
        self.bursts.push(Burst { start_s: self.start_s, stop_s: now_s, counts: self.counts() });
    }

    fn next_register(register: u8) -> u8 {
        match register {
            LED15_OFF_H | PRE_SCALE => MODE1,
            _ => register.wrapping_add(1),
        }
    }

    fn step_control(&mut self, register: u8) {
        if self.mode1 & AUTO_INCREMENT != 0 {
            self.control = Some(Self::next_register(register));
        }
    }
}

impl Device for Pca9685 {
    fn select(&mut self, address: u8, read: bool, now_s: f64) -> bool {
        // MODE1 bits 3 to 0 enable SUBADR1 to SUBADR3 and ALLCALL, in that order.
        let also = self.addresses.iter().zip([8, 4, 2, 1]);
        let by_group =
            !read && also.into_iter().any(|(&a, enable)| self.mode1 & enable != 0 && a >> 1 == address);
        self.general_call = address == 0 && !read;
        let selected = address == PCA9685_ADDRESS || by_group || self.general_call;
        if selected {
            self.start_s = now_s;
            if !read {
                self.control = None;
            }
        }
        selected
    }

    fn write(&mut self, byte: u8, now_s: f64) -> bool {
        if self.general_call {
            if byte == SOFTWARE_RESET {
                let bursts = std::mem::take(&mut self.bursts);
                *self = Self { bursts, ..Self::new(self.oscillator_hz) };
            }
            return byte == SOFTWARE_RESET;
        }
        match self.control {
            None => self.control = Some(byte),
            Some(register) => {
                self.write_register(register, byte, now_s);
                self.step_control(register);
            }
        }
        true
    }

    fn read(&mut self, _now_s: f64) -> u8 {
        let register = self.control.unwrap_or(MODE1);
        let value = self.read_register(register);
        self.step_control(register);
        value
    }

    fn stop(&mut self, now_s: f64) {
        if self.leds_written {
            self.latch(now_s);
        }
        self.general_call = false;
    }
}

fn write_led(led: &mut Led, byte_index: usize, value: u8) {
    let word = if byte_index < 2 { &mut led.on } else { &mut led.off };
    *word = if byte_index.is_multiple_of(2) {
        *word & 0xFF00 | u16::from(value)
    } else {
        // Bits 7 to 5 of the high bytes are not writable.
        *word & 0x00FF | u16::from(value & 0x1F) << 8
    };
}

/// High time in counts; `None` if the pin never changes level.
fn width(led: Led, inverted: bool) -> Option<u16> {
    // Full-off has precedence over full-on (section 7.3.3).
    let high = if led.off & FULL != 0 {
        0
    } else if led.on & FULL != 0 {
        COUNTS_PER_CYCLE
    } else {
        led.off.wrapping_sub(led.on) & (COUNTS_PER_CYCLE - 1)
    };
    let high = if inverted { COUNTS_PER_CYCLE - high } else { high };
    (high != 0 && high != COUNTS_PER_CYCLE).then_some(high)
}
