//! One joint's curve in degrees: its values in f64, and its entry in a robot's table.
//!
//! Coefficients and limits that no table holds are an error. Does not depend on the
//! file format.

use super::UnusableGait;
use protocol::JointCurve;
use protocol::gait::{COEFFICIENT_COUNT, COEFFICIENT_UNITS_PER_DEG, MAX_LIMIT_DEG};

/// One joint's curve.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct JointSeries {
    /// Angle that the amplitude scales about.
    pub centre_deg: f64,
    /// Lowest angle the joint may be sent to.
    pub min_deg: f64,
    /// Highest angle the joint may be sent to.
    pub max_deg: f64,
    /// Chebyshev coefficients of the deviation at amplitude 1.0, order 0 first.
    pub coefficients_deg: [f64; COEFFICIENT_COUNT],
    /// Root mean square of what the fit left over, at amplitude 1.0.
    pub residual_rms_deg: Option<f64>,
    /// Share of the trajectory's variance that the fit explains.
    pub r2: Option<f64>,
}

impl JointSeries {
    /// Deviation from the centre at amplitude 1.0, in degrees, at `phase` in 0 to 1.
    #[must_use]
    pub fn deviation_deg(&self, phase: f64) -> f64 {
        chebyshev(&self.coefficients_deg, 2.0 * phase - 1.0)
    }

    /// As the table has it.
    pub(super) fn quantise(&self, joint: &'static str) -> Result<JointCurve, UnusableGait> {
        let within = |field, value: f64, min: f64, max: f64| {
            if (min..=max).contains(&value) {
                Ok(())
            } else {
                Err(UnusableGait::JointValue { joint, field, value, min, max })
            }
        };
        let bound = f64::from(MAX_LIMIT_DEG);
        within("min_deg", self.min_deg, -bound, bound)?;
        within("max_deg", self.max_deg, self.min_deg + 1.0, bound)?;
        within("centre_deg", self.centre_deg, self.min_deg, self.max_deg)?;
        for &coefficient in &self.coefficients_deg {
            let bound = f64::from(i16::MAX) / f64::from(COEFFICIENT_UNITS_PER_DEG);
            within("a coefficient", coefficient, -bound, bound)?;
        }
        let (low, high) = self.deviation_range_deg();
        let too_wide = UnusableGait::Deviation { joint, deviation_deg: high.max(-low) };
        JointCurve::quantise(self.centre_deg, (self.min_deg, self.max_deg), &self.coefficients_deg)
            .ok_or(too_wide)
    }
}

/// `sum c_k T_k(x)` by Clenshaw's recurrence.
#[must_use]
pub fn chebyshev(coefficients: &[f64], x: f64) -> f64 {
    let (mut b1, mut b2) = (0.0, 0.0);
    for &c in coefficients.iter().skip(1).rev() {
        (b1, b2) = (2.0 * x * b1 - b2 + c, b1);
    }
    x * b1 - b2 + coefficients.first().copied().unwrap_or(0.0)
}
