//! Servos by name: what their data sheets say, and what follows from it.
//!
//! Holds the presets (`servo_presets.toml`, compiled in) and the rules for
//! what no data sheet has; the constants below are those rules' numbers.
//! Does not depend on the rest of a description: [`ServoDocument`] and
//! [`PowerDocument`] are `[servo]` and `[power]` as people write them.

use super::sections::{Power, Servo};
use core::f64::consts::FRAC_PI_3;
use protocol::JOINT_COUNT;
use serde::Deserialize;
use std::sync::OnceLock;
use thiserror::Error;

/// Newton metres in a kilogram-force centimetre.
const N_M_PER_KG_CM: f64 = 0.098_066_5;
/// How far beyond the stated voltages torque and speed are scaled by the voltage, as a share.
const BEYOND: f64 = 0.1;
/// Error at which a servo pulls with all of its torque. The Ant's fit says 0.28 rad.
const FULL_TORQUE_AT_RAD: f64 = 0.2;
/// Dry friction of the gears, as a share of the stall torque: ours.
const FRICTION_SHARE: f64 = 0.03;
/// Damping where the load turns the gears, in times the motor's. The Ant's fit says 10.4.
const BACKDRIVEN: f64 = 10.0;
/// Width of a dead band that no data sheet gives: the usual one.
const DEAD_BAND_US: f64 = 8.0;
/// From a pulse to the servo's acting on it: one frame of pulses at 60 Hz.
const DELAY_S: f64 = 1.0 / protocol::FRAME_RATE_HZ as f64;
/// Efficiency of gears and bridge by which the stall current follows from torque and speed:
/// it gives HS-311 0.67 A (0.7 claimed) and MG996R 2.7 A (2.5).
const EFFICIENCY: f64 = 0.5;
/// So many names are listed where one is unknown.
const NEAREST: usize = 3;

/// What the word for a number is worth.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Basis {
    /// The maker or seller says so.
    Claim,
    /// Somebody measured it.
    Measured,
    /// What servos of the kind usually do.
    Convention,
}

/// A group of a preset's fields.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Stated {
    /// Stall torque at each voltage.
    Torque,
    /// No-load speed at each voltage.
    Speed,
    /// Stall current at the voltages that have one.
    Current,
    /// [`Preset::mass_g`]
    Mass,
    /// [`Preset::dead_band_us`]
    DeadBand,
    /// [`Preset::travel_deg`] and [`Preset::pulse_us`]
    Travel,
}

/// Where numbers come from.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Source {
    /// Which ones.
    pub of: Vec<Stated>,
    /// Worth of it.
    pub basis: Basis,
    /// Maker and document, or the reason.
    pub document: String,
}

/// What a data sheet says for one voltage, in its own units.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Rating {
    /// At which voltage.
    pub voltage_v: f64,
    /// Torque at which it no longer turns, in kgf cm.
    pub stall_torque_kg_cm: f64,
    /// Seconds for 60 degrees without load.
    pub s_per_60_deg: f64,
    /// Current at which it no longer turns.
    pub stall_current_a: Option<f64>,
}

/// A servo that is sold.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Preset {
    /// As people write it.
    pub name: String,
    /// Who makes it.
    pub maker: String,
    /// With cable and horn, where its data sheet says.
    pub mass_g: Option<f64>,
    /// Whole width of its dead band.
    pub dead_band_us: Option<f64>,
    /// From end to end.
    pub travel_deg: f64,
    /// Pulses at the two ends.
    pub pulse_us: [f64; 2],
    /// By rising voltage.
    pub at: Vec<Rating>,
    /// Of every number above.
    pub sources: Vec<Source>,
}

/// A preset at one voltage, in units of the description.
#[derive(Debug, Clone, PartialEq)]
pub struct Derived {
    /// All of `[servo]`.
    pub servo: Servo,
    /// `power.heat_w_per_n2_m2`.
    pub heat_w_per_n2_m2: f64,
}

