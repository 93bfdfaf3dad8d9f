//! What a robot is made of: lengths, masses, servos, ground and power.
//!
//! Owns the description and its file format, always compiled; the simulated
//! body (`sim`) is built from it and a trial's weight comes from it. Refuses a
//! description with a number that is no number, or that no such robot can
//! have: every bound stands in `Robot::check`.
//!
//! The Ant's description is `robots/ant/robot.toml`. Its numbers that no data
//! sheet gives (friction, servos, power) come from `host twin fit`, and the
//! file's own `[twin]` section says from which.

use crate::run_folder::FileError;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Leg lengths that are sensible multiples of the Ant's: its servos lift no more.
pub const LEG_SCALE_RANGE: (f64, f64) = (0.3, 2.0);

/// The Ant, as the last fit left it.
const ANT: &str = include_str!("../robots/ant/robot.toml");

/// A robot with eight servos on four legs.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Robot {
    /// For people.
    pub name: String,
    /// Largest setpoint from neutral that the robot's tables may reach.
    pub joint_limit_deg: f64,
    /// Lengths and angles.
    pub geometry: Geometry,
    /// Where the weight sits.
    pub mass: Mass,
    /// The servos, all alike.
    pub servo: Servo,
    /// What the feet stand on.
    pub ground: Ground,
    /// From mechanical to electrical power.
    pub power: Power,
    /// What feeds it.
    pub supply: Supply,
    /// How it was fitted to measured trials, if it was.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub twin: Option<TwinRecord>,
}

/// Lengths and angles. Legs 1 to 4 stand at azimuth 45, 135, 225 and 315 degrees.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Geometry {
    /// Each hip is this far from the body's centre along x and along y.
    pub hip_offset_m: f64,
    /// Hip axis to knee axis; horizontal.
    pub thigh_m: f64,
    /// Knee axis to the foot's tip at leg scale 1.
    pub shin_m: f64,
    /// Multiplies the shin alone: 1.0 is the paper's "1 L", 0.6 its "0.6 L".
    pub leg_scale: f64,
    /// The shin's slope with the knee at neutral.
    pub shin_below_horizontal_deg: f64,
    /// The rounded end of the shin, part of its length.
    pub foot_radius_m: f64,
    /// Half the body's height, hips at its middle.
    pub torso_half_height_m: f64,
    /// How far a hip's bracket and the leg beyond it twist under the hip's
    /// torque: in series with the servo's own stiffness.
    #[serde(default)]
    pub hip_twist_rad_per_n_m: f64,
}

/// Where the weight sits. A servo is at each hip, on the body, and at each knee, on the thigh.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Mass {
    /// Frame, electronics and whatever else the body carries, without servos.
    pub torso_kg: f64,
    /// One servo.
    pub servo_kg: f64,
    /// One thigh's tube.
    pub thigh_kg: f64,
    /// One shin's tube and foot at leg scale 1.
    pub shin_kg: f64,
}

/// A position servo: it moves its own setpoint towards the asked one, and pulls towards that.
///
/// `torque = clamp(stiffness * error, limit) - damping * speed`, with the
/// setpoint slewed at the no-load speed, and `error` what of `setpoint - angle`
/// lies outside the dead band. The damping is the motor's torque-speed line;
/// dry friction then takes its part of that torque.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Servo {
    /// Torque per radian of error.
    pub stiffness_n_m_rad: f64,
    /// Torque against each rad/s of joint speed.
    pub damping_n_m_s_rad: f64,
    /// Fastest that its setpoint moves.
    pub no_load_speed_rad_s: f64,
    /// Most that its motor pulls.
    pub torque_limit_n_m: f64,
    /// Dry friction of its gears.
    #[serde(default)]
    pub friction_n_m: f64,
    /// Error that it leaves alone, either way.
    #[serde(default)]
    pub dead_band_deg: f64,
    /// Its mechanical end stop, either way from neutral.
    pub end_stop_deg: f64,
    /// Pulse that holds it at neutral.
    pub neutral_pulse_us: f64,
    /// Change of the pulse per degree.
    pub pulse_us_per_deg: f64,
}

impl Servo {
    /// Fastest that it turns with nothing attached: as its setpoint moves, or
    /// where its damping takes all of its torque.
    #[must_use]
    pub fn top_speed_rad_s(&self) -> f64 {
        self.no_load_speed_rad_s.min(self.torque_limit_n_m / self.damping_n_m_s_rad.max(1e-9))
    }
}

