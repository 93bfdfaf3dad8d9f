//! Two means compared.
//!
//! Holds by how much they differ, and whether the difference is larger than
//! their 95 % intervals. Does not depend on what was measured, nor on wording:
//! claims and report say it in their own words.

use super::summary::Mean;

/// A mean beside another.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Comparison {
    own: Mean,
    rival: Mean,
}

impl Comparison {
    /// `own` is compared with `rival`.
    #[must_use]
    pub const fn of(own: Mean, rival: Mean) -> Self {
        Self { own, rival }
    }

    /// Size of the difference, in percent of the rival.
    #[must_use]
    pub fn percent(&self) -> f64 {
        percent(self.own.mean, self.rival.mean)
    }

    /// Whether `own` is the lower of the two.
    #[must_use]
    pub fn is_lower(&self) -> bool {
        self.own.mean < self.rival.mean
    }

    /// Whether the intervals do not overlap; `None` if one of them is missing.
    #[must_use]
    pub fn is_apart(&self) -> Option<bool> {
        let (own, rival) = self.own.ci95.zip(self.rival.ci95)?;
        Some((self.own.mean - self.rival.mean).abs() > own + rival)
    }
}

/// Size of the difference of two numbers, in percent of the second.
#[must_use]
pub fn percent(own: f64, rival: f64) -> f64 {
    100.0 * (own - rival).abs() / rival.abs()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn compared(own: (f64, Option<f64>), rival: (f64, Option<f64>)) -> Comparison {
        let [own, rival] = [own, rival].map(|(mean, ci95)| Mean { mean, ci95 });
        Comparison::of(own, rival)
    }

    #[test]
    fn a_difference_is_in_percent_of_the_rival_and_apart_beyond_both_intervals() {
        let lower = compared((0.5, Some(0.04)), (0.6, Some(0.05)));
        assert!(lower.is_lower() && lower.is_apart() == Some(true));
        assert!((lower.percent() - 100.0 / 6.0).abs() < 1e-9);

        let overlapping = compared((0.5, Some(0.06)), (0.6, Some(0.05)));
        assert_eq!(overlapping.is_apart(), Some(false));
        let higher = compared((0.6, None), (0.5, Some(0.05)));
        assert!(!higher.is_lower() && higher.is_apart().is_none());
        assert!((higher.percent() - 20.0).abs() < 1e-9);
    }
}
