//! Varied robots: what a gait must tolerate.
//!
//! Holds the distributions. Each robot is within the uncertainty of the fit, with
//! battery, load and floor as [`Randomisation`] samples them, with servos of
//! another make, mounted a little off neutral, and started a little askew. Does
//! not depend on gaits.

use crate::robot::{Field, Robot};
use crate::sim::{Perturbation, Randomisation, Robots, Start};
use protocol::JOINT_COUNT;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::Serialize;

/// Of a draw's seed: robots and starts have the first ones.
const STREAM: u64 = 2;

/// How far robots differ from the fitted one: uniform, and symmetric unless said otherwise.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Tolerances {
    /// Fit, floor, load, latency, supply.
    pub robot: Randomisation,
    /// Stiffness of all servos, as a share of itself.
    pub stiffness_share: f64,
    /// Damping of all servos, as a share of itself.
    pub damping_share: f64,
    /// Mounting error of each servo's horn.
    pub neutral_deg: f64,
}

impl Default for Tolerances {
    /// # Source
    /// Ours. Friction of a foot differs between floors by a quarter and more, servos
    /// of one type by 10 to 20 %; a horn is trimmed by eye, to three counts of a
    /// pulse; a servo reacts to a pulse within two frames.
    fn default() -> Self {
        Self {
            robot: Randomisation {
                twin_spread: 2.0,
                friction_share: 0.3,
                mass_share: 0.1,
                latency_s: 0.033,
                supply_share: 0.15,
            },
            stiffness_share: 0.2,
            damping_share: 0.2,
            neutral_deg: 1.8,
        }
    }
}

/// A sampled robot and its start.
#[derive(Debug, Clone, PartialEq)]
pub struct Draw {
    /// The robot.
    pub robot: Robot,
    /// Added to every setpoint.
    pub neutral_rad: [f64; JOINT_COUNT],
    /// Where and how it starts.
    pub start: Start,
}

impl Draw {
    /// The fitted robot itself, started exactly.
    #[must_use]
    pub fn nominal(robot: &Robot) -> Self {
        Self { robot: robot.clone(), neutral_rad: [0.0; JOINT_COUNT], start: Start::default() }
    }
}

impl Tolerances {
    /// The robot of that number; the same number gives the same robot.
    #[must_use]
    pub fn draw(&self, robot: &Robot, seed: u64, number: u64) -> Draw {
        // One number out of both, unlike that of any neighbour of either.
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        random.set_stream(number);
        let seed: u64 = random.random();
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        random.set_stream(STREAM);
        let mut either_way = |range: f64| range * random.random_range(-1.0..=1.0);

        let mut drawn =
            Robots::like(robot, self.robot).map_or_else(|| robot.clone(), |robots| robots.sampled(seed));
        drawn.servo.stiffness_n_m_rad *= 1.0 + either_way(self.stiffness_share);
        let damping = 1.0 + either_way(self.damping_share);
        drawn.servo.damping_n_m_s_rad *= damping;
        drawn.servo.backdriven_damping_n_m_s_rad *= damping;
        for name in
            ["servo.stiffness_n_m_rad", "servo.damping_n_m_s_rad", "servo.backdriven_damping_n_m_s_rad"]
        {
            keep_bounds(&mut drawn, name);
        }
        Draw {
            robot: drawn,
            neutral_rad: core::array::from_fn(|_| either_way(self.neutral_deg).to_radians()),
            // The floor's friction was drawn with the robot.
            start: Start { friction_share: 0.0, ..Start::sampled(&Perturbation::default(), seed) },
        }
    }
}

/// Clamps a number to what a description may say. The robot stays a sampled one: the fitted robot
/// in its place would be easier to walk with.
fn keep_bounds(robot: &mut Robot, name: &str) {
    if let Some(field) = Field::named(name) {
        let (min, max) = field.bounds(robot);
        let value = (field.get)(robot);
        (field.set)(robot, value.max(min).min(max));
    }
}

/// Whether the fit has an uncertainty; without one, robots differ by the tolerances alone.
#[must_use]
pub fn has_spread(robot: &Robot) -> bool {
    robot.twin.as_ref().is_some_and(|twin| {
        twin.spread.iter().any(|(name, &deviation)| deviation > 0.0 && Field::named(name).is_some())
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::LegScale;

    /// The committed gaits stand on draws that needed no bounds.
    #[test]
    fn draws_of_the_ant_lie_within_what_a_description_may_say() {
        for leg in [LegScale::LONG, LegScale::SHORT] {
            let robot = Robot::ant(leg).expect("a leg scale");
            for number in 0..300 {
                let drawn = Tolerances::default().draw(&robot, 0, number).robot;
                let (min, max) = Field::named("servo.stiffness_n_m_rad").expect("a field").bounds(&drawn);

                assert!(drawn.check().is_ok());
                assert!(min < drawn.servo.stiffness_n_m_rad && drawn.servo.stiffness_n_m_rad < max);
            }
        }
    }

    #[test]
    fn a_robot_at_the_end_of_what_may_be_said_is_drawn_all_the_same() {
        let mut robot = Robot::ant(LegScale::LONG).expect("the Ant");
        for name in
            ["servo.stiffness_n_m_rad", "servo.damping_n_m_s_rad", "servo.backdriven_damping_n_m_s_rad"]
        {
            let field = Field::named(name).expect("a field");
            let (_, max) = field.bounds(&robot);
            (field.set)(&mut robot, max);
        }
        assert!(robot.check().is_ok());

        for number in 0..50 {
            let drawn = Tolerances::default().draw(&robot, 3, number).robot;

            assert!(drawn.check().is_ok(), "{number}: {:?}", drawn.check());
            assert_ne!(drawn.ground.friction, robot.ground.friction, "{number} is the robot itself");
        }
    }

    #[test]
    fn a_robot_that_was_never_fitted_has_no_spread() {
        let robot = Robot::ant(LegScale::LONG).expect("the Ant");

        assert!(has_spread(&robot));
        assert!(!has_spread(&Robot { twin: None, ..robot }));
    }

    #[test]
    fn draws_differ_by_number_and_seed_and_are_the_same_again() {
        let robot = Robot::ant(LegScale::LONG).expect("the Ant");
        let tolerances = Tolerances::default();
        let draws: Vec<Draw> = (0..20).map(|number| tolerances.draw(&robot, 3, number)).collect();

        assert_eq!(draws[7], tolerances.draw(&robot, 3, 7));
        assert_ne!(draws[7], draws[8]);
        assert_ne!(draws[7], tolerances.draw(&robot, 4, 7));
        for draw in &draws {
            let friction = draw.robot.ground.friction / robot.ground.friction;
            assert!((0.6..1.4).contains(&friction), "{friction}");
            assert!(draw.neutral_rad.iter().all(|angle| angle.to_degrees().abs() <= 1.8));
            assert!((0.0..=0.033).contains(&draw.robot.servo.delay_s));
        }
        let stiffer = |draw: &&Draw| draw.robot.servo.stiffness_n_m_rad > 1.1 * robot.servo.stiffness_n_m_rad;
        assert!(draws.iter().find(stiffer).is_some());
    }
}
