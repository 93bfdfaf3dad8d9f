//! The body as its file draws it: a torso and four legs of two hinges.
//!
//! Owns what both file formats become, before ([`Raw`]) and after ([`Drawn`])
//! the parts are found. Knows neither format; [`super::mjcf`] and
//! [`super::urdf`] do.

use super::assembly::Assembly;
use super::error::ModelError;
use super::inertia::Inertia;
use super::sections::Model;
use super::solid::Solid;
use super::{mjcf, urdf};
use nalgebra::{Isometry3, Point3};

/// A file's bodies and joints, in either format.
#[derive(Debug, Default)]
pub struct Raw {
    /// All of them, the world's own body excluded.
    pub bodies: Vec<RawBody>,
    /// All between two of them.
    pub joints: Vec<RawJoint>,
}

/// A body as its file has it.
#[derive(Debug)]
pub struct RawBody {
    /// Its name, or what to call it.
    pub name: String,
    /// Zero where the file says nothing.
    pub inertia: Inertia,
    /// What it touches with.
    pub solids: Vec<Solid>,
    /// Whether it may move without any joint.
    pub free: bool,
}

/// A joint as its file has it.
#[derive(Debug)]
pub struct RawJoint {
    /// Its name, or what to call it.
    pub name: String,
    /// Index of a body.
    pub parent: usize,
    /// Index of a body.
    pub child: usize,
    /// Where and about what.
    pub hinge: Hinge,
    /// How it moves.
    pub kind: Kind,
}

/// How a joint moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Not at all.
    Fixed,
    /// About one axis.
    Hinge,
    /// In any other way, in words.
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

/// One body of a part.
#[derive(Debug, Clone, PartialEq)]
pub struct Piece {
    /// Its name.
    pub name: String,
    /// In the part's frame.
    pub inertia: Inertia,
    /// In the part's frame.
    pub solids: Vec<Solid>,
    /// Whether the leg scale draws it out.
    pub scaled: bool,
}

/// Bodies that move as one.
pub type Part = Vec<Piece>;

/// A leg, as drawn.
#[derive(Debug, Clone, PartialEq)]
pub struct DrawnLeg {
    /// Torso to thigh.
    pub hip: Hinge,
    /// Thigh to shin.
    pub knee: Hinge,
    /// Between the two.
    pub thigh: Part,
    /// Below the knee.
    pub shin: Part,
    /// Which piece of the shin, and which of its solids, is the foot's ball.
    pub foot: (usize, usize),
}

impl DrawnLeg {
    /// Middle and radius of the foot's ball, in the shin's frame.
    pub fn ball(&self) -> (Point3<f64>, f64) {
        let (piece, solid) = self.foot;
        // `assemble` found a ball there.
        self.shin[piece].solids[solid].ball().unwrap_or((Point3::origin(), 0.0))
    }
}

/// A robot's body, as drawn.
#[derive(Debug, Clone, PartialEq)]
pub struct Drawn {
    /// The whole file: what is kept with a run.
    pub text: String,
    /// Its frame is that of the body that `model.torso` names.
    pub torso: Part,
    /// Legs 1 to 4.
    pub legs: [DrawnLeg; 4],
}

impl Drawn {
    /// Reads a body's file.
    ///
    /// # Errors
    /// [`ModelError`] for whatever cannot walk here.
    pub fn read(model: &Model, text: String) -> Result<Self, ModelError> {
        Self::check_name(model)?;
        let raw = if model.file.ends_with(".urdf") { urdf::read(&text)? } else { mjcf::read(&text)? };
        Assembly::new(&raw)?.assemble(model, text)
    }

    /// A file beside the description, of one of the two formats.
    ///
    /// # Errors
    /// [`ModelError::Name`] for any other.
    pub fn check_name(model: &Model) -> Result<(), ModelError> {
        let known = model.file.ends_with(".xml") || model.file.ends_with(".urdf");
        if known && !model.file.contains(['/', '\\']) {
            return Ok(());
        }
        Err(ModelError::Name { file: model.file.clone() })
    }
}

/// All pieces as one body.
pub fn weld(pieces: &[Piece]) -> Inertia {
    pieces.iter().fold(Inertia::none(), |sum, piece| sum.welded(&piece.inertia))
}
