//! Energy that the robot loses to the ground, computed from the engine's contact forces.
//!
//! Holds the work under the feet. Does not depend on servos or their power. Not part
//! of a step: only the energy balance of a gait needs it.

use super::World;
use crate::sim::body::real;
use protocol::LEG_COUNT;
use rapier3d::prelude::*;

/// Velocities of the lowest points of the feet, legs 1 to 4, in m/s in the world's frame.
pub type Soles = [[f64; 3]; LEG_COUNT];

/// Energy lost to the ground in one step, and the impulse that carried the robot.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct GroundLosses {
    /// By friction under feet that slide.
    pub slid_j: f64,
    /// By stopping feet that land.
    pub landed_j: f64,
    /// Upward impulse over all feet.
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

    /// Losses of the last step, from the feet's velocities before and after it.
    #[must_use]
    pub fn ground_losses(&self, before: &Soles, after: &Soles) -> GroundLosses {
        let mut losses = GroundLosses::default();
        for (foot, impulse_n_s) in self.ground_impulses_n_s().into_iter().enumerate() {
            // The work of an impulse is its product with the mean of the velocities before and after.
            let mean = |axis: usize| 0.5 * (before[foot][axis] + after[foot][axis]);
            let [x, y, z] = impulse_n_s.to_array().map(f64::from);
            losses.slid_j -= x * mean(0) + y * mean(1);
            losses.landed_j -= z * mean(2);
            losses.lifted_n_s += z;
        }
        losses
    }

    /// The ground's impulse on each foot: normal force and friction.
    fn ground_impulses_n_s(&self) -> [Vector; LEG_COUNT] {
        let physics = &self.body.physics;
        let mut impulses = [Vector::ZERO; LEG_COUNT];
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
