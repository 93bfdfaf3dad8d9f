//! A body from MJCF, by rapier's loader.
//!
//! Checks first what the loader would ignore silently or crash on:
//! NaN and infinite numbers, shapes that it skips, files in files. Springs,
//! equalities and tendons are refused; damping, armature, friction, actuators
//! and the world's own shapes are not read: joints are servos, and those and
//! the ground are `robot.toml`'s.

use super::error::ModelError;
use super::loaded;
use super::raw::{Hinge, Kind, Raw, RawBody, RawJoint};
use rapier3d::dynamics::JointAxesMask;
use rapier3d_mjcf::mjcf_rs::body::{Body, Geom, GeomType, InertiaSpec, JointType};
use rapier3d_mjcf::mjcf_rs::compiler::InertiaFromGeom;
use rapier3d_mjcf::mjcf_rs::{Model, Pose};
use rapier3d_mjcf::{MjcfLoaderOptions, MjcfRobot};
use std::path::Path;

/// Reads a file's text.
pub fn read(text: &str) -> Result<Raw, ModelError> {
    loaded::check_text(text, &["include", "attach"])?;
    let mut model = Model::from_str(text, Path::new("")).map_err(|e| ModelError::Mjcf(Box::new(e)))?;
    check(&mut model)?;
    let robot = MjcfRobot::from_model(&model, MjcfLoaderOptions::default(), Path::new(""));
    if !robot.equality_joints.is_empty() || !model.equality.is_empty() || !model.tendons.is_empty() {
        return Err(ModelError::Unsupported { what: "an <equality> or <tendon>".to_owned() });
    }
    // The world's own body is not one of the robot's: indices move down by one.
    let free: Vec<usize> =
        robot.qpos_dofs.iter().filter(|dof| dof.joint.is_none()).map(|dof| dof.body).collect();
    let mut raw = Raw::default();
    for (k, body) in robot.bodies.iter().enumerate().skip(1) {
        let name = body.name.clone().unwrap_or_else(|| format!("body {k} without a name"));
        let drawn = &model.bodies[body.mjcf_body_id].body;
        let solids = body.colliders.iter().map(|collider| loaded::solid(&name, collider));
        raw.bodies.push(RawBody {
            inertia: loaded::inertia(&body.body, drawn.inertial.as_ref().map(|inertial| inertial.mass)),
            solids: solids.collect::<Result<_, _>>()?,
            free: free.contains(&k),
            name,
        });
    }
    for (k, joint) in robot.joints.iter().enumerate() {
        let name = joint.name.clone().unwrap_or_else(|| format!("joint {k} without a name"));
        if joint.link1 == 0 || joint.link2 == 0 {
            return Err(ModelError::Held { body: raw.bodies[joint.link2.max(1) - 1].name.clone() });
        }
        if joint.spring_stiffness_per_dof != 0.0 || joint.springdamper.is_some() {
            return Err(ModelError::Unsupported { what: format!("the spring of joint {name:?}") });
        }
        let locked = joint.joint.locked_axes;
        raw.joints.push(RawJoint {
            name,
            parent: joint.link1 - 1,
            child: joint.link2 - 1,
            hinge: Hinge {
                in_parent: loaded::frame(&joint.joint.local_frame1),
                in_child: loaded::frame(&joint.joint.local_frame2),
                range_rad: loaded::range_rad(&joint.joint),
            },
            kind: if locked == JointAxesMask::LOCKED_FIXED_AXES {
                Kind::Fixed
            } else if locked == JointAxesMask::LOCKED_REVOLUTE_AXES {
                Kind::Hinge
            } else if locked == JointAxesMask::LOCKED_PRISMATIC_AXES {
                Kind::Other("slide")
            } else {
                Kind::Other("ball joint")
            },
        });
    }
    Ok(raw)
}

