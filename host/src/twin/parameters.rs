//! What a fit may change, and how far.
//!
//! Holds names and bounds. Electronics and efficiency are not among them: see
//! [`super::power`].

use super::TwinError;
use crate::robot::{PowerLine, Robot, TwinRecord};
use std::collections::BTreeMap;

/// One number of the description.
#[derive(Debug, Clone, Copy)]
pub struct Parameter {
    /// Its path in the file.
    pub name: &'static str,
    /// Least that is searched.
    pub min: f64,
    /// Most that is searched.
    pub max: f64,
    /// Where a search begins: near where the deepest valley of all the Ant's searches lies,
    /// which few descents from random sets find; else our guess.
    pub first: f64,
    /// Whether a fit changes it unless told what to change.
    pub by_default: bool,
    get: fn(&Robot) -> f64,
    set: fn(&mut Robot, f64),
}

/// The sample time that a search starts from, where the robot has none.
const FIRST_SAMPLE_S: f64 = 0.11;

macro_rules! field {
    ($name:literal, $min:literal to $max:literal from $first:literal, $default:literal, $($path:ident).+) => {
        Parameter {
            name: $name,
            min: $min,
            max: $max,
            first: $first,
            by_default: $default,
            get: |robot| robot.$($path).+,
            set: |robot, value| robot.$($path).+ = value,
        }
    };
}

/// All of them.
pub const PARAMETERS: [Parameter; 15] = [
    field!("ground.friction", 0.3 to 0.9 from 0.31, true, ground.friction),
    field!("servo.stiffness_n_m_rad", 1.0 to 12.0 from 2.7, true, servo.stiffness_n_m_rad),
    field!("servo.damping_n_m_s_rad", 0.02 to 1.0 from 0.25, true, servo.damping_n_m_s_rad),
    field!("servo.backdriven_damping_n_m_s_rad", 0.0 to 8.0 from 2.5, true, servo.backdriven_damping_n_m_s_rad),
    field!("servo.no_load_speed_rad_s", 1.0 to 6.0 from 5.5, true, servo.no_load_speed_rad_s),
    field!("servo.torque_limit_n_m", 0.3 to 1.2 from 0.76, true, servo.torque_limit_n_m),
    field!("servo.friction_n_m", 0.0 to 0.15 from 0.01, false, servo.friction_n_m),
    field!("servo.dead_band_deg", 0.3 to 1.5 from 1.4, true, servo.dead_band_deg),
    field!("geometry.shin_below_horizontal_deg", 40.0 to 50.0 from 40.5, true, geometry.shin_below_horizontal_deg),
    field!("geometry.foot_radius_m", 0.004 to 0.025 from 0.008, true, geometry.foot_radius_m),
    field!("mass.torso_kg", 0.29 to 0.54 from 0.36, true, mass.torso_kg),
    field!("power.heat_w_per_n2_m2", 0.0 to 3.0 from 0.1, false, power.heat_w_per_n2_m2),
    field!("supply.resistance_ohm", 0.0 to 4.0 from 0.1, false, supply.resistance_ohm),
    field!("servo.end_stop_deg", 30.0 to 90.0 from 50.0, false, servo.end_stop_deg),
    Parameter {
        name: "twin.sample_s",
        min: 0.08,
        max: 0.15,
        first: FIRST_SAMPLE_S,
        by_default: true,
        get: |robot| robot.twin.as_ref().map_or(FIRST_SAMPLE_S, |twin| twin.sample_s),
        set: |robot, value| record(robot).sample_s = value,
    },
];

/// The robot's record of its fit, made where there is none.
pub fn record(robot: &mut Robot) -> &mut TwinRecord {
    let none = PowerLine { constant_w: 0.0, slope_w: 0.0 };
    robot.twin.get_or_insert_with(|| TwinRecord {
        sample_s: FIRST_SAMPLE_S,
        methods: Vec::new(),
        seed: 0,
        evaluations: 0,
        score: 0.0,
        free_power: none,
        baseline_power: none,
        spread: BTreeMap::new(),
    })
}

impl Parameter {
    /// Its value in 0 to 1 of its range.
    #[must_use]
    pub fn share_of(&self, robot: &Robot) -> f64 {
        ((self.value_of(robot) - self.min) / (self.max - self.min)).clamp(0.0, 1.0)
    }

    /// Where a search begins, in 0 to 1 of its range.
    #[must_use]
    pub fn first_share(&self) -> f64 {
        (self.first - self.min) / (self.max - self.min)
    }

    /// Its value.
    #[must_use]
    pub fn value_of(&self, robot: &Robot) -> f64 {
        (self.get)(robot)
    }

    /// Its value at a share of its range; a share outside 0 to 1 is folded back in.
    #[must_use]
    pub fn value_at(&self, share: f64) -> f64 {
        let share = share.rem_euclid(2.0);
        let share = if share > 1.0 { 2.0 - share } else { share };
        (self.min + (self.max - self.min) * share).clamp(self.min, self.max)
    }

    /// Refuses a range that does not hold the robot's own value, as with another size.
    ///
    /// # Errors
    /// [`TwinError::Elsewhere`] if the description's value lies outside the range.
    pub fn check(&self, robot: &Robot) -> Result<(), TwinError> {
        let value = self.value_of(robot);
        if (self.min..=self.max).contains(&value) {
            return Ok(());
        }
        Err(TwinError::Elsewhere { name: self.name, value, min: self.min, max: self.max })
    }

    /// Puts a value into the robot's description.
    pub fn put(&self, robot: &mut Robot, value: f64) {
        (self.set)(robot, value);
    }

    /// The named ones, or those that a fit changes by default. A name may be
    /// followed by a range, `=MIN:MAX`; then a search begins in its middle.
    ///
    /// # Errors
    /// [`TwinError::Parameter`] for an unknown name, [`TwinError::Range`]
    /// for an invalid range.
    pub fn choose(names: &[String]) -> Result<Vec<Self>, TwinError> {
        if names.is_empty() {
            return Ok(PARAMETERS.into_iter().filter(|parameter| parameter.by_default).collect());
        }
        let find = |text: &String| {
            let (name, range) = text.split_once('=').map_or((text.as_str(), None), |(n, r)| (n, Some(r)));
            let known = PARAMETERS.into_iter().find(|parameter| parameter.name == name).ok_or_else(|| {
                let has: Vec<_> = PARAMETERS.iter().map(|parameter| parameter.name).collect();
                TwinError::Parameter { name: name.to_owned(), has: has.join(", ") }
            })?;
            let Some(range) = range else { return Ok(known) };
            let ends =
                range.split_once(':').and_then(|(min, max)| Some((min.parse().ok()?, max.parse().ok()?)));
            match ends {
                Some((min, max)) if f64::is_finite(min) && f64::is_finite(max) && min < max => {
                    Ok(Self { min, max, first: 0.5 * (min + max), ..known })
                }
                _ => Err(TwinError::Range { text: text.clone() }),
            }
        };
        names.iter().map(find).collect()
    }
}
