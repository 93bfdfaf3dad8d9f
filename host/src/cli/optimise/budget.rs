//! `--budget`: how long to search, as it is typed.
//!
//! Holds the conversion of time to trials. A search that looked at the clock
//! would find another gait each time; so time is converted at a fixed rate, and
//! the same budget gives the same gait on every machine. Does not depend on the
//! speed of this one.

use std::str::FromStr;
use thiserror::Error;

/// Trials per second on two cores of an AMD EPYC of 2024: `host optimise --budget 10m`
/// took ten minutes there.
const TRIALS_PER_S: f64 = 50.0;
/// Fewer would be spent before the last stage begins.
pub const LEAST_TRIALS: u64 = 100;
/// A month of two cores.
const MOST_TRIALS: u64 = 100_000_000;

/// Trials to simulate.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Budget {
    pub trials: u64,
}

/// An invalid budget.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("{text:?} is not a valid budget: write minutes as 10m, seconds as 600s, hours as 2h, or a number of trials from {LEAST_TRIALS} to {MOST_TRIALS}; the minimum is {}s", LEAST_TRIALS as f64 / TRIALS_PER_S)]
pub struct BadBudget {
    text: String,
}

impl Budget {
    /// Seconds that give at least so many trials.
    pub fn seconds(trials: u64) -> u64 {
        (trials as f64 / TRIALS_PER_S).ceil() as u64
    }
}

impl FromStr for Budget {
    type Err = BadBudget;

    fn from_str(text: &str) -> Result<Self, BadBudget> {
        let bad = || BadBudget { text: text.into() };
        let seconds = |number: &str, unit_s: f64| {
            let number: f64 = number.parse().map_err(|_| bad())?;
            Ok((number * unit_s * TRIALS_PER_S).round() as u64)
        };
        let trials = match (text.strip_suffix('m'), text.strip_suffix('s'), text.strip_suffix('h')) {
            (Some(minutes), ..) => seconds(minutes, 60.0)?,
            (_, Some(number), _) => seconds(number, 1.0)?,
            (.., Some(hours)) => seconds(hours, 3600.0)?,
            _ => text.parse().map_err(|_| bad())?,
        };
        if (LEAST_TRIALS..=MOST_TRIALS).contains(&trials) { Ok(Self { trials }) } else { Err(bad()) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn time_is_exchanged_for_trials() {
        assert_eq!("10m".parse(), Ok(Budget { trials: 30_000 }));
        assert_eq!("600s".parse(), Ok(Budget { trials: 30_000 }));
        assert_eq!("0.5h".parse(), Ok(Budget { trials: 90_000 }));
        assert_eq!("1234".parse(), Ok(Budget { trials: 1234 }));
        for bad in ["", "m", "-5m", "10", "nanm", "infs", "ten", "1e12m"] {
            assert!(bad.parse::<Budget>().is_err(), "{bad}");
        }
    }
}
