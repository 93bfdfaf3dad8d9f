//! The gaits that are compared on one pair of legs, and where they come from.
//!
//! Holds the layout of a folder of gaits, the folders that come with the program
//! (`host/gaits/ant-1L`, `ant-0.6L`), and the common stroke: whatever a method
//! calls 1.0, here [`OWN_STROKE`] is the stroke that its gait was found at.
//! Does not depend on the plan: what a folder lacks is left out.
//!
//! A folder holds `original.csv` and `spread.csv` (the averaged stride and its
//! spread), `psto.toml`, `ours.toml`, `sinusoid.toml`, `searched.toml` (gait
//! files), `learning/` (a curve for each seed) and `made.toml` (the commands).

mod bundled;
mod error;

pub use bundled::unpack;
pub use error::MaterialsError;

use super::method::{Method, OWN_STROKE, Origin};
use crate::gait::fit::Scale;
use crate::gait::gait_file::{GaitFile, GaitFileError, Provenance, Source, gait_sha256};
use crate::gait::gait_player::Playable;
use crate::gait::sampled_gait;
use crate::gait::stride::Sample;
use crate::gait::trajectory::Trajectory;
use crate::learn::curves::RunCurves;
use crate::robot::Robot;
use crate::run_folder::FileError;
use protocol::gait::{MAX_ENCODED_LEN, MAX_ROWS};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::Path;

/// The averaged stride of PSTO's policy.
pub const STRIDE: &str = "original.csv";
/// Its spread.
pub const SPREAD: &str = "spread.csv";
/// A folder a seed, each with a learning curve.
pub const LEARNING: &str = "learning";
/// The commands that made each gait.
pub const MADE: &str = "made.toml";

/// How a gait was made.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Made {
    /// Random seed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub seed: Option<u64>,
    /// Share of the full effort that it was made with.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub effort: Option<f64>,
    /// Simulated time that was spent to make it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub simulated_s: Option<f64>,
    /// Wall-clock time that was spent to make it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub wall_s: Option<f64>,
    /// The commands, in their order.
    pub commands: Vec<String>,
}

/// `made.toml`: by method.
pub type MadeFile = BTreeMap<String, Made>;

/// The origin of a gait.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct GaitNote {
    /// The method that made it.
    pub method: Method,
    /// The commands that made it.
    pub command: String,
    /// Of those commands.
    pub seed: Option<u64>,
    /// Simulated time that was spent to make it.
    pub simulated_s: Option<f64>,
    /// Duration of a stride.
    pub period_s: f64,
    /// SHA-256 of the table that is played.
    pub gait_sha256: String,
    /// Wall-clock time that was spent to make it, where it was made for this study.
    pub prepare_wall_s: Option<f64>,
    /// A difference between the gait and what is played.
    pub remark: Option<String>,
}

/// The averaged stride of PSTO's policy: Figure 4.
#[derive(Debug, Clone, PartialEq)]
pub struct LearnedStride {
    /// Duration.
    pub period_s: f64,
    /// Evenly spaced over it, in actions: 1 is 45 degrees at the policy's own stroke.
    pub samples: Vec<Sample>,
    /// Standard deviation over strides and trials, as many.
    pub deviations: Vec<Sample>,
}

/// A gait as a robot plays it.
#[derive(Debug, Clone)]
pub struct Material {
    /// The table, at the common stroke.
    pub playable: Playable,
    /// What the report says of it.
    pub note: GaitNote,
}

/// All that is known for one pair of legs.
#[derive(Debug, Clone)]
pub struct Materials {
    /// The robot that walks.
    pub robot: Robot,
    /// In the order of [`Method::all`].
    pub gaits: Vec<Material>,
    /// How PSTO's policy learned.
    pub learning: Option<RunCurves>,
    /// What it learned.
    pub stride: Option<LearnedStride>,
}

/// The file of a method's gait in a folder of gaits.
#[must_use]
pub fn file_name(method: Method) -> String {
    match method.spec().origin {
        Origin::Stride => STRIDE.to_owned(),
        _ => format!("{}.toml", method.name()),
    }
}

/// The folder's name for a robot's gaits.
#[must_use]
pub fn folder_name(robot: &Robot) -> String {
    let name: String = robot
        .name
        .chars()
        .map(|c| if c.is_ascii_alphanumeric() { c.to_ascii_lowercase() } else { '-' })
        .collect();
    format!("{name}-{}L", robot.geometry.leg_scale.value())
}

