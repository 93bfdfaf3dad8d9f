//! One trial: what was measured, and whether it counts.
//!
//! Holds the marks and their order. A marked trial is in the table like any
//! other, and in no mean: the robot fell, went the other way, stood still or was
//! not watched. Does not depend on where a trial is walked.

use super::method::Method;
use crate::energy::cost_of_transport;
use crate::robot::LegScale;
use serde::{Deserialize, Serialize};

/// Shorter distances count as none: a ruler does not resolve them.
pub const LEAST_DISTANCE_M: f64 = 0.01;

/// Why a trial is in no mean.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Mark {
    /// The robot fell.
    Fell,
    /// It went against the direction of its method's other trials.
    Reversed,
    /// It went backwards, as the person at the robot said.
    Backwards,
    /// It stayed where it was, within [`LEAST_DISTANCE_M`].
    NoDistance,
    /// The power sensor missed samples: the energy is too low.
    MissedSamples,
    /// The robot stopped by itself, or the trial was cut short.
    Stopped,
    /// The simulation diverged.
    Diverged,
}

impl Mark {
    /// In tables and messages.
    #[must_use]
    pub const fn text(self) -> &'static str {
        match self {
            Self::Fell => "fell",
            Self::Reversed => "reversed",
            Self::Backwards => "backwards",
            Self::NoDistance => "no distance",
            Self::MissedSamples => "missed samples",
            Self::Stopped => "stopped",
            Self::Diverged => "diverged",
        }
    }
}

/// A condition of the plan.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Place {
    /// How the gait was made.
    pub method: Method,
    /// Shins, in units of 23 cm.
    pub leg: LegScale,
    /// Of the gait's deviations from their centres.
    pub amplification: f64,
}

/// What was measured of a trial.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Raw {
    /// Length of the walk.
    pub duration_s: f64,
    /// From the battery.
    pub energy_j: f64,
    /// Net displacement in the plane, or along the marked line of a floor; `None` if unknown.
    pub displacement_m: Option<[f64; 2]>,
    /// For the weight in the cost of transport.
    pub mass_kg: f64,
    /// Change of heading, if known.
    pub turned_deg: Option<f64>,
    /// Whether the robot fell.
    pub fell: bool,
    /// Whether the person at the robot said so.
    pub backwards: bool,
    /// Whether neither tracker nor person would have seen a fall.
    pub fall_unseen: bool,
    /// Power samples that failed or saturated.
    pub missed_samples: u32,
    /// The walk was cut short.
    pub stopped: bool,
    /// The simulation diverged.
    pub diverged: bool,
}

/// One row of `study-trials.csv`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Trial {
    /// How the gait was made.
    pub method: Method,
    /// Shins, in units of 23 cm.
    pub leg: LegScale,
    /// Of the gait's deviations from their centres.
    pub amplification: f64,
    /// Number within its condition, from 0.
    pub trial: u32,
    /// Length of the walk.
    pub duration_s: f64,
    /// From the battery.
    pub energy_j: f64,
    /// Net displacement along x, or along the marked line.
    pub dx_m: Option<f64>,
    /// Net displacement along y.
    pub dy_m: Option<f64>,
    /// Length of the displacement.
    pub distance_m: Option<f64>,
    /// Distance by duration.
    pub speed_m_s: Option<f64>,
    /// Energy by duration.
    pub power_w: Option<f64>,
    /// Energy by weight and distance.
    pub cost_of_transport: Option<f64>,
    /// Change of heading, if known.
    pub turned_deg: Option<f64>,
    /// Neither tracker nor person would have seen a fall.
    pub fall_unseen: bool,
    /// Power samples that are missing.
    pub missed_samples: u32,
    /// SHA-256 of the table that was played.
    pub gait_sha256: String,
    /// Why it does not count.
    pub mark: Option<Mark>,
}

impl Trial {
    /// Computes a trial from what was measured. Its direction is checked later, by [`mark_reversed`].
    #[must_use]
    pub fn of(place: Place, number: u32, raw: &Raw, gait_sha256: &str) -> Self {
        let Place { method, leg, amplification } = place;
        let distance_m = raw.displacement_m.map(|[dx_m, dy_m]| dx_m.hypot(dy_m)).filter(|d| d.is_finite());
        let lasted = raw.duration_s > 0.0;
        let mark = if raw.diverged {
            Some(Mark::Diverged)
        } else if raw.fell {
            Some(Mark::Fell)
        } else if raw.stopped || !lasted {
            Some(Mark::Stopped)
        } else if raw.missed_samples > 0 {
            Some(Mark::MissedSamples)
        } else if distance_m.is_none_or(|distance_m| distance_m < LEAST_DISTANCE_M) {
            Some(Mark::NoDistance)
        } else if raw.backwards {
            Some(Mark::Backwards)
        } else {
            None
        };
        Self {
            method,
            leg,
            amplification,
            trial: number,
            duration_s: raw.duration_s,
            energy_j: raw.energy_j,
            dx_m: raw.displacement_m.map(|[dx_m, _]| dx_m),
            dy_m: raw.displacement_m.map(|[_, dy_m]| dy_m),
            distance_m,
            speed_m_s: distance_m.filter(|_| lasted).map(|distance_m| distance_m / raw.duration_s),
            power_w: lasted.then(|| raw.energy_j / raw.duration_s).filter(|power_w| power_w.is_finite()),
            cost_of_transport: distance_m.and_then(|d| cost_of_transport(raw.energy_j, raw.mass_kg, d).ok()),
            turned_deg: raw.turned_deg,
            fall_unseen: raw.fall_unseen,
            missed_samples: raw.missed_samples,
            gait_sha256: gait_sha256.to_owned(),
            mark,
        }
    }

