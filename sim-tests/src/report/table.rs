//! The table: each figure with its key, its bar, and whether it is met.
//!
//! Holds the bars and the words. Does not depend on the emulator. A figure that
//! the firmware cannot show yet is `not measured`, with the reason; it is never
//! met.

use super::bus_faults::BusFaults;
mod details;
mod figures;

use super::elf::Elf;
use super::energy::Energy;
use super::link_loss::Silence;
use super::load::Load;
use super::memory::Memory;
use super::pacing::Pacing;
use super::supply_faults::SupplyFaults;
use super::watchdog::Bites;
use crate::nano::trace::InterruptLog;
use std::fmt::Write as _;

/// What the emulator leaves out, and what is done about it.
pub const EMULATOR: [&str; 12] = [
    "interrupt entry: simavr takes no time for it; 4 cycles each are added to the run itself, so to every figure",
    "START and address on the bus: simavr takes no time for them; 1 and 9 bit times are added to the run itself",
    "a STOP takes no time: up to 4 us a transfer are missing from bus figures",
    "serial bytes: simavr's last 11 bits and its receiver holds 64 bytes; here they last 10 bits each way at each \
     end's own speed and the receiver holds 3, in the run itself",
    "EEPROM: EEPE reads 0 during a write; the interrupt that tells its end, on which this firmware waits, comes \
     after 3.4 ms as on the chip; the 2 and 4 cycles that an access halts the processor are missing",
    "crystal: exact; the resonator of a cheap board is off by up to 0.5 %, which stretches every time alike, \
     frames and energy included",
    "watchdog oscillator: exact, 128 kHz; the data sheet gives a typical time only and its curves run from 109 to \
     119 kHz, so the figure is stretched by 128 / 109",
    "start-up after a reset: simavr takes no time for it; the 66 ms that every Nano's fuses ask for, after a \
     watchdog's reset too, are added to the run itself, by the watchdog's oscillator as well",
    "a held data line looks like a transfer that never ends; the unit may notice sooner, and either chip lets go \
     by itself after 25 to 35 ms",
    "power sensor: exact, its conversions take the typical time; the data sheet allows 0.5 % of current and of \
     voltage, 2 mA of offset, which are 3.3 % at 0.3 W and 5 V, and conversions a tenth longer",
    "servo driver: its oscillator is 25.00 MHz unless a scenario says otherwise; boards run from 24.0 to 25.5 MHz",
    "USB adapters: none; one that keeps bytes back adds its latency to every step of an upload",
];

#[derive(Debug)]
pub struct Measured {
    /// Bursts, uploads and saves.
    pub pacing: Pacing,
    pub load: Load,
    pub faults: BusFaults,
    pub watchdog: Bites,
    pub supply: SupplyFaults,
    /// Attached walks whose host fell silent.
    pub silences: Vec<Silence>,
    /// Streams that ended without a word.
    pub streams: Vec<Silence>,
    pub memory: Memory,
    /// The energy, once its trials are over.
    pub energy: Option<Energy>,
    /// Names for addresses.
    pub elf: Elf,
}

/// Whether a figure is within its bar.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// Within.
    Met,
    /// Beyond.
    Missed,
    /// Nothing to compare.
    NotYet,
}

impl Verdict {
    /// For people and for JSON.
    #[must_use]
    pub const fn word(self) -> &'static str {
        match self {
            Self::Met => "pass",
            Self::Missed => "FAIL",
            Self::NotYet => "not yet",
        }
    }
}

/// One line of the table.
#[derive(Debug, Clone, PartialEq)]
pub struct Figure {
    /// Its key in JSON.
    pub key: &'static str,
    pub what: &'static str,
    /// The value, or why there is none.
    pub value: Result<f64, String>,
    /// No more than this.
    pub bar: f64,
}

impl Figure {
    /// Whether it is within its bar.
    #[must_use]
    pub fn verdict(&self) -> Verdict {
        match self.value {
            // NaN is not within anything.
            Ok(value) if value <= self.bar => Verdict::Met,
            Ok(_) => Verdict::Missed,
            Err(_) => Verdict::NotYet,
        }
    }
}

/// All figures, and what stands behind them.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    /// In the order of the specification.
    pub figures: Vec<Figure>,
    /// What the figures rely on, each with its limit.
    pub limits: Vec<Figure>,
    /// Plain sentences.
    pub details: Vec<String>,
}

impl Table {
    /// The table of these measurements.
    #[must_use]
    pub fn of(measured: &Measured) -> Self {
        Self {
            figures: figures::of(measured),
            limits: figures::limits_of(measured),
            details: details::of(measured),
        }
    }

