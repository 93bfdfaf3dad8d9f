//! Which gaits make the front of speed against cost of transport.
//!
//! Holds two choices: for each speed that is asked for, the best of all gaits
//! that were found, whatever they were searched for; and of these, those that no
//! other beats in speed and cost at the same time. Does not depend on how gaits
//! are searched.

use super::score::Test;
use super::search::Pool;
use super::space::Motion;

/// A gait, and the speeds for which it has the best score on the validation robots.
#[derive(Debug, Clone, PartialEq)]
pub struct Winner {
    /// Slowest first.
    pub asked_m_s: Vec<f64>,
    /// The gait.
    pub motion: Motion,
}

/// The best gait for each speed that is asked for, slowest first; none comes twice.
#[must_use]
pub fn winners(pool: &Pool, asked_m_s: &[f64], test: impl Fn(f64) -> Test) -> Vec<Winner> {
    let mut winners: Vec<Winner> = Vec::new();
    for &asked in asked_m_s {
        let Some(best) = pool.best(&test(asked)) else { continue };
        match winners.iter_mut().find(|winner| winner.motion == *best.motion) {
            Some(winner) => winner.asked_m_s.push(asked),
            None => winners.push(Winner { asked_m_s: vec![asked], motion: best.motion.clone() }),
        }
    }
    winners
}

/// Of each speed and cost, whether no other is at least as fast and as cheap, and better in one.
#[must_use]
pub fn undominated(points: &[(f64, f64)]) -> Vec<bool> {
    let beats = |a: &(f64, f64), b: &(f64, f64)| a.0 >= b.0 && a.1 <= b.1 && a != b;
    points.iter().map(|point| !points.iter().any(|other| beats(other, point))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_gait_that_is_slower_and_dearer_than_another_is_no_part_of_a_front() {
        let points =
            [(0.2, 0.30), (0.25, 0.29), (0.3, 0.32), (0.3, 0.33), (0.1, f64::INFINITY), (0.25, 0.29)];

        // The last is as good as the second: neither beats the other.
        assert_eq!(undominated(&points), [false, true, true, false, false, true]);
    }
}
