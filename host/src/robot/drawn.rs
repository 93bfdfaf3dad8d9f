//! The body as its file draws it: a torso and four legs of two hinges.
//!
//! Holds the parts after they were found. Does not depend on the file formats,
//! nor on how the parts are found.

use super::inertia::Inertia;
use super::raw::Hinge;
use super::solid::Solid;
use super::warning::RobotWarning;
use nalgebra::Point3;
use protocol::LEG_COUNT;

/// One body of a part.
#[derive(Debug, Clone, PartialEq)]
pub struct Piece {
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

#[derive(Debug, Clone, PartialEq)]
pub struct DrawnLeg {
    pub hip: Hinge,
    pub knee: Hinge,
    pub thigh: Part,
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
    pub legs: [DrawnLeg; LEG_COUNT],
    /// What of the file is probably not meant as it is written.
    pub warnings: Vec<RobotWarning>,
}

/// All pieces as one body.
pub fn weld(pieces: &[Piece]) -> Inertia {
    pieces.iter().fold(Inertia::none(), |sum, piece| sum.welded(&piece.inertia))
}
