//! The gaits that are compared on one pair of legs, and where they come from.
//!
//! Owns the layout of a folder of gaits, the folders that come with the program
//! (`host/gaits/ant-1L`, `ant-0.6L`), and the common stroke: whatever a method
//! calls 1.0, here [`OWN_STROKE`] is the stroke that its gait was found at.
//! Refuses a folder that lacks what the plan asks for.
//!
//! A folder holds `original.csv` and `spread.csv` (the averaged stride and its
//! spread), `psto.toml`, `ours.toml`, `sinusoid.toml`, `searched.toml` (gait
//! files), `learning/` (a curve a seed) and `made.toml` (the commands).

mod error;

pub use error::MaterialsError;

use super::method::{Method, OWN_STROKE};
use super::study::{GaitNote, LearnedStride};
use crate::gait::fit::Scale;
use crate::gait::gait_file::{GaitFile, GaitFileError, Provenance, Source, gait_sha256};
use crate::gait::gait_player::Playable;
use crate::gait::sampled_gait;
use crate::gait::trajectory::Trajectory;
use crate::learn::curves::RunCurves;
use crate::robot::Robot;
use crate::run_folder::{self, FileError};
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

/// The files that come with the program.
macro_rules! files {
    ($leg:literal: $($name:literal),* $(,)?) => {
        &[$(($name, include_str!(concat!("../../gaits/", $leg, "/", $name)))),*]
    };
}

const LONG: &[(&str, &str)] = files!("ant-1L":
    "original.csv", "spread.csv", "psto.toml", "ours.toml", "sinusoid.toml", "searched.toml",
    "learning/seed-0/train.csv", "learning/seed-1/train.csv", "made.toml",
);
const SHORT: &[(&str, &str)] = files!("ant-0.6L":
    "original.csv", "spread.csv", "psto.toml", "ours.toml", "sinusoid.toml", "searched.toml",
    "learning/seed-0/train.csv", "learning/seed-1/train.csv", "made.toml",
);

/// How a gait was made.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Made {
    /// Of everything that was drawn.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub seed: Option<u64>,
    /// Share of the full effort that it was made with.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub effort: Option<f64>,
    /// Simulated time that its making took.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub simulated_s: Option<f64>,
    /// Wall-clock time that its making took.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub wall_s: Option<f64>,
    /// In their order.
    pub commands: Vec<String>,
}

/// `made.toml`: by method.
pub type MadeFile = BTreeMap<String, Made>;

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
    /// In the order of [`Method::ALL`].
    pub gaits: Vec<Material>,
    /// How PSTO's policy learned.
    pub learning: Option<RunCurves>,
    /// What it learned.
    pub stride: Option<LearnedStride>,
}

/// The folder's name for a robot's gaits.
#[must_use]
pub fn folder_name(robot: &Robot) -> String {
    let name: String = robot
        .name
        .chars()
        .map(|c| if c.is_ascii_alphanumeric() { c.to_ascii_lowercase() } else { '-' })
        .collect();
    format!("{name}-{}L", robot.geometry.leg_scale)
}

/// Writes the gaits that come with the program, unless the folder has gaits: a study's
/// own are never replaced. `made.toml` comes last, and so tells that all are there.
///
/// # Errors
/// [`MaterialsError::NoneKnown`] for other robots and legs; the disk's reasons.
pub fn unpack(robot: &Robot, folder: &Path) -> Result<(), MaterialsError> {
    let leg = robot.geometry.leg_scale;
    let is_ant = Robot::ant(leg).is_ok_and(|ant| ant == *robot);
    let files = match leg {
        leg if is_ant && (leg - 1.0).abs() < 1e-9 => LONG,
        leg if is_ant && (leg - 0.6).abs() < 1e-9 => SHORT,
        _ => return Err(MaterialsError::NoneKnown { robot: robot.name.clone(), leg }),
    };
    if folder.join(MADE).exists() {
        return Ok(());
    }
    for (name, text) in files {
        let path = folder.join(name);
        if let Some(parent) = path.parent() {
            std::fs::create_dir_all(parent).map_err(FileError::on("create", parent))?;
        }
        run_folder::write(&path, text.as_bytes())?;
    }
    Ok(())
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
    for method in Method::GAITS.into_iter().filter(|method| methods.contains(method)) {
        let path = folder.join(format!("{}.toml", method.name()));
        let Table { bytes, remark, provenance } = match (method, &stride) {
            (Method::Original, Some(stride)) => original(&folder.join(STRIDE), stride, robot)?,
            (Method::Original, None) => continue,
            _ if path.exists() => from_file(&path, method, robot)?,
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
    let label = format!("{} with legs of {} L", robot.name, robot.geometry.leg_scale);
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
fn original(path: &Path, stride: &LearnedStride, robot: &Robot) -> Result<Table, MaterialsError> {
    let scale = Scale {
        signs: [1.0; protocol::JOINT_COUNT],
        unit_deg: crate::sim::ant_env::ACTION_DEG / OWN_STROKE,
        centre_unit_deg: crate::sim::ant_env::ACTION_DEG,
        centre_offset_deg: 0.0,
        limit_deg: robot.joint_limit_deg,
    };
    let period_us = (stride.period_s * 1e6 + 1e-3).floor() as u32;
    let sampled = sampled_gait::sample(&stride.samples, &scale, Method::Original.name(), period_us)
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
    let others = gait.provenance.leg_scale.filter(|made_for| (made_for - leg).abs() > 1e-9);
    let remark = others.map(|made_for| format!("made for legs of {made_for} L, walked on {leg} L"));
    Ok(Table { bytes, remark, provenance: gait.provenance })
}
