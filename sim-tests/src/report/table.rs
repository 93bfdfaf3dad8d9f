//! The table: each figure with its key, its bar, and whether it is met.
//!
//! Owns the bars and the words. A figure that the firmware cannot show yet is
//! `not measured`, with the reason; it is never met.

use super::bus_faults::BusFaults;
mod details;
mod figures;

use super::elf::Elf;
use super::energy::Energy;
use super::load::Load;
use super::memory::Memory;
use super::pacing::Pacing;
use super::watchdog::Bites;
use crate::nano::trace::InterruptLog;
use std::fmt::Write as _;

/// What the emulator leaves out, and what is done about it.
pub const EMULATOR: [&str; 8] = [
    "interrupt entry: 4 cycles each, added to the run itself",
    "START and address on the bus: 1 and 9 bit times, added to the run itself",
    "a STOP takes no time: up to 4 us a transfer are missing from bus figures",
    "serial bytes: 10 bits each way at each end's own speed, 3 bytes of receiver, added to the run itself",
    "crystal: exact; a real one, or the resonator of a cheap board, stretches every time alike",
    "watchdog oscillator: exact here; the data sheet gives a typical time only, so 10 % are assumed and added",
    "a held data line looks like a transfer that never ends; the chip may notice sooner",
    "USB adapters: none; one that keeps bytes back adds its latency to every step of an upload",
];

/// Everything that was measured.
#[derive(Debug)]
pub struct Measured {
    /// Bursts, uploads and saves.
    pub pacing: Pacing,
    /// The processor.
    pub load: Load,
    /// The bus.
    pub faults: BusFaults,
    /// The watchdog.
    pub watchdog: Bites,
    /// Flash and memory.
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
    /// What it is.
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
    /// Plain sentences.
    pub details: Vec<String>,
}

impl Table {
    /// The table of these measurements.
    #[must_use]
    pub fn of(measured: &Measured) -> Self {
        Self { figures: figures::of(measured), details: details::of(measured) }
    }

    /// Whether every figure is within its bar.
    #[must_use]
    pub fn is_met(&self) -> bool {
        self.figures.iter().all(|figure| figure.verdict() == Verdict::Met)
    }

    /// For people.
    #[must_use]
    pub fn text(&self) -> String {
        let mut text = String::new();
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{:<58} {:>12} {:>10}  verdict", "figure", "measured", "bar");
        for figure in &self.figures {
            let value = match &figure.value {
                Ok(value) => number(*value),
                Err(_) => "-".into(),
            };
            let bar = format!("<= {}", number(figure.bar));
            let verdict = figure.verdict().word();
            let _ = writeln!(text, "{:<58} {value:>12} {bar:>10}  {verdict}", figure.what);
        }
        for figure in &self.figures {
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
        let mut object = serde_json::Map::new();
        for figure in &self.figures {
            object.insert(figure.key.into(), value(figure));
        }
        let figures = self.figures.iter().map(|figure| {
            serde_json::json!({
                "key": figure.key,
                "what": figure.what,
                "value": value(figure),
                "bar": figure.bar,
                "verdict": figure.verdict().word().to_lowercase(),
                "reason": figure.value.as_ref().err(),
            })
        });
        object.insert("figures".into(), figures.collect());
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
    fn what_was_not_measured_is_null_with_its_reason_and_never_met() {
        let table = Table { figures: vec![figure(Err("no such mode".into()))], details: vec![] };

        let json = table.json();

        assert!(json["a_key"].is_null());
        assert_eq!(json["figures"][0]["reason"], "no such mode");
        assert_eq!(json["figures"][0]["verdict"], "not yet");
        assert!(!table.is_met());
        assert!(table.text().contains("not measured: a figure (no such mode)"));
    }
}
