//! What is behind the figures, in sentences.

use super::figures::WATCHDOG_SPREAD;
use super::{Measured, all_interrupts};
use crate::nano::{CLOCK_HZ, OutputEnable, RECEIVER_PATIENCE_US, seconds};
use crate::report::energy::Energy;
use crate::report::link_loss::{PWM_CYCLE_MS, Silence};
use crate::report::supply_faults::{Stop, SupplyFaults, Trouble};
use crate::report::watchdog::Bite;

pub(super) fn of(measured: &Measured) -> Vec<String> {
    let Measured { pacing, load, faults, watchdog, memory, energy, .. } = measured;
    let lateness = pacing.lateness;
    let us = |cycles: u64| cycles as f64 / CLOCK_HZ as f64 * 1e6;
    let mut lines = vec![
        format!(
            "frames: {} bursts in {:.1} s with {} uploads and saves; lateness p50 {:.2}, p99 {:.2}, worst {:.2} us \
             after the earliest; {} frames without a burst; drift {:.4} ppm of the crystal",
            lateness.bursts,
            pacing.seconds,
            pacing.transfers.persist_ms.len(),
            lateness.p50_us,
            lateness.p99_us,
            lateness.max_us,
            lateness.missing,
            lateness.drift_ppm
        ),
        format!(
            "idle passes of the main loop take {} to {} cycles; its longest pass without a fault {:.2} ms",
            load.idle_pass_cycles.0,
            load.idle_pass_cycles.1,
            seconds(pacing.longest_pass_cycles.max(load.longest_pass_cycles)) * 1e3
        ),
    ];
    lines.push(format!(
        "of the processor's time, walking, {:.2} % are entries into handlers, which the emulator alone would leave out",
        load.entries_percent
    ));
    lines.push(format!(
        "bus: the longest servo burst takes {:.0} us, of which START and address, which the emulator alone would \
         leave out, 25; {:.1} transfers a frame keep the bus for {:.2} of its 16.67 ms",
        us(pacing.longest_burst_cycles),
        load.bus.transfers,
        load.bus.busy_ms
    ));
    for (flood, percent) in &load.flooded_percent {
        lines.push(format!("busy under a flood of {}: {percent:.1} %", flood.name()));
    }
    let interrupts = all_interrupts(measured);
    let wait =
        interrupts.longest_receive_wait().map_or("unseen".into(), |wait| format!("{:.1} us", us(wait)));
    lines.push(format!(
        "receiver: a byte waits {wait} at most to be read, of the {RECEIVER_PATIENCE_US:.0} us that two more take; \
         {} bytes lost",
        load.receiver_overruns
    ));
    for handler in interrupts.handlers() {
        lines.push(format!(
            "handler {} ({}): longest {:.2} us, mean {:.2} us",
            handler.vector,
            vector_name(handler.vector),
            us(handler.longest.cycles),
            us(handler.cycles) / handler.count as f64
        ));
    }
    if let Some(off) = interrupts.longest_off_in_main() {
        lines.push(format!(
            "interrupts off in the main program: longest {:.2} us, from {:#06x}{}",
            us(off.cycles),
            off.pc,
            measured.elf.function_at(off.pc).map_or(String::new(), |name| format!(" in {name}"))
        ));
    }
    let by_paint =
        memory.stack.by_paint.map_or("no paint".into(), |bytes| format!("{bytes} bytes by its paint"));
    lines.push(format!(
        "memory: {} bytes static; stack {} bytes by its pointer, {by_paint}; {} bytes left of 2,048",
        memory.static_bytes,
        memory.stack.by_pointer,
        2048_i64 - i64::from(memory.ram_peak_bytes())
    ));
    for cost in &faults.costs {
        let told =
            cost.told_ms.map_or(String::new(), |ms| format!("; a lasting one is reported after {ms:.0} ms"));
        lines.push(format!(
            "{} at {} moments: transfer up to {:.2} ms, main loop's pass up to {:.2} ms{told}",
            cost.fault.name(),
            faults.moments,
            cost.transfer_ms,
            cost.pass_ms
        ));
    }
    lines.extend(watchdog.bites.iter().map(bite_line));
    lines.extend(watchdog.not_covered.iter().map(|why| format!("watchdog, not covered is {why}")));
    lines.push(format!(
        "watchdog, times above are at 128 kHz; the figure is {WATCHDOG_SPREAD:.3} times the slowest of them"
    ));
    lines.extend(supply_lines(&measured.supply));
    lines.push(silence_line("attached walk", &measured.silences));
    lines.push(silence_line("stream", &measured.streams));
    if let Some(energy) = energy {
        lines.extend(energy_lines(energy));
    }
    lines
}

