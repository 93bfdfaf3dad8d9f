//! Nano, chips, supply and body in lock step, in one emulated time.
//!
//! Holds the order of things: at each 1/240 s the servos' pulses are read, the
//! body takes its step, and the power of that step loads the supply while the
//! Nano runs through it. Holds the ground truth too: pose and battery energy, which
//! the robot's own sensor does not measure. Does not depend on the wall clock, by
//! which `bin/virtual-robot` paces it.

use crate::body::{Body, JOINT_COUNT, PulseScale, STEPS_PER_S};
use crate::calibrated::with_calibration;
use crate::devices::servo_driver::{Burst, NOMINAL_OSCILLATOR_HZ};
use crate::devices::{Bus, Chip, SHUNT_OHM, ServoDriver};
use crate::electric::{Supply, SupplyError, SupplyParameters};
use crate::firmware_image::FirmwareImage;
use crate::nano::{CLOCK_HZ, Nano, NanoError, seconds};
use host::calibration::{BadCalibration, RobotCalibration};
use host::robot::Robot;
use host::sim::{Perturbation, Start, World};
use serde::Serialize;
use thiserror::Error;

/// Truth is noted 60 times a second.
const STEPS_PER_TRUTH: u64 = 4;

/// Why there is no virtual robot.
#[derive(Debug, Error)]
pub enum BuildError {
    #[error(transparent)]
    Nano(#[from] NanoError),
    #[error("the robot's supply is none: {0}")]
    Supply(#[from] SupplyError),
    #[error("no calibration holds the description's servos")]
    Calibration(#[from] BadCalibration),
}

/// What is so, whatever the robot's sensors say.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Truth {
    /// Emulated time since power-on.
    pub time_s: f64,
    /// Torso's middle.
    pub x_m: f64,
    /// Torso's middle.
    pub y_m: f64,
    /// Torso's middle, above ground.
    pub z_m: f64,
    /// Heading, counter-clockwise from x.
    pub yaw_rad: f64,
    /// From upright.
    pub tilt_rad: f64,
    /// Out of the battery's terminals since power-on.
    pub true_energy_j: f64,
    /// At the battery's terminals.
    pub supply_v: f64,
    /// Out of the battery.
    pub supply_a: f64,
    /// From neutral, in the protocol's order.
    pub joint_angles_rad: [f64; JOINT_COUNT],
}

pub struct VirtualRobot {
    nano: Nano,
    supply: Supply,
    body: Box<dyn Body>,
    scale: PulseScale,
    electronics_w: f64,
    steps: u64,
    truth: Vec<Truth>,
    bursts: Vec<Burst>,
    load: Option<Load>,
}

/// A load of its own instead of the body's, changing within a PWM frame.
struct Load {
    power_w: Box<dyn Fn(f64) -> f64 + Send>,
    /// When it changes next.
    next: u64,
    /// Battery energy at each of its changes, from `began` on.
    energy_j: Vec<f64>,
    began: u64,
}

/// The load's power is looked at this often: 32 us.
pub const LOAD_STEP_CYCLES: u64 = 512;

impl VirtualRobot {
    /// The robot standing at neutral in its world, servos limp, just powered on, and
    /// calibrated as its description says.
    ///
    /// A seed puts it down a little differently: heading, joints, friction.
    ///
    /// # Errors
    /// [`BuildError`] if board, supply or calibration cannot be.
    pub fn new(image: &FirmwareImage, robot: &Robot, seed: Option<u64>) -> Result<Self, BuildError> {
        let mut built = Self::uncalibrated(image, robot, seed)?;
        let record = RobotCalibration::of_robot(robot).record()?;
        let contents = with_calibration(&built.nano.eeprom(), &record);
        built.nano.set_eeprom(&contents);
        Ok(built)
    }

    /// The same with a fresh board, whose EEPROM is empty.
    ///
    /// # Errors
    /// [`BuildError`] if board or supply cannot be.
    pub fn uncalibrated(image: &FirmwareImage, robot: &Robot, seed: Option<u64>) -> Result<Self, BuildError> {
        let mut world = World::new(robot);
        if let Some(seed) = seed {
            world.reset(&[0.0; JOINT_COUNT], &Start::sampled(&Perturbation::default(), seed));
        }
        Self::with_body(image, robot, Box::new(world), NOMINAL_OSCILLATOR_HZ)
    }

    /// The robot with another body, a fresh board, and this oscillator in its servo driver.
    ///
    /// # Errors
    /// [`BuildError`] if board or supply cannot be.
    pub fn with_body(
        image: &FirmwareImage,
        robot: &Robot,
        body: Box<dyn Body>,
        oscillator_hz: f64,
    ) -> Result<Self, BuildError> {
        let mut bus = Bus::new();
        bus.servo_driver = ServoDriver::new(Chip::ServoDriver.address()).with_oscillator(oscillator_hz);
        let supply = Supply::new(SupplyParameters {
            open_circuit_v: robot.supply.nominal_v,
            resistance_ohm: robot.supply.resistance_ohm,
            shunt_ohm: SHUNT_OHM,
        })?;
        Ok(Self {
            nano: Nano::new(image, bus)?,
            supply,
            body,
            scale: PulseScale::of(&robot.servo),
            electronics_w: robot.power.electronics_w,
            steps: 0,
            truth: Vec::new(),
            bursts: Vec::new(),
            load: None,
        })
    }

    /// From now on the supply gives this power, a function of the time since
    /// power-on, whatever the body does.
    pub fn set_load(&mut self, power_w: impl Fn(f64) -> f64 + Send + 'static) {
        let began = self.now().next_multiple_of(LOAD_STEP_CYCLES);
        self.load = Some(Load { power_w: Box::new(power_w), next: began, energy_j: Vec::new(), began });
    }

    /// The battery's energy at a cycle under [`Self::set_load`]; `None` outside it.
    #[must_use]
    pub fn load_energy_j_at(&self, cycle: u64) -> Option<f64> {
        let load = self.load.as_ref()?;
        let since = cycle.checked_sub(load.began)?;
        let index = (since / LOAD_STEP_CYCLES) as usize;
        let (&before, &after) = (load.energy_j.get(index)?, load.energy_j.get(index + 1)?);
        let share = (since % LOAD_STEP_CYCLES) as f64 / LOAD_STEP_CYCLES as f64;
        Some(before + (after - before) * share)
    }

    /// Cycles since power-on.
    #[must_use]
    pub fn now(&self) -> u64 {
        self.nano.now()
    }

    /// Emulated seconds since power-on.
    #[must_use]
    pub fn now_s(&self) -> f64 {
        self.nano.now_s()
    }

    /// Runs everything up to `cycle`.
    ///
    /// # Errors
    /// [`NanoError`] if the firmware came to an end.
    pub fn run_until(&mut self, cycle: u64) -> Result<(), NanoError> {
        loop {
            // Step k begins at k/240 s exactly: 200,000 / 3 cycles apart.
            let boundary = (self.steps * CLOCK_HZ).div_ceil(STEPS_PER_S);
            let load_at = self.load.as_ref().map_or(u64::MAX, |load| load.next);
            self.nano.run_until(boundary.min(load_at).min(cycle))?;
            if load_at <= boundary.min(cycle) {
                self.step_load();
                continue;
            }
            if boundary > cycle {
                self.bursts.extend(self.nano.bus_mut().servo_driver.take_bursts());
                return Ok(());
            }
            self.step_body();
        }
    }

    /// Runs everything for so many emulated seconds.
    ///
    /// # Errors
    /// [`NanoError`] if the firmware came to an end.
    pub fn run_for(&mut self, duration_s: f64) -> Result<(), NanoError> {
        let cycles = (duration_s * CLOCK_HZ as f64).round().max(0.0) as u64;
        self.run_until(self.now() + cycles)
    }

    #[must_use]
    pub fn nano(&self) -> &Nano {
        &self.nano
    }

    /// The board, to talk to, reset, or break.
    pub fn nano_mut(&mut self) -> &mut Nano {
        &mut self.nano
    }

    #[must_use]
    pub fn supply(&self) -> &Supply {
        &self.supply
    }

    /// The truth, 60 samples a second, since the last call.
    pub fn take_truth(&mut self) -> Vec<Truth> {
        std::mem::take(&mut self.truth)
    }

    /// Every change of the servo driver's outputs since the last call.
    pub fn take_bursts(&mut self) -> Vec<Burst> {
        std::mem::take(&mut self.bursts)
    }

    /// Power of this step loads the supply from now to the next.
    fn step_body(&mut self) {
        let time_s = self.steps as f64 / STEPS_PER_S as f64;
        self.supply.advance(time_s);
        if self.steps.is_multiple_of(STEPS_PER_TRUTH) {
            self.truth.push(self.truth_at(time_s));
        }
        let now_s = self.nano.now_s();
        let pulses_us = self.nano.bus_mut().servo_driver.pulses_us(now_s);
        let servo_power_w = self.body.step(&self.scale.setpoints_rad(&pulses_us));
        if self.load.is_none() {
            self.supply.draw(servo_power_w + self.electronics_w, time_s);
            let (shunt_v, load_v) = (self.supply.shunt_v(), self.supply.load_v());
            self.nano.bus_mut().power_sensor.set_inputs(shunt_v, load_v, now_s);
        }
        self.steps += 1;
    }

    fn step_load(&mut self) {
        let Some(load) = &mut self.load else { return };
        let time_s = seconds(load.next);
        self.supply.draw((load.power_w)(time_s), time_s);
        load.energy_j.push(self.supply.battery_energy_j());
        load.next += LOAD_STEP_CYCLES;
        let (shunt_v, load_v) = (self.supply.shunt_v(), self.supply.load_v());
        self.nano.bus_mut().power_sensor.set_inputs(shunt_v, load_v, time_s);
    }

    fn truth_at(&self, time_s: f64) -> Truth {
        let pose = self.body.pose();
        let [x_m, y_m, z_m] = pose.position_m;
        Truth {
            time_s,
            x_m,
            y_m,
            z_m,
            yaw_rad: pose.yaw_rad,
            tilt_rad: pose.tilt_rad,
            true_energy_j: self.supply.battery_energy_j(),
            supply_v: self.supply.terminal_v(),
            supply_a: self.supply.current_a(),
            joint_angles_rad: self.body.joint_angles_rad(),
        }
    }
}
