//! Where the energy of each method goes, in the simulated robot.
//!
//! Holds the share of each cause in the cost of transport, for every method at
//! the amplification at which it is cheapest: one walk on the fitted robot from
//! an exact start, scaled to the mean over the trials. Does not depend on where
//! the trials were walked.

use super::materials::Materials;
use super::method::Method;
use super::summary::Best;
use crate::energy::STANDARD_GRAVITY_M_S2;
use crate::robot::LegScale;
use crate::search::optimise::report::power_balance_of;
use crate::sim::open_loop::Playback;
use protocol::Amplitude;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// A cost of transport and its parts, all dimensionless.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct EnergyBalance {
    /// The method whose gait walked.
    pub method: Method,
    /// Shins, in units of 23 cm.
    pub leg: LegScale,
    /// The amplification at which the method is cheapest.
    pub amplification: f64,
    /// Controller, driver and idle servos; the faster the gait, the smaller their share.
    pub electronics: f64,
    /// Friction of sliding soles.
    pub slipping: f64,
    /// Braking: work that the legs do on the servos, and legs that push against each other.
    pub braking: f64,
    /// Impact of the feet on the ground.
    pub landing: f64,
    /// Losses of the drives, and the residual of the physics step.
    pub rest: f64,
}

impl EnergyBalance {
    /// Each part with its name, in the order of the table.
    #[must_use]
    pub const fn parts(&self) -> [(&'static str, f64); 5] {
        [
            ("electronics", self.electronics),
            ("slipping soles", self.slipping),
            ("braking", self.braking),
            ("landing feet", self.landing),
            ("rest", self.rest),
        ]
    }

    /// The cost of transport: the sum of the parts.
    #[must_use]
    pub fn total(&self) -> f64 {
        self.parts().iter().map(|(_, part)| part).sum()
    }
}

/// The energy balance of every method that walked, in the order of `best`.
#[must_use]
pub fn of(legs: &[Materials], best: &[Best]) -> Vec<EnergyBalance> {
    best.par_iter().filter_map(|best| balance(legs, best)).collect()
}

fn balance(legs: &[Materials], best: &Best) -> Option<EnergyBalance> {
    let Best { method, leg, .. } = *best;
    let amplification = best.cost_amplification?;
    let materials = legs.iter().find(|materials| materials.robot.geometry.leg_scale == leg)?;
    let material = materials.gaits.iter().find(|material| material.note.method == method)?;
    let amplitude = Amplitude::from_f64(amplification)?;
    let robot = &materials.robot;
    let playback = Playback::new(&material.playable, amplitude, robot);
    let power = power_balance_of(robot, |time_s| playback.setpoints_rad(time_s))?;
    // Cost of transport by power: one number for all parts, from the trials' own mean.
    let cost = best.cost_of_transport?.mean;
    let speed_m_s = power.total_w / (cost * robot.mass_kg() * STANDARD_GRAVITY_M_S2);
    let part = |watts: f64| watts / (robot.mass_kg() * STANDARD_GRAVITY_M_S2 * speed_m_s);
    Some(EnergyBalance {
        method,
        leg,
        amplification,
        electronics: part(power.electronics_w),
        slipping: part(power.slipping_w),
        braking: part(power.braking_w),
        landing: part(power.landing_w),
        rest: part(power.drive_w + power.rest_w),
    })
}

/// Differences between two methods, part by part, as first minus second; the largest in size first.
#[must_use]
pub fn differences(first: &EnergyBalance, second: &EnergyBalance) -> Vec<(&'static str, f64)> {
    let more = first.parts().into_iter().zip(second.parts()).map(|((name, a), (_, b))| (name, a - b));
    let mut more: Vec<(&'static str, f64)> = more.collect();
    more.sort_by(|a, b| b.1.abs().total_cmp(&a.1.abs()));
    more
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiment::materials;
    use crate::experiment::summary::Mean;
    use crate::robot::{LegScale, Robot};

    #[test]
    fn the_parts_of_a_gait_that_walks_add_up_to_its_cost() {
        let folder = tempfile::tempdir().unwrap();
        let robot = Robot::ant(LegScale::LONG).unwrap();
        materials::unpack(&robot, folder.path()).unwrap();
        let legs = [materials::read(folder.path(), &robot, &[Method::Psto]).unwrap()];
        let best = Best {
            method: Method::Psto,
            leg: LegScale::LONG,
            cost_of_transport: Some(Mean { mean: 0.4, ci95: None }),
            cost_amplification: Some(1.4),
            speed_m_s: None,
            speed_amplification: None,
            cost_n: 3,
            speed_n: 0,
            paper_cost_of_transport: None,
            paper_speed_m_s: None,
        };

        let balance = of(&legs, &[best]);

        assert!((balance[0].total() - 0.4).abs() < 1e-9, "{balance:?}");
        assert!(balance[0].electronics > 0.02 && balance[0].slipping > 0.02, "{balance:?}");
    }

    #[test]
    fn differences_are_told_with_their_sign_the_largest_first() {
        let cheap = EnergyBalance {
            method: Method::Sinusoid,
            leg: LegScale::LONG,
            amplification: 1.0,
            electronics: 0.1,
            slipping: 0.1,
            braking: 0.1,
            landing: 0.05,
            rest: 0.0,
        };
        let dear = EnergyBalance { electronics: 0.05, slipping: 0.3, braking: 0.15, ..cheap };

        let [(first, most), .., (last, none)] = differences(&dear, &cheap)[..] else { panic!() };
        assert_eq!((first, last, none), ("slipping soles", "rest", 0.0));
        assert!((most - 0.2).abs() < 1e-12);
        let electronics = differences(&dear, &cheap).into_iter().find(|(part, _)| *part == "electronics");
        assert!((electronics.unwrap().1 + 0.05).abs() < 1e-12);
    }
}
