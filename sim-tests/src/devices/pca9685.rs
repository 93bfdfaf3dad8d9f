//! The PCA9685 servo driver, register by register.
//!
//! Holds the chip's registers, what its address decoder answers to, and its
//! sleep and restart; the pins are in `outputs`. Does not depend on the Nano:
//! pulses go on through a reset of the master, as they do on the bench.
//! What the data sheet forbids or leaves open has no effect here, and is noted
//! as a [`Misuse`]. Left out are external clocks, which the robot does not wire, the
//! bus time-out after 25 ms, and the start-up of the oscillator: pulses come
//! immediately. Longer than most files: bus, mode bits and restart are one state.
//!
//! # Source
//! NXP PCA9685 product data sheet, revision 4, sections 7.1 to 7.6.

mod outputs;
#[cfg(test)]
mod tests;

use super::Device;
pub use outputs::{CHANNEL_COUNT, COUNTS_PER_CYCLE};
use outputs::{Outputs, width};

/// Oscillator of a typical chip; single chips differ by several per cent.
pub const NOMINAL_OSCILLATOR_HZ: f64 = 25.0e6;
/// What is met in practice, slowest and fastest; the data sheet gives no limits.
pub const OSCILLATOR_SPREAD_HZ: [f64; 2] = [24.0e6, 25.5e6];

const MODE1: u8 = 0x00;
const MODE2: u8 = 0x01;
const SUBADR1: u8 = 0x02;
const ALLCALLADR: u8 = 0x05;
const LED0_ON_L: u8 = 0x06;
const LED15_OFF_H: u8 = 0x45;
/// The first of those up to [`ALL_LED_ON_L`].
const RESERVED: u8 = LED15_OFF_H + 1;
const ALL_LED_ON_L: u8 = 0xFA;
const ALL_LED_OFF_H: u8 = 0xFD;
const PRE_SCALE: u8 = 0xFE;
const TEST_MODE: u8 = 0xFF;

const RESTART: u8 = 0x80;
const EXTERNAL_CLOCK: u8 = 0x40;
const AUTO_INCREMENT: u8 = 0x20;
const SLEEP: u8 = 0x10;
const ALLCALL: u8 = 0x01;
const CHANGE_ON_ACK: u8 = 0x08;

/// Second byte of a software reset, after the general call address.
const SOFTWARE_RESET: u8 = 0x06;
/// Hardware forces at least this prescaler.
const MIN_PRESCALE: u8 = 3;
/// The oscillator runs so long after the end of sleep (table 5, remark 2).
const START_UP_S: f64 = 500e-6;

/// What the outputs changed to, at a STOP or, with OCH set, at an acknowledge.
#[derive(Debug, Clone, PartialEq)]
pub struct Burst {
    /// When the transaction's START came.
    pub start_s: f64,
    /// When the outputs changed.
    pub stop_s: f64,
    /// Pulse width of each channel in counts; `None` is no pulse.
    pub counts: [Option<u16>; CHANNEL_COUNT],
}

/// Something that the data sheet forbids, or says will have no effect.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Misuse {
    /// The prescaler was written while the oscillator ran: nothing happened.
    PrescaleWhileAwake,
    /// RESTART was written less than 500 us after the end of sleep: nothing happened.
    RestartTooEarly,
    /// Pulses were asked for less than 500 us after the end of sleep: their
    /// timing is not guaranteed.
    PulsesWhileStarting,
    /// A channel is to go on and off at the same count.
    EqualOnAndOff,
    /// The external clock was chosen; this robot wires none, so all pulses end.
    ExternalClock,
    /// A register that is reserved, or the test mode: not acknowledged.
    Reserved(u8),
}

/// How far a software reset has come.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum GeneralCall {
    Not,
    Addressed,
    /// Resets at the STOP.
    Armed,
}

#[derive(Debug)]
pub struct Pca9685 {
    address: u8,
    oscillator_hz: f64,
    mode1: u8,
    mode2: u8,
    /// SUBADR1 to SUBADR3, then ALLCALLADR.
    addresses: [u8; 4],
    prescale: u8,
    outputs: Outputs,
    /// When SLEEP was cleared last.
    woken_s: f64,
    pointer: u8,
    /// The next byte written is the pointer.
    wants_pointer: bool,
    general_call: GeneralCall,
    start_s: f64,
    bursts: Vec<Burst>,
    misuses: Vec<Misuse>,
}

impl Pca9685 {
    /// A typical chip just powered on, at this 7-bit address.
    #[must_use]
    pub fn new(address: u8) -> Self {
        Self {
            address,
            oscillator_hz: NOMINAL_OSCILLATOR_HZ,
            mode1: SLEEP | ALLCALL,
            mode2: outputs::TOTEM_POLE,
            addresses: [0xE2, 0xE4, 0xE8, 0xE0],
            prescale: 0x1E,
            outputs: Outputs::new(),
            woken_s: 0.0,
            pointer: MODE1,
            wants_pointer: false,
            general_call: GeneralCall::Not,
            start_s: 0.0,
            bursts: Vec::new(),
            misuses: Vec::new(),
        }
    }

