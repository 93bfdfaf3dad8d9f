//! Finds a robot's parts among a file's bodies and joints.
//!
//! Bodies that are fixed to each other are one part. Does not depend on
//! the file's format. What is not a tree of one torso, four thighs and four shins
//! is refused by the name that is wrong.

use super::drawn::{Drawn, DrawnLeg, Part, Piece, weld};
use super::error::ModelError;
use super::raw::{Hinge, Kind, Raw, RawBody, RawJoint};
use super::sections::Model;
use nalgebra::Isometry3;
use protocol::LEG_COUNT;

/// How bodies hang together.
pub struct Assembly<'r> {
    raw: &'r Raw,
    /// Of each body: the first body of its part, and where it is in that one's frame.
    roots: Vec<(usize, Isometry3<f64>)>,
    /// Of each body: the joint that carries it.
    carriers: Vec<Option<usize>>,
}

impl<'r> Assembly<'r> {
    /// Finds each body's parent joint and part.
    ///
    /// # Errors
    /// [`ModelError`] for names that are there twice, and bodies that form no tree.
    pub fn new(raw: &'r Raw) -> Result<Self, ModelError> {
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
            let next = "the first must be below the second: correct it, or leave it out";
            return Err(ModelError::Range { joint: name.clone(), low, high, next });
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
                next: match (whole.mass_kg > 0.0, self.raw.is_urdf) {
                    (true, _) => "correct them: they must be above 0, and none above the sum of the others",
                    (false, true) => "give one of its links an <inertial> with mass and inertia",
                    (false, false) => "give its geoms a mass, or one of its bodies an <inertial>",
                },
            });
        }
        Ok(pieces)
    }

    /// Refuses a torso that something carries.
    fn check_free(&self, torso: usize, torso_name: &str) -> Result<(), ModelError> {
        let root = self.roots[torso].0;
        let held = |joint: usize, next| {
            let RawJoint { name, parent, kind, .. } = &self.raw.joints[joint];
            Err(ModelError::HeldBy {
                joint: name.clone(),
                kind: match *kind {
                    Kind::Fixed => "fixed joint",
                    Kind::Hinge => "hinge",
                    Kind::Other(kind) => kind,
                },
                torso: torso_name.to_owned(),
                link: self.raw.bodies[*parent].name.clone(),
                next,
            })
        };
        if let Some(joint) = self.carriers[root] {
            let next = if self.raw.is_urdf {
                "a torso moves freely: leave that link and the joint out, or, if another link carries the hips, \
                 name that in model.torso"
            } else {
                "a torso moves freely: name the body that carries the hips in model.torso"
            };
            return held(joint, next);
        }
        if self.raw.bodies[root].free {
            return Ok(());
        }
        if !self.raw.is_urdf {
            return Err(ModelError::Held { body: self.raw.bodies[root].name.clone() });
        }
        // The fixed joint next to the root: bodies form a tree.
        let mut at = torso;
        let mut last = None;
        while let Some(joint) = self.carriers[at] {
            (at, last) = (self.raw.joints[joint].parent, Some(joint));
        }
        match last {
            Some(joint) => held(joint, "a torso moves freely: leave that link and the joint out"),
            None => Err(ModelError::Ground),
        }
    }

    /// Finds the named parts.
    ///
    /// # Errors
    /// [`ModelError`] for whatever is missing, too much, or in the wrong place.
    pub fn assemble(&self, model: &Model, text: String) -> Result<Drawn, ModelError> {
        let torso = self.body("model.torso", &model.torso)?;
        let (torso_root, torso_frame) = self.roots[torso];
        let name_of = |body: usize| self.raw.bodies[body].name.clone();
        self.check_free(torso, &model.torso)?;
        let mut hips = [0; LEG_COUNT];
        let mut knees = [0; LEG_COUNT];
        for leg in 0..LEG_COUNT {
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
        let scaled =
            model.scaled.iter().map(|name| self.body("model.scaled", name)).collect::<Result<Vec<_>, _>>()?;
        let mut roots = vec![torso_root];
        let mut legs = Vec::with_capacity(LEG_COUNT);
        for leg in 0..LEG_COUNT {
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
        match <[DrawnLeg; LEG_COUNT]>::try_from(legs) {
            Ok(legs) => Ok(Drawn { text, torso: torso_part, legs, warnings: self.raw.warnings.clone() }),
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

fn listed<'n>(one: &str, many: &str, names: impl Iterator<Item = &'n String>) -> String {
    let names: Vec<&str> = names.map(String::as_str).collect();
    match names.len() {
        0 => format!("no {one}"),
        1 => format!("the {one} {}", names[0]),
        _ => format!("the {many} {}", names.join(", ")),
    }
}
