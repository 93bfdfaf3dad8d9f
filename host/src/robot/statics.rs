//! A robot that stands at neutral: where everything is, and what its servos hold.
//!
//! Holds the poses of the level robot with all joints at 0 and the torques
//! that gravity and feet put on its joints. Feet push straight up here: the
//! friction of the ground can take some of a knee's load, but not be relied on.
//! Does not depend on the physics engine.

use super::limbs::{Leg, Limbs};
use nalgebra::{Isometry3, Matrix3, Point3, Vector3};

/// Standard gravity (CGPM 1901).
const GRAVITY_M_S2: f64 = 9.806_65;

/// Feet that carry the robot while the others swing: 1 and 3, 2 and 4.
pub const DIAGONALS: [[usize; 2]; 2] = [[0, 2], [1, 3]];

/// The level robot with all joints at neutral, in its own frame.
#[derive(Debug, Clone)]
pub struct Standing<'l> {
    limbs: &'l Limbs,
    /// Of each leg.
    pub thighs: [Isometry3<f64>; 4],
    /// Of each leg.
    pub shins: [Isometry3<f64>; 4],
    /// A point of each joint's axis and its direction: hips 1 to 4, then knees.
    pub joints: [(Point3<f64>, Vector3<f64>); 8],
    /// Middles of the feet's balls.
    pub feet_m: [Point3<f64>; 4],
    /// Of the whole robot.
    pub centre_m: Point3<f64>,
    /// Of its frame's origin over the ground, resting on whatever is lowest.
    pub height_m: f64,
}

impl<'l> Standing<'l> {
    /// The robot's pose at neutral.
    #[must_use]
    pub fn of(limbs: &'l Limbs) -> Self {
        let thighs = limbs.legs.each_ref().map(|leg| leg.hip.at(0.0));
        let shins: [_; 4] = core::array::from_fn(|leg| thighs[leg] * limbs.legs[leg].knee.at(0.0));
        let joints = core::array::from_fn(|j| {
            let leg = &limbs.legs[j % 4];
            let frame = if j < 4 { leg.hip.in_parent } else { thighs[j - 4] * leg.knee.in_parent };
            (frame.translation.vector.into(), frame.rotation * Vector3::x())
        });
        let mut moment = limbs.torso.inertia.centre_m.coords * limbs.torso.inertia.mass_kg;
        for (leg, (thigh, shin)) in limbs.legs.iter().zip(core::iter::zip(&thighs, &shins)) {
            for (link, pose) in [(&leg.thigh, thigh), (&leg.shin, shin)] {
                moment += (pose * link.inertia.centre_m).coords * link.inertia.mass_kg;
            }
        }
        Self {
            limbs,
            joints,
            feet_m: core::array::from_fn(|leg| shins[leg] * limbs.legs[leg].foot_m),
            centre_m: (moment / limbs.mass_kg()).into(),
            height_m: limbs.standing_height_m(&[0.0; 8]),
            thighs,
            shins,
        }
    }

    /// Height of each foot's lowest point over the ground.
    #[must_use]
    pub fn clearances_m(&self) -> [f64; 4] {
        self.feet_m.map(|foot_m| foot_m.z - self.limbs.foot_radius_m + self.height_m)
    }

    /// How far inside the feet's outline the centre of mass stands, seen from
    /// above; negative outside.
    #[must_use]
    pub fn margin_m(&self) -> f64 {
        let middle = self.feet_m.iter().fold(Vector3::zeros(), |sum, foot| sum + foot.coords) / 4.0;
        let mut corners = self.feet_m.map(|foot| foot.coords.xy());
        let angle = |point: &nalgebra::Vector2<f64>| (point.y - middle.y).atan2(point.x - middle.x);
        corners.sort_by(|a, b| angle(a).total_cmp(&angle(b)));
        (0..4)
            .map(|k| {
                let (from, to) = (corners[k], corners[(k + 1) % 4]);
                let edge = (to - from).try_normalize(1e-9).unwrap_or_else(nalgebra::Vector2::zeros);
                edge.perp(&(self.centre_m.coords.xy() - from))
            })
            .fold(f64::INFINITY, f64::min)
    }

    /// What each foot carries with all four on the ground, in newtons: of the
    /// ways to balance the weight the most even one.
    #[must_use]
    pub fn on_four_n(&self) -> [f64; 4] {
        let weight_n = self.limbs.mass_kg() * GRAVITY_M_S2;
        let rows = self.feet_m.map(|foot| Vector3::new(1.0, foot.x, foot.y));
        let square: Matrix3<f64> = rows.iter().map(|row| row * row.transpose()).sum();
        let load = Vector3::new(1.0, self.centre_m.x, self.centre_m.y) * weight_n;
        match square.try_inverse() {
            Some(inverse) => rows.map(|row| row.dot(&(inverse * load)).max(0.0)),
            // Feet in one line: it does not balance whatever they carry.
            None => [weight_n / 4.0; 4],
        }
    }

    /// What each foot carries with only these two on the ground, in newtons:
    /// by their distances from the centre of mass along the line between them.
    #[must_use]
    pub fn on_two_n(&self, [one, other]: [usize; 2]) -> [f64; 4] {
        let weight_n = self.limbs.mass_kg() * GRAVITY_M_S2;
        let along = self.feet_m[other].coords.xy() - self.feet_m[one].coords.xy();
        let from = self.centre_m.coords.xy() - self.feet_m[one].coords.xy();
        let share = (from.dot(&along) / along.norm_squared().max(1e-12)).clamp(0.0, 1.0);
        let mut forces_n = [0.0; 4];
        forces_n[one] = weight_n * (1.0 - share);
        forces_n[other] = weight_n * share;
        forces_n
    }

    /// Torque about each joint's axis that its servo holds while the feet carry
    /// `forces_n`: hips 1 to 4, then knees.
    #[must_use]
    pub fn holding_n_m(&self, forces_n: &[f64; 4]) -> [f64; 8] {
        core::array::from_fn(|j| {
            let (leg, (pivot_m, axis)) = (j % 4, self.joints[j]);
            let Leg { thigh, shin, .. } = &self.limbs.legs[leg];
            let about = |point_m: Point3<f64>, up_n: f64| {
                axis.dot(&(point_m - pivot_m).cross(&(Vector3::z() * up_n)))
            };
            let weight = |pose: &Isometry3<f64>, inertia: &super::Inertia| {
                about(pose * inertia.centre_m, -inertia.mass_kg * GRAVITY_M_S2)
            };
            let mut torque_n_m =
                about(self.feet_m[leg], forces_n[leg]) + weight(&self.shins[leg], &shin.inertia);
            if j < 4 {
                torque_n_m += weight(&self.thighs[leg], &thigh.inertia);
            }
            -torque_n_m
        })
    }
}
