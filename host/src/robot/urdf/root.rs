//! What is above a URDF's floating joint.
//!
//! Holds how a link such as "world" is left out where a floating joint lets the
//! whole robot move. Does not depend on shapes and masses.

use super::super::error::ModelError;
use rapier3d_urdf::urdf_rs::{JointType, Link, Robot};

/// Leaves out the links above a floating joint: the robot below moves freely, as
/// a URDF's root does here.
///
/// # Errors
/// [`ModelError::Floating`] where a part of the robot is above such a joint.
pub fn drop_above_floating(model: &mut Robot) -> Result<(), ModelError> {
    while let Some(joint) = model.joints.iter().find(|joint| joint.joint_type == JointType::Floating) {
        let below = below(model, &joint.child.link);
        let is_above = |name: &String| !below.contains(name);
        let is_held = |link: &Link| {
            let moves = |name: &String| {
                model.joints.iter().any(|other| {
                    other.name != joint.name
                        && other.parent.link == *name
                        && !matches!(other.joint_type, JointType::Fixed | JointType::Floating)
                })
            };
            link.inertial.mass.value > 0.0 || !link.collision.is_empty() || moves(&link.name)
        };
        if let Some(link) = model.links.iter().find(|link| is_above(&link.name) && is_held(link)) {
            return Err(ModelError::Floating { joint: joint.name.clone(), link: link.name.clone() });
        }
        model.links.retain(|link| below.contains(&link.name));
        model.joints.retain(|joint| below.contains(&joint.parent.link));
    }
    Ok(())
}

/// A link and all that it carries.
fn below(model: &Robot, link: &str) -> Vec<String> {
    let mut found = vec![link.to_owned()];
    let mut k = 0;
    while k < found.len() {
        let children = model.joints.iter().filter(|joint| joint.parent.link == found[k]);
        let more: Vec<String> = children.map(|joint| joint.child.link.clone()).collect();
        // A loop is the assembly's to refuse.
        found.extend(more.into_iter().filter(|name| !found.contains(name)).collect::<Vec<_>>());
        k += 1;
    }
    found
}
