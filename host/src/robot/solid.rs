//! The shapes that a robot touches the ground with.
//!
//! Holds their lowest point and how they stretch. Four kinds: both file
//! formats have them, and a leg needs no others.

use super::inertia::Stretch;
use nalgebra::{Isometry3, Point3, Vector3};

/// A solid, in the frame of its part.
#[derive(Debug, Clone, PartialEq)]
pub struct Solid {
    /// Where its middle is and how it is turned.
    pub pose: Isometry3<f64>,
    /// What it is.
    pub shape: Shape,
}

/// A solid about its own middle.
#[derive(Debug, Clone, PartialEq)]
pub enum Shape {
    /// A ball.
    Ball {
        /// Of the ball.
        radius_m: f64,
    },
    /// A rod along z with round ends.
    Capsule {
        /// From the middle to the middle of an end.
        half_m: f64,
        /// Of rod and ends.
        radius_m: f64,
    },
    /// A rod along z with flat ends.
    Cylinder {
        /// From the middle to an end.
        half_m: f64,
        /// Of the rod.
        radius_m: f64,
    },
    /// A box.
    Cuboid {
        /// From the middle to each side.
        half_m: Vector3<f64>,
    },
}

impl Solid {
    /// Height of its lowest point, where its part stands at `part`.
    pub fn lowest_m(&self, part: &Isometry3<f64>) -> f64 {
        let pose = part * self.pose;
        // The share of each of its axes that points up.
        let up = pose.rotation.inverse() * Vector3::z();
        let reach_m = match &self.shape {
            Shape::Ball { radius_m } => *radius_m,
            Shape::Capsule { half_m, radius_m } => half_m * up.z.abs() + radius_m,
            Shape::Cylinder { half_m, radius_m } => half_m * up.z.abs() + radius_m * up.x.hypot(up.y),
            Shape::Cuboid { half_m } => half_m.component_mul(&up.abs()).sum(),
        };
        pose.translation.z - reach_m
    }

    /// The same solid on a part in another frame.
    pub fn moved(&self, to: &Isometry3<f64>) -> Self {
        Self { pose: to * self.pose, shape: self.shape.clone() }
    }

    /// Moved by a stretch of its part, as it is.
    pub fn shifted(&self, stretch: &Stretch) -> Self {
        let mut solid = self.clone();
        solid.pose.translation = stretch.point(&Point3::from(self.pose.translation.vector)).into();
        solid
    }

    /// Moved and drawn out by a stretch; round remains round.
    pub fn stretched(&self, stretch: &Stretch) -> Self {
        let mut solid = self.shifted(stretch);
        // How much longer each of its own axes becomes.
        let longer = |axis: Vector3<f64>| (stretch.matrix() * (self.pose.rotation * axis)).norm();
        match &mut solid.shape {
            Shape::Ball { .. } => {}
            Shape::Capsule { half_m, .. } | Shape::Cylinder { half_m, .. } => *half_m *= longer(Vector3::z()),
            Shape::Cuboid { half_m } => {
                half_m.component_mul_assign(&Vector3::new(
                    longer(Vector3::x()),
                    longer(Vector3::y()),
                    longer(Vector3::z()),
                ));
            }
        }
        solid
    }

    /// Its middle and radius, if it is a ball.
    pub fn ball(&self) -> Option<(Point3<f64>, f64)> {
        match self.shape {
            Shape::Ball { radius_m } => Some((self.pose.translation.vector.into(), radius_m)),
            _ => None,
        }
    }
}
