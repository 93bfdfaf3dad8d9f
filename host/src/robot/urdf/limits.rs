//! The limits of URDF joints, as ROS reads them.
//!
//! Holds what is missing and the signs of a wrong unit. Does not depend on
//! shapes and masses.

use super::super::error::ModelError;
use super::super::loaded;
use super::super::mjcf::range::{TURN_OF_DEGREES_RAD, TURN_RAD, farthest, narrow};
use super::super::warning::RobotWarning;
use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};
use rapier3d_urdf::urdf_rs::{JointType, Robot};

/// Bounds the hinges' limits, and tells of those that are probably in the wrong unit.
///
/// # Errors
/// [`ModelError::Range`] for a hinge that cannot turn.
pub fn check(model: &mut Robot, text: &str) -> Result<Vec<RobotWarning>, ModelError> {
    let complete = complete(text);
    let mut limited = Vec::new();
    for joint in model.joints.iter_mut().filter(|joint| joint.joint_type == JointType::Revolute) {
        let [low, high] = [joint.limit.lower, joint.limit.upper];
        if low >= high {
            let next = if !complete.contains(&joint.name) {
                "URDF reads a missing lower or upper of a revolute joint as 0: write both in its <limit>, or \
                 type=\"continuous\""
            } else if low > high {
                "lower is above upper: exchange them"
            } else {
                "lower must be below upper: correct them, or write type=\"continuous\" for a hinge without \
                 limits and type=\"fixed\" for none"
            };
            return Err(ModelError::Range { joint: joint.name.clone(), low, high, next });
        }
        limited.push((joint.name.clone(), [low, high]));
        [joint.limit.lower, joint.limit.upper] = loaded::bounded_limits([low, high]);
    }
    let wide = limited.iter().find(|(_, range_rad)| {
        let most = farthest(range_rad);
        most > TURN_RAD && most < TURN_OF_DEGREES_RAD
    });
    let wide = wide.map(|(joint, [low, high])| RobotWarning::WideRange {
        joint: joint.clone(),
        low: *low,
        high: *high,
        unit: "rad",
        turns: (high - low) / core::f64::consts::TAU,
        hint: "URDF limits are radians: are these degrees?",
    });
    let narrow = narrow(&limited, "URDF limits are radians: are these in another unit?");
    Ok(wide.into_iter().chain(narrow).collect())
}

/// Joints whose `<limit>` has both ends; the loader reads a missing one as 0.
fn complete(text: &str) -> Vec<String> {
    let mut reader = Reader::from_str(text);
    let (mut found, mut joint) = (Vec::new(), None);
    // The text was read to its end before.
    while let Ok(event) = reader.read_event() {
        match event {
            Event::Eof => break,
            Event::Start(tag) | Event::Empty(tag) => match tag.local_name().as_ref() {
                b"joint" => joint = attribute(&tag, "name"),
                b"limit" if attribute(&tag, "lower").is_some() && attribute(&tag, "upper").is_some() => {
                    found.extend(joint.clone());
                }
                _ => {}
            },
            _ => {}
        }
    }
    found
}

fn attribute(tag: &BytesStart<'_>, name: &str) -> Option<String> {
    let attribute = tag.try_get_attribute(name).ok()??;
    Some(String::from_utf8_lossy(&attribute.value).into_owned())
}
