//! How much of the policy's speed the curve keeps without feedback.
//!
//! Plays the gait open loop at the policy's own stroke and period, on the robot that
//! the policy was recorded on. There is no comparison where the robot, the period, a
//! sign or a centre was changed. A failure here is only a warning, because the gait is
//! already written. Does not depend on how the result is shown.

use super::joined::Seams;
use super::pace::Pace;
use super::policy_record::BadRecord;
use crate::cli::recording::Chosen;
use crate::gait::fit::speeds::{fastest, peak_speeds};
use crate::gait::fit::{R2_WARNING, Scale};
use crate::gait::gait_file::{GaitFile, UnusableGait};
use crate::gait::gait_player::Playable;
use crate::gait::policy_record::RecordSummary;
use crate::robot::{LegScale, Robot, RobotError};
use crate::sim::Perturbation;
use crate::sim::ant_env::ACTION_DEG;
use crate::sim::open_loop::{Diverged, Playback, Starts, Trial, play_starts};
use protocol::gait::GaitError;
use protocol::{Amplitude, Joint};
use serde::Serialize;
use std::path::Path;
use thiserror::Error;

/// A smaller share of the policy's speed is warned of.
pub const SHARE_WARNING: f64 = 0.8;
/// Starts of the comparison; 12 s each.
const STARTS: u32 = 10;
/// Beyond this, much of the walk is not forward.
const TURNED_DEG: f64 = 30.0;
/// More strides left out than this, and the average is not what the policy does.
const LEFT_OUT_SHARE: f64 = 0.1;

