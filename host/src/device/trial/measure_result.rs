//! What `host measure --json` prints, and what a longer command reads of it.
//!
//! Holds the one type that is written and read. Does not depend on how a trial
//! is walked or judged.

use serde::{Deserialize, Serialize};

/// One trial. What is not known is null, never left out.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MeasureResult {
    /// Whether the trial counts: it was walked to its end, and has a cost of transport.
    pub valid: bool,
    /// Why it does not count.
    pub reason: Option<String>,
    /// What to know of a trial that counts, such as that the robot's calibration was another.
    #[serde(default)]
    pub remark: Option<String>,
    /// As the robot stores it.
    pub gait_name: String,
    /// SHA-256 of the table that the robot read back, hexadecimal.
    pub gait_sha256: String,
    /// CRC-32 of the same, eight hexadecimal digits.
    pub gait_crc32: String,
    /// Provenance of the gait, where the folder's own gait file is the one that was walked.
    pub gait_source: Option<String>,
    /// About each joint's centre, 0.5 to 3.0.
    pub amplitude: f64,
    /// Gait frames, without those of the entry.
    pub frames_played: u32,
    /// By the robot's clock.
    pub duration_s: f64,
    /// Of the battery, by the robot's own sensor.
    pub energy_j: f64,
    /// The same by the virtual robot's battery, which has no sensor error.
    pub true_energy_j: Option<f64>,
    /// Net displacement along x and y, from a motion tracker.
    pub displacement_m: Option<[f64; 2]>,
    /// Largest tilt of the body during the trial, from the virtual robot.
    pub max_tilt_rad: Option<f64>,
    /// Energy by duration; null if no gait frame was played.
    pub mean_power_w: Option<f64>,
    /// Net horizontal distance, 0 or more.
    pub distance_m: Option<f64>,
    /// `flag`, `prompt`, or `tracker FILE`; empty if the trial ended before it was asked for.
    pub distance_source: String,
    /// Distance by duration.
    pub speed_m_s: Option<f64>,
    /// Of the robot that walked.
    pub mass_kg: f64,
    /// Dimensionless; see [`crate::energy::cost_of_transport`].
    pub cost_of_transport: Option<f64>,
    /// Gait frames with a joint held at its limit.
    pub clipped_frames: u32,
    /// Power samples that failed or saturated.
    pub missed_samples: u16,
    /// Gait frames of which no telemetry arrived.
    pub lost_telemetry_frames: u32,
    /// Gait frames a second by this computer's clock.
    pub frame_rate_hz: Option<f64>,
    /// Path of the `trials.csv` with this trial.
    pub trials: String,
    /// Path of the trial's telemetry.
    pub telemetry: String,
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Scripts and other commands read these keys: none may go, change its name or be left out.
    #[test]
    fn what_is_printed_has_every_key_and_reads_back_the_same() {
        let result = MeasureResult {
            valid: false,
            reason: Some("the trial was interrupted".into()),
            remark: None,
            gait_name: "walk".into(),
            gait_sha256: "ab".into(),
            gait_crc32: "00000001".into(),
            gait_source: None,
            amplitude: 2.2,
            frames_played: 0,
            duration_s: 0.0,
            energy_j: 0.0,
            true_energy_j: None,
            displacement_m: Some([0.1, -0.2]),
            max_tilt_rad: None,
            mean_power_w: None,
            distance_m: None,
            distance_source: String::new(),
            speed_m_s: None,
            mass_kg: 0.92,
            cost_of_transport: None,
            clipped_frames: 0,
            missed_samples: 0,
            lost_telemetry_frames: 0,
            frame_rate_hz: None,
            trials: "trials.csv".into(),
            telemetry: "telemetry-1.csv".into(),
        };

        let json = serde_json::to_value(&result).unwrap();

        let keys: Vec<&str> = json.as_object().unwrap().keys().map(String::as_str).collect();
        assert_eq!(
            keys,
            [
                "amplitude",
                "clipped_frames",
                "cost_of_transport",
                "displacement_m",
                "distance_m",
                "distance_source",
                "duration_s",
                "energy_j",
                "frame_rate_hz",
                "frames_played",
                "gait_crc32",
                "gait_name",
                "gait_sha256",
                "gait_source",
                "lost_telemetry_frames",
                "mass_kg",
                "max_tilt_rad",
                "mean_power_w",
                "missed_samples",
                "reason",
                "remark",
                "speed_m_s",
                "telemetry",
                "trials",
                "true_energy_j",
                "valid"
            ]
        );
        assert_eq!(serde_json::from_value::<MeasureResult>(json).unwrap(), result);
    }
}
