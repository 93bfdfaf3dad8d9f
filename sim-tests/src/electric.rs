//! The supply: from the power that the robot draws to volts, amperes, joules.
//!
//! Holds the true energy, integrated exactly between changes of the power. Does
//! not depend on the body. The chain is an ideal source, its internal resistance,
//! the INA219's shunt, then everything else: servos through their own supply
//! line, and the Nano. True energy is taken at the battery's terminals, before
//! the shunt: it is what the battery gives, and slightly more than the INA219 can
//! see.

use thiserror::Error;

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SupplyParameters {
    /// Voltage without load.
    pub open_circuit_v: f64,
    /// Battery, switch and leads.
    pub resistance_ohm: f64,
    pub shunt_ohm: f64,
}

impl Default for SupplyParameters {
    /// A regulated 6 V supply on short leads, and the usual INA219 board.
    fn default() -> Self {
        Self { open_circuit_v: 6.0, resistance_ohm: 0.05, shunt_ohm: 0.1 }
    }
}

/// Why a supply cannot be.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum SupplyError {
    /// A battery must have a voltage.
    #[error("open-circuit voltage is {0} V; it must be above 0 and at most 26 V, the INA219's limit")]
    Voltage(f64),
    /// Resistances are positive.
    #[error("resistance is {0} ohm; it must be 0 or more, and finite")]
    Resistance(f64),
}

/// The supply in some state.
#[derive(Debug, Clone)]
pub struct Supply {
    parameters: SupplyParameters,
    now_s: f64,
    current_a: f64,
    battery_energy_j: f64,
    load_energy_j: f64,
    overloaded: bool,
}

impl Supply {
    /// An unloaded supply.
    ///
    /// # Errors
    /// [`SupplyError`] if the parameters are no supply.
    pub fn new(parameters: SupplyParameters) -> Result<Self, SupplyError> {
        let SupplyParameters { open_circuit_v, resistance_ohm, shunt_ohm } = parameters;
        if !(open_circuit_v > 0.0 && open_circuit_v <= 26.0) {
            return Err(SupplyError::Voltage(open_circuit_v));
        }
        for ohm in [resistance_ohm, shunt_ohm] {
            if !(ohm >= 0.0 && ohm.is_finite()) {
                return Err(SupplyError::Resistance(ohm));
            }
        }
        let state = (0.0, 0.0, 0.0, 0.0, false);
        let (now_s, current_a, battery_energy_j, load_energy_j, overloaded) = state;
        Ok(Self { parameters, now_s, current_a, battery_energy_j, load_energy_j, overloaded })
    }

    /// Loads the supply with this power from `now_s` on.
    ///
    /// Power drawn back into the supply counts as none: a servo's electronics
    /// burn it. More than the supply can give is cut to what it can.
    pub fn draw(&mut self, power_w: f64, now_s: f64) {
        self.advance(now_s);
        let SupplyParameters { open_circuit_v, resistance_ohm, shunt_ohm } = self.parameters;
        let series_ohm = resistance_ohm + shunt_ohm;
        let power_w = if power_w > 0.0 { power_w } else { 0.0 };
        // P = I (V - I R): the smaller root, in the form that survives R = 0.
        let discriminant = open_circuit_v * open_circuit_v - 4.0 * series_ohm * power_w;
        self.overloaded = discriminant < 0.0;
        self.current_a = 2.0 * power_w / (open_circuit_v + discriminant.max(0.0).sqrt());
        if self.overloaded {
            self.current_a = open_circuit_v / (2.0 * series_ohm);
        }
    }

    /// Integrates up to `now_s`; nothing changed since the last call.
    pub fn advance(&mut self, now_s: f64) {
        let elapsed_s = (now_s - self.now_s).max(0.0);
        self.battery_energy_j += self.terminal_v() * self.current_a * elapsed_s;
        self.load_energy_j += self.load_v() * self.current_a * elapsed_s;
        self.now_s = self.now_s.max(now_s);
    }

    /// Current out of the battery.
    #[must_use]
    pub fn current_a(&self) -> f64 {
        self.current_a
    }

    /// Voltage at the battery's terminals.
    #[must_use]
    pub fn terminal_v(&self) -> f64 {
        self.parameters.open_circuit_v - self.current_a * self.parameters.resistance_ohm
    }

    /// Voltage behind the shunt: the INA219's bus input.
    #[must_use]
    pub fn load_v(&self) -> f64 {
        self.terminal_v() - self.shunt_v()
    }

    #[must_use]
    pub fn shunt_v(&self) -> f64 {
        self.current_a * self.parameters.shunt_ohm
    }

    /// Energy out of the battery's terminals since the start: the truth.
    #[must_use]
    pub fn battery_energy_j(&self) -> f64 {
        self.battery_energy_j
    }

    /// Energy behind the shunt since the start: what a perfect INA219 sees.
    #[must_use]
    pub fn load_energy_j(&self) -> f64 {
        self.load_energy_j
    }

    /// Whether more power is asked for than the supply can give.
    #[must_use]
    pub fn is_overloaded(&self) -> bool {
        self.overloaded
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn supply() -> Supply {
        Supply::new(SupplyParameters::default()).unwrap()
    }

    #[test]
    fn the_load_gets_the_power_that_it_asks_for() {
        let mut supply = supply();

        supply.draw(3.0, 0.0);

        assert!((supply.current_a() * supply.load_v() - 3.0).abs() < 1e-12);
        assert!(supply.terminal_v() < 6.0);
    }

    #[test]
    fn energy_is_the_integral_of_power_and_the_battery_pays_for_the_shunt() {
        let mut supply = supply();
        supply.draw(2.0, 0.0);
        supply.draw(0.5, 3.0);
        supply.advance(5.0);

        assert!((supply.load_energy_j() - 7.0).abs() < 1e-12);
        assert!(supply.battery_energy_j() > supply.load_energy_j());
    }

    #[test]
    fn an_overload_sags_and_says_so() {
        let mut supply = supply();

        supply.draw(1000.0, 0.0);

        assert!(supply.is_overloaded());
        assert!((supply.load_v() - 3.0).abs() < 1e-12);
    }

    #[test]
    fn power_drawn_back_and_nan_count_as_none() {
        let mut supply = supply();
        for power_w in [-5.0, f64::NAN] {
            supply.draw(power_w, 0.0);

            assert!(supply.current_a().abs() < f64::EPSILON);
        }
    }

    #[test]
    fn impossible_supplies_are_refused() {
        for open_circuit_v in [0.0, -6.0, 30.0, f64::NAN] {
            let parameters = SupplyParameters { open_circuit_v, ..SupplyParameters::default() };
            assert!(Supply::new(parameters).is_err(), "{open_circuit_v}");
        }
        let parameters = SupplyParameters { shunt_ohm: f64::NAN, ..SupplyParameters::default() };
        assert!(Supply::new(parameters).is_err());
    }
}
