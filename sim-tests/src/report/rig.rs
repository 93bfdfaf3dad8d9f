//! A robot on the bench, walking, for the scenarios.
//!
//! Holds the firmware under test, how a robot is brought to walk, and what goes
//! on beside the walking. A robot that does not do what it was asked ends the
//! report. Does not depend on the figures.

use super::elf::Elf;
use crate::body::Bench;
use crate::client::{Client, ClientError};
use crate::devices::servo_driver::NOMINAL_OSCILLATOR_HZ;
use crate::firmware_image::{FirmwareImage, ImageError};
use crate::fixtures::{self, Gait};
use crate::nano::trace::Trace;
use crate::nano::{CLOCK_HZ, NanoError};
use crate::virtual_robot::{BuildError, VirtualRobot};
use host::robot::{LegScale, Robot, RobotError, Supply};
use protocol::{Command, GaitTable, Reply, State, Status};
use std::f64::consts::TAU;
use std::path::Path;
use thiserror::Error;

/// Servos in a vice draw this much each.
const SERVO_POWER_W: f64 = 0.1;
/// Chips configured, stored gait loaded, and the first samples taken.
const START_UP_S: f64 = 0.3;
/// The gaits' name: one that is saved again takes its own place over, and a
/// robot that walks for minutes does not run out of places.
const NAME: &str = "report";
/// Longest wait for a state: the entry into a gait takes about a second.
const PATIENCE_S: f64 = 5.0;