fn bite_line(bite: &Bite) -> String {
    let bootloader = bite.bootloader.map_or("no bootloader".into(), |name| format!("bootloader {name}"));
    let stop = bite.stop_ms.map_or("servos stay on".into(), |ms| format!("servos off after {ms:.1} ms"));
    let cause = bite.cause.map_or("says nothing".into(), |cause| format!("says {cause:?}"));
    let latched = if bite.latched { "latched" } else { "not latched" };
    let wiring = match bite.wiring {
        OutputEnable::Unwired => "",
        OutputEnable::PulledDown => ", OE on D4 and pulled down",
        OutputEnable::PulledUp => ", OE on D4 and pulled up",
    };
    format!("watchdog, {}, {bootloader}{wiring}: {stop}, {cause}, {latched}", bite.hang.name())
}

fn supply_lines(supply: &SupplyFaults) -> Vec<String> {
    let mut lines = Vec::new();
    for trouble in Trouble::ALL {
        let stops = || supply.stops.iter().filter(|stop| stop.trouble == trouble);
        let worst = |value: fn(&Stop) -> Option<f64>| {
            let all: Option<Vec<f64>> = stops().map(value).collect();
            all.map_or("never, at one of them,".into(), |all| {
                format!("{:.2}", all.into_iter().fold(f64::MIN, f64::max))
            })
        };
        lines.push(format!(
            "{} at {} moments of a frame: last pulse {} frames after it began at most, told after {} ms, latched {}",
            trouble.name(),
            stops().count(),
            worst(|stop| stop.frames),
            worst(|stop| stop.told_ms),
            if stops().all(|stop| stop.latched) { "each time" } else { "NOT each time" }
        ));
    }
    let tripping =
        supply.tripping_frames.map_or("some for ever".into(), |frames| format!("none from {frames} on"));
    lines.push(format!(
        "supply's debounce: {} samples in the source; by trying, dips of {} frames are forgiven at every moment, {tripping}",
        supply.debounce_frames, supply.forgiven_frames
    ));
    lines
}

fn silence_line(what: &str, silences: &[Silence]) -> String {
    let span = |value: fn(&Silence) -> Option<f64>| {
        let all: Option<Vec<f64>> = silences.iter().map(value).collect();
        all.map_or("never, at one of them,".into(), |all| {
            let (least, most) =
                (all.iter().copied().fold(f64::MAX, f64::min), all.iter().fold(0.0, |a, b| b.max(a)));
            format!("{least:.1} to {most:.1} ms")
        })
    };
    let told = if silences.iter().all(|silence| silence.told) { "told" } else { "NOT told" };
    format!(
        "{what}, the cable pulled after a whole command at {} moments of a frame: last change of the servo driver's \
         registers {} after it, on the wires up to {PWM_CYCLE_MS:.1} ms later, limp {} after it, {told}",
        silences.len(),
        span(|silence| silence.still_ms),
        span(|silence| silence.limp_ms)
    )
}

fn energy_lines(energy: &Energy) -> Vec<String> {
    let mut trials = energy.trials.clone();
    trials.sort_by(|a, b| b.error_percent.abs().total_cmp(&a.error_percent.abs()));
    let mut lines = vec![format!(
        "energy: {} trials of {:.1} s under different loads, {} of them within 1 %",
        trials.len(),
        energy.seconds,
        energy.count_within(1.0)
    )];
    let beating = trials.iter().filter(|trial| trial.ripple.beats());
    let still = trials.iter().filter(|trial| !trial.ripple.beats());
    for trial in still.take(2).chain(beating.take(5)) {
        lines.push(format!(
            "energy at {} W, {}, PWM at {:.2} Hz: {:+.2} %",
            trial.ripple.mean_w,
            trial.ripple.shape.name(),
            trial.ripple.pwm_hz,
            trial.error_percent
        ));
    }
    for result in &energy.schemes {
        lines.push(format!(
            "sensor model alone, {}: worst {:+.2} %, where PWM and frames beat {:+.2} %",
            result.scheme.name, result.worst_percent, result.worst_beating_percent
        ));
    }
    lines
}

/// ATmega328P data sheet, table 11-1.
fn vector_name(vector: u8) -> &'static str {
    match vector {
        1 => "INT0",
        2 => "INT1",
        3..=5 => "PCINT",
        6 => "WDT",
        7..=9 => "TIMER2",
        10 => "TIMER1_CAPT",
        11 => "TIMER1_COMPA",
        12 => "TIMER1_COMPB",
        13 => "TIMER1_OVF",
        14..=16 => "TIMER0",
        17 => "SPI",
        18 => "USART_RX",
        19 => "USART_UDRE",
        20 => "USART_TX",
        21 => "ADC",
        22 => "EE_READY",
        23 => "ANALOG_COMP",
        24 => "TWI",
        25 => "SPM_READY",
        _ => "unknown",
    }
}