/// What the feet stand on.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Ground {
    /// Coulomb friction of foot on ground.
    pub friction: f64,
}

/// From mechanical to electrical power:
/// `electronics + positive work / efficiency + heat * torque^2`.
///
/// The last is a winding's `I^2 R`, and the work that the robot returns to a
/// driven servo heats its winding first: the supply pays what is missing.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Power {
    /// What flows while the servos do nothing: controller, driver, idle servos.
    pub electronics_w: f64,
    /// Share of a servo's electrical power that arrives at its horn.
    pub efficiency: f64,
    /// Heat of a servo's winding per squared torque: what holding costs.
    #[serde(default)]
    pub heat_w_per_n2_m2: f64,
}

/// What feeds the robot.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Supply {
    /// Voltage without load.
    pub nominal_v: f64,
    /// Supply and leads together.
    pub resistance_ohm: f64,
}

/// Which measured trials a description was fitted to, and what came of it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TwinRecord {
    /// How long the measured robot held each sample of a table.
    pub sample_s: f64,
    /// Gaits that were fitted.
    pub methods: Vec<String>,
    /// Of the optimiser.
    pub seed: u64,
    /// Sets of parameters that were tried.
    pub evaluations: u64,
    /// Mean of the mean absolute relative errors of speed, power and cost of transport.
    pub score: f64,
    /// What the same trials say with no bound on the efficiency.
    pub free_power: PowerLine,
    /// Power from the tables' steps alone: the line to beat.
    pub baseline_power: PowerLine,
    /// Standard deviation of each fitted parameter over the sets that score about as well.
    pub spread: BTreeMap<String, f64>,
}

/// A straight line to power, fitted by least squares of the relative error.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PowerLine {
    /// At zero.
    pub constant_w: f64,
    /// Watts per unit of the predictor.
    pub slope_w: f64,
}

impl PowerLine {
    /// Power at a value of the predictor.
    #[must_use]
    pub fn at(&self, predictor: f64) -> f64 {
        self.constant_w + self.slope_w * predictor
    }
}

/// Why a robot description was refused.
#[derive(Debug, Error)]
pub enum RobotError {
    /// The file cannot be read.
    #[error(transparent)]
    File(#[from] FileError),
    /// The file is no robot description.
    #[error("{path} is no robot description")]
    Parse {
        /// Which file.
        path: PathBuf,
        /// Where and why.
        source: Box<toml::de::Error>,
    },
    /// A number that no such robot can have.
    #[error("robot description: {field} is {value}, but must be within {min} to {max}; correct the value")]
    OutOfRange {
        /// Path of the field in the file.
        field: &'static str,
        /// What it says.
        value: f64,
        /// Least allowed.
        min: f64,
        /// Most allowed.
        max: f64,
    },
}

impl Robot {
    /// The paper's Ant with shins of `leg_scale` times 0.23 m.
    ///
    /// # Errors
    /// [`RobotError::OutOfRange`] unless the scale is within [`LEG_SCALE_RANGE`].
    ///
    /// # Source
    /// Lengths: the authors' model. Joint limit: their tables reach 51.6
    /// degrees. Pulses: 330 ticks of 4.08 us are neutral, 0.6 degree a tick.
    /// Friction, servo, power, mass and the shin's slope: the fit that the
    /// description's `[twin]` section names. How the mass is shared out, foot
    /// radius, torso height and the supply are our assumptions.
    pub fn ant(leg_scale: f64) -> Result<Self, RobotError> {
        let mut robot: Self = toml::from_str(ANT).map_err(|source| RobotError::Parse {
            path: "robots/ant/robot.toml".into(),
            source: Box::new(source),
        })?;
        robot.geometry.leg_scale = leg_scale;
        robot.check()?;
        Ok(robot)
    }

    /// Reads and checks a description.
    ///
    /// # Errors
    /// [`RobotError`] naming the file, or the field, its value and its bounds.
    pub fn load(path: &Path) -> Result<Self, RobotError> {
        let text = std::fs::read_to_string(path).map_err(FileError::on("read", path))?;
        let robot: Self = toml::from_str(&text)
            .map_err(|source| RobotError::Parse { path: path.to_owned(), source: Box::new(source) })?;
        robot.check()?;
        Ok(robot)
    }

