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

    /// Distance of its farthest point from a point of its part.
    pub fn farthest_m(&self, from: &Point3<f64>) -> f64 {
        let from = self.pose.inverse() * from;
        match &self.shape {
            Shape::Ball { radius_m } => from.coords.norm() + radius_m,
            Shape::Capsule { half_m, radius_m } => {
                Vector3::new(from.x, from.y, from.z.abs() + half_m).norm() + radius_m
            }
            Shape::Cylinder { half_m, radius_m } => {
                (from.x.hypot(from.y) + radius_m).hypot(from.z.abs() + half_m)
            }
            Shape::Cuboid { half_m } => (from.coords.abs() + half_m).norm(),
        }
    }

    /// Whether it is nearer to the ground than `contact_m` anywhere but within
    /// `radius_m` of `foot_m`, where its part stands at `part`.
    pub fn touches_beyond(
        &self,
        part: &Isometry3<f64>,
        contact_m: f64,
        foot_m: &Point3<f64>,
        radius_m: f64,
    ) -> bool {
        if self.lowest_m(part) >= contact_m {
            return false;
        }
        // The lowest point is on one of the edges, up to rounding.
        let (pose, contact_m) = (part * self.pose, contact_m + 1e-9);
        self.low_edges_m(&pose).iter().any(|[one, other]| {
            let (low, high) = if one.z <= other.z { (one, other) } else { (other, one) };
            if low.z >= contact_m {
                return false;
            }
            // The part of the edge that is in contact ends there.
            let rise_m = high.z - low.z;
            let share = if rise_m > contact_m - low.z { (contact_m - low.z) / rise_m } else { 1.0 };
            let end = low + (high - low) * share;
            (low - foot_m).norm() > radius_m || (end - foot_m).norm() > radius_m
        })
    }

    /// Lines along its surface that hold its lowest points, whatever way it is turned.
    fn low_edges_m(&self, pose: &Isometry3<f64>) -> Vec<[Point3<f64>; 2]> {
        let end = |x: f64, y: f64, z: f64| pose * Point3::new(x, y, z);
        match &self.shape {
            Shape::Ball { radius_m } => {
                let low = Point3::from(pose.translation.vector) - Vector3::z() * *radius_m;
                vec![[low, low]]
            }
            Shape::Capsule { half_m, radius_m } => {
                let low = |z: f64| end(0.0, 0.0, z) - Vector3::z() * *radius_m;
                vec![[low(-half_m), low(*half_m)]]
            }
            Shape::Cylinder { half_m, radius_m } => {
                let down = pose.rotation.inverse() * -Vector3::z();
                let out = Vector3::new(down.x, down.y, 0.0).try_normalize(1e-9).unwrap_or_else(Vector3::x);
                let rim = |side: f64, z: f64| end(side * radius_m * out.x, side * radius_m * out.y, z);
                let along = [rim(1.0, -half_m), rim(1.0, *half_m)];
                // Across both flat ends, for one that stands upright.
                vec![along, [rim(1.0, -half_m), rim(-1.0, -half_m)], [rim(1.0, *half_m), rim(-1.0, *half_m)]]
            }
            Shape::Cuboid { half_m } => {
                let corner = |k: usize| {
                    let side = |axis: usize| if k >> axis & 1 == 0 { -half_m[axis] } else { half_m[axis] };
                    end(side(0), side(1), side(2))
                };
                let pairs = (0..8).flat_map(|k| [1, 2, 4].map(|bit| (k, k | bit))).filter(|(k, l)| k != l);
                pairs.map(|(k, l)| [corner(k), corner(l)]).collect()
            }
        }
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
