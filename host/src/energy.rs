//! Cost of transport, and the two values of gravity.
//!
//! Holds the arithmetic from a trial's energy and distance to its cost of
//! transport. Does not depend on a robot, a port or a file.

use thiserror::Error;

/// Standard gravity, in m/s^2.
///
/// # Source
/// ISO 80000-3: 9.80665 m/s^2, exactly.
pub const STANDARD_GRAVITY_M_S2: f64 = 9.806_65;

/// Gravity of the simulated world, in m/s^2.
///
/// 0.03 % above [`STANDARD_GRAVITY_M_S2`]. The twin was fitted with it, and another
/// value would change every simulated gait. A robot's weight in a cost of transport
/// is computed with standard gravity.
pub const SIMULATED_GRAVITY_M_S2: f64 = 9.81;

/// Why a trial has no cost of transport; each variant holds the value that was given.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum EnergyError {
    /// The robot stood still, or walked backwards.
    #[error("the distance must be above 0 for a cost of transport, got {distance_m} m")]
    NoProgress {
        /// Net distance, in metres.
        distance_m: f64,
    },
    /// The mass is 0, negative or not finite.
    #[error("the mass must be above 0, got {mass_kg} kg")]
    Mass {
        /// In kilograms.
        mass_kg: f64,
    },
    /// The energy is negative or not finite.
    #[error("the energy must be 0 or more, got {energy_j} J")]
    Energy {
        /// In joules.
        energy_j: f64,
    },
}

/// Cost of transport: energy spent per unit weight per unit distance.
///
/// `energy_j / (mass_kg · g · distance_m)`, dimensionless; lower is better.
/// `energy_j` is battery energy, electronics included.
///
/// # Errors
/// [`EnergyError::NoProgress`] unless `distance_m > 0`: a robot that stood
/// still or walked backwards has no cost of transport. [`EnergyError::Mass`]
/// and [`EnergyError::Energy`] for a mass or an energy that is out of range.
///
/// # Source
/// Gabrielli & von Kármán (1950), "specific resistance".
pub fn cost_of_transport(energy_j: f64, mass_kg: f64, distance_m: f64) -> Result<f64, EnergyError> {
    if !(mass_kg.is_finite() && mass_kg > 0.0) {
        return Err(EnergyError::Mass { mass_kg });
    }
    if !(energy_j.is_finite() && energy_j >= 0.0) {
        return Err(EnergyError::Energy { energy_j });
    }
    if !(distance_m.is_finite() && distance_m > 0.0) {
        return Err(EnergyError::NoProgress { distance_m });
    }
    Ok(energy_j / (mass_kg * STANDARD_GRAVITY_M_S2 * distance_m))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 1 kg lifted nowhere: 9.80665 J over 1 m is the definition of one.
    #[test]
    fn a_joule_per_newton_metre_is_one() {
        let cost = cost_of_transport(9.806_65, 1.0, 1.0);

        assert_eq!(cost, Ok(1.0));
    }

    /// The paper's best: about 0.8 W at 0.137 m/s and 10 N cost 0.584; here over
    /// 12 s with 0.9 kg: 9.6 J / (0.9 * 9.80665 N * 1.644 m) = 9.6 / 14.5099.
    #[test]
    fn a_trial_worked_by_hand_agrees() {
        let cost = cost_of_transport(9.6, 0.9, 1.644).unwrap();

        assert!((cost - 0.661_616).abs() < 1e-6, "{cost}");
    }

    #[test]
    fn standing_still_and_walking_backwards_have_no_cost() {
        for distance_m in [0.0, -0.3, f64::NAN, f64::INFINITY] {
            let cost = cost_of_transport(9.6, 0.9, distance_m);

            assert!(matches!(cost, Err(EnergyError::NoProgress { .. })), "{distance_m}: {cost:?}");
        }
    }

    #[test]
    fn a_weightless_robot_and_a_negative_energy_are_refused() {
        assert_eq!(cost_of_transport(1.0, 0.0, 1.0), Err(EnergyError::Mass { mass_kg: 0.0 }));
        assert_eq!(cost_of_transport(-1.0, 1.0, 1.0), Err(EnergyError::Energy { energy_j: -1.0 }));
    }
}
