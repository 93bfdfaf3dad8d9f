//! Each figure's value and bar.

use super::{Figure, Measured, all_interrupts};
use crate::nano::{CLOCK_HZ, OutputEnable, RECEIVER_PATIENCE_US};
use crate::report::energy::Energy;
use crate::report::link_loss;
use crate::report::supply_faults::MAX_DEBOUNCE_FRAMES;
use crate::report::watchdog::{Bite, Bites};
use protocol::ResetCause;

/// The watchdog's oscillator runs at 128 kHz in name; the data sheet's curves go
/// down to 109.
pub(super) const WATCHDOG_SPREAD: f64 = 128.0 / 109.0;

pub(super) fn of(measured: &Measured) -> Vec<Figure> {
    let Measured { pacing, load, faults, watchdog, supply, memory, energy, .. } = measured;
    let us = |cycles: u64| cycles as f64 / CLOCK_HZ as f64 * 1e6;
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
            link_loss::stream_stop_ms(&measured.streams),
            100.0,
        ),
        figure(
            "supply_fault_stop_frames",
            "undervoltage or overcurrent: stop (frames after debounce)",
            supply.stop_frames(),
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
            "energy against the battery's, worst load, PWM out of step (%)",
            energy_error.ok_or("no trial ended".to_owned()),
            1.0,
        ),
    ]
}

/// What the figures above rely on.
pub(super) fn limits_of(measured: &Measured) -> Vec<Figure> {
    let us = |cycles: u64| cycles as f64 / CLOCK_HZ as f64 * 1e6;
    let wait = all_interrupts(measured).longest_receive_wait();
    vec![
        Figure {
            key: "receive_wait_max_us",
            what: "received byte waits to be read, longest (us)",
            value: wait.map(us).ok_or("no byte was seen".to_owned()),
            bar: RECEIVER_PATIENCE_US,
        },
        Figure {
            key: "receiver_lost_bytes",
            what: "received bytes lost under a flood",
            value: Ok(f64::from(measured.load.receiver_overruns)),
            bar: 0.0,
        },
        Figure {
            key: "supply_debounce_frames",
            what: "supply's debounce (frames)",
            value: Ok(f64::from(measured.supply.debounce_frames)),
            bar: f64::from(MAX_DEBOUNCE_FRAMES),
        },
        Figure {
            key: "attached_stop_ms",
            what: "attached walk without a host: last move (ms)",
            value: link_loss::slowest_ms(&measured.silences),
            bar: link_loss::ATTACHED_BAR_MS,
        },
        Figure {
            key: "energy_in_step_error_percent",
            what: "energy where the PWM runs at exactly 60 Hz (%)",
            value: in_step_error_percent(measured),
            bar: 1.0,
        },
    ]
}

fn in_step_error_percent(measured: &Measured) -> Result<f64, String> {
    let energy = measured.energy.as_ref().ok_or("no trial ended".to_owned())?;
    let worst = energy.worst_in_step().ok_or("no chip's PWM gets there".to_owned())?;
    Ok(worst.error_percent.abs())
}

/// The slowest hang without a bootloader and with OE left alone, on the slowest
/// oscillator.
fn watchdog_stop_ms(watchdog: &Bites) -> Result<f64, String> {
    let mut worst = 0.0_f64;
    let is_plain = |bite: &&Bite| bite.bootloader.is_none() && bite.wiring == OutputEnable::Unwired;
    for bite in watchdog.bites.iter().filter(is_plain) {
        match bite.stop_ms {
            Some(stop_ms) if bite.cause == Some(ResetCause::Watchdog) => worst = worst.max(stop_ms),
            Some(_) => return Err(format!("{} is not reported as a watchdog's reset", bite.hang.name())),
            None => return Err(format!("{} leaves the servos on", bite.hang.name())),
        }
    }
    Ok(worst * WATCHDOG_SPREAD)
}
