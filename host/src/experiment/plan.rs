//! Which conditions there are, and which of them no robot can walk.
//!
//! Owns the order, method by method and leg by leg, and the reason beside each
//! condition that is not run: joints beyond their limits, a method without a
//! gait for these legs. Refuses to bend a gait until it fits.

use super::materials::{Material, Materials};
use super::method::Method;
use super::paper;
use super::summary::Planned;
use super::trial::Place;
use protocol::{Amplitude, Speed};
use serde::{Deserialize, Serialize};

/// What is walked, how often, and how long.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Plan {
    /// Methods.
    pub methods: Vec<Method>,
    /// Amplifications; [`super::method::OWN_STROKE`] is the stroke that a gait was found at.
    pub amplifications: Vec<f64>,
    /// Trials of each condition.
    pub trials: u32,
    /// Length of each.
    pub duration_s: f64,
    /// Of the trials' perturbations.
    pub seed: u64,
    /// Whether every trial in the twin has a robot of its own, within what the fit and tolerances leave open.
    pub robots_differ: bool,
}

impl Plan {
    /// The paper's, with our methods beside its own.
    #[must_use]
    pub fn paper(trials: u32, seed: u64) -> Self {
        Self {
            methods: Method::GAITS[..5].to_vec(),
            amplifications: paper::AMPLIFICATIONS.to_vec(),
            trials,
            duration_s: paper::TRIAL_S,
            seed,
            robots_differ: false,
        }
    }

    /// Every condition of some legs' gaits.
    #[must_use]
    pub fn conditions(&self, legs: &[Materials]) -> Vec<Planned> {
        let mut planned = Vec::new();
        for materials in legs {
            let methods = Method::GAITS.into_iter().filter(|method| self.methods.contains(method));
            for method in methods {
                let material = materials.gaits.iter().find(|material| material.note.method == method);
                for &amplification in &self.amplifications {
                    let place = Place { method, leg: materials.robot.geometry.leg_scale, amplification };
                    planned.push(condition(place, material, materials));
                }
            }
        }
        planned
    }
}

fn condition(place: Place, material: Option<&Material>, materials: &Materials) -> Planned {
    let Some(Material { playable, .. }) = material else {
        let not_run = Some(format!("there is no gait of {} for these legs", place.method.label()));
        return Planned { place, setpoint_speed_max_rad_s: None, not_run };
    };
    let Some(amplitude) = Amplitude::from_f64(place.amplification) else {
        let (least, most) = (Amplitude::MIN.value(), Amplitude::MAX.value());
        let not_run = Some(format!("the firmware plays amplifications from {least} to {most}"));
        return Planned { place, setpoint_speed_max_rad_s: None, not_run };
    };
    let servo_rad_s = materials.robot.servo.top_speed_rad_s();
    let demands = playable.demands(amplitude, Speed::ONE, servo_rad_s.to_degrees());
    let fastest_deg_s = demands.iter().map(|demand| demand.fastest_deg_s).fold(0.0, f64::max);
    Planned {
        place,
        setpoint_speed_max_rad_s: Some(fastest_deg_s.to_radians()),
        not_run: playable.check_limits(place.amplification).err().map(|error| error.to_string()),
    }
}
