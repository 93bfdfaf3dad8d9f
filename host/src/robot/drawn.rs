//! The body as its file draws it: a torso and four legs of two hinges.
//!
//! Owns the search for the robot's parts among the file's bodies and joints:
//! bodies that are fixed to each other are one part. Refuses whatever is no
//! tree of one torso, four thighs and four shins. Knows neither file format;
//! [`super::mjcf`] and [`super::urdf`] do.

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

/// How bodies hang together.
struct Assembly<'r> {
    raw: &'r Raw,
    /// Of each body: the first body of its part, and where it is in that one's frame.
    roots: Vec<(usize, Isometry3<f64>)>,
    /// Of each body: the joint that carries it.
    carriers: Vec<Option<usize>>,
}

impl<'r> Assembly<'r> {
    fn new(raw: &'r Raw) -> Result<Self, ModelError> {
        for (k, body) in raw.bodies.iter().enumerate() {
            if raw.bodies[..k].iter().any(|other| other.name == body.name) {
                return Err(ModelError::Twice { name: body.name.clone() });
            }
        }
        let mut carriers = vec![None; raw.bodies.len()];
        for (k, joint) in raw.joints.iter().enumerate() {
            if raw.joints[..k].iter().any(|other| other.name == joint.name) {
                return Err(ModelError::Twice { name: joint.name.clone() });
            }
            let looped = || ModelError::Loop { body: raw.bodies[joint.child].name.clone() };
            if carriers[joint.child].replace(k).is_some() {
                return Err(looped());
            }
        }
        let mut assembly = Self { raw, roots: Vec::new(), carriers };
        for body in 0..raw.bodies.len() {
            let root = assembly.root_of(body)?;
            assembly.roots.push(root);
        }
        Ok(assembly)
    }

    /// Follows fixed joints up, and looks further up whether there is an end.
    fn root_of(&self, body: usize) -> Result<(usize, Isometry3<f64>), ModelError> {
        let (mut root, mut pose, mut moved) = (body, Isometry3::identity(), false);
        let mut at = body;
        for _ in 0..=self.raw.bodies.len() {
            let Some(joint) = self.carriers[at].map(|joint| &self.raw.joints[joint]) else {
                return Ok((root, pose));
            };
            moved |= joint.kind != Kind::Fixed;
            at = joint.parent;
            if !moved {
                (root, pose) = (at, joint.hinge.at(0.0) * pose);
            }
        }
        Err(ModelError::Loop { body: self.raw.bodies[body].name.clone() })
    }

    fn body(&self, field: &'static str, name: &str) -> Result<usize, ModelError> {
        self.raw.bodies.iter().position(|body| body.name == name).ok_or_else(|| ModelError::Unknown {
            field,
            name: name.to_owned(),
            has: listed("body", "bodies", self.raw.bodies.iter().map(|body| &body.name)),
        })
    }

    fn hinge(&self, field: &'static str, name: &str) -> Result<usize, ModelError> {
        let joints = &self.raw.joints;
        let found = joints.iter().position(|joint| joint.name == name).ok_or_else(|| {
            let hinges = joints.iter().filter(|joint| joint.kind == Kind::Hinge);
            ModelError::Unknown {
                field,
                name: name.to_owned(),
                has: listed("hinge", "hinges", hinges.map(|joint| &joint.name)),
            }
        })?;
        match joints[found].kind {
            Kind::Hinge => Ok(found),
            Kind::Fixed => Err(ModelError::Moves { name: name.to_owned(), kind: "fixed joint" }),
            Kind::Other(kind) => Err(ModelError::Moves { name: name.to_owned(), kind }),
        }
    }

    /// The hinge between two parts, in their frames.
    fn between(&self, joint: usize, parent_frame: &Isometry3<f64>) -> Result<Hinge, ModelError> {
        let RawJoint { name, parent, child, hinge, .. } = &self.raw.joints[joint];
        if let Some([low, high]) = hinge.range_rad
            && low >= high
        {
            return Err(ModelError::Range { joint: name.clone(), low, high });
        }
        Ok(Hinge {
            in_parent: parent_frame.inverse() * self.roots[*parent].1 * hinge.in_parent,
            in_child: self.roots[*child].1 * hinge.in_child,
            range_rad: hinge.range_rad,
        })
    }

    /// All bodies of the part with this root, in a frame of that root's.
    fn part(&self, root: usize, frame: &Isometry3<f64>, scaled: &[usize]) -> Result<Part, ModelError> {
        let bodies = (0..self.raw.bodies.len()).filter(|body| self.roots[*body].0 == root);
        let pieces: Part = bodies
            .map(|body| {
                let RawBody { name, inertia, solids, .. } = &self.raw.bodies[body];
                let to = frame.inverse() * self.roots[body].1;
                Piece {
                    name: name.clone(),
                    inertia: inertia.moved(&to),
                    solids: solids.iter().map(|solid| solid.moved(&to)).collect(),
                    scaled: scaled.contains(&body),
                }
            })
            .collect();
        let whole = weld(&pieces);
        if !whole.is_possible() {
            return Err(ModelError::Inertia {
                body: self.raw.bodies[root].name.clone(),
                mass_kg: whole.mass_kg,
                moments: whole.principal().moments_kg_m2.into(),
            });
        }
        Ok(pieces)
    }