    /// Its condition.
    #[must_use]
    pub const fn place(&self) -> Place {
        Place { method: self.method, leg: self.leg, amplification: self.amplification }
    }
}

/// Marks trials that went against the others of the same method and legs.
///
/// The direction of a gait is not given. It is that of the sum of the displacements
/// of all its trials that count: amplification changes the length of a
/// displacement, not its direction.
pub fn mark_reversed(trials: &mut [Trial]) {
    // Decided anew each time: trials that were added since may change the direction.
    trials.iter_mut().filter(|trial| trial.mark == Some(Mark::Reversed)).for_each(|trial| trial.mark = None);
    let way = |trial: &Trial| trial.dx_m.zip(trial.dy_m);
    let directions: Vec<(f64, f64)> = trials
        .iter()
        .map(|of| {
            let alike = |t: &&Trial| t.method == of.method && t.leg == of.leg && t.mark.is_none();
            let ways = trials.iter().filter(alike).filter_map(way);
            ways.fold((0.0, 0.0), |(x, y), (dx_m, dy_m)| (x + dx_m, y + dy_m))
        })
        .collect();
    for (trial, (x, y)) in trials.iter_mut().zip(directions) {
        let against = way(trial).is_some_and(|(dx_m, dy_m)| dx_m * x + dy_m * y < 0.0);
        if trial.mark.is_none() && against {
            trial.mark = Some(Mark::Reversed);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PLACE: Place = Place { method: Method::Psto, leg: LegScale::LONG, amplification: 2.0 };
    /// 12 s at 0.8 W over 3-4-5 times 0.3 m with 10 N: 9.6 J / (10 N * 1.5 m) = 0.64.
    const KNOWN: Raw = Raw {
        duration_s: 12.0,
        energy_j: 9.6,
        displacement_m: Some([0.9, 1.2]),
        mass_kg: 10.0 / crate::energy::STANDARD_GRAVITY_M_S2,
        turned_deg: None,
        fell: false,
        backwards: false,
        fall_unseen: false,
        missed_samples: 0,
        stopped: false,
        diverged: false,
    };

    #[test]
    fn a_trial_worked_by_hand_agrees() {
        let trial = Trial::of(PLACE, 0, &KNOWN, "");

        assert_eq!(trial.mark, None);
        assert!((trial.distance_m.unwrap() - 1.5).abs() < 1e-12);
        assert!((trial.speed_m_s.unwrap() - 0.125).abs() < 1e-12);
        assert!((trial.power_w.unwrap() - 0.8).abs() < 1e-12);
        assert!((trial.cost_of_transport.unwrap() - 0.64).abs() < 1e-12);
    }

    #[test]
    fn whatever_makes_a_trial_worthless_is_marked() {
        let marked = |raw: Raw| Trial::of(PLACE, 0, &raw, "").mark;

        assert_eq!(marked(Raw { fell: true, ..KNOWN }), Some(Mark::Fell));
        assert_eq!(marked(Raw { displacement_m: Some([0.0, 0.0]), ..KNOWN }), Some(Mark::NoDistance));
        assert_eq!(marked(Raw { displacement_m: None, ..KNOWN }), Some(Mark::NoDistance));
        assert_eq!(marked(Raw { displacement_m: Some([f64::NAN, 0.0]), ..KNOWN }), Some(Mark::NoDistance));
        assert_eq!(marked(Raw { missed_samples: 1, ..KNOWN }), Some(Mark::MissedSamples));
        assert_eq!(marked(Raw { stopped: true, ..KNOWN }), Some(Mark::Stopped));
        assert_eq!(marked(Raw { duration_s: 0.0, ..KNOWN }), Some(Mark::Stopped));
        assert_eq!(marked(Raw { diverged: true, ..KNOWN }), Some(Mark::Diverged));
    }

    #[test]
    fn a_trial_against_the_others_is_marked_and_a_wide_turn_is_not() {
        let along = |x: f64, y: f64, method| {
            let raw = Raw { displacement_m: Some([x, y]), ..KNOWN };
            Trial::of(Place { method, ..PLACE }, 0, &raw, "")
        };
        let mut trials = vec![
            along(1.0, 0.0, Method::Psto),
            along(0.5, 0.8, Method::Psto),
            along(-0.6, 0.1, Method::Psto),
            along(-1.0, 0.0, Method::Sinusoid),
        ];

        mark_reversed(&mut trials);

        let marks: Vec<Option<Mark>> = trials.iter().map(|trial| trial.mark).collect();
        assert_eq!(marks, [None, None, Some(Mark::Reversed), None]);

        // More trials show that the first three were the odd ones.
        trials.extend([along(-2.0, 0.0, Method::Psto), along(-2.0, 0.1, Method::Psto)]);
        mark_reversed(&mut trials);
        assert_eq!((trials[0].mark, trials[2].mark), (Some(Mark::Reversed), None));
    }
}
