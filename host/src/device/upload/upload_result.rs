//! What `host upload-gait --json` prints, and what a longer command reads of it.
//!
//! Holds the types that are written and read. Does not depend on how a gait is
//! read, checked or transferred.

use serde::{Deserialize, Serialize};

/// The gait that an upload, or its dry run, is about.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct GaitResult {
    /// Path of the file it comes from.
    pub gait: String,
    /// As the robot stores it.
    pub gait_name: String,
    /// SHA-256 of the table, hexadecimal.
    pub gait_sha256: String,
    /// Its provenance: `trained`, `fitted`, `table`, `sampled` and so on.
    pub gait_source: String,
    /// Duration of a stride at the gait's own speed.
    pub period_s: f64,
    /// Share of the stride in which a joint is held at its limit, 0 to 1.
    pub clipped_share: f64,
    /// What the sampling of a recording costs; null for a polynomial.
    pub sampled: Option<SampledResult>,
}

/// A recording that is played as samples.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SampledResult {
    /// Rows in the table, 2 to [`protocol::gait::MAX_ROWS`].
    pub rows: usize,
    /// Rows in the recording.
    pub recorded_rows: usize,
    /// One step of a sample at amplitude 1.0.
    pub step_deg: f64,
    /// Largest deviation from the recording at amplitude 1.0.
    pub worst_deg: f64,
}

/// A gait that the robot has taken.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct UploadResult {
    /// Which gait.
    #[serde(flatten)]
    pub gait: GaitResult,
    /// Of the robot.
    pub port: String,
    /// As the robot computed it, eight hexadecimal digits.
    pub gait_crc32: String,
    /// That the robot will play it at.
    pub amplitude: f64,
    /// Whether it is kept through power-off.
    pub saved: bool,
    /// From the first byte to the comparison with what the robot read back.
    pub transfer_s: f64,
    /// The same and the saving.
    pub total_s: f64,
}

/// A dry run: what an upload would ask of the robot.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct DryRunResult {
    /// Which gait.
    #[serde(flatten)]
    pub gait: GaitResult,
    /// Always true: tells this from an [`UploadResult`].
    pub dry_run: bool,
    /// That was asked for.
    pub amplitude: f64,
    /// What does not stop the robot, but will not look as planned.
    pub warnings: Vec<String>,
    /// Speed of the robot's servos without load.
    pub servo_deg_s: f64,
    /// Whose calibration the pulses are by, in words.
    pub calibration: String,
    /// In [`protocol::Joint::ALL`] order.
    pub joints: Vec<JointDemandResult>,
}

/// What one joint is asked for over a stride.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct JointDemandResult {
    /// `hip1` to `knee4`.
    pub name: String,
    /// Within the gait's own limits.
    pub lowest_deg: f64,
    /// Within the gait's own limits.
    pub highest_deg: f64,
    /// Largest change from one frame to the next.
    pub fastest_deg_s: f64,
    /// Share of the stride in which it is faster than the servo, 0 to 1.
    pub too_fast_share: f64,
    /// Shortest pulse that the servo is sent.
    pub shortest_us: f64,
    /// Longest pulse that the servo is sent.
    pub longest_us: f64,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_upload_is_one_flat_object_and_reads_back_the_same() {
        let gait = GaitResult {
            gait: "gait.toml".into(),
            gait_name: "walk".into(),
            gait_sha256: "ab".into(),
            gait_source: "trained".into(),
            period_s: 0.5,
            clipped_share: 0.0,
            sampled: None,
        };
        let result = UploadResult {
            gait,
            port: "/dev/ttyUSB0".into(),
            gait_crc32: "00000001".into(),
            amplitude: 2.2,
            saved: true,
            transfer_s: 0.09,
            total_s: 1.2,
        };

        let json = serde_json::to_value(&result).unwrap();

        let keys: Vec<&str> = json.as_object().unwrap().keys().map(String::as_str).collect();
        assert_eq!(
            keys,
            [
                "amplitude",
                "clipped_share",
                "gait",
                "gait_crc32",
                "gait_name",
                "gait_sha256",
                "gait_source",
                "period_s",
                "port",
                "sampled",
                "saved",
                "total_s",
                "transfer_s"
            ]
        );
        assert_eq!(serde_json::from_value::<UploadResult>(json).unwrap(), result);
    }
}
