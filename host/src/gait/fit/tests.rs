use super::*;
use crate::gait::gait_file::chebyshev;
use proptest::prelude::*;
use std::f64::consts::TAU;

const SCALE: Scale = Scale {
    signs: [1.0; JOINT_COUNT],
    unit_deg: 24.0,
    centre_unit_deg: 45.0,
    centre_offset_deg: 0.0,
    limit_deg: 55.0,
};

/// `count` rows of the same action in every joint.
fn stride(count: usize, action: impl Fn(f64) -> f64, seam: Seam) -> Vec<[f64; JOINT_COUNT]> {
    (0..count).map(|row| [action(seam.phase(row, count)); JOINT_COUNT]).collect()
}

#[test]
fn a_polynomial_of_degree_ten_is_found_again() {
    let actions = [0.1, -0.2, 0.3, 0.05, -0.04, 0.03, 0.02, -0.01, 0.02, 0.01, -0.02];
    let rows = stride(27, |phase| chebyshev(&actions, 2.0 * phase - 1.0), Seam::Free);

    let fit = &fit(&rows, &SCALE, Seam::Free).unwrap()[3];

    for (found, action) in fit.series.coefficients_deg.iter().zip(actions).skip(1) {
        assert!((found - 24.0 * action).abs() < 1e-9, "{found} {action}");
    }
    assert!(fit.series.residual_rms_deg.unwrap() < 1e-9);
    assert!((fit.series.r2.unwrap() - 1.0).abs() < 1e-12);
}

/// The mean of 0.2 + 0.3 cos over a stride is 0.2: 9 degrees at 45 a unit,
/// and the stroke is 2 * 0.3 * 24 = 14.4 degrees.
#[test]
fn the_centre_is_the_mean_action_and_the_stroke_is_in_robot_units() {
    let rows = stride(60, |phase| 0.2 + 0.3 * (TAU * phase).cos(), Seam::Continuous);

    let fit = &fit(&rows, &SCALE, Seam::Continuous).unwrap()[0];

    assert!((fit.series.centre_deg - 9.0).abs() < 1e-3, "{}", fit.series.centre_deg);
    assert!((fit.stroke_deg - 14.4).abs() < 0.01, "{}", fit.stroke_deg);
}

#[test]
fn a_negated_joint_mirrors_its_curve_and_its_centre() {
    let mut scale = SCALE;
    scale.centre_offset_deg = 12.0;
    let rows = stride(30, |phase| 0.3 + 0.2 * (TAU * phase).sin(), Seam::Free);
    let plain = fit(&rows, &scale, Seam::Free).unwrap();
    scale.signs[6] = -1.0;

    let mirrored = fit(&rows, &scale, Seam::Free).unwrap();

    assert_eq!(mirrored[5], plain[5]);
    let (a, b) = (&mirrored[6].series, &plain[6].series);
    assert!((a.centre_deg - 12.0 + b.centre_deg - 12.0).abs() < 1e-9);
    assert!((a.coefficients_deg[3] + b.coefficients_deg[3]).abs() < 1e-9);
}

#[test]
fn a_continuous_seam_joins_value_and_slope() {
    // A ramp jumps by its whole height at the seam.
    let rows = stride(27, |phase| phase, Seam::Continuous);

    let fit = &fit(&rows, &SCALE, Seam::Continuous).unwrap()[0];

    let slope =
        |phase: f64| (fit.series.deviation_deg(phase + 1e-6) - fit.series.deviation_deg(phase)) / 1e-6;
    assert!(fit.seam_jump_deg.abs() < 1e-9, "{}", fit.seam_jump_deg);
    assert!((slope(0.0) - slope(1.0 - 1e-6)).abs() < 0.05, "{} {}", slope(0.0), slope(1.0 - 1e-6));
}

#[test]
fn a_free_seam_stays_between_its_rows() {
    // Five periods in a stride are too fast for degree 10: the fit is poor, but
    // it must not run away at the ends.
    let rows = stride(27, |phase| (5.0 * TAU * phase).sin(), Seam::Free);

    let fit = &fit(&rows, &SCALE, Seam::Free).unwrap()[0];

    let (low, high) = fit.series.deviation_range_deg();
    assert!(low > -30.0 && high < 30.0, "{low} {high}");
    assert!(fit.series.r2.unwrap() < R2_WARNING);
}

#[test]
fn a_joint_that_stands_still_has_no_r2() {
    let rows = stride(20, |_| 0.25, Seam::Free);

    let fit = &fit(&rows, &SCALE, Seam::Free).unwrap()[0];

    assert_eq!(fit.series.r2, None);
    assert!((fit.series.centre_deg - 11.25).abs() < 1e-9);
}

#[test]
fn eleven_rows_are_too_few() {
    let rows = stride(11, |phase| phase, Seam::Free);

    assert_eq!(fit(&rows, &SCALE, Seam::Free), Err(FitError::TooFewRows { rows: 11 }));
}

#[test]
fn actions_that_overflow_are_refused_and_do_not_panic() {
    let rows = stride(20, |phase| f64::MAX * (phase - 0.5), Seam::Free);

    assert!(matches!(fit(&rows, &SCALE, Seam::Free), Err(FitError::Undetermined { joint: "hip1" })));
}

proptest! {
    #![proptest_config(ProptestConfig {
        rng_seed: proptest::test_runner::RngSeed::Fixed(5),
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    /// Whatever the rows, amplitude scales about the curve's mean.
    #[test]
    fn the_deviation_has_zero_mean(
        actions in prop::collection::vec(-1.0..1.0_f64, MIN_ROWS..60),
        continuous in any::<bool>(),
    ) {
        let seam = if continuous { Seam::Continuous } else { Seam::Free };
        let rows: Vec<_> = actions.iter().map(|&a| [a; JOINT_COUNT]).collect();

        let fit = &fit(&rows, &SCALE, seam).unwrap()[0];

        // The midpoint rule errs by the square of its step: 1e-8 of a large curvature.
        let count = 20_000;
        let middle = |i: usize| (i as f64 + 0.5) / count as f64;
        let mean = (0..count).map(|i| fit.series.deviation_deg(middle(i))).sum::<f64>() / count as f64;
        let (low, high) = fit.series.deviation_range_deg();
        prop_assert!(mean.abs() <= 1e-5 * (high - low), "{mean} of {}", high - low);
    }
}
