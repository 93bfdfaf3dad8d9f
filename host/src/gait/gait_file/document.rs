//! The TOML of a gait file: what stands where.

use super::{FILE_VERSION, GaitFile, JointSeries, Provenance, UnusableGait};
use protocol::{JOINT_COUNT, Joint};
use serde::{Deserialize, Serialize};

/// The file as it is written.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Document {
    version: u32,
    name: String,
    period_s: f64,
    unit_deg: f64,
    provenance: Provenance,
    joint: Vec<JointEntry>,
}

#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct JointEntry {
    name: String,
    centre_deg: f64,
    min_deg: f64,
    max_deg: f64,
    coefficients_deg: Vec<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    residual_rms_deg: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    r2: Option<f64>,
}

const HEAD: &str = "\
. angle = centre_deg + amplitude * sum of c_k T_k(2 phase - 1),
# in degrees from the joint's neutral, phase 0 to 1 over one stride.
";

/// Reads the text as far as TOML goes; the values are not looked at yet.
pub(super) fn parse(bytes: &[u8]) -> Result<Document, toml::de::Error> {
    toml::from_slice(bytes)
}

impl GaitFile {
    /// The readable file's text, of a gait that was checked.
    pub(super) fn to_toml(&self) -> String {
        let entry = |joint: Joint| {
            let series = &self.joints[joint.index()];
            JointEntry {
                name: joint.name().into(),
                centre_deg: series.centre_deg,
                min_deg: series.min_deg,
                max_deg: series.max_deg,
                coefficients_deg: series.coefficients_deg.to_vec(),
                residual_rms_deg: series.residual_rms_deg,
                r2: series.r2,
            }
        };
        let document = Document {
            version: FILE_VERSION,
            name: self.name.clone(),
            period_s: self.period_s,
            unit_deg: self.unit_deg,
            provenance: self.provenance.clone(),
            joint: Joint::ALL.into_iter().map(entry).collect(),
        };
        // TOML holds everything here but a seed of 2^63 or more, which `table` refuses.
        let whose = match (&self.provenance.robot, self.provenance.leg_scale) {
            (Some(robot), _) => format!(" of {robot}"),
            (None, Some(_)) => " of the Ant".to_owned(),
            (None, None) => String::new(),
        };
        // A name is for people: it may hold a line's end.
        let whose = whose.replace(['\n', '\r'], " ");
        format!("# A gait{whose}{HEAD}{}", toml::to_string(&document).unwrap_or_default())
    }

    pub(super) fn from_document(document: Document) -> Result<Self, UnusableGait> {
        if document.version != FILE_VERSION {
            return Err(UnusableGait::Version { found: document.version });
        }
        if document.joint.len() != JOINT_COUNT {
            return Err(UnusableGait::JointCount { found: document.joint.len() });
        }
        let mut joints: [Option<JointSeries>; JOINT_COUNT] = Default::default();
        for entry in document.joint {
            let Some(joint) = Joint::from_name(&entry.name) else {
                return Err(UnusableGait::UnknownJoint { name: entry.name });
            };
            let found = entry.coefficients_deg.len();
            let coefficients_deg = entry
                .coefficients_deg
                .try_into()
                .map_err(|_| UnusableGait::CoefficientCount { joint: joint.name(), found })?;
            let series = JointSeries {
                centre_deg: entry.centre_deg,
                min_deg: entry.min_deg,
                max_deg: entry.max_deg,
                coefficients_deg,
                residual_rms_deg: entry.residual_rms_deg,
                r2: entry.r2,
            };
            if joints[joint.index()].replace(series).is_some() {
                return Err(UnusableGait::RepeatedJoint { joint: joint.name() });
            }
        }
        // Eight entries, none unknown, none twice: every place is taken.
        let joints = joints.map(Option::unwrap_or_default);
        Ok(Self {
            name: document.name,
            period_s: document.period_s,
            unit_deg: document.unit_deg,
            provenance: document.provenance,
            joints,
        })
    }
}