/// Why a scenario gives no figure.
#[derive(Debug, Error)]
pub enum RigError {
    /// The robot cannot be.
    #[error(transparent)]
    Build(#[from] BuildError),
    /// Its description cannot be.
    #[error(transparent)]
    Robot(#[from] RobotError),
    /// The firmware ended, or does not answer as it must.
    #[error(transparent)]
    Client(#[from] ClientError),
    /// The firmware ended.
    #[error(transparent)]
    Nano(#[from] NanoError),
    /// It stays in another state.
    #[error("the robot is {found:?} and not {wanted:?} after {PATIENCE_S} s")]
    State {
        /// What it should be doing.
        wanted: State,
        found: State,
    },
    /// Nothing was noted of what was to be measured.
    #[error("the run shows no {0}: the instrument does not know this firmware")]
    Unseen(&'static str),
    /// A bootloader's file is none.
    #[error(transparent)]
    Image(#[from] ImageError),
}

/// The image under test, and what is known of it.
#[derive(Debug, Clone)]
pub struct Firmware {
    pub image: FirmwareImage,
    /// The ELF file's own tables.
    pub elf: Elf,
    /// First instruction of the main loop, in bytes.
    pub head: u32,
    /// First data address behind static memory.
    pub statics_end: u16,
}

impl Firmware {
    /// Reads an ELF file.
    ///
    /// # Errors
    /// [`ImageError`] if it is none.
    pub fn load(path: &Path) -> Result<Self, ImageError> {
        let image = FirmwareImage::load(path)?;
        let bytes =
            std::fs::read(path).map_err(|source| ImageError::Read { path: path.to_owned(), source })?;
        let elf = Elf::parse(&bytes);
        let statics = [".data", ".bss", ".noinit"].map(|name| elf.section_len(name)).iter().sum::<u32>();
        let statics_end = elf.address_of("_end").unwrap_or(0x100 + statics) as u16;
        Ok(Self { image, elf, head: 0, statics_end })
    }

    /// Finds the main loop by letting the program idle for a while.
    ///
    /// # Errors
    /// [`RigError::Unseen`] if nothing is repeated.
    pub fn with_loop(mut self) -> Result<Self, RigError> {
        let mut rig = Rig::started(&self)?;
        rig.robot.nano_mut().start_trace(Trace::new());
        rig.client.run_for(&mut rig.robot, 0.1)?;
        let trace = rig.take_trace()?;
        self.head = trace.finder.head().ok_or(RigError::Unseen("main loop"))?;
        Ok(self)
    }

    /// A trace that knows this program's main loop.
    #[must_use]
    pub fn trace(&self) -> Trace {
        Trace::of_loop(self.head, self.statics_end)
    }
}

/// A robot and its host.
pub struct Rig {
    pub robot: VirtualRobot,
    pub client: Client,
    uploads: usize,
}

impl Rig {
    /// Powered on and done with starting up.
    ///
    /// # Errors
    /// [`RigError`] if it does not start.
    pub fn started(firmware: &Firmware) -> Result<Self, RigError> {
        Self::started_with(&firmware.image, START_UP_S)
    }

    /// Another image, given so many seconds to start.
    ///
    /// # Errors
    /// [`RigError`] if it does not start.
    pub fn started_with(image: &FirmwareImage, patience_s: f64) -> Result<Self, RigError> {
        // A stiff supply: the loads that are tried must not look like a flat battery.
        Self::built(image, Supply { nominal_v: 6.0, resistance_ohm: 0.02 }, patience_s)
    }

    /// On another supply.
    ///
    /// # Errors
    /// [`RigError`] if it does not start.
    pub fn supplied(firmware: &Firmware, supply: Supply) -> Result<Self, RigError> {
        Self::built(&firmware.image, supply, START_UP_S)
    }

    fn built(image: &FirmwareImage, supply: Supply, patience_s: f64) -> Result<Self, RigError> {
        let body = Box::new(Bench::new(SERVO_POWER_W));
        let description = Robot { supply, ..Robot::ant(LegScale::LONG)? };
        let robot = VirtualRobot::with_body(image, &description, body, NOMINAL_OSCILLATOR_HZ)?;
        let mut rig = Self { robot, client: Client::new(), uploads: 0 };
        rig.client.run_for(&mut rig.robot, patience_s)?;
        Ok(rig)
    }

    /// Walking with telemetry at 60 Hz.
    ///
    /// # Errors
    /// [`RigError`] if it does not walk.
    pub fn walk(&mut self) -> Result<(), RigError> {
        self.upload(false)?;
        self.walk_on()
    }

    /// Walks the gait that is there, with telemetry at 60 Hz.
    ///
    /// # Errors
    /// [`RigError`] if it does not walk.
    pub fn walk_on(&mut self) -> Result<(), RigError> {
        self.client.expect_done(&mut self.robot, Command::StreamTelemetry { every_frames: 1 })?;
        self.client.expect_done(
            &mut self.robot,
            Command::Walk { amplitude: None, frames: None, detached: true, dry_run: false },
        )?;
        self.wait_for(State::Walking)
    }

    /// Uploads the next of three gaits, each different in most bytes.
    ///
    /// # Errors
    /// [`RigError`] if it is refused.
    pub fn upload(&mut self, persist: bool) -> Result<GaitTable, RigError> {
        let table = gait(self.uploads % 3).table();
        self.uploads += 1;
        self.client.upload(&mut self.robot, &table, fixtures::amplitude(1.0), persist)?;
        Ok(table)
    }

    /// What the robot says of itself, and when.
    ///
    /// # Errors
    /// [`RigError`] if it says nothing.
    pub fn status(&mut self) -> Result<(Status, u64), RigError> {
        match self.client.ask_timed(&mut self.robot, Command::Status)? {
            (Reply::Status(status), at) => Ok((status, at)),
            (other, _) => Err(ClientError::Unexpected(Box::new(other)).into()),
        }
    }

    /// Runs until the robot is in this state.
    ///
    /// # Errors
    /// [`RigError::State`] if it does not get there.
    pub fn wait_for(&mut self, wanted: State) -> Result<(), RigError> {
        let deadline = self.robot.now() + (PATIENCE_S * CLOCK_HZ as f64) as u64;
        loop {
            let found = self.status()?.0.state;
            if found == wanted {
                return Ok(());
            }
            if self.robot.now() > deadline {
                return Err(RigError::State { wanted, found });
            }
            self.client.run_for(&mut self.robot, 0.02)?;
        }
    }

    /// Ends the trace.
    ///
    /// # Errors
    /// [`RigError::Unseen`] if none was started.
    pub fn take_trace(&mut self) -> Result<Trace, RigError> {
        self.robot.nano_mut().take_trace().ok_or(RigError::Unseen("trace"))
    }
}

/// Three gaits that share no coefficient, within 25 degrees of neutral.
#[must_use]
pub fn gait(index: usize) -> Gait {
    let period_s = [1.2, 2.3, 3.1][index % 3];
    let shift = index as f64;
    let centre_deg = std::array::from_fn(|joint| 2.0 * joint as f64 - 7.0 + shift);
    Gait::of(NAME, period_s, centre_deg, |joint, phase| {
        let joint = joint as f64;
        let angle = TAU * phase;
        (8.0 + shift) * (angle + joint + 2.0 * shift).sin() + (4.0 - shift) * (2.0 * angle - joint).cos()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_three_gaits_differ_in_most_bytes() {
        let encoded = |index: usize| {
            let mut buffer = [0; protocol::gait::MAX_ENCODED_LEN];
            gait(index).table().encode(&mut buffer).unwrap().to_vec()
        };

        for (a, b) in [(0, 1), (1, 2), (2, 0)] {
            let (a, b) = (encoded(a), encoded(b));
            let equal = a.iter().zip(&b).filter(|(a, b)| a == b).count();
            assert!(a.len() > 230 && equal < 100, "{equal} of {} bytes are equal", a.len());
        }
    }
}