/// Reads what a folder holds of `methods`; whichever lacks its file is left out.
///
/// # Errors
/// [`MaterialsError`] naming the file that cannot be used.
pub fn read(folder: &Path, robot: &Robot, methods: &[Method]) -> Result<Materials, MaterialsError> {
    let made = read_made(folder)?;
    let stride = folder.join(STRIDE);
    let stride = if stride.exists() { Some(read_stride(folder)?) } else { None };
    let mut gaits = Vec::new();
    for method in Method::gaits().filter(|method| methods.contains(method)) {
        let path = folder.join(file_name(method));
        let Table { bytes, remark, provenance } = match (method.spec().origin, &stride) {
            (Origin::Stride, Some(stride)) => sampled(&path, method, stride, robot)?,
            (Origin::GaitFile | Origin::CommandLine, _) if path.exists() => from_file(&path, method, robot)?,
            _ => continue,
        };
        let playable = Playable::from_bytes(&bytes).map_err(|reason| GaitFileError::Bytes {
            path: path.clone(),
            len: bytes.len(),
            reason,
        })?;
        let made = made.get(method.name()).cloned().unwrap_or_default();
        let known = made.commands.join("; ");
        let note = GaitNote {
            method,
            command: if known.is_empty() { provenance.command.unwrap_or_default() } else { known },
            seed: made.seed.or(provenance.seed),
            simulated_s: made.simulated_s,
            period_s: playable.period_s(),
            gait_sha256: gait_sha256(&bytes),
            prepare_wall_s: made.wall_s,
            remark,
        };
        gaits.push(Material { playable, note });
    }
    let learning = folder.join(LEARNING);
    let label = format!("{} with legs of {}", robot.name, robot.geometry.leg_scale);
    let learning = if learning.exists() { Some(RunCurves::read(&learning, label)?) } else { None };
    Ok(Materials { robot: robot.clone(), gaits, learning, stride })
}

/// Reads `made.toml`; nothing where there is none.
///
/// # Errors
/// [`MaterialsError`] if it cannot be read.
pub fn read_made(folder: &Path) -> Result<MadeFile, MaterialsError> {
    let path = folder.join(MADE);
    match std::fs::read_to_string(&path) {
        Ok(text) => toml::from_str(&text).map_err(|source| MaterialsError::Made { path, source }),
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(MadeFile::new()),
        Err(error) => Err(FileError::on("read", &path)(error).into()),
    }
}

fn read_stride(folder: &Path) -> Result<LearnedStride, MaterialsError> {
    let path = folder.join(STRIDE);
    let stride = Trajectory::read(&path, None)?;
    let rows = stride.actions.len();
    let interval_s = stride.interval_s(0, rows)?.ok_or(MaterialsError::NoTime { path })?;
    let path = folder.join(SPREAD);
    let deviations = Trajectory::read(&path, None)?.actions;
    if deviations.len() != rows {
        return Err(MaterialsError::Spread { path, rows: deviations.len(), expected: rows });
    }
    // The last row leads back to the first.
    Ok(LearnedStride { period_s: interval_s * rows as f64, samples: stride.actions, deviations })
}

/// What is played of a gait, and what is known of it.
struct Table {
    bytes: Vec<u8>,
    remark: Option<String>,
    provenance: Provenance,
}

/// The stride itself, as a sampled table at the scale of gait files.
fn sampled(
    path: &Path,
    method: Method,
    stride: &LearnedStride,
    robot: &Robot,
) -> Result<Table, MaterialsError> {
    let scale = Scale {
        signs: [1.0; protocol::JOINT_COUNT],
        unit_deg: crate::gait::scale::TABLE_DEG_PER_ACTION,
        centre_unit_deg: crate::sim::ant_env::ACTION_DEG,
        centre_offset_deg: 0.0,
        limit_deg: robot.joint_limit_deg,
    };
    let period_us = (stride.period_s * 1e6 + 1e-3).floor() as u32;
    let sampled = sampled_gait::sample(&stride.samples, &scale, method.name(), period_us)
        .map_err(|source| MaterialsError::Sampled { path: path.to_owned(), source })?;
    let mut buffer = [0; MAX_ENCODED_LEN];
    // A table that was quantised is valid, and the longest fits.
    let bytes = sampled.table.encode(&mut buffer).map(<[u8]>::to_vec).unwrap_or_default();
    let remark = format!(
        "{} rows a stride, played as the {} samples that a table holds, with straight lines between: up to {:.2} \
         degrees from the rows at 1.0x",
        sampled.recorded_rows,
        sampled.recorded_rows.min(MAX_ROWS),
        sampled.worst_deg
    );
    Ok(Table { bytes, remark: Some(remark), provenance: Provenance::of(Source::Trained) })
}

/// A gait file's table, at the common stroke.
fn from_file(path: &Path, method: Method, robot: &Robot) -> Result<Table, MaterialsError> {
    let mut gait = GaitFile::load(path)?;
    // A searched gait is found at its file's 1.0, the others at a policy's own stroke.
    if gait.provenance.source == Source::Searched {
        for joint in &mut gait.joints {
            joint.coefficients_deg.iter_mut().for_each(|c| *c /= OWN_STROKE);
        }
    }
    method.name().clone_into(&mut gait.name);
    let encoded = gait.encoded();
    let bytes = encoded.map_err(|source| GaitFileError::Unusable { path: path.to_owned(), source })?;
    let leg = robot.geometry.leg_scale;
    let others = gait.provenance.leg_scale.filter(|made_for| *made_for != leg);
    let remark = others.map(|made_for| format!("made for legs of {made_for}, walked on {leg}"));
    Ok(Table { bytes, remark, provenance: gait.provenance })
}
