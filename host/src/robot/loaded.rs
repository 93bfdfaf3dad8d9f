//! From what rapier's loaders hand over to bodies in double precision.
//!
//! Holds the two checks that both formats need before a loader may see a file.
//! Does not depend on either format.

use super::error::ModelError;
use super::inertia::Inertia;
use super::solid::{Shape, Solid};
use nalgebra::{Isometry3, Matrix3, Quaternion, Translation3, UnitQuaternion, Vector3};
use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};
use rapier3d::prelude::*;

/// A robot of eight servos takes a few kilobytes.
const MOST_BYTES: usize = 1 << 20;
/// Parsers recurse, and a stack ends.
const MOST_DEPTH: usize = 64;
/// Largest length, mass or angle that is plausible, in m, kg or rad.
const MOST: f64 = 1000.0;
/// Largest density in kg/m^3; osmium has 22,590.
pub const MOST_DENSITY: f64 = 25_000.0;
/// Largest moment of inertia that a loader may see, in kg m^2. Moments that do
/// not suit a part's size are found later, by the radius of gyration.
pub const MOST_MOMENT: f64 = 1e12;
/// Hinges that turn farther than this have no limit: files say 1e16 or infinity.
const UNLIMITED_RAD: f64 = 1000.0;
/// What the engine's single precision may differ by, as a share.
const SINGLE: f64 = 1e-6;

/// What is wrong with the two formats' texts in the same way.
#[derive(Debug, Clone, Copy)]
pub struct Format {
    /// Its root element.
    pub root: &'static str,
    /// The other format's root element.
    pub other_root: &'static str,
    /// How files of the other format are named.
    pub other_ending: &'static str,
    /// Elements that take in other files.
    pub other_files: &'static [&'static str],
}

/// Refuses a text that would take a parser's memory or stack, that has parts
/// in other files, that is a xacro or of the other format, or that is not XML.
pub fn check_text(text: &str, format: &Format) -> Result<(), ModelError> {
    if text.len() > MOST_BYTES {
        return Err(ModelError::TooLong { bytes: text.len(), most: MOST_BYTES });
    }
    let mut reader = Reader::from_str(text);
    let mut depth = 0_usize;
    loop {
        let (tag, opens) = match reader.read_event().map_err(|e| ModelError::Xml(Box::new(e)))? {
            Event::Eof => return Ok(()),
            Event::DocType(_) => return Err(ModelError::Unsupported { what: "a <!DOCTYPE>".to_owned() }),
            Event::End(_) => {
                depth = depth.saturating_sub(1);
                continue;
            }
            Event::Start(tag) => (tag, true),
            Event::Empty(tag) => (tag, false),
            _ => continue,
        };
        check_xacro(&tag)?;
        // Whatever its prefix: parsers go by the local name.
        let name = tag.local_name();
        if depth == 0 && name.as_ref() == format.other_root.as_bytes() {
            let Format { root, other_root, other_ending, .. } = *format;
            return Err(ModelError::OtherFormat { root, other_root, other_ending });
        }
        if let Some(tag) = format.other_files.iter().find(|tag| tag.as_bytes() == name.as_ref()) {
            return Err(ModelError::Include { tag });
        }
        if depth + 1 > MOST_DEPTH {
            return Err(ModelError::TooDeep { most: MOST_DEPTH });
        }
        depth += usize::from(opens);
    }
}

/// Refuses what xacro has still to expand: its elements, and `${...}` or `$(...)` in
/// an attribute. The namespace alone also remains in expanded files.
fn check_xacro(tag: &BytesStart<'_>) -> Result<(), ModelError> {
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    let is_xacro = tag.name().prefix().is_some_and(|prefix| prefix.as_ref() == b"xacro");
    if is_xacro {
        return Err(ModelError::Xacro { what: format!("<{}>", text(tag.name().as_ref())) });
    }
    // Attributes that are not well formed are the parser's to tell.
    let mut attributes = tag.attributes();
    let mut values = attributes.with_checks(false).flatten().map(|attribute| text(&attribute.value));
    match values.find(|value| value.contains("${") || value.contains("$(")) {
        Some(what) => Err(ModelError::Xacro { what: format!("{what:?}") }),
        None => Ok(()),
    }
}

/// Refuses NaN and numbers beyond +-1000.
pub fn check_numbers(what: impl Fn() -> String, values: &[f64]) -> Result<(), ModelError> {
    check_within(what, values, MOST)
}

