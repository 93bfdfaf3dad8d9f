//! Whether the robot's servos follow the curve.
//!
//! A gait that is too fast for them even at amplitude 1.0, the smallest of use, is an
//! error: the robot would not walk the curve. A jump at a free seam is only a warning:
//! the authors' own loop has one, their robot walked with it, and a servo is back on
//! the curve a few frames later. Does not depend on how the curve was fitted.

use super::USUAL_AMPLITUDE;
use super::joined::{Joined, Seams};
use crate::cli::explain::failure_with_help;
use crate::cli::{Cause, Failure};
use crate::gait::fit::speeds::{fastest, largest_followed, peak_speeds};
use crate::gait::fit::{R2_WARNING, Seam};
use crate::gait::gait_file::limits::as_typed;
use crate::gait::policy_record::RecordSummary;
use protocol::{Amplitude, FRAME_RATE_HZ, Joint};
use thiserror::Error;

#[derive(Debug, Error)]
#[error(
    "{joint} would have to turn at {fastest_deg_s:.0} degrees/s even at amplitude 1.0; \
     the servos of {robot} do {servo_deg_s:.0}"
)]
struct TooFast {
    joint: &'static str,
    fastest_deg_s: f64,
    robot: String,
    servo_deg_s: f64,
}

/// What the servos can do, and how far that takes the gait.
pub struct Pace {
    pub servo_deg_s: f64,
    /// Up to which amplitude they follow, if to any.
    pub largest_followed: Option<f64>,
}

impl Pace {
    pub fn of(gait: &Joined, servo_deg_s: f64) -> Self {
        Self { servo_deg_s, largest_followed: largest_followed(&gait.playable, servo_deg_s) }
    }

    /// Refuses what they follow at no useful amplitude.
    pub fn check(
        &self,
        seams: &Seams,
        time_stretch: f64,
        robot: &str,
        record: Option<&RecordSummary>,
    ) -> Result<(), Failure> {
        let (joint, fastest_deg_s) = fastest(&seams.taken.at_one);
        if fastest_deg_s <= self.servo_deg_s {
            return Ok(());
        }
        let servo_deg_s = self.servo_deg_s;
        // Up, to a tenth.
        let stretch = (10.0 * time_stretch * fastest_deg_s / servo_deg_s).ceil() / 10.0;
        let crowded = record.and_then(RecordSummary::crowded_strides);
        let mut moves: Vec<String> = too_much(poorest(&seams.taken), crowded).into_iter().collect();
        // Slower, a curve that cannot follow so many strides would still not.
        if crowded.is_none() {
            moves.push(format!("play it slower: --time-stretch {stretch}, or a longer --period"));
        }
        let is_slow = |other: &Joined| fastest(&other.at_one).1 <= servo_deg_s;
        if seams.seam() == Seam::Free && seams.other.as_ref().is_some_and(is_slow) {
            moves.push("join its ends: --seam continuous".to_owned());
        }
        moves.push(match self.largest_followed {
            Some(amplitude) => format!("write it anyway: --lag, and play it at {amplitude}x at most"),
            None => "write it anyway: --lag; its servos will lag at every amplitude".to_owned(),
        });
        moves.push("name a robot with faster servos: --robot FOLDER".to_owned());
        let (joint, robot) = (joint.name(), robot.to_owned());
        let error = TooFast { joint, fastest_deg_s, robot, servo_deg_s };
        Err(failure_with_help(Cause::Input, error, moves.join("; or ")))
    }

    /// What a servo turns from one frame to the next.
    pub fn frame_deg(&self) -> f64 {
        self.servo_deg_s / f64::from(FRAME_RATE_HZ)
    }

    /// Says where the servos stop following, if that is below where the gait is to be played.
    pub fn warning(&self, seams: &Seams) -> Option<String> {
        let usual = Amplitude::from_f64(USUAL_AMPLITUDE);
        let at = |amplitude: Amplitude, words: &str| {
            let peaks = peak_speeds(&seams.taken.playable, amplitude);
            let (joint, deg_s) = fastest(&peaks);
            (deg_s > self.servo_deg_s)
                .then(|| format!("{} at {deg_s:.0} at {}x{words}", joint.name(), as_typed(amplitude)))
        };
        let own = seams.own_stroke.and_then(|amplitude| at(amplitude, ", the policy's own stroke"));
        let asked: Vec<String> = own.into_iter().chain(usual.and_then(|a| at(a, ""))).collect();
        let up_to = self
            .largest_followed
            .map_or("at no amplitude".to_owned(), |a| format!("up to {a}x, beyond that they lag"));
        (!asked.is_empty()).then(|| {
            format!(
                "the servos do {:.0} degrees/s, but must turn {}; they follow {up_to}",
                self.servo_deg_s,
                asked.join(", and ")
            )
        })
    }
}

/// The joint of which the curve keeps least, if that is too little.
fn poorest(joined: &Joined) -> Option<(Joint, f64)> {
    let r2 = |joint: Joint| joined.fits[joint.index()].series.r2.map(|r2| (joint, r2));
    Joint::ALL
        .into_iter()
        .filter_map(r2)
        .filter(|&(_, r2)| r2 < R2_WARNING)
        .min_by(|a, b| a.1.total_cmp(&b.1))
}

/// What to do about a curve that is asked to follow more than it can.
fn too_much(poorest: Option<(Joint, f64)>, crowded: Option<f64>) -> Option<String> {
    let poor = poorest.map(|(joint, r2)| format!("{}'s R2 is {r2:.2}", joint.name()));
    match (crowded, poor) {
        (Some(strides), poor) => Some(format!(
            "record the stride itself, host record without --window: one curve cannot follow {strides:.1} \
             strides{}",
            poor.map_or(String::new(), |poor| format!(" ({poor})"))
        )),
        (None, Some(poor)) => {
            let help = "fit fewer strides at a time, --rows A..B: the curve does not follow the recording";
            Some(format!("{help} ({poor})"))
        }
        (None, None) => None,
    }
}
