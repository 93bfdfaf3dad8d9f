//! The table: each figure with its key, its bar, and whether it is met.
//!
//! Owns the bars and the words. A figure that the firmware cannot show yet is
//! `not measured`, with the reason; it is never met.

use super::bus_faults::BusFaults;
mod details;

use super::elf::Elf;
use super::energy::Energy;
use super::load::Load;
use super::memory::Memory;
use super::pacing::Pacing;
use super::watchdog::Bites;
use crate::nano::CLOCK_HZ;
use crate::nano::trace::InterruptLog;
use protocol::ResetCause;
use std::fmt::Write as _;

/// What the emulator leaves out, and what is done about it.
pub const EMULATOR: [&str; 8] = [
    "interrupt entry: 4 cycles each, added to the run itself",
    "START and address on the bus: 1 and 9 bit times, added to the run itself",
    "a STOP takes no time: up to 4 us a transfer are missing from bus figures",
    "serial bytes: 10 bits each way at each end's own speed, 3 bytes of receiver, added to the run itself",
    "crystal: exact; a real one moves every frame alike, by up to 50 ppm",
    "watchdog oscillator: exact here; the chip's own spreads by about 10 %, added to the figure",
    "a held data line looks like a transfer that never ends; the chip may notice sooner",
    "USB adapters: none; one that keeps bytes back adds its latency to every step of an upload",
];

/// Spread of the watchdog's 128 kHz oscillator over supply and temperature.
const WATCHDOG_SPREAD: f64 = 1.1;

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
        Self { figures: figures(measured), details: details::of(measured) }
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

fn figures(measured: &Measured) -> Vec<Figure> {
    let Measured { pacing, load, faults, watchdog, memory, energy, .. } = measured;
    let us = |cycles: u64| cycles as f64 / CLOCK_HZ as f64 * 1e6;
    let none = |why: &str| Err(why.to_owned());
    let interrupts = all_interrupts(measured);
    let longest_off = interrupts.longest_off().ok_or("no interrupt was seen".to_owned());
    let longest_handler = interrupts.longest_handler().ok_or("no interrupt was seen".to_owned());
    let upload = pacing.transfers.slowest_upload_ms().ok_or("no upload ended".to_owned());
    let persist = pacing.transfers.slowest_persist_ms().ok_or("no save ended".to_owned());
    let flood = load.worst_flood().map(|(_, percent)| percent).ok_or("no flood ran".to_owned());
    let fault = faults.worst().map(|cost| cost.transfer_ms).ok_or("no fault was put in".to_owned());
    let energy_error = energy.as_ref().and_then(Energy::worst).map(|trial| trial.error_percent.abs());
    let lateness = pacing.lateness;
    let every_frame = if lateness.missing == 0 {
        Ok(())
    } else {
        Err(format!("{} frames had no burst at all", lateness.missing))
    };
    let figure = |key, what, value, bar| Figure { key, what, value, bar };
    vec![
        figure(
            "frame_jitter_p99_us",
            "servo burst against the 60 Hz grid, 99 of 100 (us)",
            every_frame.clone().map(|()| lateness.p99_us),
            5.0,
        ),
        figure(
            "frame_jitter_max_us",
            "servo burst against the 60 Hz grid, worst (us)",
            every_frame.map(|()| lateness.max_us),
            10.0,
        ),
        figure("cpu_busy_percent", "processor busy, walking with telemetry (%)", Ok(load.busy_percent), 25.0),
        figure("cpu_busy_flood_percent", "processor busy, and the line flooded (%)", flood, 35.0),
        figure("irq_off_max_us", "interrupts off, longest (us)", longest_off.map(|s| us(s.cycles)), 15.0),
        figure(
            "isr_max_us",
            "interrupt handler, longest (us)",
            longest_handler.map(|h| us(h.longest.cycles)),
            15.0,
        ),
        figure("flash_bytes", "flash (bytes)", Ok(f64::from(memory.flash_bytes)), 24.0 * 1024.0),
        figure(
            "ram_peak_bytes",
            "static memory and deepest stack (bytes)",
            Ok(f64::from(memory.ram_peak_bytes())),
            1640.0,
        ),
        figure("upload_ms", "verified upload of a full gait into RAM (ms)", upload, 60.0),
        figure("persist_ms", "upload and save while walking (ms)", persist, 1500.0),
        figure("i2c_fault_max_ms", "bus fault: transfer to a free bus, longest (ms)", fault, 2.0),
        figure(
            "link_loss_stop_ms",
            "link lost while streaming: servos stop (ms)",
            none("the firmware has no streaming mode"),
            100.0,
        ),
        figure(
            "supply_fault_stop_frames",
            "undervoltage or overcurrent: stop (frames after debounce)",
            none("the firmware has no supply fault"),
            3.0,
        ),
        figure(
            "watchdog_stop_ms",
            "hung program to servos off, slow oscillator (ms)",
            watchdog_stop_ms(watchdog),
            150.0,
        ),
        figure(
            "energy_error_percent",
            "energy against the battery's, worst load (%)",
            energy_error.ok_or("no trial ended".to_owned()),
            1.0,
        ),
    ]
}

/// The slowest hang without a bootloader, on the slowest oscillator.
fn watchdog_stop_ms(watchdog: &Bites) -> Result<f64, String> {
    let mut worst = 0.0_f64;
    for bite in watchdog.bites.iter().filter(|bite| bite.bootloader.is_none()) {
        match bite.stop_ms {
            Some(stop_ms) if bite.cause == Some(ResetCause::Watchdog) => worst = worst.max(stop_ms),
            Some(_) => return Err(format!("{} is not reported as a watchdog's reset", bite.hang.name())),
            None => return Err(format!("{} leaves the servos on", bite.hang.name())),
        }
    }
    Ok(worst * WATCHDOG_SPREAD)
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
