//! Converts the robot's clock to the host's.
//!
//! Messages are late by the cable, the adapter and the scheduler, never early, so
//! the smallest delay among neighbours is the best estimate. There is a window at
//! each end of the trial, because a Nano's resonator may be off by half a percent,
//! which is 60 ms over a trial. Does not depend on what the robot did meanwhile.

use crate::device::session::Sample;
use protocol::FRAME_RATE_HZ;

/// Telemetry this far from a moment is used for its time.
const WINDOW_FRAMES: u32 = 90;

/// A trial on the host's clock.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Interval {
    /// Start of the first gait frame, in Unix time.
    pub start_unix_s: f64,
    /// End of the last.
    pub end_unix_s: f64,
    /// Gait frames a second by the host's clock; the robot's own is 60.
    pub frame_rate_hz: f64,
}

/// When the gait frames of `samples` were played; `None` without telemetry of them.
///
/// A sample is taken as a frame starts and counts the gait frames that have
/// ended, so the first one started `trial_frames` frames before.
#[must_use]
pub fn interval(samples: &[Sample]) -> Option<Interval> {
    let frames = samples.last()?.telemetry.trial_frames;
    // The counter freezes with the last gait frame, so a sample that shows all of them may be later.
    let in_trial = samples.iter().find(|s| (1..frames).contains(&s.telemetry.trial_frames))?;
    let start_frame = in_trial.telemetry.uptime_frames.wrapping_sub(in_trial.telemetry.trial_frames);
    let start_unix_s = host_time_s(samples, start_frame)?;
    let end_unix_s = host_time_s(samples, start_frame.wrapping_add(frames))?;
    let frame_rate_hz = f64::from(frames) / (end_unix_s - start_unix_s);
    frame_rate_hz.is_finite().then_some(Interval { start_unix_s, end_unix_s, frame_rate_hz })
}

/// Host time at the start of a frame, by the promptest of its neighbours.
fn host_time_s(samples: &[Sample], frame: u32) -> Option<f64> {
    let distance = |s: &Sample| s.telemetry.uptime_frames.wrapping_sub(frame) as i32;
    let window = samples.iter().filter(|s| distance(s).unsigned_abs() <= WINDOW_FRAMES);
    window.map(|s| s.unix_time_s - f64::from(distance(s)) / f64::from(FRAME_RATE_HZ)).min_by(f64::total_cmp)
}

#[cfg(test)]
mod tests {
    use super::*;
    use protocol::{State, Telemetry};

    /// 120 entry frames, then 720 gait frames, each sample `delay_s(frame)` late.
    fn samples(rate_hz: f64, delay_s: impl Fn(u32) -> f64) -> Vec<Sample> {
        (0..=845_u32)
            .map(|frame| {
                let telemetry = Telemetry {
                    uptime_frames: frame.wrapping_add(u32::MAX - 300),
                    state: if frame < 120 { State::Entering } else { State::Walking },
                    trial_frames: frame.saturating_sub(120).min(720),
                    trial_energy_uj: 0,
                    clipped_frames: 0,
                    phase: 0,
                    bus_mv: 5000,
                    current_ua: 0,
                    missed_samples: 0,
                };
                Sample { unix_time_s: 1e9 + f64::from(frame) / rate_hz + delay_s(frame), telemetry }
            })
            .collect()
    }

    #[test]
    fn the_trial_starts_with_its_first_gait_frame_and_lasts_all_of_them() {
        let interval = interval(&samples(60.0, |_| 0.0)).unwrap();

        assert!((interval.start_unix_s - (1e9 + 2.0)).abs() < 1e-6, "{interval:?}");
        assert!((interval.end_unix_s - (1e9 + 14.0)).abs() < 1e-6, "{interval:?}");
        assert!((interval.frame_rate_hz - 60.0).abs() < 1e-6);
    }

    /// Two of three messages wait up to 30 ms in the adapter, and around the
    /// start all do but one.
    #[test]
    fn latency_does_not_move_the_trial() {
        let late = |frame: u32| match frame {
            110..=130 if frame != 117 => 0.03,
            _ if frame.is_multiple_of(3) => 0.0,
            _ => 0.016,
        };

        let interval = interval(&samples(60.0, late)).unwrap();

        assert!((interval.start_unix_s - (1e9 + 2.0)).abs() < 1e-6, "{interval:?}");
    }

    /// 0.5 % slow: 12.06 s by the host's clock. The window may err by
    /// 0.5 % of its 1.5 s.
    #[test]
    fn a_slow_resonator_is_seen_at_both_ends() {
        let interval = interval(&samples(60.0 * 0.995, |_| 0.002)).unwrap();

        assert!((interval.frame_rate_hz - 59.7).abs() < 0.05, "{interval:?}");
        assert!((interval.start_unix_s - (1e9 + 2.0101)).abs() < 0.008, "{interval:?}");
        assert!((interval.end_unix_s - (1e9 + 14.0704)).abs() < 0.008, "{interval:?}");
    }

    /// Telemetry of the walk was lost: what is left came 5 frames after its end or later.
    #[test]
    fn a_trial_seen_only_after_its_end_has_no_place_on_the_clock() {
        assert_eq!(interval(&samples(60.0, |_| 0.0)[845..]), None);
    }

    #[test]
    fn a_trial_without_a_gait_frame_has_no_interval() {
        assert_eq!(interval(&samples(60.0, |_| 0.0)[..100]), None);
    }
}