    /// Whether every figure is within its bar, and what they rely on within its limits.
    #[must_use]
    pub fn is_met(&self) -> bool {
        self.figures.iter().chain(&self.limits).all(|figure| figure.verdict() == Verdict::Met)
    }

    #[must_use]
    pub fn text(&self) -> String {
        let mut text = String::new();
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{:<58} {:>12} {:>10}  verdict", "figure", "measured", "bar");
        for (index, figure) in self.figures.iter().chain(&self.limits).enumerate() {
            if index == self.figures.len() {
                let _ = writeln!(text, "what these rely on");
            }
            let value = match &figure.value {
                Ok(value) => number(*value),
                Err(_) => "-".into(),
            };
            let bar = format!("<= {}", number(figure.bar));
            let verdict = figure.verdict().word();
            let _ = writeln!(text, "{:<58} {value:>12} {bar:>10}  {verdict}", figure.what);
        }
        for figure in self.figures.iter().chain(&self.limits) {
            if let Err(why) = &figure.value {
                let _ = writeln!(text, "not measured: {} ({why})", figure.what);
            }
        }
        for (title, lines) in [
            ("Behind the figures", self.details.iter().map(String::as_str).collect::<Vec<_>>()),
            ("What the emulator leaves out", EMULATOR.to_vec()),
        ] {
            let _ = writeln!(text, "\n{title}");
            for line in lines {
                let _ = writeln!(text, "- {line}");
            }
        }
        text
    }

    /// For programs: each key with its value or null, then verdicts, reasons and details.
    #[must_use]
    pub fn json(&self) -> serde_json::Value {
        let value =
            |figure: &Figure| figure.value.as_ref().ok().map_or(serde_json::Value::Null, |v| (*v).into());
        let row = |figure: &Figure| {
            serde_json::json!({
                "key": figure.key,
                "what": figure.what,
                "value": value(figure),
                "bar": figure.bar,
                "verdict": figure.verdict().word().to_lowercase(),
                "reason": figure.value.as_ref().err(),
            })
        };
        let mut object = serde_json::Map::new();
        for figure in self.figures.iter().chain(&self.limits) {
            object.insert(figure.key.into(), value(figure));
        }
        object.insert("figures".into(), self.figures.iter().map(row).collect());
        object.insert("limits".into(), self.limits.iter().map(row).collect());
        object.insert("details".into(), self.details.clone().into());
        object.insert("emulator".into(), EMULATOR.to_vec().into());
        object.into()
    }
}

fn number(value: f64) -> String {
    if value.fract().abs() < 1e-9 { format!("{value:.0}") } else { format!("{value:.2}") }
}

fn all_interrupts(measured: &Measured) -> InterruptLog {
    let mut all = InterruptLog::default();
    all.merge(&measured.pacing.interrupts);
    all.merge(&measured.load.interrupts);
    all.merge(&measured.faults.interrupts);
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    fn figure(value: Result<f64, String>) -> Figure {
        Figure { key: "a_key", what: "a figure", value, bar: 5.0 }
    }

    #[test]
    fn a_figure_on_its_bar_is_met_and_one_beyond_or_nan_is_missed() {
        assert_eq!(figure(Ok(5.0)).verdict(), Verdict::Met);
        assert_eq!(figure(Ok(5.01)).verdict(), Verdict::Missed);
        assert_eq!(figure(Ok(f64::NAN)).verdict(), Verdict::Missed);
    }

    #[test]
    fn a_limit_that_is_missed_is_a_table_that_is_not_met() {
        let met = Table { figures: vec![figure(Ok(4.0))], limits: vec![figure(Ok(5.0))], details: vec![] };
        let missed = Table { limits: vec![figure(Ok(6.0))], ..met.clone() };

        assert!(met.is_met() && !missed.is_met());
        assert_eq!(missed.json()["limits"][0]["verdict"], "fail");
    }

    #[test]
    fn what_was_not_measured_is_null_with_its_reason_and_never_met() {
        let table =
            Table { figures: vec![figure(Err("no such mode".into()))], limits: vec![], details: vec![] };

        let json = table.json();

        assert!(json["a_key"].is_null());
        assert_eq!(json["figures"][0]["reason"], "no such mode");
        assert_eq!(json["figures"][0]["verdict"], "not yet");
        assert!(!table.is_met());
        assert!(table.text().contains("not measured: a figure (no such mode)"));
    }
}
