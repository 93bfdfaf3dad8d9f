//! The law of eight position servos: from pulses to torques.
//!
//! Owns their delay, their own setpoints on the way to the asked ones, and the
//! joints' ends. Refuses to know bodies: it sees angles and gives torques.

use crate::robot::{Limbs, Robot, Servo};
use std::collections::VecDeque;

/// Torque per radian beyond a joint's end; with the servo's own damping it
/// stops a shin of the Ant within a degree.
const END_STOP_N_M_RAD: f64 = 20.0;
/// The same for strong servos, a multiple of their torque: they push no more than two degrees in.
const END_STOP_PER_TORQUE_RAD: f64 = 30.0;

/// A joint's speed counts as one way or the other over this time: contacts
/// tremble from step to step, and gears do not notice.
const WAY_S: f64 = 0.02;

/// Eight servos.
pub struct Servos {
    /// Where each servo's own setpoint has got to.
    setpoints_rad: [f64; 8],
    /// What is asked for but not yet acted on, the oldest first.
    waiting: VecDeque<[Option<f64>; 8]>,
    /// How far each joint turns, and the torque per radian beyond.
    stops_rad: [[f64; 2]; 8],
    stops_n_m_rad: [f64; 8],
    /// Which way each joint has turned of late: its speed, smoothed over [`WAY_S`].
    ways_rad_s: [f64; 8],
    step_s: f64,
}

impl Servos {
    /// Servos that hold these angles, and will until the first pulses get through.
    pub fn new(robot: &Robot, limbs: &Limbs, angles_rad: &[f64; 8], step_s: f64) -> Self {
        let delay_steps = (robot.servo.delay_s / step_s).round() as usize;
        Self {
            setpoints_rad: *angles_rad,
            waiting: VecDeque::from(vec![angles_rad.map(Some); delay_steps]),
            stops_rad: limbs.stops_rad(robot),
            stops_n_m_rad: stop_stiffness_n_m_rad(limbs, &robot.servo, step_s),
            ways_rad_s: [0.0; 8],
            step_s,
        }
    }

    /// Where each servo's own setpoint has got to.
    pub fn setpoints_rad(&self) -> [f64; 8] {
        self.setpoints_rad
    }

    /// Takes this step's pulses, and gives those that are acted on in it.
    pub fn receive(&mut self, asked_rad: &[Option<f64>; 8]) -> [Option<f64>; 8] {
        self.waiting.push_back(*asked_rad);
        // Never empty: one was pushed.
        self.waiting.pop_front().unwrap_or(*asked_rad)
    }

    /// What resists each joint's speed in the coming step.
    pub fn dampings_n_m_s_rad(
        &mut self,
        servo: &Servo,
        pulls_n_m: &[f64; 8],
        speeds_rad_s: &[f64; 8],
    ) -> [f64; 8] {
        let share = self.step_s / (WAY_S + self.step_s);
        core::array::from_fn(|j| {
            let way_rad_s = &mut self.ways_rad_s[j];
            *way_rad_s += share * (speeds_rad_s[j] - *way_rad_s);
            servo.damping_at(pulls_n_m[j], *way_rad_s)
        })
    }

    /// One servo's law: where its setpoint goes and how hard it pulls.
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
                // It starts again from wherever it is.
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
                // A bridge's voltage, and so the torque, goes with the supply's.
                voltage_share * (servo.stiffness_n_m_rad * outside_rad).clamp(-limit_n_m, limit_n_m)
            }
        };
        let [low_rad, high_rad] = self.stops_rad[j];
        pull_n_m - self.stops_n_m_rad[j] * (angle_rad - angle_rad.max(low_rad).min(high_rad))
    }
}

/// Hard, but a spring that is computed from the step before must not be harder
/// than its step, what it turns and the joint's damping allow. The links before
/// it give way, too, so that it turns a fraction of what it carries.
fn stop_stiffness_n_m_rad(limbs: &Limbs, servo: &Servo, step_s: f64) -> [f64; 8] {
    let wanted = END_STOP_N_M_RAD.max(END_STOP_PER_TORQUE_RAD * servo.torque_limit_n_m);
    let most = |carried: f64| (carried / (2.0 * step_s) + servo.damping_n_m_s_rad) / step_s;
    limbs.carried_kg_m2().map(|carried| wanted.min(most(carried)))
}
