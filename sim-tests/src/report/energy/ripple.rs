//! A power that pulses within each PWM frame and swings with the gait.
//!
//! A servo's motor is driven right after each of its pulses, the longer the
//! farther it is from where it should be; all pulses begin with the PWM frame. Does
//! not depend on the body.

use std::f64::consts::TAU;

use super::GAIT_PERIOD_S;

/// The electronics' share, constant.
const FLOOR_W: f64 = 0.2;
/// The gait's swing about the mean.
const SWING: f64 = 0.3;

/// What the power does within a PWM frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Shape {
    /// Nothing.
    Flat,
    /// On for this share of the frame.
    Pulse {
        /// Share.
        duty: f64,
    },
    /// Falls from its peak to nothing over this share, as a line.
    Decay {
        /// Share.
        duty: f64,
    },
    /// On twice, a third of a frame apart, for this share each.
    TwoPulses {
        /// Share of each.
        duty: f64,
    },
}

impl Shape {
    /// Power over the mean of the frame, at a phase in [0, 1).
    fn value(self, phase: f64) -> f64 {
        match self {
            Self::Flat => 1.0,
            Self::Pulse { duty } => {
                if phase < duty {
                    1.0 / duty
                } else {
                    0.0
                }
            }
            Self::Decay { duty } => (2.0 / duty * (1.0 - phase / duty)).max(0.0),
            Self::TwoPulses { duty } => {
                let on = phase < duty || (1.0 / 3.0..1.0 / 3.0 + duty).contains(&phase);
                if on { 0.5 / duty } else { 0.0 }
            }
        }
    }

    #[must_use]
    pub fn name(self) -> String {
        match self {
            Self::Flat => "flat".into(),
            Self::Pulse { duty } => format!("pulse of {:.0} %", duty * 100.0),
            Self::Decay { duty } => format!("ramp of {:.0} %", duty * 100.0),
            Self::TwoPulses { duty } => format!("two pulses of {:.0} %", duty * 100.0),
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ripple {
    pub mean_w: f64,
    /// Within a PWM frame.
    pub shape: Shape,
    /// PWM frames a second.
    pub pwm_hz: f64,
}

impl Ripple {
    #[must_use]
    pub fn new(mean_w: f64, shape: Shape, pwm_hz: f64) -> Self {
        Self { mean_w, shape, pwm_hz }
    }

    /// Power at a time.
    #[must_use]
    pub fn power_w(&self, time_s: f64) -> f64 {
        let swing = 1.0 + SWING * (TAU * time_s / GAIT_PERIOD_S).sin();
        let phase = (time_s * self.pwm_hz).fract();
        self.floor_w() + (self.mean_w - self.floor_w()) * swing * self.shape.value(phase)
    }

    #[must_use]
    pub fn peak_w(&self) -> f64 {
        self.floor_w() + (self.mean_w - self.floor_w()) * (1.0 + SWING) * self.shape.value(0.0)
    }

    /// Whether PWM and the firmware's frames drift through each other within a
    /// trial of some seconds; otherwise both see the same moment for ever.
    #[must_use]
    pub fn beats(&self) -> bool {
        const STANDSTILL_HZ: f64 = 0.05;
        (self.pwm_hz - f64::from(protocol::FRAME_RATE_HZ)).abs() > STANDSTILL_HZ
    }

    fn floor_w(&self) -> f64 {
        FLOOR_W.min(self.mean_w / 2.0)
    }
}

#[cfg(test)]
mod tests {
    use crate::report::energy::loads;

    #[test]
    fn every_load_has_the_mean_that_it_says_and_stays_below_its_peak() {
        for ripple in loads(59.838) {
            // Long enough for PWM and gait to meet in every way.
            let values: Vec<f64> = (0..1_200_000).map(|i| ripple.power_w(f64::from(i) * 2e-5)).collect();
            let mean_w = values.iter().sum::<f64>() / values.len() as f64;
            let peak_w = values.iter().copied().fold(0.0, f64::max);

            assert!((mean_w / ripple.mean_w - 1.0).abs() < 2e-3, "{ripple:?}: {mean_w} W");
            assert!(peak_w <= ripple.peak_w() + 1e-9, "{ripple:?}: {peak_w} W");
        }
    }
}
