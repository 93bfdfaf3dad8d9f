//! Whether a body looks the same turned by half a turn about z.
//!
//! Holds the comparison of legs 1 and 3, and 2 and 4, at some angles of their
//! joints. Does not depend on how bodies are drawn: joints may have frames that
//! differ, as long as the legs move alike.

use super::Robot;
use super::inertia::Inertia;
use super::limbs::{Leg, Limbs, Link};
use core::f64::consts::PI;
use nalgebra::{Isometry3, UnitQuaternion, Vector3};
use protocol::LEG_COUNT;

/// Bodies are drawn by hand, in single precision: within these they are alike.
const ALIKE_M: f64 = 1e-4;
const ALIKE_SHARE: f64 = 1e-3;
const ALIKE_RAD: f64 = 1e-3;
/// Angles from neutral at which legs are compared.
const ANGLES_RAD: [[f64; 2]; 3] = [[0.0, 0.0], [0.4, -0.3], [-0.5, 0.6]];

impl Robot {
    /// Whether half a turn about z carries the body into itself, leg 1 into leg 3
    /// and leg 2 into leg 4. Such a robot walks backwards with the gait of the
    /// opposite legs as well as it walks forward with its own.
    #[must_use]
    pub fn is_symmetric_by_half_turn(&self) -> bool {
        let limbs = Limbs::of(self);
        let half_turn = Isometry3::from_parts(
            nalgebra::Translation3::identity(),
            UnitQuaternion::from_axis_angle(&Vector3::z_axis(), PI),
        );
        let turned = |leg: usize| &limbs.legs[(leg + LEG_COUNT / 2) % LEG_COUNT];
        let identity = Isometry3::identity();
        is_alike(&limbs.torso, &identity, &limbs.torso, &half_turn)
            && (0..LEG_COUNT).all(|leg| are_legs_alike(&limbs.legs[leg], turned(leg), &half_turn))
    }
}

/// Whether `other`, turned, is where `leg` is, at all [`ANGLES_RAD`].
fn are_legs_alike(leg: &Leg, other: &Leg, half_turn: &Isometry3<f64>) -> bool {
    are_ranges_alike(leg.hip.range_rad, other.hip.range_rad)
        && are_ranges_alike(leg.knee.range_rad, other.knee.range_rad)
        && ANGLES_RAD.into_iter().all(|[hip_rad, knee_rad]| {
            let thigh = leg.hip.at(hip_rad);
            let shin = thigh * leg.knee.at(knee_rad);
            let other_thigh = half_turn * other.hip.at(hip_rad);
            let other_shin = other_thigh * other.knee.at(knee_rad);
            let feet_apart_m = (shin * leg.foot_m - other_shin * other.foot_m).norm();
            feet_apart_m < ALIKE_M
                && is_alike(&leg.thigh, &thigh, &other.thigh, &other_thigh)
                && is_alike(&leg.shin, &shin, &other.shin, &other_shin)
        })
}

fn are_ranges_alike(one: Option<[f64; 2]>, other: Option<[f64; 2]>) -> bool {
    match (one, other) {
        (None, None) => true,
        (Some(one), Some(other)) => (0..2).all(|end| (one[end] - other[end]).abs() < ALIKE_RAD),
        _ => false,
    }
}

/// Whether two links at two poses have the same mass at the same place, and touch alike.
fn is_alike(one: &Link, at: &Isometry3<f64>, other: &Link, other_at: &Isometry3<f64>) -> bool {
    let (own, others) = (one.inertia.moved(at), other.inertia.moved(other_at));
    are_inertias_alike(&own, &others)
        && one.solids.len() == other.solids.len()
        && views().all(|view| {
            let lowest_m = |link: &Link, pose: &Isometry3<f64>| {
                link.solids.iter().map(|solid| solid.lowest_m(&(view * pose))).fold(f64::INFINITY, f64::min)
            };
            let (own_m, others_m) = (lowest_m(one, at), lowest_m(other, other_at));
            // Without solids both are infinite.
            own_m == others_m || (own_m - others_m).abs() < ALIKE_M
        })
}

fn are_inertias_alike(one: &Inertia, other: &Inertia) -> bool {
    let mass_kg = one.mass_kg.max(other.mass_kg);
    let size_kg_m2 = one.tensor_kg_m2.norm().max(other.tensor_kg_m2.norm());
    (one.mass_kg - other.mass_kg).abs() <= ALIKE_SHARE * mass_kg
        && (one.centre_m - other.centre_m).norm() < ALIKE_M
        && (one.tensor_kg_m2 - other.tensor_kg_m2).norm() <= ALIKE_SHARE * size_kg_m2
}

/// The body tilted every which way: what is lowest in all of them is its shape.
fn views() -> impl Iterator<Item = Isometry3<f64>> {
    (0..6).flat_map(|roll| (0..6).map(move |pitch| (roll, pitch))).map(|(roll, pitch)| {
        let turn = |steps: i32| f64::from(steps) * PI / 3.0;
        Isometry3::from_parts(
            nalgebra::Translation3::identity(),
            UnitQuaternion::from_euler_angles(turn(roll), turn(pitch), 0.0),
        )
    })
}

#[cfg(test)]
mod tests {
    use crate::robot::{LegScale, Robot};
    use std::path::Path;
    use std::sync::Arc;

    #[test]
    fn the_ant_is_symmetric_on_all_legs_and_the_pony_is_not() {
        let pony = Path::new(env!("CARGO_MANIFEST_DIR")).join("robots/pony");

        for leg in [LegScale::LONG, LegScale::SHORT] {
            assert!(Robot::ant(leg).unwrap().is_symmetric_by_half_turn(), "{leg}");
        }
        assert!(!Robot::load(&pony).unwrap().is_symmetric_by_half_turn());
    }

    #[test]
    fn one_leg_that_differs_a_little_is_no_symmetry() {
        let mut robot = Robot::ant(LegScale::LONG).unwrap();
        let drawn = Arc::make_mut(&mut robot.drawn);
        drawn.legs[2].hip.in_parent.translation.x += 0.001;

        assert!(!robot.is_symmetric_by_half_turn());
    }
}