/// Refuses NaN and numbers beyond +-`most`.
pub fn check_within(what: impl Fn() -> String, values: &[f64], most: f64) -> Result<(), ModelError> {
    match values.iter().find(|value| !(-most..=most).contains(*value)) {
        Some(value) => Err(ModelError::Number { what: what(), value: *value, most }),
        None => Ok(()),
    }
}

/// Limits of any size as the loaders take them: what is beyond every hinge's
/// turn becomes +-1000 rad.
pub fn bounded_limits(limits_rad: [f64; 2]) -> [f64; 2] {
    // NaN remains, and is refused.
    limits_rad.map(|limit_rad| limit_rad.clamp(-UNLIMITED_RAD, UNLIMITED_RAD))
}

/// What the file said, up to seven digits: loaders keep single precision, and
/// 0.055 in it is not the double precision's.
fn wide(value: Real) -> f64 {
    value.to_string().parse().unwrap_or(f64::from(value))
}

/// A frame.
pub fn frame(pose: &Pose) -> Isometry3<f64> {
    let [x, y, z] = pose.translation.to_array().map(wide);
    let [i, j, k, w] = pose.rotation.to_array().map(f64::from);
    let turn = UnitQuaternion::from_quaternion(Quaternion::new(w, i, j, k));
    Isometry3::from_parts(Translation3::new(x, y, z), turn)
}

/// How far a hinge turns from where it is drawn, if anything stops it.
pub fn range_rad(joint: &GenericJoint) -> Option<[f64; 2]> {
    joint.limits(JointAxis::AngX).map(|limits| [wide(limits.min), wide(limits.max)])
}

/// A body's inertia, and the mass that the file says in double precision, if
/// that is what the loader took.
pub fn inertia(body: &RigidBody, said_kg: Option<f64>) -> Inertia {
    let Some(RigidBodyAdditionalMassProps::MassProps(mass)) =
        body.mass_properties().additional_local_mprops.as_deref()
    else {
        return Inertia::none();
    };
    let turn = frame(&Pose::from_parts(Vector::ZERO, mass.principal_inertia_local_frame)).rotation;
    let turn = turn.to_rotation_matrix();
    let moments = Vector3::from(mass.principal_inertia().to_array().map(f64::from));
    Inertia {
        mass_kg: said_kg
            .filter(|said| (said - f64::from(mass.mass())).abs() < SINGLE * said)
            .unwrap_or_else(|| wide(mass.mass())),
        centre_m: mass.local_com.to_array().map(wide).into(),
        tensor_kg_m2: turn.matrix() * Matrix3::from_diagonal(&moments) * turn.matrix().transpose(),
    }
}

/// A shape to touch with.
pub fn solid(body: &str, collider: &Collider) -> Result<Solid, ModelError> {
    let pose = frame(collider.position());
    // Ours stand along z, rapier's along y.
    let upright = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), -core::f64::consts::FRAC_PI_2);
    match collider.shape().as_typed_shape() {
        TypedShape::Ball(ball) => Ok(Solid { pose, shape: Shape::Ball { radius_m: wide(ball.radius) } }),
        TypedShape::Cuboid(cuboid) => {
            let half_m = Vector3::from(cuboid.half_extents.to_array().map(wide));
            Ok(Solid { pose, shape: Shape::Cuboid { half_m } })
        }
        TypedShape::Capsule(capsule) => {
            let end = |point: Vector| Vector3::from(point.to_array().map(wide));
            let (from, to) = (end(capsule.segment.a), end(capsule.segment.b));
            let along = to - from;
            let turn = UnitQuaternion::rotation_between(&Vector3::z(), &along).unwrap_or_else(|| {
                UnitQuaternion::from_axis_angle(&Vector3::x_axis(), core::f64::consts::PI)
            });
            let middle = Isometry3::from_parts(((from + to) / 2.0).into(), turn);
            let shape = Shape::Capsule { half_m: along.norm() / 2.0, radius_m: wide(capsule.radius) };
            Ok(Solid { pose: pose * middle, shape })
        }
        TypedShape::Cylinder(cylinder) => {
            let shape =
                Shape::Cylinder { half_m: wide(cylinder.half_height), radius_m: wide(cylinder.radius) };
            Ok(Solid { pose: pose * upright, shape })
        }
        _ => Err(ModelError::Shape {
            body: body.to_owned(),
            shape: "shape of another kind",
            looks: "none touches",
        }),
    }
}
