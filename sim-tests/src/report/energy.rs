//! The robot's energy against the battery's, under a current that pulses.
//!
//! Holds the trials: the real firmware walks while the supply gives a power that
//! pulses with the servos' PWM and swings with the gait, and its trial energy
//! is compared with what left the battery's terminals meanwhile. Does not depend on
//! other settings of the sensor; what they would give is in [`schemes`].

pub mod ripple;
pub mod schemes;

use super::rig::{Firmware, Rig, RigError};
use crate::devices::servo_driver::{NOMINAL_OSCILLATOR_HZ, OSCILLATOR_SPREAD_HZ};
use crate::nano::CLOCK_HZ;
use protocol::FRAME_RATE_HZ;
use ripple::{Ripple, Shape};
use schemes::SchemeResult;

/// Mean powers of the robot's, from standing to more than its servos take.
const MEANS_W: [f64; 4] = [0.3, 1.0, 3.0, 8.0];
/// 3.05 A at 5 V behind 0.15 ohm, within the sensor's 3.2 A.
const MAX_PEAK_W: f64 = 13.9;
/// A trial is a whole number of these.
pub(crate) const GAIT_PERIOD_S: f64 = 1.2;

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Trial {
    pub ripple: Ripple,
    /// Reported over true, less one, in per cent.
    pub error_percent: f64,
}

#[derive(Debug)]
pub struct Energy {
    /// Of the firmware.
    pub trials: Vec<Trial>,
    /// Of other settings of the sensor, on the same loads.
    pub schemes: Vec<SchemeResult>,
    pub seconds: f64,
}

impl Energy {
    /// The trial that is farthest off, of those whose PWM moves on against the
    /// frames.
    #[must_use]
    pub fn worst(&self) -> Option<Trial> {
        self.worst_of(true)
    }

    /// The same of those whose PWM is in step with the frames, which nine readings
    /// at fixed moments cannot tell apart; none if the PWM's rate is never theirs.
    #[must_use]
    pub fn worst_in_step(&self) -> Option<Trial> {
        self.worst_of(false)
    }

    fn worst_of(&self, beating: bool) -> Option<Trial> {
        let trials = self.trials.iter().copied().filter(|trial| trial.ripple.beats() == beating);
        trials.max_by(|a, b| a.error_percent.abs().total_cmp(&b.error_percent.abs()))
    }

    /// Trials of which the error is within `percent`.
    #[must_use]
    pub fn count_within(&self, percent: f64) -> usize {
        self.trials.iter().filter(|trial| trial.error_percent.abs() <= percent).count()
    }
}

/// The loads that are tried on a firmware whose PWM runs at so many hertz with a
/// nominal oscillator.
///
/// Other chips' oscillators are tried at both ends of their spread, and, if it
/// lies between them, where the PWM runs at the frames' own pace and both see the
/// same moment of each other for ever.
#[must_use]
pub fn loads(nominal_hz: f64) -> Vec<Ripple> {
    let [slowest_hz, fastest_hz] =
        OSCILLATOR_SPREAD_HZ.map(|oscillator_hz| nominal_hz * oscillator_hz / NOMINAL_OSCILLATOR_HZ);
    let in_step = Some(f64::from(FRAME_RATE_HZ)).filter(|hz| (slowest_hz..=fastest_hz).contains(hz));
    let shapes = [
        Shape::Flat,
        Shape::Pulse { duty: 0.1 },
        Shape::Pulse { duty: 0.3 },
        Shape::Pulse { duty: 0.5 },
        Shape::Pulse { duty: 0.75 },
        Shape::Decay { duty: 0.5 },
        Shape::TwoPulses { duty: 0.15 },
    ];
    let mut loads: Vec<Ripple> = MEANS_W
        .into_iter()
        .flat_map(|mean_w| shapes.into_iter().map(move |shape| Ripple::new(mean_w, shape, nominal_hz)))
        .collect();
    for pwm_hz in [slowest_hz, fastest_hz].into_iter().chain(in_step) {
        for mean_w in [1.0, 3.0] {
            loads.push(Ripple::new(mean_w, Shape::Pulse { duty: 0.3 }, pwm_hz));
        }
    }
    loads.retain(|ripple| ripple.peak_w() <= MAX_PEAK_W);
    loads
}

/// Walks under each load.
///
/// # Errors
/// [`RigError`] if the robot does not walk, or sends no telemetry.
pub fn measure(firmware: &Firmware, duration_s: f64) -> Result<Energy, RigError> {
    let periods = (duration_s / GAIT_PERIOD_S).round().max(1.0);
    let seconds = periods * GAIT_PERIOD_S;
    let nominal_hz = Rig::started(firmware)?.robot.nano().bus().servo_driver.frequency_hz();
    let loads = loads(nominal_hz);
    let mut trials = Vec::with_capacity(loads.len());
    for &ripple in &loads {
        trials.push(trial(firmware, ripple, seconds)?);
    }
    let schemes = schemes::SCHEMES.into_iter().map(|scheme| scheme.try_on(&loads, seconds)).collect();
    Ok(Energy { trials, schemes, seconds })
}

fn trial(firmware: &Firmware, ripple: Ripple, duration_s: f64) -> Result<Trial, RigError> {
    let mut rig = Rig::started(firmware)?;
    rig.robot.set_load(move |time_s| ripple.power_w(time_s));
    rig.walk()?;
    // The first frames of a trial may still hold the sample before it.
    rig.client.run_for(&mut rig.robot, 0.2)?;
    let began = rig.robot.now();
    rig.client.run_for(&mut rig.robot, duration_s + 0.1)?;

    // Two samples a whole number of the load's periods apart: what the sensor
    // lags behind is then the same at both ends.
    let frames = (duration_s * f64::from(FRAME_RATE_HZ)).round() as u32;
    let at = |wanted: Option<u32>| {
        rig.client
            .telemetry()
            .find(|(cycle, sample)| {
                *cycle >= began && wanted.is_none_or(|frame| sample.trial_frames == frame)
            })
            .ok_or(RigError::Unseen("telemetry of the trial"))
    };
    let (first_at, first) = at(None)?;
    let (_, last) = at(Some(first.trial_frames + frames))?;
    let last_at = first_at + u64::from(frames) * CLOCK_HZ / u64::from(FRAME_RATE_HZ);
    let energy_at = |cycle| rig.robot.load_energy_j_at(cycle).ok_or(RigError::Unseen("true energy"));
    let true_j = energy_at(last_at)? - energy_at(first_at)?;
    let reported_j = last.trial_energy_uj.saturating_sub(first.trial_energy_uj) as f64 * 1e-6;
    Ok(Trial { ripple, error_percent: 100.0 * (reported_j / true_j - 1.0) })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pwm_in_step_with_the_frames_is_tried_where_some_chip_runs_so() {
        let is_in_step = |ripple: &&Ripple| (ripple.pwm_hz - 60.0).abs() < 1e-9;

        // Prescalers 101 and 105.
        assert_eq!(loads(59.838).iter().filter(is_in_step).count(), 2);
        assert_eq!(loads(57.580).iter().filter(is_in_step).count(), 0);
        assert!(loads(57.580).iter().any(|ripple| (ripple.pwm_hz - 58.73).abs() < 0.01), "the fastest chip");
    }
}
