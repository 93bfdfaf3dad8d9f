//! Measures of agreement: mean relative error, rank correlation, fitted lines.

use crate::robot::PowerLine;

/// Mean over pairs of `|predicted / measured - 1|`; 0 where there is nothing to compare.
#[must_use]
pub fn mean_relative_error(predicted: &[f64], measured: &[f64]) -> f64 {
    let errors = predicted.iter().zip(measured).map(|(p, m)| (p / m - 1.0).abs());
    errors.sum::<f64>() / predicted.len().max(1) as f64
}

/// Ranks from 1; equal values share the mean of theirs.
fn ranks(values: &[f64]) -> Vec<f64> {
    values
        .iter()
        .map(|value| {
            let below = values.iter().filter(|other| *other < value).count() as f64;
            let equal = values.iter().filter(|other| *other == value).count() as f64;
            below + (equal + 1.0) / 2.0
        })
        .collect()
}

/// Spearman's rank correlation; none with fewer than two values or no variation.
#[must_use]
pub fn spearman(a: &[f64], b: &[f64]) -> Option<f64> {
    let (a, b) = (ranks(a), ranks(b));
    let mean = (a.len() as f64 + 1.0) / 2.0;
    let product = |x: &[f64], y: &[f64]| x.iter().zip(y).map(|(x, y)| (x - mean) * (y - mean)).sum::<f64>();
    let spread = (product(&a, &a) * product(&b, &b)).sqrt();
    (a.len() > 1 && spread > 0.0).then(|| product(&a, &b) / spread)
}

/// The line to measured powers with the least squared relative errors.
#[must_use]
pub fn line_to(predictor: &[f64], measured_w: &[f64]) -> PowerLine {
    // Normal equations of a + b x = m, each weighted by 1 / m^2.
    let [mut w, mut wx, mut wxx, mut wm, mut wxm] = [0.0; 5];
    for (x, m) in predictor.iter().zip(measured_w) {
        let weight = 1.0 / (m * m);
        w += weight;
        wx += weight * x;
        wxx += weight * x * x;
        wm += weight * m;
        wxm += weight * x * m;
    }
    let determinant = w * wxx - wx * wx;
    if determinant <= 1e-12 * w * wxx {
        let constant_w = if w > 0.0 { wm / w } else { 0.0 };
        return PowerLine { constant_w, slope_w: 0.0 };
    }
    PowerLine { constant_w: (wm * wxx - wxm * wx) / determinant, slope_w: (w * wxm - wx * wm) / determinant }
}
