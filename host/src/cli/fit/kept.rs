//! What of the policy's speed the curve keeps when nothing corrects it.
//!
//! Owns the comparison: the gait, open loop, at the policy's own stroke and
//! period, in the twin in which the policy was recorded. Refuses to compare
//! with a `record.json` that is of another trajectory. Whatever goes wrong here
//! is a warning: the gait is written by then.

use super::joined::Seams;
use super::pace::Pace;
use crate::cli::recording::Chosen;
use crate::fit::R2_WARNING;
use crate::fit::speeds::fastest;
use crate::gait_file::GaitFile;
use crate::playable::Playable;
use crate::robot::Robot;
use crate::run_folder::FileError;
use crate::sim::Perturbation;
use crate::sim::open_loop::{Playback, Starts, Trial, play_starts};
use protocol::{Amplitude, Joint};
use serde::{Deserialize, Serialize};
use std::path::PathBuf;
use thiserror::Error;

/// What `host record` leaves beside a trajectory; its own constant needs the learner built in.
const RECORD: &str = "record.json";
/// The curve should keep this much.
pub const SHARE_WARNING: f64 = 0.8;
/// Starts of the comparison; 12 s each.
const STARTS: u32 = 10;
/// Beyond this, net distance says less than the path.
const TURNED_DEG: f64 = 30.0;
/// More strides left out than this, and the average is not what the policy does.
const LEFT_OUT_SHARE: f64 = 0.1;

/// What of `record.json` is of interest here.
#[derive(Debug, Deserialize)]
struct Record {
    period_s: f64,
    speed_m_s: f64,
    power_w: f64,
    #[serde(default)]
    strides_averaged: u32,
    #[serde(default)]
    strides_left_out: u32,
}

/// Why there is no comparison where there should be one.
#[derive(Debug, Error)]
pub enum NoComparison {
    #[error(transparent)]
    File(FileError),
    #[error("{path} is no record of a policy: {source}; `host record` writes it anew")]
    Parse { path: PathBuf, source: serde_json::Error },
    #[error(
        "{path} is of a stride of {record_s:.3} s, the trajectory beside it lasts {recorded_s:.3} s; \
         `host record` writes both anew"
    )]
    Other { path: PathBuf, record_s: f64, recorded_s: f64 },
    #[error(transparent)]
    Diverged(#[from] crate::sim::open_loop::Diverged),
}

/// The curve against the policy.
#[derive(Debug, Clone, Serialize)]
pub struct Kept {
    pub amplitude: f64,
    pub period_s: f64,
    pub starts: u32,
    pub duration_s: f64,
    /// Mean over the starts of net distance over time.
    pub speed_m_s: f64,
    pub power_w: f64,
    pub policy_speed_m_s: f64,
    pub policy_power_w: f64,
    /// Of a policy that walks forward.
    pub share_of_policy_speed: Option<f64>,
    pub fell: usize,
    pub turned_deg: f64,
    pub clipped_share: f64,
    /// What may have cost the speed.
    pub reasons: Vec<String>,
}

impl Kept {
    /// Plays `gait`; none where the trajectory is not a run's own recording, or
    /// the robot does not have the policy's stroke.
    pub fn of(
        chosen: &Chosen,
        robot: &Robot,
        gait: &GaitFile,
        seams: &Seams,
        pace: &Pace,
    ) -> Result<Option<Self>, NoComparison> {
        let (Some(amplitude), Some(record)) = (seams.own_stroke, record(chosen)?) else { return Ok(None) };
        // At the recorded period, however much slower it is to be played.
        let own = GaitFile { period_s: chosen.recorded_s, ..gait.clone() };
        let playable = own.encoded().ok().and_then(|bytes| Playable::from_bytes(&bytes).ok());
        let Some(playable) = playable else { return Ok(None) };
        let playback = Playback::new(&playable, amplitude, robot);
        let trial = Trial::default();
        let starts = Starts { perturbation: Perturbation::default(), seed: 0, count: STARTS };
        let walks = play_starts(robot, &trial, &starts, |time_s| playback.setpoints_rad(time_s))?;
        let count = walks.len().max(1) as f64;
        let speed_m_s = walks.iter().map(|walk| walk.speed_m_s).sum::<f64>() / count;
        let walks_forward = record.speed_m_s > 0.0;
        let mut kept = Self {
            amplitude: amplitude.value(),
            period_s: own.period_s,
            starts: STARTS,
            duration_s: trial.duration_s,
            speed_m_s,
            power_w: walks.iter().map(|walk| walk.mean_power_w).sum::<f64>() / count,
            policy_speed_m_s: record.speed_m_s,
            policy_power_w: record.power_w,
            share_of_policy_speed: walks_forward.then(|| speed_m_s / record.speed_m_s),
            fell: walks.iter().filter(|walk| walk.fell).count(),
            turned_deg: (walks.iter().map(|walk| walk.turned_rad).sum::<f64>() / count).to_degrees(),
            clipped_share: playable.clipped_share(amplitude),
            reasons: Vec::new(),
        };
        kept.reasons = kept.reasons(&record, seams, pace, amplitude);
        Ok(Some(kept))
    }

