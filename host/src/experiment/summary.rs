//! From trials to conditions: means with their uncertainty, and the best of each method.
//!
//! Holds the statistics. Marked trials are in no mean, and conditions that were
//! not run have a reason in place of numbers. Does not depend on where trials
//! were walked.

use super::method::Method;
use super::trial::{Mark, Place, Trial};
use crate::robot::LegScale;
use serde::{Deserialize, Serialize};

/// A mean over the trials that count, and its uncertainty.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Mean {
    /// Arithmetic mean.
    pub mean: f64,
    /// Half the width of its 95 % confidence interval, by Student's t; `None` for a single trial.
    pub ci95: Option<f64>,
}

impl Mean {
    /// Mean and interval with so many decimals.
    #[must_use]
    pub fn text(&self, decimals: usize) -> String {
        match self.ci95 {
            Some(ci95) => format!("{:.decimals$} \u{b1} {ci95:.decimals$}", self.mean),
            None => format!("{:.decimals$}", self.mean),
        }
    }
}

/// One method at one amplification on one pair of legs.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Condition {
    /// How the gait was made.
    pub method: Method,
    /// Shins, in units of 23 cm.
    pub leg: LegScale,
    /// Of the gait's deviations from their centres.
    pub amplification: f64,
    /// Trials that count.
    pub n: usize,
    /// Trials in all.
    pub trials: usize,
    /// Net distance over time.
    pub speed_m_s: Option<Mean>,
    /// From the battery.
    pub power_w: Option<Mean>,
    /// Energy by weight and distance.
    pub cost_of_transport: Option<Mean>,
    /// Trials in which the robot fell.
    pub falls: usize,
    /// The marks of trials that do not count, falls among them.
    pub marks: Vec<Mark>,
    /// Fastest setpoint of the gait; beyond the servo's speed it lags.
    pub setpoint_speed_max_rad_s: Option<f64>,
    /// Why there is no trial.
    pub not_run: Option<String>,
}

impl Condition {
    /// Whether more than half of the trials count: of a gait that mostly falls, the others are luck.
    #[must_use]
    pub const fn mostly_counts(&self) -> bool {
        2 * self.n > self.trials
    }
}

/// A condition of the plan, before it is walked.
#[derive(Debug, Clone, PartialEq)]
pub struct Planned {
    /// Method, legs and amplification.
    pub place: Place,
    /// Fastest setpoint, if a gait is known.
    pub setpoint_speed_max_rad_s: Option<f64>,
    /// Why it is not walked.
    pub not_run: Option<String>,
}

/// The best of one method on one pair of legs, as in the paper's Table 2: the
/// least cost of transport and the highest speed, not always at the same amplification. Of conditions
/// of which half the trials or more do not count, none is the best.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Best {
    /// How the gait was made.
    pub method: Method,
    /// Shins, in units of 23 cm.
    pub leg: LegScale,
    /// Lowest mean cost of transport.
    pub cost_of_transport: Option<Mean>,
    /// The amplification of that cost.
    pub cost_amplification: Option<f64>,
    /// Trials that it is the mean of.
    pub cost_n: usize,
    /// Highest mean speed.
    pub speed_m_s: Option<Mean>,
    /// The amplification of that speed.
    pub speed_amplification: Option<f64>,
    /// Trials that it is the mean of.
    pub speed_n: usize,
    /// The lowest cost of this method in the paper.
    pub paper_cost_of_transport: Option<f64>,
    /// The highest speed of this method in the paper.
    pub paper_speed_m_s: Option<f64>,
}

/// The mean of some values; `None` if there are none.
#[must_use]
pub fn mean_of(values: &[f64]) -> Option<Mean> {
    if values.is_empty() {
        return None;
    }
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let ci95 = (values.len() > 1).then(|| {
        let variance = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / (count - 1.0);
        student_t95(values.len() - 1) * (variance / count).sqrt()
    });
    Some(Mean { mean, ci95 })
}

