//! The sections of `robot.toml`.
//!
//! Holds the fields and what they mean. Does not depend on their bounds, which
//! are in `super::fields`.

use super::error::RobotError;
use super::leg_scale::LegScale;
use protocol::{JOINT_COUNT, Joint, LEG_COUNT};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Which file draws the body, and what its parts are called there. Legs 1 to 4.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Model {
    /// Beside robot.toml: `.xml` is MJCF, `.urdf` is URDF.
    pub file: String,
    /// The body whose frame is the robot's, and whose mass is [`Mass::torso_kg`].
    pub torso: String,
    /// Joints of torso and thighs.
    pub hips: [String; LEG_COUNT],
    /// Joints of thighs and shins.
    pub knees: [String; LEG_COUNT],
    /// Bodies, each with one ball that touches.
    pub feet: [String; LEG_COUNT],
    /// Bodies that the leg scale draws out along their limb, masses with them.
    pub scaled: Vec<String>,
}

/// Lengths and angles that differ from what the model's file draws.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Geometry {
    /// Multiplies the limbs of [`Model::scaled`]; 1 is as drawn.
    pub leg_scale: LegScale,
    /// The shins' slope with the knees at neutral: each knee is turned from
    /// where it is drawn to the nearest angle that gives it.
    pub shin_below_horizontal_deg: f64,
    /// Of the feet's balls. Their tips remain where the drawn ones are.
    pub foot_radius_m: f64,
}

/// Masses that differ from the model's file.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Mass {
    /// The torso's body alone, its inertia in proportion; bodies that are
    /// fixed to it, such as servos, keep their own.
    pub torso_kg: f64,
}

/// A position servo: it moves its own setpoint towards the asked one, and pulls towards that.
///
/// `torque = clamp(stiffness * error, limit) - damping * speed`, with the
/// setpoint slewed at the no-load speed, and `error` what of `setpoint - angle`
/// lies outside the dead band. The damping is the motor's torque-speed line, or
/// the gears' resistance where the load drives them; dry friction then takes its
/// part of that torque.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "super::servo_presets::ServoDocument")]
pub struct Servo {
    /// The servo's name among the presets, which gave what the file left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub model: Option<String>,
    /// Voltage at the servos, for the preset.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub voltage_v: Option<f64>,
    /// Torque per radian of error.
    pub stiffness_n_m_rad: f64,
    /// Torque against each rad/s of joint speed.
    pub damping_n_m_s_rad: f64,
    /// Fastest that its setpoint moves.
    pub no_load_speed_rad_s: f64,
    /// Most that its motor pulls.
    pub torque_limit_n_m: f64,
    /// The same where the load turns it against its motor, or while its motor
    /// rests, if that is more: reduction gears are harder to turn from outside.
    pub backdriven_damping_n_m_s_rad: f64,
    /// Dry friction of its gears.
    pub friction_n_m: f64,
    /// Error that it leaves alone, either way.
    pub dead_band_deg: f64,
    /// Its mechanical end stop, either way from neutral.
    pub end_stop_deg: f64,
    /// From a pulse to the servo's acting on it.
    pub delay_s: f64,
    /// Pulse that holds it at neutral.
    pub neutral_pulse_us: f64,
    /// Change of the pulse per degree.
    pub pulse_us_per_deg: f64,
    /// Shortest and longest pulse that a servo is sent; without it, those of its end stops.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pulse_range_us: Option<[f64; 2]>,
    /// Output of the PCA9685 of each joint, hips 1 to 4, then knees; without it, 0 to 7.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub channels: Option<[u8; JOINT_COUNT]>,
    /// Whether the servo turns against its joint, in the same order; without it, none does.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reversed: Option<[bool; JOINT_COUNT]>,
}

impl Servo {
    /// Output of the PCA9685 of each joint.
    #[must_use]
    pub fn channels(&self) -> [u8; JOINT_COUNT] {
        self.channels.unwrap_or(core::array::from_fn(|joint| joint as u8))
    }

    /// Whether each servo turns against its joint.
    #[must_use]
    pub fn reversed(&self) -> [bool; JOINT_COUNT] {
        self.reversed.unwrap_or([false; JOINT_COUNT])
    }

    /// Shortest and longest pulse that a servo is sent: the range that is given, else from end
    /// stop to end stop.
    #[must_use]
    pub fn pulse_range_us(&self) -> [f64; 2] {
        let reach_us = self.end_stop_deg * self.pulse_us_per_deg;
        self.pulse_range_us.unwrap_or([self.neutral_pulse_us - reach_us, self.neutral_pulse_us + reach_us])
    }

    /// The first of the wiring's values that no board has.
    pub(super) fn check_wiring(&self) -> Result<(), RobotError> {
        let channels = self.channels();
        for (joint, &channel) in channels.iter().enumerate() {
            let name = Joint::ALL[joint].name();
            if usize::from(channel) >= JOINT_COUNT {
                return Err(RobotError::Channel { joint: name, channel, problem: "the outputs are 0 to 7" });
            }
            if channels[..joint].contains(&channel) {
                return Err(RobotError::Channel { joint: name, channel, problem: "another joint has it" });
            }
        }
        let [shortest, longest] = self.pulse_range_us();
        let holds_neutral = (shortest..=longest).contains(&self.neutral_pulse_us);
        if self.pulse_range_us.is_some() && !(shortest > 0.0 && longest <= 4000.0 && holds_neutral) {
            return Err(RobotError::PulseRange { shortest, longest, neutral: self.neutral_pulse_us });
        }
        Ok(())
    }

    /// Fastest that it turns with nothing attached: as its setpoint moves, or
    /// where its damping takes all of its torque.
    #[must_use]
    pub fn top_speed_rad_s(&self) -> f64 {
        self.no_load_speed_rad_s.min(self.torque_limit_n_m / self.damping_n_m_s_rad.max(1e-9))
    }

    /// Torque against each rad/s of a joint that turns at `speed_rad_s` while its
    /// motor pulls with `pull_n_m`, or does not.
    #[must_use]
    pub fn damping_at(&self, pull_n_m: f64, speed_rad_s: f64) -> f64 {
        if pull_n_m * speed_rad_s > 0.0 {
            self.damping_n_m_s_rad
        } else {
            self.damping_n_m_s_rad.max(self.backdriven_damping_n_m_s_rad)
        }
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

impl Supply {
    /// Most power that it gives, in W: where its voltage has sunk to half. Infinite
    /// without resistance.
    #[must_use]
    pub fn most_power_w(&self) -> f64 {
        self.nominal_v * self.nominal_v / (4.0 * self.resistance_ohm)
    }
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