    fn reasons(&self, record: &Record, seams: &Seams, pace: &Pace, amplitude: Amplitude) -> Vec<String> {
        let mut reasons = Vec::new();
        if self.fell > 0 {
            reasons.push(format!("it fell from {} of {} starts", self.fell, self.starts));
        }
        if self.clipped_share > 0.0 {
            let percent = 100.0 * self.clipped_share;
            reasons.push(format!("joints are held at their limits in {percent:.0} % of the stride"));
        }
        for joint in Joint::ALL {
            if let Some(r2) = seams.taken.fits[joint.index()].series.r2.filter(|&r2| r2 < R2_WARNING) {
                let percent = 100.0 * r2;
                reasons.push(format!("{}'s curve keeps {percent:.0} % of its variance", joint.name()));
            }
        }
        if let Some((joint, deg_s)) =
            seams.taken.at_own_stroke.as_ref().map(fastest).filter(|&(_, deg_s)| deg_s > pace.servo_deg_s)
        {
            let (servo_deg_s, at) = (pace.servo_deg_s, amplitude.value());
            let name = joint.name();
            reasons.push(format!("{name} is to turn at {deg_s:.0} degrees/s at {at}x, of {servo_deg_s:.0}"));
        }
        let strides = record.strides_averaged.saturating_add(record.strides_left_out);
        if f64::from(record.strides_left_out) > LEFT_OUT_SHARE * f64::from(strides) {
            let left_out = record.strides_left_out;
            reasons.push(format!("{left_out} of the policy's {strides} strides were unlike the average"));
        }
        if self.turned_deg.abs() > TURNED_DEG {
            reasons.push(format!("it turns by {:.0} degrees in {} s", self.turned_deg, self.duration_s));
        }
        reasons
    }

    /// That it keeps too little, and why, as far as anybody knows.
    pub fn warning(&self) -> Option<String> {
        let share = self.share_of_policy_speed.filter(|&share| share < SHARE_WARNING)?;
        let why = if self.reasons.is_empty() {
            "the fit does not say why: the policy answers to what it senses, a curve does not".to_owned()
        } else {
            self.reasons.join("; ")
        };
        Some(format!(
            "open loop it keeps {:.0} % of the policy's speed, below {:.0}: {why}",
            100.0 * share,
            100.0 * SHARE_WARNING
        ))
    }

    /// One line for people.
    pub fn words(&self) -> String {
        let share = self.share_of_policy_speed.map_or(String::new(), |s| format!(", {:.0} %", 100.0 * s));
        format!(
            "open loop at {}x, the policy's own stroke: {:.3} m/s on {:.2} W{share} of the policy's \
             {:.3} m/s on {:.2} W; fell from {} of {} starts",
            self.amplitude,
            self.speed_m_s,
            self.power_w,
            self.policy_speed_m_s,
            self.policy_power_w,
            self.fell,
            self.starts
        )
    }
}

/// What the policy did that the whole trajectory is of, if it says.
fn record(chosen: &Chosen) -> Result<Option<Record>, NoComparison> {
    let path = chosen.path.with_file_name(RECORD);
    if !chosen.is_whole_stride || !path.exists() {
        return Ok(None);
    }
    let text = std::fs::read(&path).map_err(|e| NoComparison::File(FileError::on("read", &path)(e)))?;
    let record: Record =
        serde_json::from_slice(&text).map_err(|source| NoComparison::Parse { path: path.clone(), source })?;
    let (record_s, recorded_s) = (record.period_s, chosen.recorded_s);
    // A hundredth: times in the file are rounded.
    if (record_s - recorded_s).abs() > 0.01 * recorded_s {
        return Err(NoComparison::Other { path, record_s, recorded_s });
    }
    Ok(Some(record))
}
