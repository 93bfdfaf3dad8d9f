//! Plays a gait on the simulated robot, open loop and without firmware.
//!
//! Holds the trial: a slow entry, then a walk whose setpoints are computed 60 times
//! a second and held, as on the robot. Does not depend on where the gait comes
//! from: it is a function from a time to eight angles. [`Playback`] is that function
//! for a gait as the robot plays it, and [`play_starts`] plays one from many starts.

mod direction;
mod playback;
mod starts;

pub use direction::{Direction, LEAST_DISTANCE_M, direction_warning};
pub use playback::Playback;
pub use starts::{Diverged, Starts, play_sound, play_starts};

use super::start::Start;
use super::world::World;
use crate::energy::STANDARD_GRAVITY_M_S2;
use crate::robot::Robot;
use protocol::JOINT_COUNT;

/// Setpoints a second, the robot's frame rate.
pub const FRAME_RATE_HZ: f64 = protocol::FRAME_RATE_HZ as f64;

/// A servo whose torque is more than this share of its limit is strained.
pub const STRAINED: f64 = 0.95;

/// How a trial is run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Trial {
    /// Time from standing at neutral to the gait's first pose; not measured.
    pub entry_s: f64,
    /// The measured walk.
    pub duration_s: f64,
    /// Heading, height, joint angles and friction at the start.
    pub start: Start,
}

impl Default for Trial {
    /// The paper's 12 s, after an entry slower than any servo.
    fn default() -> Self {
        Self { entry_s: 1.5, duration_s: 12.0, start: Start::default() }
    }
}

/// Result of a walk, over the measured time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Walk {
    /// Net horizontal displacement.
    pub distance_m: f64,
    /// Displacement along the world's x and y.
    pub displacement_m: [f64; 2],
    /// Distance over time.
    pub speed_m_s: f64,
    /// From the supply, servos and electronics.
    pub energy_j: f64,
    /// Energy over time.
    pub mean_power_w: f64,
    /// Positive work of the servos' horns over time.
    pub mean_mechanical_power_w: f64,
    /// Heat of the servos' windings that the supply delivers, over time.
    pub mean_holding_power_w: f64,
    /// Energy per weight and distance; infinite if the robot stood still.
    pub cost_of_transport: f64,
    /// Change of heading, counter-clockwise, whole turns included.
    pub turned_rad: f64,
    /// Maximum speed of the torso in any direction, the entry included; NaN if the
    /// simulation diverged.
    pub fastest_m_s: f64,
    /// Maximum angle between the torso's z axis and the world's.
    pub max_tilt_rad: f64,
    /// Share of the time in which anything but the feet touched the ground.
    pub dragged_share: f64,
    /// Share of the time in which a servo pulled with more than [`STRAINED`] of its torque.
    pub strained_share: f64,
    /// Share of the time in which the servos asked for more power than the supply gives.
    pub supply_limited_share: f64,
    /// Whether it fell at any time, the entry included.
    pub fell: bool,
}

/// No servos move a torso faster than this: the simulation diverged.
const DIVERGED_M_S: f64 = 100.0;

impl Walk {
    /// Whether all numbers are finite and possible; the cost of transport may be infinite.
    #[must_use]
    pub fn is_sound(&self) -> bool {
        let numbers = [self.distance_m, self.energy_j, self.turned_rad, self.max_tilt_rad];
        // False for NaN.
        numbers.iter().all(|number| number.is_finite()) && self.fastest_m_s < DIVERGED_M_S
    }
}

/// Plays `gait` in a new world: from a time in seconds, from 0, to angles in radians.
pub fn play(robot: &Robot, trial: &Trial, mut gait: impl FnMut(f64) -> [f64; JOINT_COUNT]) -> Walk {
    play_in(&mut World::new(robot), trial, &mut gait)
}

