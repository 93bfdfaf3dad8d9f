//! Trials in simulation, without firmware.
//!
//! Holds the perturbations: start number `n` of a seed is the same for every
//! method and amplification, so that no method is luckier than another; so is
//! robot number `n`, where each trial has a robot of its own. The setpoints are
//! computed from the robot's own table, held at its limits and rounded to pulses,
//! as in the firmware. Does not depend on the ledger.

use super::materials::Materials;
use super::method::{Method, Origin};
use super::plan::Plan;
use super::summary::Planned;
use super::trial::{Place, Raw, Trial};
use crate::robot::Robot;
use crate::search::optimise::tolerances::{Draw, Tolerances};
use crate::sim::Perturbation;
use crate::sim::open_loop::{self, FRAME_RATE_HZ, Playback, Starts, Walk};
use crate::twin::{Gait, Tables, TwinError};
use protocol::{Amplitude, JOINT_COUNT};
use rayon::prelude::*;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

/// How trials of one condition differ.
///
/// # Source
/// Ours: how accurately a robot is placed by hand; trials then differ about as much as the authors'.
pub const PERTURBATION: Perturbation =
    Perturbation { yaw_rad: 0.05, height_m: 0.005, joint_rad: 0.05, friction_share: 0.1 };

/// The authors' tables, as `--reference-tables` names them.
#[derive(Debug, Clone)]
pub struct Authors {
    tables: Tables,
    robot: Robot,
    /// How long their sketch held a row.
    sample_s: f64,
}

impl Authors {
    /// Reads the tables for the robot with the paper's long legs.
    ///
    /// # Errors
    /// [`TwinError`] naming file, line and column.
    pub fn read(path: &Path, robot: &Robot, sample_s: f64) -> Result<Self, TwinError> {
        Ok(Self { tables: Tables::read(path)?, robot: robot.clone(), sample_s })
    }

    /// Their conditions; those without a table have that as the reason why they are not run.
    #[must_use]
    pub fn conditions(&self, plan: &Plan) -> Vec<Planned> {
        let planned = |(method, amplification): (Method, f64)| {
            let angles_rad = self.tables.angles_rad(&table(method, amplification)?, &self.robot);
            Some(Planned {
                place: Place { method, leg: self.robot.geometry.leg_scale, amplification },
                setpoint_speed_max_rad_s: None,
                not_run: angles_rad.err().map(|_| "the authors have no such table".to_owned()),
            })
        };
        Method::all()
            .flat_map(|method| plan.amplifications.iter().map(move |&a| (method, a)))
            .filter_map(planned)
            .collect()
    }

    /// Setpoints over time: each row is held for the sample time.
    fn setpoints(&self, place: Place) -> Option<impl Fn(f64) -> [f64; JOINT_COUNT] + Sync + use<>> {
        let angles_rad =
            self.tables.angles_rad(&table(place.method, place.amplification)?, &self.robot).ok()?;
        let sample_s = self.sample_s;
        Some(move |time_s: f64| {
            // Half a frame's hundredth: a time on the border belongs to the new row.
            let row = ((time_s + 0.01 / FRAME_RATE_HZ) / sample_s) as usize % angles_rad.len().max(1);
            angles_rad.get(row).copied().unwrap_or_default()
        })
    }
}

/// The authors' name of a table.
fn table(method: Method, amplification: f64) -> Option<Gait> {
    let Origin::AuthorsTables(name) = method.spec().origin else { return None };
    Some(Gait::new(name, amplification))
}

/// Walks some trials of a condition, on all cores, in the order of their numbers; those that have
/// not begun when `stop` is set are left out.
#[must_use]
pub fn walk(
    plan: &Plan,
    legs: &[Materials],
    authors: Option<&Authors>,
    place: Place,
    numbers: &[u32],
    stop: &AtomicBool,
) -> Vec<Trial> {
    if let Some((authors, setpoints)) = authors.and_then(|a| Some((a, a.setpoints(place)?))) {
        return each(plan, &authors.robot, place, numbers, "", stop, setpoints);
    }
    let same_legs = |materials: &&Materials| materials.robot.geometry.leg_scale == place.leg;
    let Some(materials) = legs.iter().find(same_legs) else { return Vec::new() };
    let material = materials.gaits.iter().find(|material| material.note.method == place.method);
    let (Some(material), Some(amplitude)) = (material, Amplitude::from_f64(place.amplification)) else {
        return Vec::new();
    };
    let playback = Playback::new(&material.playable, amplitude, &materials.robot);
    let setpoints = |time_s: f64| playback.setpoints_rad(time_s);
    each(plan, &materials.robot, place, numbers, &material.note.gait_sha256, stop, setpoints)
}

fn each(
    plan: &Plan,
    robot: &Robot,
    place: Place,
    numbers: &[u32],
    gait_sha256: &str,
    stop: &AtomicBool,
    setpoints: impl Fn(f64) -> [f64; JOINT_COUNT] + Sync,
) -> Vec<Trial> {
    let starts = Starts { perturbation: PERTURBATION, seed: plan.seed, count: plan.trials };
    let one = |&number: &u32| {
        if stop.load(Ordering::Relaxed) {
            return None;
        }
        let draw = if plan.robots_differ {
            Tolerances::default().draw(robot, plan.seed, number.into())
        } else {
            Draw { start: starts.start(number), ..Draw::nominal(robot) }
        };
        let duration_s = plan.duration_s;
        let trial = open_loop::Trial { duration_s, start: draw.start, ..open_loop::Trial::default() };
        let walk = open_loop::play_sound(&draw.robot, &trial, |time_s| {
            let mut angles_rad = setpoints(time_s);
            angles_rad.iter_mut().zip(draw.neutral_rad).for_each(|(angle, neutral)| *angle += neutral);
            angles_rad
        });
        Some(Trial::of(place, number, &raw(walk.as_ref(), plan, &draw.robot), gait_sha256))
    };
    numbers.par_iter().filter_map(one).collect()
}

/// What is measured of a walk; nothing if the simulation diverged.
fn raw(walk: Option<&Walk>, plan: &Plan, robot: &Robot) -> Raw {
    let unknown = Raw { duration_s: plan.duration_s, mass_kg: robot.mass_kg(), ..Raw::default() };
    let Some(walk) = walk else { return Raw { diverged: true, ..unknown } };
    Raw {
        energy_j: walk.energy_j,
        displacement_m: Some(walk.displacement_m),
        turned_deg: Some(walk.turned_rad.to_degrees()),
        fell: walk.fell,
        ..unknown
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::LegScale;

    #[test]
    fn after_ctrl_c_no_further_trial_is_walked_and_what_was_is_kept() {
        let robot = Robot::ant(LegScale::LONG).unwrap();
        let plan = Plan { duration_s: 0.1, ..Plan::paper(4, 0) };
        let place = Place { method: Method::Psto, leg: LegScale::LONG, amplification: 1.0 };
        let walked = |stop: bool| {
            let stop = AtomicBool::new(stop);
            each(&plan, &robot, place, &[0, 2], "abc", &stop, |_| [0.0; JOINT_COUNT])
        };

        assert_eq!(walked(false).iter().map(|trial| trial.trial).collect::<Vec<_>>(), [0, 2]);
        assert_eq!(walked(true), []);
    }
}
