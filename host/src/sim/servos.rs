//! The model of eight position servos: from setpoints to torques.
//!
//! Holds their delay, their own setpoints, which move towards the given ones at
//! limited speed, and the end stops. Does not depend on bodies: angles in, torques out.

use crate::robot::{Limbs, Robot, Servo};
use protocol::JOINT_COUNT;
use std::collections::VecDeque;

/// Torque per radian beyond a joint's end; with the servo's own damping it
/// stops a shin of the Ant within a degree.
const END_STOP_N_M_RAD: f64 = 20.0;
/// The same for strong servos, a multiple of their torque: they exceed the end stop by two degrees at most.
const END_STOP_PER_TORQUE_RAD: f64 = 30.0;

/// Time constant of the smoothed joint speed that decides whether the motor or the load
/// turns a joint: contact forces vary from step to step, and gears do not react to that.
const DIRECTION_S: f64 = 0.02;

/// The state of eight servos.
pub struct Servos {
    /// Each servo's own setpoint, on its way to the given one.
    setpoints_rad: [f64; JOINT_COUNT],
    /// Setpoints within the servos' delay, the oldest first.
    waiting: VecDeque<[Option<f64>; JOINT_COUNT]>,
    /// End stops of each joint, and the torque per radian beyond.
    stops_rad: [[f64; 2]; JOINT_COUNT],
    stops_n_m_rad: [f64; JOINT_COUNT],
    /// Joint speeds, smoothed over [`DIRECTION_S`].
    smoothed_rad_s: [f64; JOINT_COUNT],
    step_s: f64,
}

impl Servos {
    /// Servos that hold these angles until the first setpoints have passed the delay.
    pub fn new(robot: &Robot, limbs: &Limbs, angles_rad: &[f64; JOINT_COUNT], step_s: f64) -> Self {
        let delay_steps = (robot.servo.delay_s / step_s).round() as usize;
        Self {
            setpoints_rad: *angles_rad,
            waiting: VecDeque::from(vec![angles_rad.map(Some); delay_steps]),
            stops_rad: limbs.stops_rad(robot),
            stops_n_m_rad: stop_stiffness_n_m_rad(limbs, &robot.servo, step_s),
            smoothed_rad_s: [0.0; JOINT_COUNT],
            step_s,
        }
    }

    /// Each servo's own setpoint.
    pub fn setpoints_rad(&self) -> [f64; JOINT_COUNT] {
        self.setpoints_rad
    }

    /// Takes this step's setpoints, and returns those of the delay before.
    pub fn receive(&mut self, asked_rad: &[Option<f64>; JOINT_COUNT]) -> [Option<f64>; JOINT_COUNT] {
        self.waiting.push_back(*asked_rad);
        // Never empty: one was just pushed.
        self.waiting.pop_front().unwrap_or(*asked_rad)
    }

    /// Damping of each joint in the coming step.
    pub fn dampings_n_m_s_rad(
        &mut self,
        servo: &Servo,
        pulls_n_m: &[f64; JOINT_COUNT],
        speeds_rad_s: &[f64; JOINT_COUNT],
    ) -> [f64; JOINT_COUNT] {
        let share = self.step_s / (DIRECTION_S + self.step_s);
        core::array::from_fn(|j| {
            let speed_rad_s = &mut self.smoothed_rad_s[j];
            *speed_rad_s += share * (speeds_rad_s[j] - *speed_rad_s);
            servo.damping_at(pulls_n_m[j], *speed_rad_s)
        })
    }

    /// Moves one servo's own setpoint and returns its torque, end stop included.
    pub fn pull_n_m(
        &mut self,
        servo: &Servo,
        j: usize,
        asked_rad: Option<f64>,
        angle_rad: f64,
        voltage_share: f64,
    ) -> f64 {
        let setpoint = &mut self.setpoints_rad[j];
        let pull_n_m = match asked_rad {
            None => {
                // When setpoints come again, it starts from the present angle.
                *setpoint = angle_rad;
                0.0
            }
            Some(asked_rad) => {
                let reach_rad = servo.no_load_speed_rad_s * voltage_share * self.step_s;
                if asked_rad.is_finite() {
                    let stop_rad = servo.end_stop_deg.to_radians();
                    let asked_rad = asked_rad.clamp(-stop_rad, stop_rad);
                    *setpoint += (asked_rad - *setpoint).clamp(-reach_rad, reach_rad);
                }
                let limit_n_m = servo.torque_limit_n_m;
                let (error_rad, dead_rad) = (*setpoint - angle_rad, servo.dead_band_deg.to_radians());
                let outside_rad = error_rad - error_rad.clamp(-dead_rad, dead_rad);
                // The motor's voltage, and with it the torque, is proportional to the supply's.
                voltage_share * (servo.stiffness_n_m_rad * outside_rad).clamp(-limit_n_m, limit_n_m)
            }
        };
        pull_n_m - self.beyond_stop_n_m(j, angle_rad)
    }

    /// The part of [`Self::pull_n_m`] that is the end stop's, at the same angle.
    pub fn stop_n_m(&self, j: usize, angle_rad: f64) -> f64 {
        -self.beyond_stop_n_m(j, angle_rad)
    }

    fn beyond_stop_n_m(&self, j: usize, angle_rad: f64) -> f64 {
        let [low_rad, high_rad] = self.stops_rad[j];
        self.stops_n_m_rad[j] * (angle_rad - angle_rad.max(low_rad).min(high_rad))
    }
}

/// As stiff as wanted, but no stiffer than is stable: the spring is explicit, so its
/// stiffness is limited by the step, the inertia it turns and the joint's damping.
/// The links before it move too, so that only a part of the carried inertia counts.
fn stop_stiffness_n_m_rad(limbs: &Limbs, servo: &Servo, step_s: f64) -> [f64; JOINT_COUNT] {
    let wanted = END_STOP_N_M_RAD.max(END_STOP_PER_TORQUE_RAD * servo.torque_limit_n_m);
    let most = |carried: f64| (carried / (2.0 * step_s) + servo.damping_n_m_s_rad) / step_s;
    limbs.carried_kg_m2().map(|carried| wanted.min(most(carried)))
}
