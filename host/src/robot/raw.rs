//! A file's bodies and joints, before the robot's parts are found among them.
//!
//! Holds what MJCF and URDF have in common. Does not depend on either format.

use super::inertia::Inertia;
use super::solid::Solid;
use super::warning::RobotWarning;
use nalgebra::Isometry3;

/// A file's bodies and joints, in either format.
#[derive(Debug, Default)]
pub struct Raw {
    /// All of them, the world's own body excluded.
    pub bodies: Vec<RawBody>,
    pub joints: Vec<RawJoint>,
    /// Whether the file is a URDF: advice is in the file's own format.
    pub is_urdf: bool,
    /// What is probably not meant as it is written.
    pub warnings: Vec<RobotWarning>,
}

#[derive(Debug)]
pub struct RawBody {
    /// A made-up one where the file has none.
    pub name: String,
    /// Zero where the file says nothing.
    pub inertia: Inertia,
    pub solids: Vec<Solid>,
    /// Whether it moves freely, without a joint.
    pub free: bool,
}

#[derive(Debug)]
pub struct RawJoint {
    /// A made-up one where the file has none.
    pub name: String,
    /// Index in [`Raw::bodies`].
    pub parent: usize,
    /// Index in [`Raw::bodies`].
    pub child: usize,
    pub hinge: Hinge,
    pub kind: Kind,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    Fixed,
    Hinge,
    /// Neither; the kind in words, for an error.
    Other(&'static str),
}

/// A hinge turns about the x axis of its frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Hinge {
    /// Its frame in the part that carries it.
    pub in_parent: Isometry3<f64>,
    /// The same frame in the part that it carries, as drawn.
    pub in_child: Isometry3<f64>,
    /// How far it turns from where it is drawn.
    pub range_rad: Option<[f64; 2]>,
}

impl Hinge {
    /// Where the carried part is, turned so far from where it is drawn.
    pub fn at(&self, angle_rad: f64) -> Isometry3<f64> {
        let turn = nalgebra::UnitQuaternion::from_axis_angle(&nalgebra::Vector3::x_axis(), angle_rad);
        self.in_parent * turn * self.in_child.inverse()
    }
}
