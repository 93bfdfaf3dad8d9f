//! The PCA9685's sixteen outputs: registers, counters, pulses.
//!
//! Holds the PWM registers, what the outputs follow of them, the counters, and
//! the pulses on the pins. Does not depend on the bus, nor on the mode registers but
//! for the bits that shape a pulse.

/// Channels of the chip.
pub const CHANNEL_COUNT: usize = 16;
/// Counts of one PWM cycle.
pub const COUNTS_PER_CYCLE: u16 = 4096;

/// MODE2: outputs drive high too; without it they are open drains.
pub(super) const TOTEM_POLE: u8 = 0x04;
/// MODE2: high and low change places.
const INVERT: u8 = 0x10;
/// Full-on in an ON register, full-off in an OFF register.
const FULL: u16 = 0x1000;
/// All four registers of a channel.
const WHOLE: u8 = 0b1111;

/// The ON and OFF registers of a channel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Led {
    pub on: u16,
    pub off: u16,
}

/// Full-off, as after power-on.
const LED_AT_POWER_ON: Led = Led { on: 0, off: FULL };

/// The counters, running.
#[derive(Debug, Clone, Copy)]
struct Counters {
    since_s: f64,
    cycle_s: f64,
    /// Number of the cycle that the pins are in; -1 before the first look.
    cycle: f64,
    /// Asleep: they stop here, at the end of a cycle.
    end_s: Option<f64>,
}

#[derive(Debug)]
pub(super) struct Outputs {
    leds: [Led; CHANNEL_COUNT],
    /// Registers of each channel written since they were latched, as bits.
    written: [u8; CHANNEL_COUNT],
    /// What the outputs follow.
    pub latched: [Led; CHANNEL_COUNT],
    counters: Option<Counters>,
    /// The pin OE is low.
    pub enabled: bool,
    on_pins_us: [Option<f64>; CHANNEL_COUNT],
    /// End of the longest pulse of the last cycle that had any.
    pub last_pulse_ends_s: Option<f64>,
}

impl Outputs {
    pub fn new() -> Self {
        Self {
            leds: [LED_AT_POWER_ON; CHANNEL_COUNT],
            written: [0; CHANNEL_COUNT],
            latched: [LED_AT_POWER_ON; CHANNEL_COUNT],
            counters: None,
            enabled: true,
            on_pins_us: [None; CHANNEL_COUNT],
            last_pulse_ends_s: None,
        }
    }

    /// Writes one of a channel's four registers; true if all four are written.
    pub fn write(&mut self, channel: usize, byte_index: usize, value: u8) -> bool {
        let led = &mut self.leds[channel];
        let word = if byte_index < 2 { &mut led.on } else { &mut led.off };
        *word = if byte_index.is_multiple_of(2) {
            *word & 0xFF00 | u16::from(value)
        } else {
            // Bits 7 to 5 of the high bytes are not writable.
            *word & 0x00FF | u16::from(value & 0x1F) << 8
        };
        self.written[channel] |= 1 << byte_index;
        self.written[channel] == WHOLE
    }

    pub fn read(&self, channel: usize, byte_index: usize) -> u8 {
        let led = self.leds[channel];
        let word = if byte_index < 2 { led.on } else { led.off };
        word.to_le_bytes()[byte_index % 2]
    }

    /// Whether anything was written that the outputs do not follow yet.
    pub fn is_written(&self) -> bool {
        self.written != [0; CHANNEL_COUNT]
    }

    /// Outputs follow what was written; on an acknowledge, whole channels and
    /// those that a write to all of them reached.
    pub fn latch(&mut self, on_stop: bool) {
        let to_all = self.written.iter().all(|written| *written != 0);
        for (channel, written) in self.written.iter_mut().enumerate() {
            if on_stop || to_all || *written == WHOLE {
                self.latched[channel] = self.leds[channel];
                *written = 0;
            }
        }
    }

    pub fn has_equal_counts(&self) -> bool {
        self.latched.iter().any(|led| (led.on | led.off) & FULL == 0 && led.on == led.off)
    }

