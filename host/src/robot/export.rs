//! The body that is simulated, as a file for other simulators.
//!
//! Holds what both formats need of [`Limbs`]: names, poses at neutral, ranges.
//! What the description changes is applied: leg scale, the shins' slope,
//! torso mass, foot radius; joints read 0 at neutral and turn as far as the
//! tighter of drawn range and end stop. Does not depend on files.

mod mjcf;
mod urdf;

use super::{Inertia, Limbs, Model, Robot, Solid};
use nalgebra::{Isometry3, Vector3};

/// A file format for bodies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// MuJoCo's.
    Mjcf,
    /// ROS's.
    Urdf,
}

impl Format {
    /// Of its files.
    #[must_use]
    pub fn extension(self) -> &'static str {
        match self {
            Self::Mjcf => "xml",
            Self::Urdf => "urdf",
        }
    }
}

/// A body's file, and the `[model]` that names its parts.
#[derive(Debug, Clone, PartialEq)]
pub struct Export {
    /// The file's text.
    pub text: String,
    /// For a robot.toml beside it, in which `[geometry]` and `[mass]` are left out.
    pub model: Model,
}

/// The effective body of a robot; `file` is what the export will be called.
#[must_use]
pub fn export(robot: &Robot, format: Format, file: &str) -> Export {
    let named = |part: &str| core::array::from_fn(|leg| format!("leg{}_{part}", leg + 1));
    let torso = robot.model.torso.clone();
    // Names of ours, unless the torso has one of them.
    let [thighs, shins, feet] = ["thigh", "shin", "foot"].map(|part| {
        let names: [String; 4] = named(part);
        if names.contains(&torso) { named(&format!("{part}_")) } else { names }
    });
    let limbs = Limbs::of(robot);
    let body = Body {
        robot,
        stops_rad: limbs.stops_rad(robot),
        height_m: limbs.standing_height_m(&[0.0; 8]),
        limbs: &limbs,
        thighs: &thighs,
        shins: &shins,
        feet: &feet,
    };
    let model = Model {
        file: file.to_owned(),
        torso,
        hips: robot.model.hips.clone(),
        knees: robot.model.knees.clone(),
        feet: feet.clone(),
        scaled: [thighs.to_vec(), shins.to_vec(), feet.to_vec()].concat(),
    };
    let text = match format {
        Format::Mjcf => mjcf::text(&body),
        Format::Urdf => urdf::text(&body),
    };
    Export { text, model }
}

/// What is written.
struct Body<'r> {
    robot: &'r Robot,
    limbs: &'r Limbs,
    stops_rad: [[f64; 2]; 8],
    height_m: f64,
    thighs: &'r [String; 4],
    shins: &'r [String; 4],
    feet: &'r [String; 4],
}

impl Body<'_> {
    /// What the file is, for its comment.
    fn note(&self) -> String {
        // Two hyphens end a comment in XML.
        let name = self.robot.name.replace("--", "- -").replace("--", "- -");
        format!(
            "{name} as psto simulates it: leg scale, neutral slope, masses and feet of robot.toml are applied.\n    \
             Metres, kilograms, radians; x forward, y left, z up. Joints read 0 at neutral; their ranges are the\n    \
             tighter of drawn range and servo end stop."
        )
    }
}

/// A number as both formats read it.
fn number(value: f64) -> String {
    // -0 would be read back as it is, and looks like a mistake.
    if value == 0.0 { "0".to_owned() } else { value.to_string() }
}

fn numbers(values: &[f64]) -> String {
    values.iter().map(|value| number(*value)).collect::<Vec<_>>().join(" ")
}

fn vector(vector: &Vector3<f64>) -> String {
    numbers(vector.as_slice())
}

/// An attribute's text.
fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('"', "&quot;")
}

/// xx, yy, zz, xy, xz, yz.
fn moments(inertia: &Inertia) -> [f64; 6] {
    let m = &inertia.tensor_kg_m2;
    [m[(0, 0)], m[(1, 1)], m[(2, 2)], m[(0, 1)], m[(0, 2)], m[(1, 2)]]
}

/// A part's solids in another frame.
fn moved(solids: &[Solid], to: &Isometry3<f64>) -> Vec<Solid> {
    solids.iter().map(|solid| solid.moved(to)).collect()
}

#[cfg(test)]
mod tests;