/// Why a preset cannot be used.
#[derive(Debug, Error, PartialEq)]
pub enum PresetError {
    /// No such servo.
    #[error(
        "servo.model is {name:?}, which is not one of the {count} known servos; did you mean {nearest}? \
         Else leave out model and give every number of [servo]"
    )]
    Unknown {
        /// As in the description.
        name: String,
        /// How many there are.
        count: usize,
        /// The names nearest to it.
        nearest: String,
    },
    /// Torque and speed go with voltage.
    #[error(
        "servo.model is {name:?}, but servo.voltage_v is missing: give the voltage at the servos, {stated}"
    )]
    NoVoltage {
        /// The servo.
        name: String,
        /// Its range in words.
        stated: String,
    },
    /// Too far from what the data sheet states.
    #[error("servo.voltage_v is {voltage_v}, but {name} is known for {stated}; give a voltage within that")]
    Voltage {
        /// The servo.
        name: String,
        /// Asked.
        voltage_v: f64,
        /// Its range in words.
        stated: String,
    },
    /// A number is missing, and no preset gives it.
    #[error("missing field `{field}`; give it, or a servo.model with servo.voltage_v")]
    Missing {
        /// Of `[servo]`.
        field: &'static str,
    },
    /// A voltage says nothing of a servo that has no name.
    #[error("servo.voltage_v goes with servo.model: name the servo, or leave the voltage out")]
    VoltageOfNone,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Presets {
    servo: Vec<Preset>,
}

/// All presets, lightest first.
#[must_use]
pub fn presets() -> &'static [Preset] {
    static ALL: OnceLock<Vec<Preset>> = OnceLock::new();
    ALL.get_or_init(|| {
        #[expect(clippy::expect_used, reason = "the file is part of the program, and tests read it")]
        toml::from_str::<Presets>(include_str!("servo_presets.toml")).expect("servo_presets.toml").servo
    })
}

/// The preset of a name, whatever its case, spaces and hyphens.
///
/// # Errors
/// [`PresetError::Unknown`] with the names nearest to it.
pub fn preset(name: &str) -> Result<&'static Preset, PresetError> {
    let wanted = bare(name);
    presets().iter().find(|preset| bare(&preset.name) == wanted).ok_or_else(|| {
        let mut by_distance: Vec<(usize, &str)> = presets()
            .iter()
            .map(|preset| (distance(&bare(&preset.name), &wanted), preset.name.as_str()))
            .collect();
        by_distance.sort_by_key(|(distance, _)| *distance);
        let nearest: Vec<&str> = by_distance.iter().take(NEAREST).map(|(_, name)| *name).collect();
        PresetError::Unknown { name: name.to_owned(), count: presets().len(), nearest: nearest.join(", ") }
    })
}

fn bare(name: &str) -> String {
    name.chars().filter(|c| c.is_alphanumeric()).flat_map(char::to_lowercase).collect()
}

/// Characters to insert, delete or replace (Levenshtein).
fn distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, from) in a.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, to) in b.iter().enumerate() {
            let replaced = diagonal + usize::from(from != *to);
            diagonal = row[j + 1];
            row[j + 1] = replaced.min(diagonal + 1).min(row[j] + 1);
        }
    }
    row[b.len()]
}

impl Preset {
    /// Lowest and highest usable voltage.
    #[must_use]
    pub fn voltages_v(&self) -> [f64; 2] {
        let (first, last) = (self.at.first(), self.at.last());
        [first, last].map(|rating| rating.map_or(0.0, |rating| rating.voltage_v))
    }

    /// Its mass in kilograms, where its data sheet says.
    #[must_use]
    pub fn mass_kg(&self) -> Option<f64> {
        self.mass_g.map(|mass_g| mass_g / 1000.0)
    }

    /// The stated voltages, in words.
    fn stated(&self) -> String {
        let [low, high] = self.voltages_v();
        if low == high {
            format!("{low} V, a tenth more or less")
        } else {
            format!("{low} to {high} V, a tenth more or less")
        }
    }