    /// The pin OE cuts a pulse off in its middle.
    pub fn set_enabled(&mut self, enabled: bool, now_s: f64) {
        self.enabled = enabled;
        if !enabled {
            self.last_pulse_ends_s = self.last_pulse_ends_s.map(|ends_s| ends_s.min(now_s));
        }
    }

    /// Whether pulses, if any, go on.
    pub fn will_go_on(&self) -> bool {
        self.enabled && self.counters.is_some_and(|counters| counters.end_s.is_none())
    }

    /// The pulses of the cycle that was looked at last.
    pub fn pulses_us(&self) -> [Option<f64>; CHANNEL_COUNT] {
        if self.enabled { self.on_pins_us } else { [None; CHANNEL_COUNT] }
    }

    /// With every output off the counters are disabled, too (section 7.3.3), so
    /// the first channel to come on begins a cycle.
    pub fn control(&mut self, now_s: f64, may_run: bool, cycle_s: f64) {
        let is_ending = self.counters.is_some_and(|counters| counters.end_s.is_some());
        let should_run = may_run && !self.are_all_off();
        match (self.counters, should_run) {
            (None, true) => {
                self.counters = Some(Counters { since_s: now_s, cycle_s, cycle: -1.0, end_s: None });
            }
            (Some(_), false) if !is_ending || self.are_all_off() => self.stop_now(),
            _ => {}
        }
    }

    /// The oscillator goes to sleep, but not within a cycle.
    pub fn stop_after_this_cycle(&mut self, now_s: f64) {
        if let Some(counters) = &mut self.counters {
            let cycle = ((now_s - counters.since_s) / counters.cycle_s).floor();
            counters.end_s = Some(counters.since_s + (cycle + 1.0) * counters.cycle_s);
        }
    }

    pub fn stop_now(&mut self) {
        self.counters = None;
        self.on_pins_us = [None; CHANNEL_COUNT];
    }

    /// Brings the pins up to date, which ask for these widths since the last
    /// call; true if the counters came to the end of their last cycle.
    pub fn run(&mut self, now_s: f64, counts: &[Option<u16>; CHANNEL_COUNT]) -> bool {
        let Some(counters) = &mut self.counters else { return false };
        let cycles = (now_s - counters.since_s) / counters.cycle_s;
        let has_ended = counters.end_s.is_some_and(|end_s| end_s <= now_s);
        let cycle = match counters.end_s {
            Some(end_s) if has_ended => ((end_s - counters.since_s) / counters.cycle_s).round() - 1.0,
            _ => cycles.floor(),
        };
        if cycle > counters.cycle {
            counters.cycle = cycle;
            let count_s = counters.cycle_s / f64::from(COUNTS_PER_CYCLE);
            self.on_pins_us = counts.map(|counts| counts.map(|counts| f64::from(counts) * count_s * 1e6));
            let began_s = counters.since_s + cycle * counters.cycle_s;
            if let Some(longest) = counts.iter().flatten().max().filter(|_| self.enabled) {
                self.last_pulse_ends_s = Some(began_s + f64::from(*longest) * count_s);
            }
        }
        if has_ended {
            self.stop_now();
        }
        has_ended
    }

    fn are_all_off(&self) -> bool {
        self.latched.iter().all(|led| led.off & FULL != 0)
    }
}

/// High time in counts; `None` if the pin never changes level, or never drives
/// high.
pub(super) fn width(led: Led, mode2: u8) -> Option<u16> {
    // Full-off has precedence over full-on (section 7.3.3).
    let high = if led.off & FULL != 0 {
        0
    } else if led.on & FULL != 0 {
        COUNTS_PER_CYCLE
    } else {
        led.off.wrapping_sub(led.on) & (COUNTS_PER_CYCLE - 1)
    };
    let high = if mode2 & INVERT != 0 { COUNTS_PER_CYCLE - high } else { high };
    let changes = high != 0 && high != COUNTS_PER_CYCLE;
    (changes && mode2 & TOTEM_POLE != 0).then_some(high)
}
