//! The integer setpoint stays within 0.05 degree of the unquantised series,
//! over every phase and the whole range of amplitudes.

use proptest::prelude::*;
use protocol::gait::{COEFFICIENT_COUNT, MAX_DEVIATION_DEG};
use protocol::{Amplitude, JointCurve};

const BOUND_DEG: f64 = 0.05;
/// The bound derived in `gait.rs`; a regression shows here first.
const DERIVED_BOUND_DEG: f64 = 0.0430;

/// `sum c_k T_k(x)`, `x = 2 phase - 1`, by the cosine form: an evaluation
/// that shares nothing with the one under test.
fn series_deg(coefficients: &[f64; COEFFICIENT_COUNT], phase: u16) -> f64 {
    let x = 2.0 * f64::from(phase) / 65536.0 - 1.0;
    let angle = x.acos();
    coefficients.iter().enumerate().map(|(k, c)| c * (k as f64 * angle).cos()).sum()
}

fn worst_error_deg(
    centre_deg: f64,
    coefficients: &[f64; COEFFICIENT_COUNT],
    amplitude: f64,
    phases: impl Iterator<Item = u16>,
) -> f64 {
    let curve = JointCurve::quantise(centre_deg, (-90.0, 90.0), coefficients).expect("a curve that fits");
    let quantised = Amplitude::from_f64(amplitude).expect("an amplitude in range");
    phases
        .map(|phase| {
            let exact = centre_deg + amplitude * series_deg(coefficients, phase);
            // Beyond +-127.99 degrees the type saturates; no limit reaches there.
            if exact.abs() > 127.0 {
                return 0.0;
            }
            (curve.setpoint(phase, quantised).deg() - exact).abs()
        })
        .fold(0.0, f64::max)
}

/// Coefficients as an adversary of the rounding would choose them: each half
/// a unit off the grid, all of one sign where the Chebyshev terms agree.
fn worst_case_rounding() -> [f64; COEFFICIENT_COUNT] {
    core::array::from_fn(|k| (3.0 / (k + 1) as f64 * 512.0).floor() / 512.0 + 0.499_999 / 512.0)
}

#[test]
fn every_phase_stays_within_the_bound_at_every_kind_of_amplitude() {
    let smooth = [0.0, 12.1, -7.3, 3.21, 1.17, -0.77, 0.35, 0.21, -0.13, 0.07, 0.02];
    let steep = [1.0, -20.0, 10.0, 15.0, -5.0, 4.0, -3.0, 2.0, 1.0, -1.0, 1.5];
    for coefficients in [smooth, steep, worst_case_rounding(), worst_case_rounding().map(|c| -c)] {
        for amplitude in [0.5, 1.0, 1.875, 2.2, 2.4, 3.0] {
            let worst = worst_error_deg(-7.123, &coefficients, amplitude, 0..=u16::MAX);
            assert!(worst <= DERIVED_BOUND_DEG, "{worst} degrees at amplitude {amplitude}");
        }
    }
}

#[test]
fn the_bound_is_not_an_idle_one() {
    let worst = worst_error_deg(0.0, &worst_case_rounding(), 3.0, 0..=u16::MAX);

    assert!(worst > 0.03, "the worst case errs by only {worst} degrees: the bound could be tighter");
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, rng_seed: proptest::test_runner::RngSeed::Fixed(1), failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn any_curve_stays_within_the_bound(
        centre_deg in -55.0..55.0_f64,
        coefficients in prop::array::uniform11(-12.0..12.0_f64),
        amplitude in 0.5..3.0_f64,
        first in 0..1024_u16,
    ) {
        prop_assume!(JointCurve::quantise(centre_deg, (-90.0, 90.0), &coefficients).is_some());
        let worst = worst_error_deg(centre_deg, &coefficients, amplitude, (first..=u16::MAX).step_by(509));
        prop_assert!(worst <= BOUND_DEG, "{worst} degrees");
    }

    #[test]
    fn hostile_coefficients_neither_panic_nor_escape_the_limits(
        raw in prop::array::uniform11(any::<i16>()),
        phase in any::<u16>(),
        amplitude in 4096..=24576_u16,
    ) {
        let mut curve = JointCurve::quantise(0.0, (-55.0, 55.0), &[0.0; COEFFICIENT_COUNT]).expect("a flat curve");
        curve.coefficients = raw.map(protocol::gait::Coefficient);
        let asked = curve.setpoint(phase, Amplitude::from_units(amplitude).expect("in range"));
        let held = curve.limited(asked);
        prop_assert!(curve.min <= held && held <= curve.max);
    }
}

#[test]
fn curves_beyond_the_number_range_are_refused() {
    let mut coefficients = [0.0; COEFFICIENT_COUNT];
    coefficients[1] = MAX_DEVIATION_DEG + 0.2;
    assert_eq!(JointCurve::quantise(0.0, (-90.0, 90.0), &coefficients), None);

    coefficients[1] = f64::NAN;
    assert_eq!(JointCurve::quantise(0.0, (-90.0, 90.0), &coefficients), None);

    coefficients[1] = 10.0;
    assert_eq!(JointCurve::quantise(f64::INFINITY, (-90.0, 90.0), &coefficients), None);
    assert!(JointCurve::quantise(0.0, (-90.0, 90.0), &coefficients).is_some());
}

#[test]
fn amplitude_scales_about_the_centre() {
    let mut coefficients = [0.0; COEFFICIENT_COUNT];
    coefficients[1] = 10.0;
    let curve = JointCurve::quantise(20.0, (-90.0, 90.0), &coefficients).expect("a line");

    let at =
        |phase, amplitude| curve.setpoint(phase, Amplitude::from_f64(amplitude).expect("in range")).deg();

    assert_eq!(at(32768, 1.0), 20.0);
    assert_eq!(at(32768, 2.0), 20.0);
    assert_eq!(at(0, 1.0), 10.0);
    assert_eq!(at(0, 2.0), 0.0);
}
