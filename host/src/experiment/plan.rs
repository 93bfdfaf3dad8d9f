//! The conditions of a study, and which of them no robot can walk.
//!
//! Holds their order, method by method and pair of legs by pair of legs, and the
//! reason beside each condition that is not run: joints beyond their limits, a
//! method without a gait for these legs. No gait is changed to make it fit. Does
//! not depend on trials.

use super::materials::{Material, Materials};
use super::method::Method;
use super::summary::Planned;
use super::trial::Place;
use crate::gait::gait_player::Demand;
use crate::paper;
use protocol::{Amplitude, JOINT_COUNT, Joint, Speed};
use serde::{Deserialize, Serialize};

/// Angles here are the robot's, rounded: a gait that was made for the limit is within it.
const TOLERANCE_DEG: f64 = 0.05;

/// What decides the conditions of a study and their trials.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Plan {
    /// What is compared.
    pub methods: Vec<Method>,
    /// Amplifications; [`super::method::OWN_STROKE`] is the stroke that a gait was found at.
    pub amplifications: Vec<f64>,
    /// Trials of each condition.
    pub trials: u32,
    /// Length of each trial.
    pub duration_s: f64,
    /// Random seed of the trials' perturbations.
    pub seed: u64,
    /// Whether every simulated trial has another robot, within the uncertainty of fit and tolerances.
    pub robots_differ: bool,
    /// Mass of a real robot, if it was weighed; otherwise that of its description.
    pub mass_kg: Option<f64>,
}

impl Plan {
    /// The paper's, with all methods that the program has gaits for.
    #[must_use]
    pub fn paper(trials: u32, seed: u64) -> Self {
        Self {
            methods: Method::bundled().collect(),
            amplifications: paper::AMPLIFICATIONS.to_vec(),
            trials,
            duration_s: paper::TRIAL_S,
            seed,
            robots_differ: false,
            mass_kg: None,
        }
    }

    /// Every condition on these legs.
    #[must_use]
    pub fn conditions(&self, legs: &[Materials]) -> Vec<Planned> {
        let mut planned = Vec::new();
        for materials in legs {
            let methods = Method::gaits().filter(|method| self.methods.contains(method));
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
        let not_run = Some(format!("{} is missing for these legs", place.method.spec().gait));
        return Planned { place, setpoint_speed_max_rad_s: None, not_run };
    };
    let Some(amplitude) = Amplitude::from_f64(place.amplification) else {
        let (least, most) = (Amplitude::MIN.value(), Amplitude::MAX.value());
        let not_run = Some(format!("the firmware plays amplifications from {least} to {most}"));
        return Planned { place, setpoint_speed_max_rad_s: None, not_run };
    };
    let robot = &materials.robot;
    let demands = playable.demands(amplitude, Speed::ONE, robot.servo.top_speed_rad_s().to_degrees());
    let fastest_deg_s = demands.iter().map(|demand| demand.fastest_deg_s).fold(0.0, f64::max);
    // One range for all, whatever limit a gait's file has.
    let range_deg = robot.joint_limit_deg.min(robot.servo.end_stop_deg);
    let beyond = playable.check_limits(place.amplification).err().map(|error| error.to_string());
    Planned {
        place,
        setpoint_speed_max_rad_s: Some(fastest_deg_s.to_radians()),
        not_run: out_of_range(&demands, range_deg).or(beyond),
    }
}

/// The joint that would go the farthest beyond a servo's range, if one would.
fn out_of_range(demands: &[Demand; JOINT_COUNT], range_deg: f64) -> Option<String> {
    let reach = Joint::ALL.into_iter().zip(demands).map(|(joint, demand)| {
        let is_low = -demand.lowest_deg > demand.highest_deg;
        (joint, if is_low { demand.lowest_deg } else { demand.highest_deg })
    });
    let (joint, angle_deg) = reach.max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))?;
    (angle_deg.abs() > range_deg + TOLERANCE_DEG).then(|| {
        format!(
            "{} would go to {angle_deg:.1} degrees; the servos' range ends at {range_deg:.0}",
            joint.name()
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiment::materials;
    use crate::robot::{LegScale, Robot};

    #[test]
    fn amplifications_beyond_the_servos_range_are_planned_and_not_run() {
        let folder = tempfile::tempdir().unwrap();
        let robot = Robot::ant(LegScale::LONG).unwrap();
        materials::unpack(&robot, folder.path()).unwrap();
        let legs = [materials::read(folder.path(), &robot, &Method::gaits().collect::<Vec<_>>()).unwrap()];
        let plan = Plan { amplifications: vec![1.0, 2.9], ..Plan::paper(3, 0) };

        let planned = plan.conditions(&legs);

        assert_eq!(planned.len(), 10);
        for of in planned {
            // A gait whose file says 45 degrees names its own limit.
            let beyond = |why: &String| why.contains("range ends at 45") || why.contains("limit is");
            assert_eq!(of.not_run.as_ref().is_some_and(beyond), of.place.amplification > 2.0, "{of:?}");
            assert!(of.setpoint_speed_max_rad_s.is_some_and(|speed| speed > 0.5), "{of:?}");
        }
    }

    #[test]
    fn a_method_without_a_gait_says_so_instead_of_walking() {
        let folder = tempfile::tempdir().unwrap();
        let robot = Robot::ant(LegScale::LONG).unwrap();
        materials::unpack(&robot, folder.path()).unwrap();
        std::fs::remove_file(folder.path().join("sinusoid.toml")).unwrap();
        let legs = [materials::read(folder.path(), &robot, &Method::gaits().collect::<Vec<_>>()).unwrap()];

        let planned = Plan { methods: vec![Method::Sinusoid], ..Plan::paper(3, 0) }.conditions(&legs);

        assert!(
            planned.iter().all(|of| of
                .not_run
                .as_ref()
                .is_some_and(|why| why.contains("the sinusoid gait is missing")))
        );
    }
}