/// Resets `world` to the trial's start and plays `gait` in it.
pub fn play_in(world: &mut World, trial: &Trial, gait: &mut dyn FnMut(f64) -> [f64; JOINT_COUNT]) -> Walk {
    world.reset(&[0.0; JOINT_COUNT], &trial.start);
    let frames = |duration_s: f64| (duration_s * FRAME_RATE_HZ).round().max(0.0) as usize;

    let first = gait(0.0);
    let mut fell = false;
    let mut fastest_m_s = 0.0_f64;
    let mut note_speed = |world: &World| {
        let speed_m_s = speed_m_s(world);
        // Not `max`, which would drop a NaN.
        if speed_m_s > fastest_m_s || speed_m_s.is_nan() {
            fastest_m_s = speed_m_s;
        }
    };
    // In the last third of the entry the setpoints stand still: servos arrive, the body settles.
    let entry_frames = frames(trial.entry_s);
    for frame in 0..entry_frames {
        let share = (1.5 * (frame + 1) as f64 / entry_frames as f64).min(1.0);
        for _ in 0..World::STEPS_PER_FRAME {
            world.step(&first.map(|angle| Some(share * angle)));
        }
        fell |= world.has_fallen();
        note_speed(world);
    }

    let before = world.torso();
    let frame_count = frames(trial.duration_s);
    let mut servo_energy_j = 0.0;
    let (mut mechanical_j, mut holding_j) = (0.0, 0.0);
    let mut turned_rad = 0.0;
    let mut yaw_rad = before.yaw_rad();
    let mut max_tilt_rad = 0.0_f64;
    let mut dragged_frames = 0;
    let mut strained_steps = 0;
    let mut limited_steps = 0.0;
    for frame in 0..frame_count {
        let setpoints = gait(frame as f64 / FRAME_RATE_HZ).map(Some);
        for _ in 0..World::STEPS_PER_FRAME {
            let outcome = world.step(&setpoints);
            servo_energy_j += outcome.servo_power_w * World::STEP_S;
            mechanical_j += outcome.mechanical_power_w * World::STEP_S;
            holding_j += outcome.holding_power_w * World::STEP_S;
            strained_steps += usize::from(outcome.torque_share > STRAINED);
            limited_steps += outcome.supply_limited_share;
        }
        let torso = world.torso();
        let turn_rad = torso.yaw_rad() - yaw_rad;
        turned_rad += turn_rad - core::f64::consts::TAU * (turn_rad / core::f64::consts::TAU).round();
        yaw_rad = torso.yaw_rad();
        max_tilt_rad = max_tilt_rad.max(torso.tilt_rad());
        note_speed(world);
        dragged_frames += usize::from(world.body_touches_ground());
        fell |= world.has_fallen();
    }

    let after = world.torso();
    let duration_s = (frame_count as f64 / FRAME_RATE_HZ).max(World::STEP_S);
    let displacement_m = [0, 1].map(|axis| after.position_m[axis] - before.position_m[axis]);
    let distance_m = displacement_m[0].hypot(displacement_m[1]);
    let electronics_w = world.robot().power.electronics_w.min(world.robot().supply.most_power_w());
    let energy_j = servo_energy_j + electronics_w * duration_s;
    Walk {
        distance_m,
        displacement_m,
        speed_m_s: distance_m / duration_s,
        energy_j,
        mean_power_w: energy_j / duration_s,
        mean_mechanical_power_w: mechanical_j / duration_s,
        mean_holding_power_w: holding_j / duration_s,
        cost_of_transport: energy_j / (world.robot().mass_kg() * STANDARD_GRAVITY_M_S2 * distance_m),
        turned_rad,
        fastest_m_s,
        max_tilt_rad,
        dragged_share: dragged_frames as f64 / frame_count.max(1) as f64,
        strained_share: strained_steps as f64 / (frame_count * World::STEPS_PER_FRAME).max(1) as f64,
        supply_limited_share: limited_steps / (frame_count * World::STEPS_PER_FRAME).max(1) as f64,
        fell,
    }
}

/// Speed of the torso; NaN if a joint's coordinate is not finite. The engine does
/// not report that, and the torso may then stand still for ever.
fn speed_m_s(world: &World) -> f64 {
    let has_numbers = world.joint_angles_rad().iter().all(|angle| angle.is_finite());
    let speed = world.torso().velocity_m_s.iter().map(|v| v * v).sum::<f64>().sqrt();
    if has_numbers { speed } else { f64::NAN }
}

#[cfg(test)]
mod tests;