    /// The rating at a voltage: between two stated ones along a straight line, a
    /// little beyond them in proportion to the voltage.
    fn rating(&self, voltage_v: f64) -> Result<Rating, PresetError> {
        let [low, high] = self.voltages_v();
        if !(low * (1.0 - BEYOND)..=high * (1.0 + BEYOND)).contains(&voltage_v) {
            return Err(PresetError::Voltage { name: self.name.clone(), voltage_v, stated: self.stated() });
        }
        let inside = voltage_v.clamp(low, high);
        let upper = self.at.iter().position(|rating| rating.voltage_v >= inside).unwrap_or(0);
        let (a, b) = (&self.at[upper.saturating_sub(1)], &self.at[upper]);
        let width = b.voltage_v - a.voltage_v;
        let share = if width > 0.0 { (inside - a.voltage_v) / width } else { 1.0 };
        let between = |a: f64, b: f64| a + (b - a) * share;
        let beyond = voltage_v / inside;
        Ok(Rating {
            voltage_v,
            stall_torque_kg_cm: between(a.stall_torque_kg_cm, b.stall_torque_kg_cm) * beyond,
            // Speed, and not its inverse, is what goes with voltage.
            s_per_60_deg: 1.0 / (between(1.0 / a.s_per_60_deg, 1.0 / b.s_per_60_deg) * beyond),
            // Only where both sides have one.
            stall_current_a: a.stall_current_a.zip(b.stall_current_a).map(|(a, b)| between(a, b) * beyond),
        })
    }

    /// Every number of `[servo]` at a voltage, and the heat of holding.
    ///
    /// # Errors
    /// [`PresetError::Voltage`] more than a tenth beyond the stated ones.
    pub fn at(&self, voltage_v: f64) -> Result<Derived, PresetError> {
        let rating = self.rating(voltage_v)?;
        let stall_n_m = rating.stall_torque_kg_cm * N_M_PER_KG_CM;
        let speed_rad_s = FRAC_PI_3 / rating.s_per_60_deg;
        let damping = stall_n_m / speed_rad_s;
        let [low_us, high_us] = self.pulse_us;
        let pulse_us_per_deg = (high_us - low_us) / self.travel_deg;
        let stall_w = match rating.stall_current_a {
            Some(current_a) => current_a * voltage_v,
            // A motor's stall power is its stall torque times its no-load speed.
            None => stall_n_m * speed_rad_s / EFFICIENCY,
        };
        Ok(Derived {
            servo: Servo {
                model: Some(self.name.clone()),
                voltage_v: Some(voltage_v),
                stiffness_n_m_rad: stall_n_m / FULL_TORQUE_AT_RAD,
                damping_n_m_s_rad: damping,
                no_load_speed_rad_s: speed_rad_s,
                torque_limit_n_m: stall_n_m,
                backdriven_damping_n_m_s_rad: BACKDRIVEN * damping,
                friction_n_m: FRICTION_SHARE * stall_n_m,
                dead_band_deg: self.dead_band_us.unwrap_or(DEAD_BAND_US) / (2.0 * pulse_us_per_deg),
                end_stop_deg: self.travel_deg / 2.0,
                delay_s: DELAY_S,
                neutral_pulse_us: f64::midpoint(low_us, high_us),
                pulse_us_per_deg,
                pulse_range_us: None,
                channels: None,
                reversed: None,
            },
            heat_w_per_n2_m2: stall_w / (stall_n_m * stall_n_m),
        })
    }
}