/// Two-sided 95 % point of Student's t.
///
/// # Source
/// Tables of the distribution to 30 degrees of freedom; beyond them the expansion
/// of Abramowitz and Stegun, 26.7.5, about the normal 1.959964, within 0.0001.
fn student_t95(degrees_of_freedom: usize) -> f64 {
    const TABLE: [f64; 30] = [
        12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262, 2.228, 2.201, 2.179, 2.160, 2.145,
        2.131, 2.120, 2.110, 2.101, 2.093, 2.086, 2.080, 2.074, 2.069, 2.064, 2.060, 2.056, 2.052, 2.048,
        2.045, 2.042,
    ];
    const NORMAL: f64 = 1.959_964;
    let known = degrees_of_freedom.checked_sub(1).and_then(|k| TABLE.get(k));
    known.copied().unwrap_or_else(|| {
        let n = degrees_of_freedom as f64;
        let first = (NORMAL.powi(3) + NORMAL) / 4.0;
        let second = (5.0 * NORMAL.powi(5) + 16.0 * NORMAL.powi(3) + 3.0 * NORMAL) / 96.0;
        NORMAL + first / n + second / (n * n)
    })
}

/// Statistics of each planned condition over its trials.
#[must_use]
pub fn conditions(planned: &[Planned], trials: &[Trial]) -> Vec<Condition> {
    planned.iter().map(|planned| condition(planned, trials)).collect()
}

fn condition(planned: &Planned, trials: &[Trial]) -> Condition {
    let own: Vec<&Trial> = trials.iter().filter(|trial| trial.place() == planned.place).collect();
    let counted: Vec<&Trial> = own.iter().copied().filter(|trial| trial.mark.is_none()).collect();
    let mean = |of: fn(&Trial) -> Option<f64>| {
        mean_of(&counted.iter().filter_map(|trial| of(trial)).collect::<Vec<f64>>())
    };
    let marks: Vec<Mark> = own.iter().filter_map(|trial| trial.mark).collect();
    let Place { method, leg, amplification } = planned.place;
    Condition {
        method,
        leg,
        amplification,
        n: counted.len(),
        trials: own.len(),
        speed_m_s: mean(|trial| trial.speed_m_s),
        power_w: mean(|trial| trial.power_w),
        cost_of_transport: mean(|trial| trial.cost_of_transport),
        falls: marks.iter().filter(|&&mark| mark == Mark::Fell).count(),
        marks,
        setpoint_speed_max_rad_s: planned.setpoint_speed_max_rad_s,
        not_run: planned.not_run.clone(),
    }
}

