//! The free fit against scikit-learn's PolynomialFeatures and LinearRegression.
//!
//! `reference.json` is made by `scripts/fit-reference.py`, from a synthetic
//! stride of two periods, noise included; the same script does the comparison
//! on anybody's trajectory.

use super::*;
use serde::Deserialize;

#[derive(Deserialize)]
struct Reference {
    rows: Vec<[f64; JOINT_COUNT]>,
    phases: Vec<f64>,
    /// Of each joint, at each phase, in units of action.
    curves: Vec<Vec<f64>>,
    means: Vec<f64>,
    r2: Vec<f64>,
}

#[test]
fn the_free_fit_is_scikit_learns_between_the_rows_too() {
    let reference: Reference = serde_json::from_str(include_str!("reference.json")).unwrap();
    let scale = Scale {
        signs: [1.0; JOINT_COUNT],
        unit_deg: 1.0,
        centre_unit_deg: 1.0,
        centre_offset_deg: 0.0,
        limit_deg: 55.0,
    };

    let fits = fit(&reference.rows, &scale, Seam::Free).unwrap();

    let mut worst = 0.0_f64;
    for (joint, fit) in fits.iter().enumerate() {
        let ours = |phase| fit.series.centre_deg + fit.series.deviation_deg(phase);
        for (&phase, theirs) in reference.phases.iter().zip(&reference.curves[joint]) {
            worst = worst.max((ours(phase) - theirs).abs());
        }
        worst = worst.max((fit.series.centre_deg - reference.means[joint]).abs());
        worst = worst.max((fit.series.r2.unwrap() - reference.r2[joint]).abs());
    }
    assert!(worst <= 1e-6, "{worst} in units of action");
    assert_eq!((reference.phases.len(), reference.curves.len()), (105, JOINT_COUNT), "nothing was compared");
}
