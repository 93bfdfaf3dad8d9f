//! The report's instruments on the real firmware image, and every figure of it
//! against its bar.
//!
//! Runs are shorter than the report's own. A missing image fails every test
//! here, and the message says how to build one.

use sim_tests::firmware_image::FirmwareImage;
use sim_tests::report::load::{self, Flood};
use sim_tests::report::rig::Firmware;
use sim_tests::report::table::Table;
use sim_tests::report::{self, Lengths, pacing};
use std::sync::OnceLock;

/// Every key that the report promises.
const KEYS: [&str; 15] = [
    "frame_jitter_p99_us",
    "frame_jitter_max_us",
    "cpu_busy_percent",
    "cpu_busy_flood_percent",
    "irq_off_max_us",
    "isr_max_us",
    "flash_bytes",
    "ram_peak_bytes",
    "upload_ms",
    "persist_ms",
    "i2c_fault_max_ms",
    "link_loss_stop_ms",
    "supply_fault_stop_frames",
    "watchdog_stop_ms",
    "energy_error_percent",
];
/// What the figures rely on.
const LIMITS: [&str; 5] = [
    "receive_wait_max_us",
    "receiver_lost_bytes",
    "supply_debounce_frames",
    "attached_stop_ms",
    "energy_in_step_error_percent",
];

/// Figures whose bar is missed, and how far they may miss it: no further than
/// today. `docs/firmware.md` says the same; a bar that is met again loses its line here.
const MISSED: [(&str, f64); 2] = [
    // In trials as short as these, which are not a whole number of beats.
    ("energy_error_percent", 6.0),
    ("energy_in_step_error_percent", 30.0),
];

fn elf() -> std::path::PathBuf {
    FirmwareImage::default_path()
}

fn firmware() -> Firmware {
    let firmware = Firmware::load(&elf()).unwrap_or_else(|error| panic!("{error}"));
    firmware.with_loop().unwrap()
}

/// One short report for all tests here.
fn table() -> &'static Table {
    static TABLE: OnceLock<Table> = OnceLock::new();
    TABLE.get_or_init(|| {
        let lengths = Lengths { pacing_s: 2.5, load_s: 0.5, energy_s: 1.2, moments: 2 };
        report::measure(&elf(), lengths).unwrap_or_else(|error| panic!("{error}"))
    })
}

#[test]
fn every_figure_is_a_number_within_its_bar_or_misses_it_by_no_more_than_is_said() {
    let json = table().json();
    println!("{}", table().text());
    let mut wrong = Vec::new();
    for row in ["figures", "limits"].iter().flat_map(|part| json[*part].as_array().unwrap()) {
        let key = row["key"].as_str().unwrap();
        let bar = row["bar"].as_f64().unwrap();
        let missed = MISSED.iter().find(|(missed, _)| *missed == key);
        let allowed = missed.map_or(bar, |(_, allowed)| *allowed);
        match row["value"].as_f64() {
            Some(value) if value <= allowed => {
                if missed.is_some() && value <= bar {
                    println!("{key} meets its bar now: {value} of {bar}; its line in MISSED can go");
                }
            }
            Some(value) => wrong.push(format!("{key} is {value}, more than {allowed}")),
            None => wrong.push(format!("{key} is not a number: {}", row["reason"])),
        }
    }

    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn every_promised_key_is_there_once_with_its_bar_and_its_verdict() {
    let json = table().json();

    for (part, keys) in [("figures", &KEYS[..]), ("limits", &LIMITS)] {
        let rows = json[part].as_array().unwrap();
        let found: Vec<&str> = rows.iter().map(|row| row["key"].as_str().unwrap()).collect();
        assert_eq!(found, keys);
        for row in rows {
            let key = row["key"].as_str().unwrap();
            assert_eq!(json[key], row["value"], "{key}");
            let within = row["value"].as_f64().is_some_and(|value| value <= row["bar"].as_f64().unwrap());
            assert_eq!(row["verdict"] == "pass", within, "{key}");
        }
    }
    for (missed, _) in MISSED {
        assert!(KEYS.contains(&missed) || LIMITS.contains(&missed), "{missed}");
    }
}

/// What the figures leave out stands beside them, for people and for programs.
#[test]
fn the_emulators_limits_and_every_way_to_hang_are_printed_with_the_figures() {
    let (json, text) = (table().json(), table().text());

    let said =
        |part: &str| json[part].as_array().unwrap().iter().map(|line| line.as_str().unwrap()).collect();
    let (emulator, details): (Vec<&str>, Vec<&str>) = (said("emulator"), said("details"));
    for line in emulator.iter().chain(&details) {
        assert!(text.contains(line), "{line}");
    }
    for word in [
        "interrupt entry",
        "START and address",
        "STOP",
        "serial bytes",
        "EEPE",
        "crystal",
        "watchdog oscillator",
    ] {
        assert!(emulator.iter().any(|line| line.contains(word)), "{word}");
    }
    for word in [
        "receiver: a byte waits",
        "entries into handlers",
        "bus: the longest servo burst",
        "supply's debounce: 5 samples",
        "watchdog, main loop hung, no bootloader",
        "watchdog, frame handler hung, no bootloader",
        "stand-in for Optiboot",
        "attached walk, the cable pulled",
        "stream, the cable pulled",
    ] {
        assert!(details.iter().any(|line| line.contains(word)), "{word}");
    }
    // The old bootloader is either measured, or it is said why not.
    assert!(details.iter().any(|line| line.contains("ATmegaBOOT")), "{details:#?}");
}

#[test]
fn equal_images_give_equal_figures() {
    let firmware = firmware();
    let run = || {
        let pacing = pacing::measure(&firmware, 2.0).unwrap();
        (pacing.lateness, pacing.transfers, pacing.stack)
    };

    assert_eq!(run(), run());
}

#[test]
fn a_flooded_line_is_busier_than_a_quiet_one_and_never_idle_for_free() {
    let load = load::measure(&firmware(), 1.0).unwrap();

    println!("{:.1} % quiet, {:?}", load.busy_percent, load.flooded_percent);
    assert!(load.busy_percent > 1.0 && load.busy_percent < 100.0);
    assert_eq!(load.flooded_percent.len(), Flood::ALL.len());
    for (flood, percent) in &load.flooded_percent {
        assert!(*percent > load.busy_percent + 1.0, "{}: {percent} %", flood.name());
    }
}
