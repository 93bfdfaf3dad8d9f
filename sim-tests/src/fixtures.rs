//! Named gaits, each with its unquantised formula.
//!
//! Holds the f64 reference that the robot's pulses are compared with. Does not depend
//! on the arithmetic of [`protocol::gait`], nor on files: these gaits are code.

use protocol::gait::COEFFICIENT_COUNT;
use protocol::{Amplitude, Angle, GaitTable, JOINT_COUNT, JointCurve, LEG_COUNT, Name};
use std::f64::consts::{PI, TAU};

/// A gait before it is quantised.
#[derive(Debug, Clone, PartialEq)]
pub struct Gait {
    /// What the robot reports.
    pub name: &'static str,
    /// One stride.
    pub period_s: f64,
    /// What the amplitude scales about.
    pub centre_deg: [f64; JOINT_COUNT],
    /// Chebyshev series of the deviation at amplitude 1.0, order 0 first.
    pub series_deg: [[f64; COEFFICIENT_COUNT]; JOINT_COUNT],
    /// Either way from neutral.
    pub limit_deg: f64,
}

impl Gait {
    /// The best series of degree 10 for any deviation over a stride.
    #[must_use]
    pub fn of(
        name: &'static str,
        period_s: f64,
        centre_deg: [f64; JOINT_COUNT],
        deviation_deg: impl Fn(usize, f64) -> f64,
    ) -> Self {
        let series_deg = std::array::from_fn(|joint| chebyshev_series(|phase| deviation_deg(joint, phase)));
        Self { name, period_s, centre_deg, series_deg, limit_deg: 55.0 }
    }

    /// What the robot is sent.
    ///
    /// # Panics
    /// If the gait does not fit a table: a mistake in this file.
    #[must_use]
    pub fn table(&self) -> GaitTable {
        let limits = (-self.limit_deg, self.limit_deg);
        GaitTable {
            name: Name::new(self.name).expect("a printable name"),
            period_us: (self.period_s * 1e6 + 1e-3).floor() as u32,
            unit: Angle::from_deg(24.0),
            joints: std::array::from_fn(|joint| {
                JointCurve::quantise(self.centre_deg[joint], limits, &self.series_deg[joint])
                    .expect("within the table's range")
            }),
        }
    }

    /// Angle of a joint at a phase in [0, 1), in f64 throughout.
    #[must_use]
    pub fn angle_deg(&self, joint: usize, phase: f64, amplitude: f64) -> f64 {
        let asked = self.centre_deg[joint] + amplitude * evaluate(&self.series_deg[joint], phase);
        asked.clamp(-self.limit_deg, self.limit_deg)
    }
}

/// A diagonal trot: two legs swing while two push, knees lift the swinging ones.
///
/// At 2.2 it reaches 38 degrees.
#[must_use]
pub fn trot() -> Gait {
    // Legs 1 and 3 together, half a stride before 2 and 4. Forward is x: legs 1
    // and 2 point to the left of it and swing forward clockwise.
    let deviation_deg = |joint: usize, phase: f64| {
        let leg = joint % LEG_COUNT;
        let phase = phase + if leg.is_multiple_of(2) { 0.0 } else { 0.5 };
        if joint < LEG_COUNT {
            let forward = if leg < 2 { -1.0 } else { 1.0 };
            forward * 11.0 * (TAU * phase).sin()
        } else {
            // Lifted, that is negative, while the hip swings forward.
            -11.0 * (TAU * phase).cos()
        }
    };
    Gait::of("trot", 1.2, [0.0, 0.0, 0.0, 0.0, 10.0, 10.0, 10.0, 10.0], deviation_deg)
}

/// Every joint at its own harmonic and centre: nothing symmetric hides a swap.
#[must_use]
pub fn medley() -> Gait {
    let centre_deg = std::array::from_fn(|joint| 3.0 * joint as f64 - 10.0);
    Gait::of("medley", 2.7, centre_deg, |joint, phase| {
        let joint = joint as f64;
        (6.0 + joint) * (TAU * phase + joint).sin() + 3.0 * (2.0 * TAU * phase - joint).cos()
    })
}

/// The nearest amplitude that the wire carries.
///
/// # Panics
/// If it lies outside 0.5 to 3.0.
#[must_use]
pub fn amplitude(value: f64) -> Amplitude {
    Amplitude::from_f64(value).expect("within 0.5 to 3.0")
}

/// Sum of `c_k cos(k acos x)`, `x = 2 phase - 1`: a Chebyshev series by its definition.
#[must_use]
pub fn evaluate(series: &[f64; COEFFICIENT_COUNT], phase: f64) -> f64 {
    let angle = (2.0 * phase - 1.0).clamp(-1.0, 1.0).acos();
    series.iter().enumerate().map(|(order, c)| c * (order as f64 * angle).cos()).sum()
}

/// Projects a function of phase on Chebyshev polynomials at 256 Gauss points.
fn chebyshev_series(f: impl Fn(f64) -> f64) -> [f64; COEFFICIENT_COUNT] {
    const POINTS: usize = 256;
    let mut series = [0.0; COEFFICIENT_COUNT];
    for point in 0..POINTS {
        let angle = PI * (point as f64 + 0.5) / POINTS as f64;
        let value = f((angle.cos() + 1.0) / 2.0);
        for (order, c) in series.iter_mut().enumerate() {
            let weight = if order == 0 { 1.0 } else { 2.0 };
            *c += weight / POINTS as f64 * value * (order as f64 * angle).cos();
        }
    }
    series
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_gait_makes_a_valid_table_and_stays_within_its_limits_at_2_2() {
        for gait in [trot(), medley()] {
            assert_eq!(gait.table().validate(), Ok(()), "{}", gait.name);
            let largest = (0..JOINT_COUNT)
                .flat_map(|joint| (0..1000).map(move |i| (joint, f64::from(i) / 1000.0)))
                .map(|(joint, phase)| gait.angle_deg(joint, phase, 2.2).abs())
                .fold(0.0, f64::max);
            assert!(largest < gait.limit_deg, "{} reaches {largest} degrees", gait.name);
        }
    }

    #[test]
    fn the_series_follows_a_sine_to_a_hundredth_of_a_degree() {
        let series = chebyshev_series(|phase| 10.0 * (TAU * phase).sin());

        for i in 0..=100 {
            let phase = f64::from(i) / 100.0;
            assert!((evaluate(&series, phase) - 10.0 * (TAU * phase).sin()).abs() < 0.01, "phase {phase}");
        }
    }
}
