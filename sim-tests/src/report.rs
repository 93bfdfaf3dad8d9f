//! Measures the real firmware image on the emulated Nano, and compares it with the
//! bars.
//!
//! Holds the scenarios, the instruments that read them, and the table. A figure that
//! the firmware cannot show yet is `not measured`. Does not depend on the wall
//! clock: equal images give equal figures. What the emulator leaves out is in
//! [`table::EMULATOR`], and printed with every report.

pub mod bootloader;
pub mod bus_faults;
pub mod elf;
pub mod energy;
pub mod link_loss;
pub mod load;
pub mod memory;
pub mod pacing;
pub mod rig;
pub mod supply_faults;
pub mod table;
pub mod transfer;
pub mod watchdog;

use crate::firmware_image::ImageError;
use rig::{Firmware, RigError};
use std::path::Path;
use table::{Measured, Table};
use thiserror::Error;

/// Why there is no report.
#[derive(Debug, Error)]
pub enum ReportError {
    /// The image cannot be read.
    #[error(transparent)]
    Image(#[from] ImageError),
    /// A scenario did not go as it must.
    #[error("{scenario}: {source}")]
    Scenario { scenario: &'static str, source: RigError },
}

/// How long to look.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lengths {
    /// Seconds of walking for the pacing of frames.
    pub pacing_s: f64,
    /// Seconds of walking for each figure of the load.
    pub load_s: f64,
    /// Seconds of each trial whose energy is compared.
    pub energy_s: f64,
    /// Moments of a frame at which the supply goes wrong, or the cable is pulled.
    pub moments: u32,
}

impl Lengths {
    /// In proportion to the pacing's seconds; 60 are the bars' own.
    #[must_use]
    pub fn of(pacing_s: f64) -> Self {
        Self {
            pacing_s,
            load_s: (pacing_s / 6.0).max(2.0),
            energy_s: (pacing_s / 5.0).max(2.4),
            moments: (pacing_s / 5.0).clamp(4.0, 12.0) as u32,
        }
    }
}

/// Measures everything that this image can show.
///
/// # Errors
/// [`ReportError`] if the image is none, or does not walk.
pub fn measure(elf: &Path, lengths: Lengths) -> Result<Table, ReportError> {
    let in_scenario = |scenario| move |source| ReportError::Scenario { scenario, source };
    let firmware = Firmware::load(elf)?.with_loop().map_err(in_scenario("finding the main loop"))?;

    // Two threads: the energy trials take as long as everything else.
    let (rest, energy) = std::thread::scope(|scope| {
        let energy = scope.spawn(|| energy::measure(&firmware, lengths.energy_s));
        let rest = measure_rest(&firmware, lengths);
        (rest, energy.join())
    });
    let mut measured = rest?;
    match energy {
        Ok(energy) => measured.energy = Some(energy.map_err(in_scenario("energy"))?),
        Err(panic) => std::panic::resume_unwind(panic),
    }
    Ok(Table::of(&measured))
}

fn measure_rest(firmware: &Firmware, lengths: Lengths) -> Result<Measured, ReportError> {
    let in_scenario = |scenario| move |source| ReportError::Scenario { scenario, source };
    let pacing = pacing::measure(firmware, lengths.pacing_s).map_err(in_scenario("frame pacing"))?;
    let load = load::measure(firmware, lengths.load_s).map_err(in_scenario("load"))?;
    let faults = bus_faults::measure(firmware).map_err(in_scenario("bus faults"))?;
    let watchdog = watchdog::measure(firmware).map_err(in_scenario("watchdog"))?;
    let supply = supply_faults::measure(firmware, lengths.moments).map_err(in_scenario("supply faults"))?;
    let silences = link_loss::attached_walk(firmware, lengths.moments).map_err(in_scenario("link loss"))?;
    let stack = pacing.stack.or(load.stack).or(faults.stack);
    let memory = memory::Memory::of(firmware, stack);
    let streams = link_loss::stream(firmware, lengths.moments).map_err(in_scenario("streaming"))?;
    let elf = firmware.elf.clone();
    Ok(Measured { pacing, load, faults, watchdog, supply, silences, streams, memory, energy: None, elf })
}