    fn assemble(&self, model: &Model, text: String) -> Result<Drawn, ModelError> {
        let torso = self.body("model.torso", &model.torso)?;
        let (torso_root, torso_frame) = self.roots[torso];
        let name_of = |body: usize| self.raw.bodies[body].name.clone();
        if self.carriers[torso_root].is_some() || !self.raw.bodies[torso_root].free {
            return Err(ModelError::Held { body: name_of(torso_root) });
        }
        let mut hips = [0; 4];
        let mut knees = [0; 4];
        for leg in 0..4 {
            hips[leg] = self.hinge("model.hips", &model.hips[leg])?;
            knees[leg] = self.hinge("model.knees", &model.knees[leg])?;
        }
        for (k, joint) in self.raw.joints.iter().enumerate() {
            let times = hips.iter().chain(&knees).filter(|named| **named == k).count();
            match joint.kind {
                _ if times > 1 => return Err(ModelError::Twice { name: joint.name.clone() }),
                Kind::Fixed => {}
                _ if times == 1 => {}
                Kind::Hinge => return Err(ModelError::Moves { name: joint.name.clone(), kind: "hinge" }),
                Kind::Other(kind) => return Err(ModelError::Moves { name: joint.name.clone(), kind }),
            }
        }
        let scaled = model
            .scaled
            .iter()
            .map(|name| self.body("model.scaled", name))
            .collect::<Result<Vec<_>, _>>()?;
        let mut roots = vec![torso_root];
        let mut legs = Vec::with_capacity(4);
        for leg in 0..4 {
            let (hip, knee) = (&self.raw.joints[hips[leg]], &self.raw.joints[knees[leg]]);
            let elsewhere = |field, name: &str, on: usize, must: String| ModelError::Elsewhere {
                field,
                name: name.to_owned(),
                on: name_of(on),
                must,
            };
            if self.roots[hip.parent].0 != torso_root {
                let must = format!("the torso {:?}", model.torso);
                return Err(elsewhere("model.hips", &hip.name, hip.parent, must));
            }
            let thigh = self.roots[hip.child].0;
            if self.roots[knee.parent].0 != thigh {
                let must = format!("the thigh that {:?} carries", hip.name);
                return Err(elsewhere("model.knees", &knee.name, knee.parent, must));
            }
            let shin = self.roots[knee.child].0;
            let foot = self.body("model.feet", &model.feet[leg])?;
            if self.roots[foot].0 != shin {
                let must = format!("the shin that {:?} carries", knee.name);
                return Err(elsewhere("model.feet", &model.feet[leg], self.roots[foot].0, must));
            }
            roots.extend([thigh, shin]);
            legs.push(self.leg([hips[leg], knees[leg]], &torso_frame, foot, &scaled)?);
        }
        if let Some(scaled) = scaled.iter().find(|body| self.roots[**body].0 == torso_root) {
            return Err(ModelError::Elsewhere {
                field: "model.scaled",
                name: name_of(*scaled),
                on: name_of(torso_root),
                must: "a thigh or a shin".to_owned(),
            });
        }
        if let Some(loose) = (0..self.raw.bodies.len()).find(|body| !roots.contains(&self.roots[*body].0)) {
            return Err(ModelError::Loose { body: name_of(loose) });
        }
        let mut torso_part = self.part(torso_root, &torso_frame, &[])?;
        // The named body comes first: it is the one that `mass.torso_kg` weighs.
        let named = torso_part.iter().position(|piece| piece.name == model.torso).unwrap_or(0);
        torso_part.swap(0, named);
        if torso_part[0].inertia.mass_kg <= 0.0 {
            let what = format!("the mass of the torso {:?}", model.torso);
            return Err(ModelError::NotPositive { what, value: torso_part[0].inertia.mass_kg });
        }
        // Four were pushed.
        match <[DrawnLeg; 4]>::try_from(legs) {
            Ok(legs) => Ok(Drawn { text, torso: torso_part, legs }),
            Err(_) => Err(ModelError::Loose { body: name_of(torso_root) }),
        }
    }

    fn leg(
        &self,
        [hip, knee]: [usize; 2],
        torso_frame: &Isometry3<f64>,
        foot: usize,
        scaled: &[usize],
    ) -> Result<DrawnLeg, ModelError> {
        let origin = Isometry3::identity();
        let thigh_root = self.roots[self.raw.joints[hip].child].0;
        let shin_root = self.roots[foot].0;
        let shin = self.part(shin_root, &origin, scaled)?;
        let foot_name = &self.raw.bodies[foot].name;
        let piece = shin.iter().position(|piece| piece.name == *foot_name).unwrap_or(0);
        let balls: Vec<usize> =
            (0..shin[piece].solids.len()).filter(|k| shin[piece].solids[*k].ball().is_some()).collect();
        let &[ball] = &balls[..] else {
            return Err(ModelError::Foot { body: foot_name.clone(), balls: balls.len() });
        };
        let leg = DrawnLeg {
            hip: self.between(hip, torso_frame)?,
            knee: self.between(knee, &origin)?,
            thigh: self.part(thigh_root, &origin, scaled)?,
            shin,
            foot: (piece, ball),
        };
        let lever = leg.knee.in_child.inverse() * leg.ball().0;
        if lever.y.hypot(lever.z) < 1e-4 {
            return Err(ModelError::NoShin { body: foot_name.clone() });
        }
        Ok(leg)
    }
}

/// All pieces as one body.
pub fn weld(pieces: &[Piece]) -> Inertia {
    pieces.iter().fold(Inertia::none(), |sum, piece| sum.welded(&piece.inertia))
}

fn listed<'n>(one: &str, many: &str, names: impl Iterator<Item = &'n String>) -> String {
    let names: Vec<&str> = names.map(String::as_str).collect();
    match names.len() {
        0 => format!("no {one}"),
        1 => format!("the {one} {}", names[0]),
        _ => format!("the {many} {}", names.join(", ")),
    }
}
