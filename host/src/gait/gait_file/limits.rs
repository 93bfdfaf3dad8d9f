//! How far a gait may be amplified before a joint leaves its limits.
//!
//! Holds the extremes of the curves. Does not depend on a robot: the limits are data
//! of the gait file.

use super::{GaitFile, JointSeries};
use protocol::{Amplitude, Joint};
use thiserror::Error;

/// Points a curve is searched at before the extreme is refined. A degree-10
/// curve has at most nine extremes; between neighbouring points it is a parabola.
const SEARCH_POINTS: usize = 1024;

/// The last phase before the next stride begins: robots count in 1/65536.
const LAST_PHASE: f64 = 65_535.0 / 65_536.0;

/// The largest amplitude at which a gait stays within its limits, and what stops it there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LargestAmplitude {
    /// Every joint fits up to here; may lie outside 0.5 to 3.0.
    pub amplitude: f64,
    /// The joint that meets its limit first.
    pub joint: Joint,
    /// Where in the stride.
    pub phase: f64,
    /// The limit that it meets.
    pub limit_deg: f64,
}

/// A gait that leaves a joint's limits at the asked amplitude.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[error(
    "at amplitude {amplitude} {} would go to {angle_deg:.1} degrees at phase {phase:.3}; its limit is {limit_deg:.1}",
    .joint.name()
)]
pub struct LeavesLimits {
    /// What was asked.
    pub amplitude: f64,
    /// The joint that would leave its limits the farthest.
    pub joint: Joint,
    /// Where in the stride.
    pub phase: f64,
    /// How far it would go.
    pub angle_deg: f64,
    /// How far it may go.
    pub limit_deg: f64,
    /// What the gait can be played at; `None` if no amplitude of the robot fits.
    pub largest: Option<f64>,
}

impl GaitFile {
    /// The largest amplitude that fits the limits; `None` if no joint moves.
    #[must_use]
    pub fn largest_amplitude(&self) -> Option<LargestAmplitude> {
        let per_side = Joint::ALL.into_iter().flat_map(|joint| {
            let series = &self.joints[joint.index()];
            [(1.0, series.max_deg), (-1.0, series.min_deg)].map(|(sign, limit_deg)| {
                let (phase, deviation_deg) = series.extreme(sign);
                let room = (limit_deg - series.centre_deg) / deviation_deg;
                // A joint that never goes to this side has no limit there.
                let amplitude = if deviation_deg * sign > 0.0 { room } else { f64::INFINITY };
                LargestAmplitude { amplitude, joint, phase, limit_deg }
            })
        });
        per_side.min_by(|a, b| a.amplitude.total_cmp(&b.amplitude)).filter(|l| l.amplitude.is_finite())
    }

    /// Checks that no joint leaves its limits at `amplitude`.
    ///
    /// # Errors
    /// [`LeavesLimits`] for the joint that would leave them the farthest.
    pub fn check_limits(&self, amplitude: f64) -> Result<(), LeavesLimits> {
        let mut worst: Option<(f64, LeavesLimits)> = None;
        for joint in Joint::ALL {
            let series = &self.joints[joint.index()];
            for (sign, limit_deg) in [(1.0, series.max_deg), (-1.0, series.min_deg)] {
                let (phase, deviation_deg) = series.extreme(sign);
                let angle_deg = series.centre_deg + amplitude * deviation_deg;
                let excess_deg = (angle_deg - limit_deg) * sign;
                // Rounding in `largest_amplitude` must not make its own answer unplayable.
                if excess_deg > 1e-9 && worst.is_none_or(|(most, _)| excess_deg > most) {
                    let largest = None;
                    let found = LeavesLimits { amplitude, joint, phase, angle_deg, limit_deg, largest };
                    worst = Some((excess_deg, found));
                }
            }
        }
        let Some((_, mut found)) = worst else { return Ok(()) };
        let least = Amplitude::MIN.value();
        found.largest = self
            .largest_amplitude()
            .map(|l| round_down(l.amplitude).min(Amplitude::MAX.value()))
            .filter(|&l| l >= least);
        Err(found)
    }

    /// Share of the stride in which at least one joint is beyond its limits, 0 to 1.
    #[must_use]
    pub fn clipped_share(&self, amplitude: f64) -> f64 {
        const POINTS: usize = 8192;
        let beyond = |i: &usize| {
            let phase = *i as f64 / POINTS as f64;
            Joint::ALL.into_iter().any(|joint| {
                let series = &self.joints[joint.index()];
                let angle_deg = self.angle_deg(joint, phase, amplitude);
                angle_deg > series.max_deg + 1e-9 || angle_deg < series.min_deg - 1e-9
            })
        };
        (0..POINTS).filter(beyond).count() as f64 / POINTS as f64
    }
}

/// To two decimals, downwards: what is printed can be typed again and fits.
#[must_use]
pub fn round_down(amplitude: f64) -> f64 {
    // 1e-9: 2.2 * 100 is 220.00000000000003, and 2.3 * 100 is 229.99999999999997.
    (amplitude * 100.0 + 1e-9).floor() / 100.0
}

/// The amplitude as it was typed: the robot's is rounded to 1/8192, and back to three decimals here.
#[must_use]
pub fn as_typed(amplitude: Amplitude) -> f64 {
    (amplitude.value() * 1000.0).round() / 1000.0
}

impl JointSeries {
    /// Lowest and highest deviation from the centre at amplitude 1.0, in degrees.
    #[must_use]
    pub fn deviation_range_deg(&self) -> (f64, f64) {
        (self.extreme(-1.0).1, self.extreme(1.0).1)
    }

    /// Phase and value of the highest (`sign` 1) or lowest (-1) deviation.
    fn extreme(&self, sign: f64) -> (f64, f64) {
        let step = 1.0 / SEARCH_POINTS as f64;
        let value = |phase: f64| sign * self.deviation_deg(phase);
        let best = (0..=SEARCH_POINTS)
            .map(|i| (i as f64 * step).min(LAST_PHASE))
            .max_by(|&a, &b| value(a).total_cmp(&value(b)))
            .unwrap_or(0.0);
        // The curve has one extreme between the neighbours: halve towards it.
        let (mut low, mut high) = ((best - step).max(0.0), (best + step).min(LAST_PHASE));
        while high - low > 1e-9 {
            let third = (high - low) / 3.0;
            if value(low + third) < value(high - third) {
                low += third;
            } else {
                high -= third;
            }
        }
        // The ends of the stride count as they are: there the search stops short of them.
        let refined = [best, (low + high) / 2.0];
        let phase = if value(refined[1]) > value(refined[0]) { refined[1] } else { refined[0] };
        (phase, self.deviation_deg(phase))
    }
}