    /// The description as [`Self::load`] reads it.
    #[must_use]
    pub fn to_toml(&self) -> String {
        // Strings and finite numbers in tables: nothing that TOML cannot hold.
        toml::to_string_pretty(self).unwrap_or_default()
    }

    /// Everything that the legs carry and are.
    #[must_use]
    pub fn mass_kg(&self) -> f64 {
        let leg = 2.0 * self.mass.servo_kg + self.mass.thigh_kg + self.scaled_shin_kg();
        self.mass.torso_kg + 4.0 * leg
    }

    /// Knee axis to the foot's tip.
    #[must_use]
    pub fn scaled_shin_m(&self) -> f64 {
        self.geometry.shin_m * self.geometry.leg_scale
    }

    /// One shin; a tube's mass goes with its length.
    #[must_use]
    pub fn scaled_shin_kg(&self) -> f64 {
        self.mass.shin_kg * self.geometry.leg_scale
    }

    /// Checks every number against its bounds.
    ///
    /// # Errors
    /// [`RobotError::OutOfRange`] for the first that lies outside.
    pub fn check(&self) -> Result<(), RobotError> {
        let Self { geometry, mass, servo, ground, power, supply, .. } = self;
        let bounds = [
            ("joint_limit_deg", self.joint_limit_deg, 1.0, 90.0),
            ("geometry.hip_offset_m", geometry.hip_offset_m, 0.01, 1.0),
            ("geometry.thigh_m", geometry.thigh_m, 0.01, 1.0),
            ("geometry.shin_m", geometry.shin_m, 0.03, 1.0),
            ("geometry.leg_scale", geometry.leg_scale, LEG_SCALE_RANGE.0, LEG_SCALE_RANGE.1),
            ("geometry.shin_below_horizontal_deg", geometry.shin_below_horizontal_deg, 0.0, 90.0),
            ("geometry.foot_radius_m", geometry.foot_radius_m, 0.001, 0.004 + self.scaled_shin_m() / 4.0),
            ("geometry.torso_half_height_m", geometry.torso_half_height_m, 0.005, 0.5),
            ("geometry.hip_twist_rad_per_n_m", geometry.hip_twist_rad_per_n_m, 0.0, 5.0),
            ("mass.torso_kg", mass.torso_kg, 0.01, 20.0),
            ("mass.servo_kg", mass.servo_kg, 0.001, 1.0),
            ("mass.thigh_kg", mass.thigh_kg, 0.001, 2.0),
            ("mass.shin_kg", mass.shin_kg, 0.001, 2.0),
            ("servo.stiffness_n_m_rad", servo.stiffness_n_m_rad, 0.0, 200.0),
            ("servo.damping_n_m_s_rad", servo.damping_n_m_s_rad, 0.0, 20.0),
            ("servo.no_load_speed_rad_s", servo.no_load_speed_rad_s, 0.1, 50.0),
            ("servo.torque_limit_n_m", servo.torque_limit_n_m, 0.0, 50.0),
            ("servo.friction_n_m", servo.friction_n_m, 0.0, 5.0),
            ("servo.dead_band_deg", servo.dead_band_deg, 0.0, 10.0),
            ("servo.end_stop_deg", servo.end_stop_deg, 20.0, 180.0),
            ("servo.neutral_pulse_us", servo.neutral_pulse_us, 500.0, 2500.0),
            ("servo.pulse_us_per_deg", servo.pulse_us_per_deg, 1.0, 30.0),
            ("ground.friction", ground.friction, 0.0, 2.0),
            ("power.electronics_w", power.electronics_w, 0.0, 100.0),
            ("power.efficiency", power.efficiency, 0.05, 1.0),
            ("power.heat_w_per_n2_m2", power.heat_w_per_n2_m2, 0.0, 1000.0),
            ("supply.nominal_v", supply.nominal_v, 1.0, 26.0),
            ("supply.resistance_ohm", supply.resistance_ohm, 0.0, 5.0),
        ];
        for (field, value, min, max) in bounds {
            // NaN lies within nothing.
            if !(min..=max).contains(&value) {
                return Err(RobotError::OutOfRange { field, value, min, max });
            }
        }
        if let Some(value) = self.twin.as_ref().map(|twin| twin.sample_s)
            && !(0.02..=1.0).contains(&value)
        {
            return Err(RobotError::OutOfRange { field: "twin.sample_s", value, min: 0.02, max: 1.0 });
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;
