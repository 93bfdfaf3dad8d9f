//! Report on a gait: over robots that no search has seen, over amplitudes, and
//! where its energy goes.
//!
//! Holds the sampling of these robots and the statistics. The numbers are
//! reported beside their bounds, without a verdict. Does not depend on how the
//! gait was found.

use super::score::{STRAINED_SHARE, Test};
use super::space::{Bounds, Motion};
use super::tolerances::{Draw, Tolerances};
use crate::energy::STANDARD_GRAVITY_M_S2;
use crate::robot::Robot;
use crate::search::null_is_infinite;
use crate::sim::World;
use crate::sim::open_loop::{FRAME_RATE_HZ, Walk};
use protocol::JOINT_COUNT;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};

/// Length of a trial, as in the paper.
pub const TRIAL_S: f64 = 12.0;
/// Numbers of sampled robots from this bit on belong to reports; searches have the lower ones.
const STAGE: u64 = 1 << 40;
/// With fewer there is no tenth.
pub const LEAST_DRAWS: usize = 8;
/// Amplitudes at which a gait is tested.
const AMPLITUDES: [f64; 11] = [0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.1, 1.2, 1.3, 1.4, 1.5];

/// Over draws: what half of them, nine tenths and a tenth stay below. A robot that stood still has
/// an infinite cost of transport.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Quantiles {
    /// A tenth is below.
    #[serde(deserialize_with = "null_is_infinite")]
    pub p10: f64,
    /// Half is below.
    #[serde(deserialize_with = "null_is_infinite")]
    pub median: f64,
    /// Nine tenths are below.
    #[serde(deserialize_with = "null_is_infinite")]
    pub p90: f64,
}

/// How a gait walks over draws.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct OverDraws {
    /// Number of robots.
    pub draws: usize,
    /// Energy per weight and distance, each robot by its own weight.
    pub cost_of_transport: Quantiles,
    /// Net distance over time.
    pub speed_m_s: Quantiles,
    /// Displacement along the world's x, which is forward.
    pub forward_m: Quantiles,
    /// Displacement along the world's y.
    pub sideways_m: Quantiles,
    /// From the supply.
    pub power_w: Quantiles,
    /// Turned in 12 s, either way.
    pub yaw_deg: Quantiles,
    /// Farthest that the torso leaned.
    pub tilt_deg: Quantiles,
    /// Share of the time with a servo at the end of its torque.
    pub strained_share: Quantiles,
    /// Robots that fell.
    pub fell: usize,
    /// Robots that touched the ground with torso, thighs or shins.
    pub dragged: usize,
    /// Robots whose servos, without load, are slower than the fastest setpoint, and lag.
    pub slower_servos: usize,
}

/// Robots of a report.
#[derive(Debug, Clone, Copy)]
pub struct Fresh<'a> {
    /// Of the sampled robots.
    pub seed: u64,
    /// Number of robots; once `stop` is set, [`LEAST_DRAWS`] are enough.
    pub draws: usize,
    /// Set to end the report early.
    pub stop: &'a AtomicBool,
}

/// How a gait walks at one amplitude.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct AtAmplitude {
    /// About the gait's own stroke, 1.0.
    pub amplitude: f64,
    /// Fastest setpoint.
    pub setpoint_speed_rad_s: f64,
    /// Whether joints and servos keep the bounds, no robot fell, and only feet touched the ground.
    pub safe: bool,
    /// How it walks there.
    pub walks: OverDraws,
}

/// Where the power goes, on the fitted robot.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct PowerBalance {
    /// Controller, driver, idle servos.
    pub electronics_w: f64,
    /// Friction under soles that slide.
    pub slipping_w: f64,
    /// Feet that are stopped by the ground.
    pub landing_w: f64,
    /// Work that the legs do on the servos, which cannot store it: braking, and
    /// legs that push against each other.
    pub braking_w: f64,
    /// Between horn and battery: the drive's losses and the windings' heat.
    pub drive_w: f64,
    /// Residual of the physics step.
    pub rest_w: f64,
    /// Sum of the parts.
    pub total_w: f64,
}

/// Plays a motion on new robots.
#[must_use]
pub fn over_draws(
    robot: &Robot,
    tolerances: &Tolerances,
    test: &Test,
    motion: &Motion,
    amplitude: f64,
    fresh: Fresh<'_>,
) -> OverDraws {
    let fastest_rad_s = motion.fastest_deg_s(amplitude).to_radians();
    let played = |number: u64| {
        let wanted = number < LEAST_DRAWS as u64 || !fresh.stop.load(Ordering::Relaxed);
        wanted.then(|| {
            let draw = tolerances.draw(robot, fresh.seed, STAGE | number);
            (test.walk(&draw, motion, amplitude), draw.robot.servo.top_speed_rad_s() < fastest_rad_s)
        })
    };
    let walks: Vec<(Walk, bool)> = (0..fresh.draws as u64).into_par_iter().filter_map(played).collect();
    let of = |value: fn(&Walk) -> f64| quantiles(walks.iter().map(|(walk, _)| value(walk)).collect());
    let count = |is: fn(&(Walk, bool)) -> bool| walks.iter().filter(|walk| is(walk)).count();
    OverDraws {
        draws: walks.len(),
        cost_of_transport: of(|walk| walk.cost_of_transport),
        speed_m_s: of(|walk| walk.speed_m_s),
        forward_m: of(|walk| walk.displacement_m[0]),
        sideways_m: of(|walk| walk.displacement_m[1]),
        power_w: of(|walk| walk.mean_power_w),
        yaw_deg: of(|walk| walk.turned_rad.to_degrees().abs()),
        tilt_deg: of(|walk| walk.max_tilt_rad.to_degrees()),
        strained_share: of(|walk| walk.strained_share),
        fell: count(|(walk, _)| walk.fell),
        dragged: count(|(walk, _)| walk.dragged_share > 0.0),
        slower_servos: count(|(_, slower)| *slower),
    }
}