/// Why there is no comparison where there should be one.
#[derive(Debug, Error)]
pub enum NoComparison {
    #[error(transparent)]
    Record(#[from] BadRecord),
    #[error("it walked in strides of {record_s:.3} s; --period says {recorded_s:.3} s")]
    Period { record_s: f64, recorded_s: f64 },
    #[error("it walked as {own} with legs of {own_leg}; this gait is for {robot} with legs of {leg}")]
    Robot { own: String, own_leg: LegScale, robot: String, leg: LegScale },
    #[error("its joints turn and stand as recorded; {flag} says otherwise")]
    Scale { flag: &'static str },
    #[error("the robot has no amplitude for its stroke: {ACTION_DEG} degrees an action, {unit_deg} at 1x")]
    Stroke { unit_deg: f64 },
    #[error("the run's own robot cannot be read")]
    Unreadable(#[from] RobotError),
    #[error("the policy's own stride is not a gait")]
    Unusable(#[from] UnusableGait),
    #[error("the policy's own stride is not a gait: {}", crate::gait::gait_file::describe(*.0))]
    Undecodable(GaitError),
    #[error(transparent)]
    Diverged(#[from] Diverged),
}

/// The speed of the curve without feedback, and of the policy.
#[derive(Debug, Clone, Serialize)]
pub struct OpenLoopComparison {
    pub amplitude: f64,
    /// The policy's; the gait's may be another.
    pub period_s: f64,
    pub starts: u32,
    pub duration_s: f64,
    /// Mean over the starts of the way forward over time, as the policy's.
    pub speed_m_s: f64,
    pub power_w: f64,
    pub policy_speed_m_s: f64,
    pub policy_power_w: f64,
    /// Of a policy that walks forward.
    pub share_of_policy_speed: Option<f64>,
    pub fell: usize,
    pub turned_deg: f64,
    pub clipped_share: f64,
    /// What may have reduced the speed.
    pub reasons: Vec<String>,
}

impl OpenLoopComparison {
    /// Plays `gait` on the robot of the policy that `record` is of.
    pub fn of(
        chosen: &Chosen,
        robot: &Robot,
        gait: &GaitFile,
        seams: &Seams,
        pace: &Pace,
        record: &RecordSummary,
    ) -> Result<Self, NoComparison> {
        check_as_recorded(chosen, robot, record)?;
        let stroke = NoComparison::Stroke { unit_deg: chosen.scale.unit_deg };
        let amplitude = seams.own_stroke.ok_or(stroke)?;
        // At the recorded period, however much slower it is to be played.
        let own = GaitFile { period_s: chosen.recorded_s, ..gait.clone() };
        let playable = Playable::from_bytes(&own.encoded()?).map_err(NoComparison::Undecodable)?;
        let playback = Playback::new(&playable, amplitude, robot);
        let trial = Trial::default();
        let starts = Starts { perturbation: Perturbation::default(), seed: 0, count: STARTS };
        let walks = play_starts(robot, &trial, &starts, |time_s| playback.setpoints_rad(time_s))?;
        let count = walks.len().max(1) as f64;
        let forward_m = walks.iter().map(|walk| walk.displacement_m[0]).sum::<f64>() / count;
        let speed_m_s = forward_m / trial.duration_s;
        let walks_forward = record.speed_m_s > 0.0;
        let mut comparison = Self {
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
        comparison.reasons = comparison.reasons(record, seams, pace, &playable, amplitude);
        Ok(comparison)
    }

    fn reasons(
        &self,
        record: &RecordSummary,
        seams: &Seams,
        pace: &Pace,
        playable: &Playable,
        amplitude: Amplitude,
    ) -> Vec<String> {
        let mut reasons = Vec::new();
        if self.fell > 0 {
            reasons.push(format!("it fell from {} of {} starts", self.fell, self.starts));
        }
        if self.clipped_share > 0.0 {
            let percent = 100.0 * self.clipped_share;
            reasons.push(format!("joints are held at their limits in {percent:.0} % of the stride"));
        }
        let r2 = |joint: Joint| seams.taken.fits[joint.index()].series.r2.map(|r2| (joint, r2));
        let poor: Vec<String> = Joint::ALL
            .into_iter()
            .filter_map(r2)
            .filter(|&(_, r2)| r2 < R2_WARNING)
            .map(|(joint, r2)| format!("{} {:.0} %", joint.name(), percent(r2)))
            .collect();
        if !poor.is_empty() {
            reasons.push(format!("curves keep too little of their variance: {}", poor.join(", ")));
        }
        let (joint, deg_s) = fastest(&peak_speeds(playable, amplitude));
        if deg_s > pace.servo_deg_s {
            let (servo_deg_s, at) = (pace.servo_deg_s, amplitude.value());
            let name = joint.name();
            reasons.push(format!(
                "{name} must turn at {deg_s:.0} degrees/s at {at}x; its servo does {servo_deg_s:.0}"
            ));
        }
        if let Some(strides) = record.crowded_strides() {
            reasons.push(format!("one curve must follow {strides:.1} strides"));
        }
        let strides = record.strides_averaged.saturating_add(record.strides_left_out);
        if record.strides_left_out as f64 > LEFT_OUT_SHARE * strides as f64 {
            let left_out = record.strides_left_out;
            reasons.push(format!("{left_out} of the policy's {strides} strides differed from the average"));
        }
        if self.turned_deg.abs() > TURNED_DEG {
            reasons.push(format!("it turns by {:.0} degrees in {} s", self.turned_deg, self.duration_s));
        }
        reasons
    }

    /// That it keeps too little of the speed, with the likely reasons.
    pub fn warning(&self) -> Option<String> {
        let Some(share) = self.share_of_policy_speed else {
            return Some(format!(
                "the policy itself does not walk forward ({:.3} m/s): there is no speed to compare the gait's with",
                self.policy_speed_m_s
            ));
        };
        if share >= SHARE_WARNING {
            return None;
        }
        let why = if self.reasons.is_empty() {
            "the fit does not show why: unlike the policy, a curve has no feedback".to_owned()
        } else {
            self.reasons.join("; ")
        };
        let keeps = if share < 0.0 {
            format!("it walks backward, at {:.3} m/s, where the policy walks forward", self.speed_m_s)
        } else {
            format!(
                "it keeps {:.0} % of the policy's speed, below {:.0}",
                percent(share),
                100.0 * SHARE_WARNING
            )
        };
        Some(format!("open loop {keeps}: {why}"))
    }

    /// For people; `played_s` is the gait's own period.
    pub fn words(&self, played_s: f64) -> String {
        let share = self.share_of_policy_speed.map_or(String::new(), |s| format!("{:.0} % of ", percent(s)));
        let other = if (played_s - self.period_s).abs() > 1e-6 {
            format!("\nthe gait itself takes {played_s:.3} s a stride, and is so much slower or faster")
        } else {
            String::new()
        };
        format!(
            "open loop at {}x and {:.3} s a stride, the policy's own: forward at {:.3} m/s on {:.2} W,\n\
             {share}the policy's {:.3} m/s on {:.2} W; fell from {} of {} starts{other}",
            self.amplitude,
            self.period_s,
            self.speed_m_s,
            self.power_w,
            self.policy_speed_m_s,
            self.policy_power_w,
            self.fell,
            self.starts
        )
    }
}

/// Down: what is below the bar must not be printed as the bar.
fn percent(share: f64) -> f64 {
    // 0.29 times 100 is a little less than 29.
    (100.0 * share + 1e-9).floor()
}

/// Refuses what is not the walk that was recorded.
fn check_as_recorded(chosen: &Chosen, robot: &Robot, record: &RecordSummary) -> Result<(), NoComparison> {
    let (record_s, recorded_s) = (record.period_s, chosen.recorded_s);
    if !record.lasts(recorded_s) {
        return Err(NoComparison::Period { record_s, recorded_s });
    }
    let folder = chosen.path.parent().unwrap_or(Path::new(""));
    let own = Robot::of_run(folder)?.map_or_else(|| Robot::ant(LegScale::LONG), Ok)?;
    if own != *robot {
        let (own_leg, leg) = (own.geometry.leg_scale, robot.geometry.leg_scale);
        return Err(NoComparison::Robot { own: own.name, own_leg, robot: robot.name.clone(), leg });
    }
    changed(&chosen.scale).map_or(Ok(()), |flag| Err(NoComparison::Scale { flag }))
}

/// The flag that makes joints turn or stand otherwise than the policy had them.
fn changed(scale: &Scale) -> Option<&'static str> {
    let differs = |a: f64, b: f64| (a - b).abs() > 1e-9;
    if scale.signs.iter().any(|&sign| sign < 0.0) {
        Some("--negate")
    } else if differs(scale.centre_unit_deg, ACTION_DEG) {
        Some("--centre-unit-deg")
    } else if differs(scale.centre_offset_deg, 0.0) {
        Some("--centre-offset-deg")
    } else {
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_below_the_bar_is_not_printed_as_the_bar() {
        assert_eq!((percent(0.7999), percent(0.8), percent(-0.001)), (79.0, 80.0, -1.0));
    }
}