/// Every number and shape, and drops what is only to be looked at.
fn check(model: &mut Model) -> Result<(), ModelError> {
    let from_geoms = model.compiler.inertia_from_geom;
    for (k, entry) in model.bodies.iter_mut().enumerate() {
        let body = &mut entry.body;
        let name = body.name.clone().unwrap_or_else(|| format!("{k} without a name"));
        if k == 0 {
            // A floor and other things beside the robot.
            body.geoms.clear();
            continue;
        }
        let weighs = match from_geoms {
            InertiaFromGeom::True => true,
            InertiaFromGeom::False => false,
            InertiaFromGeom::Auto => body.inertial.is_none(),
        };
        body.geoms.retain(|geom| weighs || touches(geom));
        check_body(&name, body)?;
    }
    Ok(())
}

fn touches(geom: &Geom) -> bool {
    geom.contype != 0 || geom.conaffinity != 0
}

fn check_body(name: &str, body: &Body) -> Result<(), ModelError> {
    let of = |part: &str| format!("{part} of body {name:?}");
    loaded::check_numbers(|| of("the place"), &numbers(&body.pose))?;
    if let Some(inertial) = &body.inertial {
        let what = || of("the <inertial>");
        loaded::check_numbers(what, &numbers(&inertial.pose))?;
        loaded::check_numbers(what, &[inertial.mass])?;
        match &inertial.inertia {
            InertiaSpec::Diagonal(moments) => loaded::check_numbers(what, moments)?,
            InertiaSpec::Full(moments) => loaded::check_numbers(what, moments)?,
        }
        if inertial.mass < 0.0 {
            return Err(ModelError::NotPositive { what: of("the mass"), value: inertial.mass });
        }
    }
    for joint in body.joints.iter().filter(|joint| joint.type_ != JointType::Free) {
        let what =
            || format!("joint {:?} of body {name:?}", joint.name.as_deref().unwrap_or("without a name"));
        loaded::check_numbers(what, &joint.pos)?;
        loaded::check_numbers(what, &joint.axis)?;
        loaded::check_numbers(what, &[joint.ref_, joint.springref, joint.stiffness])?;
        loaded::check_numbers(what, &joint.range.unwrap_or_default())?;
        let length = joint.axis.iter().map(|part| part * part).sum::<f64>().sqrt();
        if length < 1e-6 {
            let what = format!("the length of the axis of {}", what());
            return Err(ModelError::NotPositive { what, value: length });
        }
    }
    body.geoms.iter().try_for_each(|geom| check_geom(name, geom))
}

fn check_geom(body: &str, geom: &Geom) -> Result<(), ModelError> {
    let what = || format!("a geom of body {body:?}");
    let refuse = |shape| Err(ModelError::Shape { body: body.to_owned(), shape });
    let sizes = match geom.type_ {
        GeomType::Sphere => 1,
        GeomType::Capsule | GeomType::Cylinder if geom.fromto.is_some() => 1,
        GeomType::Capsule | GeomType::Cylinder => 2,
        GeomType::Box => 3,
        GeomType::Plane => return refuse("plane"),
        GeomType::Hfield => return refuse("height field"),
        GeomType::Ellipsoid => return refuse("ellipsoid"),
        GeomType::Mesh => return refuse("mesh"),
        GeomType::Sdf => return refuse("distance field"),
    };
    loaded::check_numbers(what, &geom.size)?;
    loaded::check_numbers(what, &numbers(&geom.pose))?;
    loaded::check_numbers(what, &geom.fromto.unwrap_or_default())?;
    loaded::check_numbers(what, &[geom.mass.unwrap_or_default(), geom.density.unwrap_or_default()])?;
    match geom.size[..sizes].iter().find(|size| **size <= 0.0) {
        Some(size) => Err(ModelError::NotPositive { what: format!("a size of {}", what()), value: *size }),
        None => Ok(()),
    }
}

fn numbers(pose: &Pose) -> [f64; 7] {
    let [x, y, z] = pose.translation.to_array();
    let [i, j, k, w] = pose.rotation.to_array();
    [x, y, z, i, j, k, w]
}
