//! The geoms of MJCF bodies, as MuJoCo reads them.
//!
//! Holds which are for looks only, and turns those into boxes that the loader
//! does not know. Does not depend on bodies' places or joints.

use super::super::error::ModelError;
use super::super::loaded;
use super::super::warning::RobotWarning;
use super::numbers;
use rapier3d_mjcf::mjcf_rs::Pose;
use rapier3d_mjcf::mjcf_rs::body::{Body, Geom, GeomType};
use rapier3d_mjcf::mjcf_rs::compiler::InertiaFromGeom;
use rapier3d_mjcf::mjcf_rs::glam::{DQuat, DVec3};

/// Foams weigh more; less is probably in g/cm^3.
const LEAST_DENSITY: f64 = 15.0;
const LOOKS: &str = "contype=\"0\" conaffinity=\"0\"";

/// Checks a body's geoms, and drops those that neither touch nor weigh anything.
///
/// # Errors
/// [`ModelError`] for numbers and shapes that cannot be used.
pub fn check(
    name: &str,
    body: &mut Body,
    from_geoms: InertiaFromGeom,
) -> Result<Vec<RobotWarning>, ModelError> {
    let weighs = match from_geoms {
        InertiaFromGeom::True => true,
        InertiaFromGeom::False => false,
        InertiaFromGeom::Auto => body.inertial.is_none(),
    };
    body.geoms.retain(|geom| touches(geom) || (weighs && !is_weightless(geom)));
    let mut warnings = Vec::new();
    for geom in &mut body.geoms {
        if touches(geom) || !matches!(geom.type_, GeomType::Mesh | GeomType::Sdf) {
            check_geom(name, geom)?;
        } else {
            let (why, next) = if from_geoms == InertiaFromGeom::True {
                (
                    "is weighed by its geoms (inertiafromgeom=\"true\")",
                    "leave inertiafromgeom out and give the body an <inertial>",
                )
            } else {
                ("has no <inertial>", "give the body an <inertial>")
            };
            return Err(ModelError::Weighed { body: name.to_owned(), why, shape: kind(geom), next });
        }
        if let (true, None, Some(density)) = (weighs, geom.mass, geom.density)
            && density > 0.0
            && density < LEAST_DENSITY
        {
            warnings.push(RobotWarning::Density { body: name.to_owned(), density });
        }
    }
    Ok(warnings)
}

fn touches(geom: &Geom) -> bool {
    geom.contype != 0 || geom.conaffinity != 0
}

/// Planes and height fields weigh nothing in MuJoCo, whatever they say.
fn is_weightless(geom: &Geom) -> bool {
    matches!(geom.type_, GeomType::Plane | GeomType::Hfield)
        || geom.mass.map_or(geom.density == Some(0.0), |mass_kg| mass_kg == 0.0)
}

fn kind(geom: &Geom) -> &'static str {
    match geom.type_ {
        GeomType::Sphere => "sphere",
        GeomType::Capsule => "capsule",
        GeomType::Cylinder => "cylinder",
        GeomType::Box => "box",
        GeomType::Plane => "plane",
        GeomType::Hfield => "height field",
        GeomType::Ellipsoid => "ellipsoid",
        GeomType::Mesh => "mesh",
        GeomType::Sdf => "distance field",
    }
}

fn check_geom(body: &str, geom: &mut Geom) -> Result<(), ModelError> {
    let what = || format!("a geom of body {body:?}");
    let shape = kind(geom);
    loaded::check_numbers(what, &geom.size)?;
    loaded::check_numbers(what, &numbers(&geom.pose))?;
    loaded::check_numbers(what, &geom.fromto.unwrap_or_default())?;
    loaded::check_numbers(what, &[geom.mass.unwrap_or_default()])?;
    loaded::check_within(
        || format!("the density of {}", what()),
        &[geom.density.unwrap_or_default()],
        loaded::MOST_DENSITY,
    )?;
    for (of, value) in [("mass", geom.mass), ("density", geom.density)] {
        if let Some(value) = value.filter(|value| *value < 0.0) {
            return Err(ModelError::Negative { what: format!("the {of} of {}", what()), value });
        }
    }
    let (count, needs) = match geom.type_ {
        GeomType::Sphere => (1, "1 number, its radius"),
        GeomType::Capsule | GeomType::Cylinder if geom.fromto.is_some() => (1, "1 number, its radius"),
        GeomType::Capsule | GeomType::Cylinder => {
            (2, "2 numbers, its radius and half its length, or 1 and fromto")
        }
        GeomType::Box if geom.fromto.is_some() => (1, "1 number, half its width"),
        GeomType::Ellipsoid if geom.fromto.is_some() && !touches(geom) => (1, "1 number, half its width"),
        GeomType::Box => (3, "3 numbers, half of each side, or 1 and fromto"),
        // Weighed only: it touches with nothing.
        GeomType::Ellipsoid if !touches(geom) => (3, "3 numbers, its half axes, or 1 and fromto"),
        GeomType::Ellipsoid | GeomType::Plane | GeomType::Hfield | GeomType::Mesh | GeomType::Sdf => {
            return Err(ModelError::Shape { body: body.to_owned(), shape, looks: LOOKS });
        }
    };
    if geom.type_ == GeomType::Sphere && geom.fromto.is_some() {
        return Err(ModelError::FromTo { what: what(), shape });
    }
    match geom.size[..count].iter().find(|size| **size <= 0.0) {
        Some(0.0) => return Err(ModelError::Size { what: what(), shape, size: geom.size, needs }),
        Some(size) => {
            return Err(ModelError::NotPositive { what: format!("a size of {}", what()), value: *size });
        }
        None => {}
    }
    if let Some(ends) = geom.fromto {
        between(geom, ends, what)?;
    }
    if geom.type_ == GeomType::Ellipsoid {
        weigh_as_box(geom);
    }
    Ok(())
}

/// A box or ellipsoid between two points: as wide either way as its first size.
fn between(geom: &mut Geom, ends: [f64; 6], what: impl Fn() -> String) -> Result<(), ModelError> {
    let [from, to] = [DVec3::new(ends[0], ends[1], ends[2]), DVec3::new(ends[3], ends[4], ends[5])];
    let length = (to - from).length();
    if length < 1e-9 {
        return Err(ModelError::NotPositive {
            what: format!("the length between the ends (fromto) of {}", what()),
            value: length,
        });
    }
    // The loader does rods itself.
    if matches!(geom.type_, GeomType::Box | GeomType::Ellipsoid) {
        let turn = DQuat::from_rotation_arc(DVec3::Z, (to - from) / length);
        geom.pose = Pose::from_parts((from + to) * 0.5, turn);
        geom.size = [geom.size[0], geom.size[0], length / 2.0];
        geom.fromto = None;
    }
    Ok(())
}

/// The box with an ellipsoid's mass and moments: `m/3 half^2 = m/5 axis^2`.
fn weigh_as_box(geom: &mut Geom) {
    let [a, b, c] = geom.size;
    let volume_m3 = 4.0 / 3.0 * core::f64::consts::PI * a * b * c;
    // 1000 kg/m^3 is MuJoCo's default.
    geom.mass = Some(geom.mass.unwrap_or(geom.density.unwrap_or(1000.0) * volume_m3));
    geom.size = geom.size.map(|axis| axis * 0.6_f64.sqrt());
    geom.type_ = GeomType::Box;
}
