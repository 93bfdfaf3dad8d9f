//! Speeds of gaits whose curves are known.

use super::*;
use crate::gait::gait_file::{GaitFile, JointSeries, Provenance, Source};

/// hip1's deviation has these Chebyshev coefficients; all else stands.
fn gait(coefficients: &[f64], period_s: f64) -> Playable {
    let mut coefficients_deg = [0.0; 11];
    coefficients_deg[..coefficients.len()].copy_from_slice(coefficients);
    let still = JointSeries { min_deg: -55.0, max_deg: 55.0, ..JointSeries::default() };
    let mut joints: [JointSeries; JOINT_COUNT] = std::array::from_fn(|_| still.clone());
    joints[0].coefficients_deg = coefficients_deg;
    let provenance = Provenance::of(Source::Fitted);
    let gait = GaitFile { name: "known".into(), period_s, unit_deg: 24.0, provenance, joints };
    Playable::from_bytes(&gait.encoded().unwrap()).unwrap()
}

fn amplitude(value: f64) -> Amplitude {
    Amplitude::from_f64(value).unwrap()
}

/// A ramp from -10 to 10 degrees in 2 s is 10 degrees/s, and 20 back in one frame.
#[test]
fn a_jump_at_the_seam_is_a_speed_of_its_own() {
    let peaks = peak_speeds(&gait(&[0.0, 10.0], 2.0), amplitude(1.0));

    assert!((peaks[0].curve_deg_s - 10.0).abs() < 0.5, "{peaks:?}");
    assert!((peaks[0].seam_deg_s - 1200.0).abs() < 12.0, "{peaks:?}");
    assert_eq!(peaks[0].deg_s(), peaks[0].seam_deg_s);
    assert!((peaks[0].jump_deg + 20.0).abs() < 0.1, "{peaks:?}");
    assert_eq!(peaks[1], PeakSpeed::default(), "it stands");
}

/// 10 T2 is a parabola: 40 degrees in half a stride, steepest at the seam,
/// 4 * 10 * 2 / 2 s = 40 degrees/s.
#[test]
fn speeds_grow_with_the_amplitude_up_to_the_limits() {
    let parabola = gait(&[0.0, 0.0, 10.0], 2.0);

    let curve_deg_s = |a| peak_speeds(&parabola, amplitude(a))[0].curve_deg_s;
    let fastest = curve_deg_s(1.0);

    assert!((fastest - 39.7).abs() < 0.7, "{fastest}");
    assert!((curve_deg_s(2.0) / fastest - 2.0).abs() < 0.02);
}

#[test]
fn the_largest_amplitude_that_servos_follow_is_where_the_curve_is_as_fast_as_they() {
    let parabola = gait(&[0.0, 0.0, 10.0], 2.0);
    let one_deg_s = peak_speeds(&parabola, amplitude(1.0))[0].curve_deg_s;

    let followed = largest_followed(&parabola, 2.0 * one_deg_s).unwrap();

    assert!((followed - 2.0).abs() <= 0.02, "{followed}");
    assert_eq!(largest_followed(&parabola, 10.0 * one_deg_s), Some(3.0));
    assert_eq!(largest_followed(&parabola, 0.4 * one_deg_s), None);
}

/// The seam alone would ask for 1,200 degrees/s.
#[test]
fn a_jump_at_the_seam_does_not_count_as_a_curve_that_servos_cannot_follow() {
    assert_eq!(largest_followed(&gait(&[0.0, 10.0], 2.0), 50.0), Some(3.0));
}

/// T5 - T1 begins and ends at 0, and is steepest there.
#[test]
fn a_curve_that_is_fastest_where_strides_meet_is_as_fast_there() {
    let steep = gait(&[0.0, -8.0, 0.0, 0.0, 0.0, 8.0], 0.4);

    let peak = peak_speeds(&steep, amplitude(1.0))[0];

    assert!(peak.jump_deg.abs() < 0.1, "{peak:?}");
    // 8 (25 - 1) * 2 / 0.4 s = 960 degrees/s at the seam itself, less over a frame of 1/24 stride.
    assert!(peak.seam_deg_s > 300.0, "{peak:?}");
    assert!((peak.curve_deg_s - peak.seam_deg_s).abs() < 4.0, "{peak:?}");
    assert!(lagging_share(&steep, Joint::Hip1, amplitude(1.0), 0.9 * peak.seam_deg_s) > 0.0);
    assert_eq!(lagging_share(&steep, Joint::Hip2, amplitude(1.0), 1.0), 0.0);
}
