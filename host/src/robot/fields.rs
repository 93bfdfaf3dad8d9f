//! The numbers of a description that have bounds, each by its path in the file.
//!
//! Holds their names and bounds: `Robot::check` refuses what lies outside, and
//! whoever changes a number by its name stays inside. Does not depend on files.

use super::leg_scale::{LEG_SCALE_RANGE, LegScale};
use super::{Robot, limbs};

/// A number of a description.
#[derive(Debug, Clone, Copy)]
pub struct Field {
    /// Its path in the file.
    pub name: &'static str,
    /// Reads it.
    pub get: fn(&Robot) -> f64,
    /// Writes it, whatever it is; a leg scale is held within its range.
    pub set: fn(&mut Robot, f64),
    bounds: Bounds,
}

#[derive(Debug, Clone, Copy)]
enum Bounds {
    Between(f64, f64),
    /// A foot's ball within a shin of this robot.
    Foot,
}

macro_rules! field {
    ($name:literal, $bounds:expr, $($path:ident).+) => {
        Field {
            name: $name,
            get: |robot| robot.$($path).+,
            set: |robot, value| robot.$($path).+ = value,
            bounds: $bounds,
        }
    };
    ($name:literal, $min:literal to $max:literal, $($path:ident).+) => {
        field!($name, Bounds::Between($min, $max), $($path).+)
    };
}

/// All of them.
pub const FIELDS: [Field; 22] = [
    field!("joint_limit_deg", 1.0 to 90.0, joint_limit_deg),
    Field {
        name: "geometry.leg_scale",
        get: |robot| robot.geometry.leg_scale.value(),
        set: |robot, value| robot.geometry.leg_scale = LegScale::clamped(value),
        bounds: Bounds::Between(LEG_SCALE_RANGE.0, LEG_SCALE_RANGE.1),
    },
    field!("geometry.shin_below_horizontal_deg", 0.0 to 90.0, geometry.shin_below_horizontal_deg),
    field!("geometry.foot_radius_m", Bounds::Foot, geometry.foot_radius_m),
    field!("mass.torso_kg", 0.01 to 20.0, mass.torso_kg),
    field!("servo.stiffness_n_m_rad", 0.0 to 200.0, servo.stiffness_n_m_rad),
    field!("servo.damping_n_m_s_rad", 0.0 to 20.0, servo.damping_n_m_s_rad),
    field!("servo.backdriven_damping_n_m_s_rad", 0.0 to 50.0, servo.backdriven_damping_n_m_s_rad),
    field!("servo.no_load_speed_rad_s", 0.1 to 50.0, servo.no_load_speed_rad_s),
    field!("servo.torque_limit_n_m", 0.0 to 50.0, servo.torque_limit_n_m),
    field!("servo.friction_n_m", 0.0 to 5.0, servo.friction_n_m),
    field!("servo.dead_band_deg", 0.0 to 10.0, servo.dead_band_deg),
    field!("servo.end_stop_deg", 20.0 to 180.0, servo.end_stop_deg),
    field!("servo.delay_s", 0.0 to 0.2, servo.delay_s),
    field!("servo.neutral_pulse_us", 500.0 to 2500.0, servo.neutral_pulse_us),
    field!("servo.pulse_us_per_deg", 1.0 to 30.0, servo.pulse_us_per_deg),
    field!("ground.friction", 0.0 to 2.0, ground.friction),
    field!("power.electronics_w", 0.0 to 100.0, power.electronics_w),
    field!("power.efficiency", 0.05 to 1.0, power.efficiency),
    field!("power.heat_w_per_n2_m2", 0.0 to 1000.0, power.heat_w_per_n2_m2),
    field!("supply.nominal_v", 1.0 to 26.0, supply.nominal_v),
    field!("supply.resistance_ohm", 0.0 to 5.0, supply.resistance_ohm),
];

impl Field {
    /// The field of that path, if it is one with bounds.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        FIELDS.into_iter().find(|field| field.name == name)
    }

    /// Least and most where they are the same for every robot.
    pub(super) fn fixed_bounds(&self) -> Option<(f64, f64)> {
        match self.bounds {
            Bounds::Between(min, max) => Some((min, max)),
            Bounds::Foot => None,
        }
    }

    /// Least and most that this robot may have.
    #[must_use]
    pub fn bounds(&self, robot: &Robot) -> (f64, f64) {
        match self.bounds {
            Bounds::Between(min, max) => (min, max),
            Bounds::Foot => {
                let scale = robot.geometry.leg_scale.value();
                (0.001, 0.004 + limbs::shortest_drawn_shin_m(&robot.drawn) * scale / 4.0)
            }
        }
    }
}