    /// The same chip with another oscillator.
    #[must_use]
    pub fn with_oscillator(self, oscillator_hz: f64) -> Self {
        Self { oscillator_hz, ..self }
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

    /// Whether the oscillator is off, or will be when the PWM cycle ends.
    #[must_use]
    pub fn is_asleep(&self) -> bool {
        self.mode1 & SLEEP != 0
    }

    /// The pulse that each servo got last; `None` where no pulses come.
    ///
    /// A servo sees a new width only when the chip's next PWM cycle begins,
    /// up to 16.7 ms after the registers changed.
    pub fn pulses_us(&mut self, now_s: f64) -> [Option<f64>; CHANNEL_COUNT] {
        self.settle(now_s);
        self.outputs.pulses_us()
    }

    /// When the last pulse that began before `now_s` ends or ended, if there
    /// was any.
    pub fn last_pulse_ends_s(&mut self, now_s: f64) -> Option<f64> {
        self.settle(now_s);
        self.outputs.last_pulse_ends_s
    }

    /// Pulse widths in counts as the registers ask, whatever the oscillator
    /// and the pin OE do.
    #[must_use]
    pub fn counts(&self) -> [Option<u16>; CHANNEL_COUNT] {
        self.outputs.latched.map(|led| width(led, self.mode2))
    }

    /// Whether any servo gets pulses, now or as soon as a PWM cycle begins.
    #[must_use]
    pub fn drives_any(&self) -> bool {
        self.outputs.will_go_on() && self.counts().iter().any(Option::is_some)
    }

    /// The level on the pin OE: true, low, lets the registers have the outputs;
    /// otherwise no servo gets a pulse (MODE2's OUTNE can make the pins high or
    /// open, but no pulse of them). Registers and counters go on meanwhile.
    pub fn set_enabled(&mut self, enabled: bool, now_s: f64) {
        self.settle(now_s);
        self.outputs.set_enabled(enabled, now_s);
    }

    /// Whether the pin OE is low.
    #[must_use]
    pub fn is_enabled(&self) -> bool {
        self.outputs.enabled
    }

    /// Every change of the outputs since the last call, in order.
    pub fn take_bursts(&mut self) -> Vec<Burst> {
        std::mem::take(&mut self.bursts)
    }

    /// What the chip was asked to do against its data sheet, in order.
    #[must_use]
    pub fn misuses(&self) -> &[Misuse] {
        &self.misuses
    }

    /// Brings outputs and RESTART up to date; nothing changed since last time.
    fn settle(&mut self, now_s: f64) {
        let counts = self.counts();
        if self.outputs.run(now_s, &counts) {
            self.mode1 |= RESTART;
        }
    }

    /// Lets the counters run if they should, and no longer than they should.
    fn control_counters(&mut self, now_s: f64) {
        let may_run = self.mode1 & (SLEEP | RESTART | EXTERNAL_CLOCK) == 0;
        let cycle_s = 1.0 / self.frequency_hz();
        self.outputs.control(now_s, may_run, cycle_s);
        self.settle(now_s);
    }

    fn write_register(&mut self, register: u8, value: u8, now_s: f64) {
        self.settle(now_s);
        match register {
            MODE1 => self.write_mode1(value, now_s),
            MODE2 => self.mode2 = value & 0x1F,
            SUBADR1..=ALLCALLADR => self.addresses[usize::from(register - SUBADR1)] = value & 0xFE,
            LED0_ON_L..=LED15_OFF_H => {
                let index = usize::from(register - LED0_ON_L);
                let is_whole = self.outputs.write(index / 4, index % 4, value);
                // An update on ACK wants all four registers of a channel (table 6).
                if is_whole && self.mode2 & CHANGE_ON_ACK != 0 {
                    self.latch(now_s);
                }
            }
            ALL_LED_ON_L..=ALL_LED_OFF_H => {
                for channel in 0..CHANNEL_COUNT {
                    self.outputs.write(channel, usize::from(register - ALL_LED_ON_L), value);
                }
                if self.mode2 & CHANGE_ON_ACK != 0 {
                    self.latch(now_s);
                }
            }
            // Blocked unless the oscillator sleeps (table 4, note 1).
            PRE_SCALE if self.is_asleep() => self.prescale = value.max(MIN_PRESCALE),
            PRE_SCALE => self.misuses.push(Misuse::PrescaleWhileAwake),
            _ => {}
        }
    }

    fn write_mode1(&mut self, value: u8, now_s: f64) {
        let was_asleep = self.is_asleep();
        // Sticky: only asleep can it be set, and only a reset clears it.
        let external = self.mode1 & EXTERNAL_CLOCK | if was_asleep { value & EXTERNAL_CLOCK } else { 0 };
        if external & !self.mode1 != 0 {
            self.misuses.push(Misuse::ExternalClock);
        }
        self.mode1 = self.mode1 & RESTART | external | value & !(RESTART | EXTERNAL_CLOCK);
        match (was_asleep, self.is_asleep()) {
            // RESTART is set when the cycle ends, if any channel was not off by then.
            (false, true) => self.outputs.stop_after_this_cycle(now_s),
            (true, false) => {
                self.outputs.stop_now();
                self.woken_s = now_s;
            }
            _ => {}
        }
        // Writing 1 restarts the channels and clears the bit; 0 leaves it.
        if value & self.mode1 & RESTART != 0 && !self.is_asleep() {
            if now_s - self.woken_s >= START_UP_S {
                self.mode1 &= !RESTART;
            } else {
                self.misuses.push(Misuse::RestartTooEarly);
            }
        }
        self.control_counters(now_s);
    }

    fn read_register(&self, register: u8) -> u8 {
        match register {
            MODE1 => self.mode1,
            MODE2 => self.mode2,
            SUBADR1..=ALLCALLADR => self.addresses[usize::from(register - SUBADR1)],
            LED0_ON_L..=LED15_OFF_H => {
                let index = usize::from(register - LED0_ON_L);
                self.outputs.read(index / 4, index % 4)
            }
            PRE_SCALE => self.prescale,
            // ALL_LED registers read as zero.
            _ => 0,
        }
    }

    /// Outputs follow the registers from here on.
    fn latch(&mut self, now_s: f64) {
        self.settle(now_s);
        let before = self.counts();
        let on_stop = self.mode2 & CHANGE_ON_ACK == 0;
        self.outputs.latch(on_stop);
        // Section 7.3.1.1: such a write clears RESTART.
        self.mode1 &= !RESTART;
        self.control_counters(now_s);
        let counts = self.counts();
        let is_starting = !self.is_asleep() && now_s - self.woken_s < START_UP_S;
        if is_starting && counts != before && counts.iter().any(Option::is_some) {
            self.misuses.push(Misuse::PulsesWhileStarting);
        }
        if self.outputs.has_equal_counts() {
            self.misuses.push(Misuse::EqualOnAndOff);
        }
        self.bursts.push(Burst { start_s: self.start_s, stop_s: now_s, counts });
    }

    fn step_pointer(&mut self) {
        if self.mode1 & AUTO_INCREMENT != 0 {
            self.pointer = match self.pointer {
                LED15_OFF_H | PRE_SCALE => MODE1,
                register => register.wrapping_add(1),
            };
        }
    }

    /// Software reset: as after power-on, but for what tests have noted.
    fn reset(&mut self, now_s: f64) {
        self.settle(now_s);
        let (bursts, misuses) = (std::mem::take(&mut self.bursts), std::mem::take(&mut self.misuses));
        let (enabled, last) = (self.outputs.enabled, self.outputs.last_pulse_ends_s);
        *self = Self { bursts, misuses, ..Self::new(self.address).with_oscillator(self.oscillator_hz) };
        (self.outputs.enabled, self.outputs.last_pulse_ends_s) = (enabled, last);
    }
}

impl Device for Pca9685 {
    fn select(&mut self, address: u8, read: bool, now_s: f64) -> bool {
        self.settle(now_s);
        // MODE1 bits 3 to 0 enable SUBADR1 to SUBADR3 and ALLCALL, in that order,
        // for reading as well as for writing.
        let mut also = self.addresses.iter().zip([8, 4, 2, 1]);
        let by_group = also.any(|(&a, enable)| self.mode1 & enable != 0 && a >> 1 == address);
        let is_general = address == 0 && !read;
        // A repeated START after the reset's byte is not a software reset.
        self.general_call = if is_general { GeneralCall::Addressed } else { GeneralCall::Not };
        let selected = address == self.address || by_group || is_general;
        if selected {
            self.start_s = now_s;
            self.wants_pointer = !read;
        }
        selected
    }

    fn write(&mut self, byte: u8, now_s: f64) -> bool {
        if self.general_call != GeneralCall::Not {
            let is_reset = self.general_call == GeneralCall::Addressed && byte == SOFTWARE_RESET;
            // One byte more, or another, and it is called off.
            self.general_call = if is_reset { GeneralCall::Armed } else { GeneralCall::Not };
            return is_reset;
        }
        if self.wants_pointer {
            self.wants_pointer = matches!(byte, RESERVED..ALL_LED_ON_L | TEST_MODE);
            if self.wants_pointer {
                self.misuses.push(Misuse::Reserved(byte));
                return false;
            }
            self.pointer = byte;
            return true;
        }
        self.write_register(self.pointer, byte, now_s);
        self.step_pointer();
        true
    }

    fn read(&mut self, now_s: f64) -> u8 {
        self.settle(now_s);
        let value = self.read_register(self.pointer);
        self.step_pointer();
        value
    }

    fn stop(&mut self, now_s: f64) {
        if self.general_call == GeneralCall::Armed {
            self.reset(now_s);
        }
        self.general_call = GeneralCall::Not;
        if self.outputs.is_written() && self.mode2 & CHANGE_ON_ACK == 0 {
            self.latch(now_s);
        }
    }
}
