//! A body from URDF, by rapier's loader.
//!
//! Checks first what the loader would ignore silently or crash on:
//! joints of links that are not there, NaN and infinite numbers, meshes, turned
//! inertias. Not read: looks, damping, friction, effort and velocity limits:
//! joints are servos, and those are `robot.toml`'s.

mod limits;
mod root;

use super::error::ModelError;
use super::loaded::{self, Format};
use super::raw::{Hinge, Kind, Raw, RawBody, RawJoint};
use super::warning::RobotWarning;
use rapier3d_urdf::urdf_rs::{self, Geometry, Joint, JointType, Link, Pose};
use rapier3d_urdf::{UrdfLoaderOptions, UrdfRobot};
use std::path::Path;

const FORMAT: Format = Format { root: "robot", other_root: "mujoco", other_ending: ".xml", other_files: &[] };
/// No origin is turned farther than once around.
const TURN_RAD: f64 = 6.4;

/// Reads a file's text.
pub fn read(text: &str) -> Result<Raw, ModelError> {
    loaded::check_text(text, &FORMAT)?;
    let mut model = urdf_rs::read_from_string(text).map_err(|e| ModelError::Urdf(Box::new(e)))?;
    model.links.iter().try_for_each(check_link)?;
    for joint in &model.joints {
        check_joint(joint)?;
        for link in [&joint.parent.link, &joint.child.link] {
            if !model.links.iter().any(|known| known.name == *link) {
                let names: Vec<&str> = model.links.iter().map(|link| link.name.as_str()).collect();
                return Err(ModelError::Unknown {
                    field: "a joint",
                    name: link.clone(),
                    has: format!("the links {}", names.join(", ")),
                });
            }
        }
    }
    let mut warnings = limits::check(&mut model, text)?;
    warnings.extend(turned(&model));
    root::drop_above_floating(&mut model)?;
    // Links without a body of their own are parts of those that they are fixed
    // to; that is for us to find, so the loader is to leave them.
    let options = UrdfLoaderOptions { squeeze_empty_fixed_links: false, ..UrdfLoaderOptions::default() };
    let robot = UrdfRobot::from_robot(&model, options, Path::new(""));
    let mut raw = Raw { is_urdf: true, warnings, ..Raw::default() };
    for link in &robot.links {
        let drawn = &model.links[link.urdf_link_index];
        let name = drawn.name.clone();
        let solids = link.colliders.iter().map(|found| loaded::solid(&name, &found.collider));
        raw.bodies.push(RawBody {
            inertia: loaded::inertia(&link.body, Some(drawn.inertial.mass.value)),
            solids: solids.collect::<Result<_, _>>()?,
            // A URDF's root moves freely unless it is called otherwise.
            free: name != "world",
            name,
        });
    }
    for joint in &robot.joints {
        let drawn = &model.joints[joint.urdf_joint_index];
        raw.joints.push(RawJoint {
            name: drawn.name.clone(),
            parent: joint.link1,
            child: joint.link2,
            hinge: Hinge {
                in_parent: loaded::frame(&joint.joint.local_frame1),
                in_child: loaded::frame(&joint.joint.local_frame2),
                range_rad: loaded::range_rad(&joint.joint),
            },
            kind: match drawn.joint_type {
                JointType::Fixed => Kind::Fixed,
                JointType::Revolute | JointType::Continuous => Kind::Hinge,
                JointType::Prismatic => Kind::Other("prismatic joint"),
                JointType::Floating => Kind::Other("floating joint"),
                JointType::Planar => Kind::Other("planar joint"),
                JointType::Spherical => Kind::Other("spherical joint"),
            },
        });
    }
    Ok(raw)
}

/// Origins that are turned farther than once around.
fn turned(model: &urdf_rs::Robot) -> Option<RobotWarning> {
    let joints = model.joints.iter().map(|joint| (format!("joint {:?}", joint.name), &joint.origin));
    let shapes = model.links.iter().flat_map(|link| {
        link.collision.iter().map(|one| (format!("a <collision> of link {:?}", link.name), &one.origin))
    });
    let far = |pose: &Pose| pose.rpy.iter().copied().find(|angle| angle.abs() > TURN_RAD);
    let (what, angle) = joints.chain(shapes).find_map(|(what, pose)| Some((what, far(pose)?)))?;
    Some(RobotWarning::Turned { what, angle, radians: angle.to_radians() })
}

fn numbers(pose: &Pose) -> Vec<f64> {
    pose.xyz.iter().chain(pose.rpy.iter()).copied().collect()
}

fn check_link(link: &Link) -> Result<(), ModelError> {
    let name = &link.name;
    let what = || format!("the <inertial> of link {name:?}");
    let urdf_rs::Inertial { origin, mass, inertia } = &link.inertial;
    loaded::check_numbers(what, &numbers(origin))?;
    let moments = [inertia.ixx, inertia.ixy, inertia.ixz, inertia.iyy, inertia.iyz, inertia.izz];
    loaded::check_within(what, &moments, loaded::MOST_MOMENT)?;
    loaded::check_numbers(what, &[mass.value])?;
    if mass.value < 0.0 {
        return Err(ModelError::NotPositive {
            what: format!("the mass of link {name:?}"),
            value: mass.value,
        });
    }
    if origin.rpy.iter().any(|angle| angle.abs() > 1e-9) {
        return Err(ModelError::TurnedInertia { link: name.clone() });
    }
    for collision in &link.collision {
        let what = || format!("a <collision> of link {name:?}");
        loaded::check_numbers(what, &numbers(&collision.origin))?;
        let sizes: Vec<f64> = match &collision.geometry {
            Geometry::Box { size } => size.to_vec(),
            Geometry::Cylinder { radius, length } | Geometry::Capsule { radius, length } => {
                vec![*radius, *length]
            }
            Geometry::Sphere { radius } => vec![*radius],
            Geometry::Mesh { .. } => {
                return Err(ModelError::Shape { body: name.clone(), shape: "mesh", looks: "in <visual>" });
            }
        };
        loaded::check_numbers(what, &sizes)?;
        if let Some(size) = sizes.iter().find(|size| **size <= 0.0) {
            return Err(ModelError::NotPositive { what: format!("a size of {}", what()), value: *size });
        }
    }
    Ok(())
}

fn check_joint(joint: &Joint) -> Result<(), ModelError> {
    let what = || format!("joint {:?}", joint.name);
    loaded::check_numbers(what, &numbers(&joint.origin))?;
    loaded::check_numbers(what, joint.axis.xyz.as_slice())?;
    // Infinite limits are none, but NaN is refused.
    if joint.limit.lower.is_nan() || joint.limit.upper.is_nan() {
        loaded::check_numbers(|| format!("the <limit> of {}", what()), &[f64::NAN])?;
    }
    let length = joint.axis.xyz.iter().map(|part| part * part).sum::<f64>().sqrt();
    if joint.joint_type != JointType::Fixed && length < 1e-6 {
        let what = format!("the length of the axis of {}", what());
        return Err(ModelError::NotPositive { what, value: length });
    }
    if joint.mimic.is_some() {
        return Err(ModelError::Unsupported { what: format!("the <mimic> of joint {:?}", joint.name) });
    }
    Ok(())
}