fn quantiles(mut values: Vec<f64>) -> Quantiles {
    values.sort_by(f64::total_cmp);
    let at = |share: f64| {
        let Some(last) = values.len().checked_sub(1) else { return f64::NAN };
        let place = share * last as f64;
        let (below, above) = (place.floor() as usize, place.ceil() as usize);
        let part = place - below as f64;
        // Infinite costs have no middle.
        if part == 0.0 { values[below] } else { values[below] * (1.0 - part) + values[above] * part }
    };
    Quantiles { p10: at(0.1), median: at(0.5), p90: at(0.9) }
}

/// The gait from half its stroke to one and a half; nothing once `fresh.stop` is set.
#[must_use]
pub fn over_amplitudes(
    robot: &Robot,
    tolerances: &Tolerances,
    test: &Test,
    motion: &Motion,
    fresh: Fresh<'_>,
) -> Vec<AtAmplitude> {
    let bounds = Bounds::of(robot);
    let at = |amplitude: f64| {
        if fresh.stop.load(Ordering::Relaxed) {
            return None;
        }
        let walks = over_draws(robot, tolerances, test, motion, amplitude, fresh);
        let fastest_deg_s = motion.fastest_deg_s(amplitude);
        let keeps_bounds = fastest_deg_s <= robot.servo.top_speed_rad_s().to_degrees()
            && motion.excess_deg(&bounds, amplitude) <= 1e-6;
        let safe = keeps_bounds
            && walks.fell == 0
            && walks.dragged == 0
            && walks.strained_share.median <= STRAINED_SHARE;
        Some(AtAmplitude { amplitude, setpoint_speed_rad_s: fastest_deg_s.to_radians(), safe, walks })
    };
    // An incomplete list would read as if the rest were not safe.
    AMPLITUDES.into_iter().map(at).collect::<Option<_>>().unwrap_or_default()
}

/// The safe amplitudes about 1.0 without a gap; `None` if 1.0 is not safe.
#[must_use]
pub fn safe_range(amplitudes: &[AtAmplitude]) -> Option<(f64, f64)> {
    let own = amplitudes.iter().position(|at| at.amplitude == 1.0 && at.safe)?;
    let below = amplitudes[..=own].iter().rev().take_while(|at| at.safe).last()?;
    let above = amplitudes[own..].iter().take_while(|at| at.safe).last()?;
    Some((below.amplitude, above.amplitude))
}

/// Where the power of a walk on the fitted robot goes; `None` if the simulation diverges.
#[must_use]
pub fn power_balance(robot: &Robot, motion: &Motion) -> Option<PowerBalance> {
    power_balance_of(robot, |time_s| motion.angles_rad(time_s, 1.0))
}

/// The same of anything that gives setpoints in radians for a time in seconds.
pub fn power_balance_of(
    robot: &Robot,
    setpoints: impl Fn(f64) -> [f64; JOINT_COUNT],
) -> Option<PowerBalance> {
    // A simulation that diverges triggers assertions of the engine.
    let power = catch_unwind(AssertUnwindSafe(|| follow_power(robot, &setpoints))).ok()?;
    power.total_w.is_finite().then_some(power)
}

fn follow_power(robot: &Robot, gait: &dyn Fn(f64) -> [f64; JOINT_COUNT]) -> PowerBalance {
    let draw = Draw::nominal(robot);
    let mut world = World::new(robot);
    world.reset(&gait(0.0), &draw.start);
    let steps_per_frame = (1.0 / (FRAME_RATE_HZ * World::STEP_S)).round() as usize;
    let settle_frames = (2.0 * FRAME_RATE_HZ) as usize;
    let frames = settle_frames + (TRIAL_S * FRAME_RATE_HZ) as usize;
    let (mut slid_j, mut landed_j, mut returned_j, mut given_j, mut servo_j) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for frame in 0..frames {
        let setpoints = gait(frame as f64 / FRAME_RATE_HZ).map(Some);
        for _ in 0..steps_per_frame {
            let before = world.sole_velocities_m_s();
            let outcome = world.step(&setpoints);
            if frame < settle_frames {
                continue;
            }
            let losses = world.ground_losses(&before, &world.sole_velocities_m_s());
            slid_j += losses.slid_j;
            landed_j += losses.landed_j;
            returned_j += outcome.returned_power_w * World::STEP_S;
            given_j += outcome.mechanical_power_w * World::STEP_S;
            servo_j += outcome.servo_power_w * World::STEP_S;
        }
    }
    let watts = |energy_j: f64| energy_j / TRIAL_S;
    PowerBalance {
        electronics_w: robot.power.electronics_w,
        slipping_w: watts(slid_j),
        landing_w: watts(landed_j),
        braking_w: watts(returned_j),
        drive_w: watts(servo_j - given_j),
        rest_w: watts(given_j - slid_j - landed_j - returned_j),
        total_w: robot.power.electronics_w + watts(servo_j),
    }
}

/// Cost of transport of the electronics alone at a speed: a lower bound for any gait.
#[must_use]
pub fn floor(robot: &Robot, speed_m_s: f64) -> f64 {
    robot.power.electronics_w / (robot.mass_kg() * STANDARD_GRAVITY_M_S2 * speed_m_s)
}

#[cfg(test)]
mod tests;
