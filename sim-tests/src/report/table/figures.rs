//! Each figure's value and bar.

use super::{Figure, Measured, all_interrupts};
use crate::nano::CLOCK_HZ;
use crate::report::energy::Energy;
use crate::report::watchdog::Bites;
use protocol::{PROTOCOL_VERSION, ResetCause};

/// Assumed of the watchdog's oscillator: the data sheet gives a typical time only.
const WATCHDOG_SPREAD: f64 = 1.1;

pub(super) fn of(measured: &Measured) -> Vec<Figure> {
    let Measured { pacing, load, faults, watchdog, memory, energy, .. } = measured;
    let us = |cycles: u64| cycles as f64 / CLOCK_HZ as f64 * 1e6;
    let none = |what: &str| Err(format!("version {PROTOCOL_VERSION} of the protocol has no {what}"));
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
            none("streaming of setpoints"),
            100.0,
        ),
        figure(
            "supply_fault_stop_frames",
            "undervoltage or overcurrent: stop (frames after debounce)",
            Err("this report has no scenario for it yet; tests/nano/faults.rs has".to_owned()),
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
