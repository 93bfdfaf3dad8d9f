//! `robot.toml` as people write it: what the drawing says, they may leave out.

use super::drawn::Drawn;
use super::error::{ModelError, RobotError};
use super::sections::{Geometry, Ground, Mass, Model, Power, Servo, Supply, TwinRecord};
use super::{Robot, limbs};
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
    power: Power,
    supply: Supply,
    twin: Option<TwinRecord>,
}

/// What descriptions once said of a geometry.
const NO_LONGER: &str = "hip_twist_rad_per_n_m";

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct GeometryDocument {
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
    // The name is checked before anything of that name is read.
    Drawn::check_name(&model).map_err(|error| refused(file, error))?;
    let model_text = read_model(&model.file)?;
    let (drawn, geometry) = draw(&model, model_text, &geometry)
        .map_err(|error| refused(&file.with_file_name(&model.file), error))?;
    let mass = Mass { torso_kg: mass.torso_kg.unwrap_or(drawn.torso[0].inertia.mass_kg) };
    let drawn = Arc::new(drawn);
    Ok(Robot { name, joint_limit_deg, model, geometry, mass, servo, ground, power, supply, twin, drawn })
}

/// The drawing, and its geometry where the description says nothing.
fn draw(model: &Model, text: String, said: &GeometryDocument) -> Result<(Drawn, Geometry), ModelError> {
    let drawn = Drawn::read(model, text)?;
    let slope = said.shin_below_horizontal_deg.map_or_else(|| limbs::drawn_slope_deg(&drawn), Ok)?;
    let foot_radius_m = said.foot_radius_m.map_or_else(|| limbs::drawn_radius_m(&drawn), Ok)?;
    let geometry = Geometry {
        leg_scale: said.leg_scale.unwrap_or(1.0),
        shin_below_horizontal_deg: slope,
        foot_radius_m,
    };
    Ok((drawn, geometry))
}
