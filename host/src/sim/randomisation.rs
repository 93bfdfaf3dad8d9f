//! Domain randomisation: a robot for each seed, near the described one.
//!
//! Holds which numbers of a description vary and by how much; a sampled robot passes
//! `Robot::check`. Does not depend on worlds or episodes. Without any spread nothing
//! is sampled, and the robot is the described one to the bit.
//!
//! The twin is a fit to one robot on one floor. A real robot differs by the spread
//! of that fit, by its battery, its load and its floor. A policy that was trained on
//! many such robots does not depend on the exact numbers of one.

use crate::robot::{Field, Robot};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

/// The random stream of an episode's seed that robots are sampled from. Starts use
/// stream 0, so that a start does not depend on the robot.
const STREAM: u64 = 1;

/// Ranges of the differences from the described robot; all uniform.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Randomisation {
    /// Every parameter with a standard deviation in the description's `[twin.spread]`:
    /// within so many standard deviations either way, sampled independently.
    pub twin_spread: f64,
    /// Ground friction, either way, as a share of itself.
    pub friction_share: f64,
    /// Mass, either way, as a share of the whole robot's. The torso carries
    /// it: what differs from day to day is battery, cables and load.
    pub mass_share: f64,
    /// Maximum of what is added to the servos' delay, from 0.
    pub latency_s: f64,
    /// Supply voltage, either way, as a share of itself. A motor's no-load
    /// speed and stall torque go with it, and so does the torque for an angle's
    /// error, which sets the share of time that the voltage is on. Damping, the
    /// slope of the torque-speed line, does not depend on it.
    pub supply_share: f64,
}

impl Randomisation {
    /// Every robot is the described one.
    pub const NONE: Self =
        Self { twin_spread: 0.0, friction_share: 0.0, mass_share: 0.0, latency_s: 0.0, supply_share: 0.0 };

    /// Whether this needs the spread of a fit, and the robot has none.
    #[must_use]
    pub fn lacks_spread(&self, robot: &Robot) -> bool {
        self.twin_spread > 0.0 && fitted(robot).next().is_none()
    }
}

/// Samples robots near the described one.
#[derive(Debug, Clone)]
pub struct Robots {
    described: Robot,
    mass_kg: f64,
    randomisation: Randomisation,
    /// Fitted fields and their standard deviations.
    fitted: Vec<(Field, f64)>,
}

/// Fitted fields with their standard deviations. `twin.sample_s`, how long the
/// measured robot held a table's row, has no field: it plays no part under a policy.
fn fitted(robot: &Robot) -> impl Iterator<Item = (Field, f64)> {
    let spread = robot.twin.iter().flat_map(|twin| &twin.spread);
    spread.filter_map(|(name, &deviation)| Some((Field::named(name)?, deviation)))
}

impl Robots {
    /// Robots near this one; `None` where all would be the same.
    #[must_use]
    pub fn like(robot: &Robot, randomisation: Randomisation) -> Option<Self> {
        (randomisation != Randomisation::NONE).then(|| Self {
            described: robot.clone(),
            mass_kg: robot.mass_kg(),
            randomisation,
            fitted: fitted(robot).collect(),
        })
    }

    /// Samples a robot; the same seed gives the same robot. Each number stays within
    /// the bounds of a description.
    #[must_use]
    pub fn sampled(&self, seed: u64) -> Robot {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        random.set_stream(STREAM);
        // Sampled even where it is multiplied by zero, so that switching one
        // difference on does not change another.
        let mut either_way = || random.random_range(-1.0..=1.0);
        let Randomisation { twin_spread, friction_share, mass_share, latency_s, supply_share } =
            self.randomisation;
        let friction = 1.0 + friction_share * either_way();
        let load_kg = self.mass_kg * mass_share * either_way();
        let latency_s = latency_s * f64::abs(either_way());
        let voltage = 1.0 + supply_share * either_way();

        let mut robot = self.described.clone();
        // Last, so that a fit with one more parameter does not change the others.
        for (field, deviation) in &self.fitted {
            let value = (field.get)(&robot);
            (field.set)(&mut robot, value + twin_spread * deviation * either_way());
        }
        robot.ground.friction *= friction;
        robot.mass.torso_kg += load_kg;
        robot.servo.delay_s += latency_s;
        robot.supply.nominal_v *= voltage;
        robot.servo.no_load_speed_rad_s *= voltage;
        robot.servo.torque_limit_n_m *= voltage;
        robot.servo.stiffness_n_m_rad *= voltage;
        self.within_bounds(robot)
    }

    fn within_bounds(&self, mut robot: Robot) -> Robot {
        for field in crate::robot::FIELDS {
            let (min, max) = field.bounds(&robot);
            let value = (field.get)(&robot);
            // Not `clamp`, which panics where a bound is NaN.
            (field.set)(&mut robot, value.max(min).min(max));
        }
        // A range of pulses has to hold the neutral one, wherever that was sampled.
        let neutral_us = robot.servo.neutral_pulse_us;
        robot.servo.pulse_range_us = robot
            .servo
            .pulse_range_us
            .map(|[shortest_us, longest_us]| [shortest_us.min(neutral_us), longest_us.max(neutral_us)]);
        // The other check that is not a bound of a single number: whether the knees
        // can be turned to that slope.
        if robot.check().is_err() {
            robot.geometry.shin_below_horizontal_deg = self.described.geometry.shin_below_horizontal_deg;
        }
        robot
    }
}

#[cfg(test)]
mod tests;