/// The best of each method and pair of legs, in the order of the conditions.
#[must_use]
pub fn best(conditions: &[Condition]) -> Vec<Best> {
    let mut seen: Vec<(Method, LegScale)> = Vec::new();
    for condition in conditions {
        if !seen.contains(&(condition.method, condition.leg)) {
            seen.push((condition.method, condition.leg));
        }
    }
    let best_of = |(method, leg): (Method, LegScale)| {
        let own = || conditions.iter().filter(move |c| c.method == method && c.leg == leg);
        let by = |of: fn(&Condition) -> Option<Mean>, sign: f64| {
            own()
                .filter(|c| c.mostly_counts())
                .filter_map(|c| of(c).map(|mean| (mean, c.amplification, c.n)))
                .min_by(|a, b| (sign * a.0.mean).total_cmp(&(sign * b.0.mean)))
        };
        let cheapest = by(|c| c.cost_of_transport, 1.0);
        let fastest = by(|c| c.speed_m_s, -1.0);
        let paper = method.table_2(leg);
        Best {
            method,
            leg,
            cost_of_transport: cheapest.map(|(mean, ..)| mean),
            cost_amplification: cheapest.map(|(_, amplification, _)| amplification),
            cost_n: cheapest.map_or(0, |(.., n)| n),
            speed_m_s: fastest.map(|(mean, ..)| mean),
            speed_amplification: fastest.map(|(_, amplification, _)| amplification),
            speed_n: fastest.map_or(0, |(.., n)| n),
            paper_cost_of_transport: paper.map(|(cost, _)| cost),
            paper_speed_m_s: paper.map(|(_, speed_m_s)| speed_m_s),
        }
    };
    seen.into_iter().map(best_of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiment::trial::Raw;

    fn trial(amplification: f64, number: u32, energy_j: f64, distance_m: f64, fell: bool) -> Trial {
        let place = Place { method: Method::Psto, leg: LegScale::LONG, amplification };
        let raw = Raw {
            duration_s: 10.0,
            energy_j,
            displacement_m: Some([distance_m, 0.0]),
            mass_kg: 1.0 / crate::energy::STANDARD_GRAVITY_M_S2,
            fell,
            ..Raw::default()
        };
        Trial::of(place, number, &raw, "")
    }

    fn planned(amplification: f64, not_run: Option<&str>) -> Planned {
        let place = Place { method: Method::Psto, leg: LegScale::LONG, amplification };
        Planned { place, setpoint_speed_max_rad_s: None, not_run: not_run.map(str::to_owned) }
    }

    /// 1, 2 and 3: mean 2, standard deviation 1, and 4.303 / sqrt(3) = 2.484.
    #[test]
    fn a_mean_of_three_has_students_interval() {
        let Mean { mean, ci95 } = mean_of(&[1.0, 2.0, 3.0]).unwrap();

        assert_eq!(mean, 2.0);
        assert!((ci95.unwrap() - 2.4844).abs() < 1e-3);
        assert_eq!(mean_of(&[5.0]), Some(Mean { mean: 5.0, ci95: None }));
        assert_eq!(mean_of(&[]), None);
        // Beyond the table: 2.0395 at 31, 1.9840 at 100.
        assert!((student_t95(31) - 2.0395).abs() < 2e-4 && (student_t95(100) - 1.9840).abs() < 2e-4);
    }

    /// Costs 10 J / (1 N * 1 m) = 10 and 30 / 2 = 15; the fall, at 99, is in no mean.
    #[test]
    fn a_marked_trial_is_counted_and_not_averaged() {
        let trials = [
            trial(1.0, 0, 10.0, 1.0, false),
            trial(1.0, 1, 30.0, 2.0, false),
            trial(1.0, 2, 99.0, 1.0, true),
        ];

        let found = &conditions(&[planned(1.0, None)], &trials)[0];

        assert_eq!((found.n, found.trials, found.falls), (2, 3, 1));
        assert_eq!(found.cost_of_transport.unwrap().mean, 12.5);
        assert!((found.speed_m_s.unwrap().mean - 0.15).abs() < 1e-12);
        assert_eq!(found.power_w.unwrap().mean, 2.0);
        assert_eq!(found.marks, [Mark::Fell]);
    }

    #[test]
    fn the_best_cost_and_the_best_speed_may_lie_at_different_amplifications() {
        let trials = [trial(1.0, 0, 10.0, 1.0, false), trial(2.0, 0, 40.0, 2.0, false)];
        let planned = [planned(1.0, None), planned(2.0, None), planned(2.4, Some("beyond the joints"))];

        let conditions = conditions(&planned, &trials);
        let best = best(&conditions);

        assert_eq!(best.len(), 1);
        assert_eq!((best[0].cost_amplification, best[0].speed_amplification), (Some(1.0), Some(2.0)));
        assert_eq!(best[0].paper_cost_of_transport, Some(0.595));
        assert_eq!((conditions[2].n, conditions[2].cost_of_transport), (0, None));
        assert_eq!(conditions[2].not_run.as_deref(), Some("beyond the joints"));
    }

    /// The one that stayed up at 2.0x is cheapest by far, and luck.
    #[test]
    fn a_condition_of_which_half_the_trials_do_not_count_is_not_the_best() {
        let trials = [
            trial(1.0, 0, 9.0, 1.0, false),
            trial(1.0, 1, 9.0, 1.0, false),
            trial(2.0, 0, 1.0, 2.0, false),
            trial(2.0, 1, 1.0, 2.0, true),
        ];

        let conditions = conditions(&[planned(1.0, None), planned(2.0, None)], &trials);
        let best = &best(&conditions)[0];

        assert_eq!((best.cost_amplification, best.cost_n), (Some(1.0), 2));
        assert_eq!((best.speed_amplification, best.speed_n), (Some(1.0), 2));
    }
}
