//! What the ground takes from the robot, computed from the engine's contact forces.
//!
//! Owns the work under the soles. Not part of a step: it is looked at by those
//! who ask where the energy goes.

use super::World;
use crate::sim::body::real;
use rapier3d::prelude::*;

/// Speeds of the lowest points of the feet, legs 1 to 4.
pub type Soles = [[f64; 3]; 4];

/// What the ground took in one step, and how hard it pushed.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Taken {
    /// By friction under soles that slide.
    pub slid_j: f64,
    /// By stopping feet that land.
    pub landed_j: f64,
    /// Upwards, over all feet.
    pub lifted_n_s: f64,
}

impl World {
    /// Velocity of the lowest point of each foot.
    #[must_use]
    pub fn sole_velocities_m_s(&self) -> Soles {
        let radius_m = real(self.limbs.foot_radius_m);
        core::array::from_fn(|leg| {
            let shin = &self.body.physics.bodies[self.body.shins[leg]];
            let sole = shin.position().transform_point(self.body.feet[leg]) - Vector::Z * radius_m;
            shin.velocity_at_point(sole).to_array().map(f64::from)
        })
    }

    /// The ground's part in the last step, given the soles' speeds before and after it.
    #[must_use]
    pub fn taken_by_ground(&self, before: &Soles, after: &Soles) -> Taken {
        let mut taken = Taken::default();
        for (foot, impulse_n_s) in self.ground_impulses_n_s().into_iter().enumerate() {
            // An impulse's work is that with the mean of the speeds before and after it.
            let mean = |axis: usize| 0.5 * (before[foot][axis] + after[foot][axis]);
            let [x, y, z] = impulse_n_s.to_array().map(f64::from);
            taken.slid_j -= x * mean(0) + y * mean(1);
            taken.landed_j -= z * mean(2);
            taken.lifted_n_s += z;
        }
        taken
    }

    /// What the ground did to each foot: its push up and its friction.
    fn ground_impulses_n_s(&self) -> [Vector; 4] {
        let physics = &self.body.physics;
        let mut impulses = [Vector::ZERO; 4];
        for pair in physics.contact_pairs() {
            for (handle, sign) in [(pair.collider1, 1.0), (pair.collider2, -1.0)] {
                let parent = physics.colliders.get(handle).and_then(Collider::parent);
                let Some(foot) = self.body.shins.iter().position(|shin| Some(*shin) == parent) else {
                    continue;
                };
                for manifold in pair.solver_manifolds() {
                    let pushed =
                        manifold.data.normal * manifold.points.iter().map(|p| p.data.impulse).sum::<Real>();
                    let rubbed: Vector = manifold.points.iter().map(|p| p.data.warmstart_tangent_world).sum();
                    impulses[foot] += (rubbed - pushed) * sign;
                }
            }
        }
        impulses
    }
}
