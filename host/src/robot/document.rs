//! Reads `robot.toml` and the drawing that it names.
//!
//! Holds what is optional in the file: lengths and masses default to the drawing's.
//! Does not depend on the numbers' bounds.

use super::assembly::Assembly;
use super::drawn::Drawn;
use super::error::{ModelError, RobotError};
use super::leg_scale::{LEG_SCALE_RANGE, LegScale};
use super::sections::{Geometry, Ground, Mass, Model, Servo, Supply, TwinRecord};
use super::servo_presets::PowerDocument;
use super::{Robot, limbs, mjcf, plausible, urdf};
use serde::Deserialize;
use std::path::Path;
use std::sync::Arc;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Document {
    name: String,
    joint_limit_deg: f64,
    model: Model,
    #[serde(default)]
    geometry: GeometryDocument,
    #[serde(default)]
    mass: MassDocument,
    servo: Servo,
    ground: Ground,
    power: PowerDocument,
    supply: Supply,
    twin: Option<TwinRecord>,
}

/// What descriptions once said of a geometry.
const NO_LONGER: &str = "hip_twist_rad_per_n_m";

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct GeometryDocument {
    /// Unchecked, so that the refusal names the field as every other does.
    leg_scale: Option<f64>,
    shin_below_horizontal_deg: Option<f64>,
    foot_radius_m: Option<f64>,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct MassDocument {
    torso_kg: Option<f64>,
}

/// A robot from its description's text; `read_model` gives the text of the
/// file that the description names.
///
/// # Errors
/// [`RobotError`] for a text that is none, or a body that cannot be used. The
/// numbers are not checked.
pub fn read(
    text: &str,
    file: &Path,
    read_model: impl FnOnce(&str) -> Result<String, RobotError>,
) -> Result<Robot, RobotError> {
    let document: Document = toml::from_str(text).map_err(|source| {
        let path = file.to_owned();
        let whole = toml::from_str::<toml::Table>(text);
        if let Ok(table) = whole {
            let geometry = table.get("geometry");
            if geometry.is_some() && !table.contains_key("model") {
                return RobotError::OldFile { path };
            }
            if geometry.is_some_and(|geometry| geometry.get(NO_LONGER).is_some()) {
                return RobotError::NoLonger { path, name: NO_LONGER };
            }
        }
        RobotError::Parse { path, source: Box::new(source) }
    })?;
    let Document { name, joint_limit_deg, model, geometry, mass, servo, ground, power, supply, twin } =
        document;
    let refused = |path: &Path, source: ModelError| RobotError::Model {
        path: path.to_owned(),
        source: Box::new(source),
    };
    let leg_scale = geometry.leg_scale.map_or(Ok(LegScale::LONG), LegScale::new).map_err(|_| {
        let (min, max) = LEG_SCALE_RANGE;
        let value = geometry.leg_scale.unwrap_or_default();
        RobotError::OutOfRange { field: "geometry.leg_scale", value, min, max }
    })?;
    // The name is checked before anything of that name is read.
    check_name(&model).map_err(|error| refused(file, error))?;
    let model_text = read_model(&model.file)?;
    let (drawn, geometry) = draw(&model, model_text, &geometry, leg_scale)
        .map_err(|error| refused(&file.with_file_name(&model.file), error))?;
    let mass = match mass.torso_kg {
        Some(torso_kg) => Mass { torso_kg },
        None => Mass {
            torso_kg: plausible::torso_kg(&drawn)
                .map_err(|error| refused(&file.with_file_name(&model.file), error))?,
        },
    };
    let (drawn, power) = (Arc::new(drawn), power.complete(&servo));
    Ok(Robot { name, joint_limit_deg, model, geometry, mass, servo, ground, power, supply, twin, drawn })
}

/// The drawing, and its geometry where the description says nothing.
fn draw(
    model: &Model,
    text: String,
    said: &GeometryDocument,
    leg_scale: LegScale,
) -> Result<(Drawn, Geometry), ModelError> {
    let mut drawn = read_drawing(model, text)?;
    let warnings = plausible::check(&drawn, model)?;
    drawn.warnings.extend(warnings);
    let slope = said.shin_below_horizontal_deg.map_or_else(|| limbs::drawn_slope_deg(&drawn), Ok)?;
    let foot_radius_m = said.foot_radius_m.map_or_else(|| limbs::drawn_radius_m(&drawn), Ok)?;
    let geometry = Geometry { leg_scale, shin_below_horizontal_deg: slope, foot_radius_m };
    Ok((drawn, geometry))
}

/// Reads a body's file, MJCF or URDF by its name.
pub fn read_drawing(model: &Model, text: String) -> Result<Drawn, ModelError> {
    let raw = if model.file.ends_with(".urdf") { urdf::read(&text)? } else { mjcf::read(&text)? };
    Assembly::new(&raw)?.assemble(model, text)
}

/// Accepts only a file beside the description, of one of the two formats.
fn check_name(model: &Model) -> Result<(), ModelError> {
    let known = model.file.ends_with(".xml") || model.file.ends_with(".urdf");
    if known && !model.file.contains(['/', '\\']) {
        return Ok(());
    }
    if model.file.ends_with(".xacro") {
        return Err(ModelError::Xacro { what: format!("the name {}", model.file) });
    }
    Err(ModelError::Name { file: model.file.clone() })
}
