//! The ranges of MJCF hinges, as MuJoCo reads them.
//!
//! Holds the signs of a wrong unit. Does not depend on shapes and masses.

use super::super::error::ModelError;
use super::super::loaded;
use super::super::warning::RobotWarning;
use rapier3d_mjcf::mjcf_rs::body::JointType;
use rapier3d_mjcf::mjcf_rs::{Model, Tristate};

/// Ranges of radians that were read as degrees are below this, in degrees:
/// few hinges turn farther than half a turn, which is 3.14.
pub const NARROW_DEG: f64 = 4.0;
/// A full turn, and what rounding adds.
pub const TURN_RAD: f64 = 6.4;
/// So many radians are a full turn in degrees; what is beyond means no limit.
pub const TURN_OF_DEGREES_RAD: f64 = 361.0;

/// Bounds the hinges' limits, and tells of those that are probably in the wrong unit.
///
/// # Errors
/// [`ModelError::Range`] for a limited hinge without a range.
pub fn check(model: &mut Model) -> Result<Vec<RobotWarning>, ModelError> {
    let degrees = model.compiler.angle_is_degree;
    let autolimits = model.compiler.autolimits;
    let mut limited = Vec::new();
    for (k, entry) in model.bodies.iter_mut().enumerate() {
        for joint in entry.body.joints.iter_mut().filter(|joint| joint.type_ == JointType::Hinge) {
            let name = || joint.name.clone().unwrap_or_else(|| format!("of body {k}"));
            // MuJoCo takes 0 0 for no range where nothing says that there is one.
            if joint.limited == Tristate::Auto && joint.range == Some([0.0, 0.0]) {
                joint.range = None;
            }
            match joint.range {
                Some(range_rad) if joint.limited.resolve(autolimits, true) => {
                    limited.push((name(), range_rad));
                }
                None if joint.limited == Tristate::True => {
                    let next = "limited=\"true\" needs a range: write it, or leave limited out";
                    return Err(ModelError::Range { joint: name(), low: 0.0, high: 0.0, next });
                }
                _ => {}
            }
            joint.range = joint.range.map(loaded::bounded_limits);
        }
    }
    let wide = limited.iter().find(|(_, range_rad)| {
        let most = farthest(range_rad);
        most > TURN_RAD && most < TURN_OF_DEGREES_RAD
    });
    let mut warnings: Vec<RobotWarning> = wide
        .map(|(joint, [low, high])| {
            let shown = |rad: &f64| if degrees { rounded(rad.to_degrees()) } else { *rad };
            RobotWarning::WideRange {
                joint: joint.clone(),
                low: shown(low),
                high: shown(high),
                unit: if degrees { "degrees" } else { "rad" },
                turns: (high - low) / core::f64::consts::TAU,
                hint: if degrees {
                    "leave range out, or write what the joint does"
                } else {
                    "is the file in degrees (<compiler angle=\"degree\"/>, which is MuJoCo's default)?"
                },
            }
        })
        .into_iter()
        .collect();
    let hint = if degrees {
        "is the file in radians (<compiler angle=\"radian\"/>)?"
    } else {
        "are the limits right? The file is in radians"
    };
    warnings.extend(narrow(&limited, hint));
    Ok(warnings)
}

/// The first of the hinges that turn less than [`NARROW_DEG`] either way.
pub fn narrow(limited: &[(String, [f64; 2])], hint: &'static str) -> Option<RobotWarning> {
    let is_narrow =
        |range_rad: &[f64; 2]| range_rad[0] < range_rad[1] && farthest(range_rad).to_degrees() < NARROW_DEG;
    let (joint, [low, high]) = limited.iter().find(|(_, range_rad)| is_narrow(range_rad))?;
    Some(RobotWarning::NarrowRange {
        joint: joint.clone(),
        low: rounded(low.to_degrees()),
        high: rounded(high.to_degrees()),
        count: limited.iter().filter(|(_, range_rad)| is_narrow(range_rad)).count(),
        of: limited.len(),
        hint,
    })
}

/// From where the joint is drawn.
pub fn farthest(range_rad: &[f64; 2]) -> f64 {
    range_rad[0].abs().max(range_rad[1].abs())
}

/// Without what conversion to radians and back adds.
fn rounded(degrees: f64) -> f64 {
    (degrees * 1e6).round() / 1e6
}