/// `[servo]` as people write it: with a model, all else may be left out.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ServoDocument {
    model: Option<String>,
    voltage_v: Option<f64>,
    stiffness_n_m_rad: Option<f64>,
    damping_n_m_s_rad: Option<f64>,
    no_load_speed_rad_s: Option<f64>,
    torque_limit_n_m: Option<f64>,
    backdriven_damping_n_m_s_rad: Option<f64>,
    friction_n_m: Option<f64>,
    dead_band_deg: Option<f64>,
    end_stop_deg: Option<f64>,
    delay_s: Option<f64>,
    neutral_pulse_us: Option<f64>,
    pulse_us_per_deg: Option<f64>,
    // How it is wired is nothing that a model says.
    pulse_range_us: Option<[f64; 2]>,
    channels: Option<[u8; JOINT_COUNT]>,
    reversed: Option<[bool; JOINT_COUNT]>,
}

impl TryFrom<ServoDocument> for Servo {
    type Error = PresetError;

    fn try_from(said: ServoDocument) -> Result<Self, PresetError> {
        let known = match (&said.model, said.voltage_v) {
            (Some(name), Some(voltage_v)) => Some(preset(name)?.at(voltage_v)?.servo),
            (Some(name), None) => {
                let stated = preset(name)?.stated();
                return Err(PresetError::NoVoltage { name: name.clone(), stated });
            }
            (None, Some(_)) => return Err(PresetError::VoltageOfNone),
            (None, None) => None,
        };
        let known = known.as_ref();
        let needed = |said: Option<f64>, field: &'static str, of: fn(&Servo) -> f64| {
            said.or_else(|| known.map(of)).ok_or(PresetError::Missing { field })
        };
        let optional =
            |said: Option<f64>, of: fn(&Servo) -> f64| said.or_else(|| known.map(of)).unwrap_or(0.0);
        Ok(Self {
            model: known.and_then(|servo| servo.model.clone()),
            voltage_v: said.voltage_v,
            stiffness_n_m_rad: needed(said.stiffness_n_m_rad, "stiffness_n_m_rad", |s| s.stiffness_n_m_rad)?,
            damping_n_m_s_rad: needed(said.damping_n_m_s_rad, "damping_n_m_s_rad", |s| s.damping_n_m_s_rad)?,
            no_load_speed_rad_s: needed(said.no_load_speed_rad_s, "no_load_speed_rad_s", |s| {
                s.no_load_speed_rad_s
            })?,
            torque_limit_n_m: needed(said.torque_limit_n_m, "torque_limit_n_m", |s| s.torque_limit_n_m)?,
            backdriven_damping_n_m_s_rad: optional(said.backdriven_damping_n_m_s_rad, |s| {
                s.backdriven_damping_n_m_s_rad
            }),
            friction_n_m: optional(said.friction_n_m, |s| s.friction_n_m),
            dead_band_deg: optional(said.dead_band_deg, |s| s.dead_band_deg),
            end_stop_deg: needed(said.end_stop_deg, "end_stop_deg", |s| s.end_stop_deg)?,
            delay_s: optional(said.delay_s, |s| s.delay_s),
            neutral_pulse_us: needed(said.neutral_pulse_us, "neutral_pulse_us", |s| s.neutral_pulse_us)?,
            pulse_us_per_deg: needed(said.pulse_us_per_deg, "pulse_us_per_deg", |s| s.pulse_us_per_deg)?,
            pulse_range_us: said.pulse_range_us,
            channels: said.channels,
            reversed: said.reversed,
        })
    }
}

/// `[power]` as people write it.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PowerDocument {
    electronics_w: f64,
    efficiency: f64,
    heat_w_per_n2_m2: Option<f64>,
}

impl PowerDocument {
    /// With the heat of the servo's model, where the file gives none.
    #[must_use]
    pub fn complete(self, servo: &Servo) -> Power {
        let of_model = || {
            let (name, voltage_v) = servo.model.as_deref().zip(servo.voltage_v)?;
            Some(preset(name).ok()?.at(voltage_v).ok()?.heat_w_per_n2_m2)
        };
        Power {
            electronics_w: self.electronics_w,
            efficiency: self.efficiency,
            heat_w_per_n2_m2: self.heat_w_per_n2_m2.or_else(of_model).unwrap_or(0.0),
        }
    }
}

#[cfg(test)]
mod tests;
