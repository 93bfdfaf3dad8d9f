//! The report's instruments on the real firmware image.
//!
//! A missing image fails every test here, with the next move.

use sim_tests::firmware_image::FirmwareImage;
use sim_tests::report::load::{self, Flood};
use sim_tests::report::rig::Firmware;
use sim_tests::report::watchdog::{self, Hang};
use sim_tests::report::{bus_faults, pacing};

fn firmware() -> Firmware {
    let firmware = Firmware::load(&FirmwareImage::default_path()).unwrap_or_else(|error| panic!("{error}"));
    firmware.with_loop().unwrap()
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

#[test]
fn every_bus_fault_costs_something_and_hangs_nothing() {
    let faults = bus_faults::measure(&firmware()).unwrap();

    for cost in &faults.costs {
        println!("{cost:?}");
        assert!(cost.transfer_ms > 0.5 && cost.pass_ms < 100.0, "{cost:?}");
    }
}

#[test]
fn a_hung_program_ends_with_the_servos_off_wherever_it_hangs() {
    let bites = watchdog::measure(&firmware()).unwrap();

    for hang in [Hang::MainLoop, Hang::Handler] {
        let bite = bites.bites.iter().find(|bite| bite.hang == hang && bite.bootloader.is_none()).unwrap();
        println!("{bite:?}");
        assert!(bite.stop_ms.is_some_and(|ms| ms > 10.0 && ms < 1_000.0), "{bite:?}");
        assert!(bite.cause.is_some(), "{bite:?}");
    }
    for why in &bites.not_covered {
        println!("a bootloader is not covered: {why}");
    }
}
