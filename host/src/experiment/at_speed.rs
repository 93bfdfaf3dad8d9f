//! Cost and power of a method at a speed between the amplifications that were walked.
//!
//! Holds the interpolation: straight lines between neighbouring amplifications;
//! where a gait passes a speed twice, the lower cost counts; nothing is
//! extrapolated. Does not depend on what is done with the values.

use super::method::Method;
use super::summary::{Condition, Mean};
use crate::robot::LegScale;

/// A quantity of a condition.
pub type Of = fn(&Condition) -> Option<Mean>;

/// Cost of transport.
pub const COST: Of = |condition| condition.cost_of_transport;
/// Power.
pub const POWER_W: Of = |condition| condition.power_w;

/// Speed and quantity of each amplification that was walked, in their order; not of those of which
/// half the trials or more do not count.
#[must_use]
pub fn points(conditions: &[Condition], method: Method, leg: LegScale, of: Of) -> Vec<(f64, f64)> {
    let own = conditions.iter().filter(|c| c.method == method && c.leg == leg);
    own.filter(|c| c.mostly_counts()).filter_map(|c| Some((c.speed_m_s?.mean, of(c)?.mean))).collect()
}

/// Slowest and fastest of a method.
#[must_use]
pub fn range_m_s(points: &[(f64, f64)]) -> Option<(f64, f64)> {
    points.iter().map(|&(speed_m_s, _)| (speed_m_s, speed_m_s)).reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))
}

/// The least of the quantity at a speed; `None` where no two neighbours lie about it.
#[must_use]
pub fn at(points: &[(f64, f64)], speed_m_s: f64) -> Option<f64> {
    let between = |pair: &[(f64, f64)]| {
        let [(from_m_s, from), (to_m_s, to)] = *pair else { return None };
        let (low, high) = (from_m_s.min(to_m_s), from_m_s.max(to_m_s));
        if !(low..=high).contains(&speed_m_s) {
            return None;
        }
        let share = if high > low { (speed_m_s - from_m_s) / (to_m_s - from_m_s) } else { 0.0 };
        Some(from + share * (to - from))
    };
    points.windows(2).filter_map(between).min_by(f64::total_cmp)
}

/// Speeds that all of some methods walk, in even steps; none where they share no range.
#[must_use]
pub fn common_m_s(of_methods: &[Vec<(f64, f64)>], steps: usize) -> Vec<f64> {
    let ranges: Option<Vec<(f64, f64)>> = of_methods.iter().map(|points| range_m_s(points)).collect();
    let Some(ranges) = ranges.filter(|ranges| !ranges.is_empty()) else { return Vec::new() };
    let low = ranges.iter().map(|range| range.0).fold(f64::NEG_INFINITY, f64::max);
    let high = ranges.iter().map(|range| range.1).fold(f64::INFINITY, f64::min);
    if low > high || steps == 0 {
        return Vec::new();
    }
    // Rounding must not lead beyond what the slower of them walks.
    (0..=steps).map(|step| (low + (high - low) * step as f64 / steps as f64).min(high)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Up to 0.2 m/s and back: at 0.15 m/s once 1.5, once 3.5.
    const PASSED_TWICE: [(f64, f64); 3] = [(0.1, 1.0), (0.2, 2.0), (0.1, 5.0)];

    #[test]
    fn a_speed_between_two_amplifications_lies_on_their_line_and_twice_passed_counts_the_cheaper() {
        assert!((at(&PASSED_TWICE, 0.15).unwrap() - 1.5).abs() < 1e-12);
        assert_eq!(at(&PASSED_TWICE, 0.1), Some(1.0));
        assert_eq!(at(&PASSED_TWICE, 0.25), None);
        assert_eq!(at(&PASSED_TWICE[..1], 0.1), None);
    }

    #[test]
    fn common_speeds_are_those_of_all() {
        let slow = vec![(0.05, 1.0), (0.15, 1.0)];
        let fast = vec![(0.1, 1.0), (0.3, 1.0)];

        let common = common_m_s(&[slow.clone(), fast], 2);
        assert_eq!(common.len(), 3);
        assert!((common[0] - 0.1).abs() < 1e-12 && (common[2] - 0.15).abs() < 1e-12);
        assert!(common_m_s(&[slow, vec![(0.2, 1.0), (0.3, 1.0)]], 2).is_empty());
    }
}
