//! A body from MJCF, by rapier's loader.
//!
//! Checks first what the loader would ignore silently or crash on:
//! NaN and infinite numbers, shapes that it skips, files in files. Springs,
//! equalities and tendons are refused; damping, armature, friction, actuators
//! and the world's own shapes are not read: joints are servos, and those and
//! the ground are `robot.toml`'s.

mod geom;
pub mod range;

use super::error::ModelError;
use super::loaded::{self, Format};
use super::raw::{Hinge, Kind, Raw, RawBody, RawJoint};
use super::warning::RobotWarning;
use rapier3d::dynamics::JointAxesMask;
use rapier3d_mjcf::mjcf_rs::body::{Body, InertiaSpec, JointType};
use rapier3d_mjcf::mjcf_rs::{Model, Pose};
use rapier3d_mjcf::{MjcfLoaderOptions, MjcfRobot};
use std::path::Path;

const FORMAT: Format = Format {
    root: "mujoco",
    other_root: "robot",
    other_ending: ".urdf",
    other_files: &["include", "attach"],
};

/// Reads a file's text.
pub fn read(text: &str) -> Result<Raw, ModelError> {
    loaded::check_text(text, &FORMAT)?;
    let mut model = Model::from_str(text, Path::new("")).map_err(|e| ModelError::Mjcf(Box::new(e)))?;
    let mut warnings = range::check(&mut model)?;
    warnings.extend(check(&mut model)?);
    let robot = MjcfRobot::from_model(&model, MjcfLoaderOptions::default(), Path::new(""));
    if !robot.equality_joints.is_empty() || !model.equality.is_empty() || !model.tendons.is_empty() {
        return Err(ModelError::Unsupported { what: "an <equality> or <tendon>".to_owned() });
    }
    // The world's own body is not one of the robot's: indices move down by one.
    let free: Vec<usize> =
        robot.qpos_dofs.iter().filter(|dof| dof.joint.is_none()).map(|dof| dof.body).collect();
    let mut raw = Raw { warnings, ..Raw::default() };
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
        let kind = kind_of(joint.joint.locked_axes);
        if joint.link1 == 0 || joint.link2 == 0 {
            let body = raw.bodies[joint.link2.max(1) - 1].name.clone();
            return Err(match kind {
                Kind::Fixed => ModelError::Held { body },
                Kind::Hinge => ModelError::Tied { joint: name, kind: "hinge", body },
                Kind::Other(kind) => ModelError::Tied { joint: name, kind, body },
            });
        }
        if joint.spring_stiffness_per_dof != 0.0 || joint.springdamper.is_some() {
            return Err(ModelError::Unsupported { what: format!("the spring of joint {name:?}") });
        }
        raw.joints.push(RawJoint {
            name,
            parent: joint.link1 - 1,
            child: joint.link2 - 1,
            hinge: Hinge {
                in_parent: loaded::frame(&joint.joint.local_frame1),
                in_child: loaded::frame(&joint.joint.local_frame2),
                range_rad: loaded::range_rad(&joint.joint),
            },
            kind,
        });
    }
    Ok(raw)
}

fn kind_of(locked: JointAxesMask) -> Kind {
    if locked == JointAxesMask::LOCKED_FIXED_AXES {
        Kind::Fixed
    } else if locked == JointAxesMask::LOCKED_REVOLUTE_AXES {
        Kind::Hinge
    } else if locked == JointAxesMask::LOCKED_PRISMATIC_AXES {
        Kind::Other("slide")
    } else {
        Kind::Other("ball joint")
    }
}

/// Every number and shape, and drops what is only to be looked at.
fn check(model: &mut Model) -> Result<Vec<RobotWarning>, ModelError> {
    let mut warnings = Vec::new();
    let from_geoms = model.compiler.inertia_from_geom;
    for (k, entry) in model.bodies.iter_mut().enumerate() {
        let body = &mut entry.body;
        let name = body.name.clone().unwrap_or_else(|| format!("{k} without a name"));
        if k == 0 {
            // A floor and other things beside the robot.
            body.geoms.clear();
            continue;
        }
        check_body(&name, body)?;
        warnings.extend(geom::check(&name, body, from_geoms)?);
    }
    Ok(warnings)
}

fn check_body(name: &str, body: &Body) -> Result<(), ModelError> {
    let of = |part: &str| format!("{part} of body {name:?}");
    loaded::check_numbers(|| of("the place"), &numbers(&body.pose))?;
    if let Some(inertial) = &body.inertial {
        let what = || of("the <inertial>");
        loaded::check_numbers(what, &numbers(&inertial.pose))?;
        loaded::check_numbers(what, &[inertial.mass])?;
        match &inertial.inertia {
            InertiaSpec::Diagonal(moments) => loaded::check_within(what, moments, loaded::MOST_MOMENT)?,
            InertiaSpec::Full(moments) => loaded::check_within(what, moments, loaded::MOST_MOMENT)?,
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
    Ok(())
}

/// Of a pose.
fn numbers(pose: &Pose) -> [f64; 7] {
    let [x, y, z] = pose.translation.to_array();
    let [i, j, k, w] = pose.rotation.to_array();
    [x, y, z, i, j, k, w]
}
