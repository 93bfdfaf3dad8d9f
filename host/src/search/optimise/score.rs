//! The score of a gait, over varied robots.
//!
//! Holds the trial, the penalties, and the mean over robots. The cost of
//! transport counts net distance, or what of it goes forward, so a gait that goes in
//! circles already pays for it there. Does not depend on how gaits are searched.

use super::space::Motion;
use super::tolerances::Draw;
use crate::robot::Robot;
use crate::sim::open_loop::{self, Trial, Walk};

/// Within this much either way in 12 s, a gait is straight.
const STRAIGHT_DEG: f64 = 8.0;
/// Within this, level.
const LEVEL_RAD: f64 = 0.15;
/// Penalties, in units of cost of transport: for each degree beyond straight,
const TURN_PRICE: f64 = 0.01;
/// each radian beyond level,
const TILT_PRICE: f64 = 2.0;
/// more than the feet on the ground, for all of the time,
const DRAG_PRICE: f64 = 1.0;
/// servos at their torque limit, for all of the time,
const STRAIN_PRICE: f64 = 1.0;
/// a fall, and a speed of 0 where some is asked for.
const FALL_PRICE: f64 = 3.0;
const SLOW_PRICE: f64 = 3.0;
/// Cap of the cost of transport in a score: that of a standing robot is infinite.
const MOST_COST: f64 = 5.0;
/// Servos may be at the end of their torque for this share of the time.
pub const STRAINED_SHARE: f64 = 0.02;
/// Weight of the worst of the robots beside their mean.
const WORST_WEIGHT: f64 = 0.3;

/// The walk of a simulation that diverged.
const LOST: Walk = Walk {
    distance_m: 0.0,
    displacement_m: [0.0; 2],
    speed_m_s: 0.0,
    fastest_m_s: 0.0,
    energy_j: 0.0,
    mean_power_w: 0.0,
    mean_mechanical_power_w: 0.0,
    mean_holding_power_w: 0.0,
    cost_of_transport: f64::INFINITY,
    turned_rad: 0.0,
    max_tilt_rad: 0.0,
    dragged_share: 0.0,
    strained_share: 0.0,
    supply_limited_share: 0.0,
    fell: true,
};

/// What a gait is optimised for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Aim {
    /// The lowest cost of transport at this speed or faster.
    Cost {
        /// Minimum speed.
        at_least_m_s: f64,
    },
    /// The highest speed.
    Speed,
}

/// What of a walk's displacement counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Counted {
    /// All of it, in any direction.
    Distance,
    /// Its part along +x; a gait that goes backwards counts as one that stands.
    Forward,
}

/// How a gait is tried.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Test {
    /// What is optimised.
    pub aim: Aim,
    /// Which displacement the speed and the cost of transport are of.
    pub counted: Counted,
    /// The walk that is measured, after an entry.
    pub duration_s: f64,
}

impl Test {
    /// Plays a motion on a sampled robot. A simulation that diverges counts as a fall.
    #[must_use]
    pub fn walk(&self, draw: &Draw, motion: &Motion, amplitude: f64) -> Walk {
        let trial = Trial { entry_s: 1.0, duration_s: self.duration_s, start: draw.start };
        let walk = open_loop::play_sound(&draw.robot, &trial, |time_s| {
            let mut angles_rad = motion.angles_rad(time_s, amplitude);
            angles_rad.iter_mut().zip(draw.neutral_rad).for_each(|(angle, neutral)| *angle += neutral);
            angles_rad
        });
        walk.unwrap_or(LOST)
    }

    /// Score of a motion over some robots: lower is better, and below 1 it walks.
    #[must_use]
    pub fn score(&self, draws: &[Draw], motion: &Motion) -> f64 {
        self.score_of(draws.iter().map(|draw| self.walk(draw, motion, 1.0)))
    }

    /// The same for walks that were played before: the aim has no effect on a walk.
    pub fn score_of(&self, walks: impl Iterator<Item = Walk>) -> f64 {
        let mut count = 0_usize;
        let (mut sum, mut worst) = (0.0, f64::NEG_INFINITY);
        for walk in walks {
            let price = self.price(&walk);
            count += 1;
            sum += price;
            worst = f64::max(worst, price);
        }
        let mean = sum / count.max(1) as f64;
        mean + WORST_WEIGHT * (worst - mean)
    }

    /// Speed and cost of transport of the displacement that counts.
    fn counted(&self, walk: &Walk) -> (f64, f64) {
        match self.counted {
            Counted::Distance => (walk.speed_m_s, walk.cost_of_transport),
            Counted::Forward => {
                let share = walk.displacement_m[0] / walk.distance_m;
                // False for NaN, of a robot that did not move at all.
                if share > 0.0 {
                    (share * walk.speed_m_s, walk.cost_of_transport / share)
                } else {
                    (0.0, f64::INFINITY)
                }
            }
        }
    }

    fn price(&self, walk: &Walk) -> f64 {
        let (speed_m_s, cost_of_transport) = self.counted(walk);
        let aimed_at = match self.aim {
            Aim::Cost { at_least_m_s } => {
                let missing = (1.0 - speed_m_s / at_least_m_s).max(0.0);
                cost_of_transport.min(MOST_COST) + SLOW_PRICE * missing
            }
            // In the same range as a cost of transport, for the prices' sake.
            Aim::Speed => (0.1 / speed_m_s).min(MOST_COST),
        };
        let turned_deg = walk.turned_rad.to_degrees().abs() * 12.0 / self.duration_s;
        aimed_at
            + TURN_PRICE * (turned_deg - STRAIGHT_DEG).max(0.0)
            + TILT_PRICE * (walk.max_tilt_rad - LEVEL_RAD).max(0.0)
            + DRAG_PRICE * walk.dragged_share
            + STRAIN_PRICE * (walk.strained_share - STRAINED_SHARE).max(0.0)
            + FALL_PRICE * f64::from(u8::from(walk.fell))
    }
}

/// Default of the minimum speed: 0.25 m/s on long legs, less on shorter ones.
#[must_use]
pub fn usual_speed_m_s(robot: &Robot) -> f64 {
    0.125 + 0.125 * robot.geometry.leg_scale.value()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_goes_forward_counts_where_it_is_asked_for() {
        let walk = |x_m: f64, y_m: f64| Walk {
            distance_m: x_m.hypot(y_m),
            displacement_m: [x_m, y_m],
            speed_m_s: x_m.hypot(y_m) / 10.0,
            cost_of_transport: 1.0,
            fell: false,
            ..LOST
        };
        let test = |counted| Test { aim: Aim::Cost { at_least_m_s: 0.3 }, counted, duration_s: 10.0 };
        let score = |counted, walk: Walk| test(counted).score_of([walk].into_iter());

        assert_eq!(score(Counted::Distance, walk(-3.0, 0.0)), 1.0);
        assert_eq!(score(Counted::Forward, walk(3.0, 0.0)), 1.0);
        assert_eq!(score(Counted::Forward, walk(-3.0, 0.0)), MOST_COST + SLOW_PRICE);
        // 3 m forward of 5 m: as fast as asked for, at 5 / 3 of the cost.
        assert!((score(Counted::Forward, walk(3.0, 4.0)) - 5.0 / 3.0).abs() < 1e-9);
    }
}
