//! The robot on flat ground, in steps of 1/240 s.
//!
//! Holds the power of the servos and the way torques act on the body. Does not
//! depend on gaits or rewards. The same calls give the same bits in every process:
//! each start builds a new world, and nothing in it runs in threads.
//!
//! The world's frame is that of the start: origin under the torso's middle, z
//! up, x between legs 4 and 1. Lengths are f64 outside, f32 in the engine.

mod ground;

pub use ground::{GroundLosses, Soles};

use super::body::{Body, Pose0, frame, real};
use super::servos::Servos;
use super::start::Start;
use super::torso::TorsoState;
use crate::robot::{Limbs, Robot};
use protocol::{JOINT_COUNT, LEG_COUNT};
use rapier3d::prelude::*;
use std::sync::Arc;

/// A foot nearer to the ground than this is in contact.
const CONTACT_M: f64 = 0.001;
/// Beyond this tilt the robot has fallen: it does not stand up again by itself.
const FALLEN_TILT_RAD: f64 = 1.0;
/// Minimum of the supply's voltage under load, as a share of nominal. Below it a
/// servo's own electronics would reset, which is not modelled.
const LEAST_VOLTAGE_SHARE: f64 = 0.5;

/// The simulated robot.
pub struct World {
    robot: Robot,
    limbs: Arc<Limbs>,
    body: Body,
    servos: Servos,
    joint_angles_rad: [f64; JOINT_COUNT],
    joint_speeds_rad_s: [f64; JOINT_COUNT],
    /// Physics steps in a [`World::STEP_S`].
    substeps: u32,
    /// The supply's voltage over nominal, under the load of the step before.
    voltage_share: f64,
}

/// Power of one step, over all servos.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct StepOutcome {
    /// Electrical power of all servos at the supply, without the electronics.
    pub servo_power_w: f64,
    /// Mechanical power that servos deliver: the sum of torque times speed over those
    /// where it is positive. A servo that the load drives returns nothing to the supply.
    pub mechanical_power_w: f64,
    /// Mechanical power that servos take back from the robot; it becomes heat.
    pub returned_power_w: f64,
    /// Heat of all windings.
    pub heat_power_w: f64,
    /// The part of the windings' heat that the supply delivers: power returned to a
    /// servo heats its winding first.
    pub holding_power_w: f64,
    /// Maximum over servos of torque over torque limit.
    pub torque_share: f64,
    /// Share of the step in which the servos asked for more power than the supply
    /// gives. What is counted above is what it gives.
    pub supply_limited_share: f64,
}

impl World {
    /// Physics steps in a frame of the robot, which is a control step of the task.
    pub const STEPS_PER_FRAME: usize = 4;

    /// Length of a physics step: 1/240 s.
    pub const STEP_S: f64 = 1.0 / (protocol::FRAME_RATE_HZ as f64 * Self::STEPS_PER_FRAME as f64);

    /// The robot standing at neutral.
    #[must_use]
    pub fn new(robot: &Robot) -> Self {
        Self::refined(robot, 1)
    }

    /// The same, with `substeps` physics steps, at least 1, each [`Self::STEP_S`]: shows how
    /// much of a result is an error of the step.
    #[must_use]
    pub fn refined(robot: &Robot, substeps: u32) -> Self {
        let limbs = Arc::new(Limbs::of(robot));
        Self::standing(robot.clone(), limbs, &[0.0; JOINT_COUNT], &Start::default(), substeps.max(1))
    }

    /// Starts again, standing with these joint angles, changed by `start`.
    pub fn reset(&mut self, joint_angles_rad: &[f64; JOINT_COUNT], start: &Start) {
        let (robot, limbs) = (self.robot.clone(), Arc::clone(&self.limbs));
        *self = Self::standing(robot, limbs, joint_angles_rad, start, self.substeps);
    }

    /// The same, with another robot.
    pub fn reset_as(&mut self, robot: Robot, joint_angles_rad: &[f64; JOINT_COUNT], start: &Start) {
        let limbs = Arc::new(Limbs::of(&robot));
        *self = Self::standing(robot, limbs, joint_angles_rad, start, self.substeps);
    }

    fn standing(
        robot: Robot,
        limbs: Arc<Limbs>,
        asked_rad: &[f64; JOINT_COUNT],
        start: &Start,
        substeps: u32,
    ) -> Self {
        let angles: [f64; JOINT_COUNT] = core::array::from_fn(|j| asked_rad[j] + start.joint_offsets_rad[j]);
        let step_s = Self::STEP_S / f64::from(substeps);
        let pose = Pose0 {
            joint_angles_rad: angles,
            height_m: limbs.standing_height_m(&angles) + start.drop_m,
            yaw_rad: start.yaw_rad,
            friction: (robot.ground.friction * (1.0 + start.friction_share)).max(0.0),
            step_s,
        };
        Self {
            body: Body::new(&limbs, &robot.servo, &pose),
            servos: Servos::new(&robot, &limbs, &angles, step_s),
            robot,
            limbs,
            joint_angles_rad: angles,
            joint_speeds_rad_s: [0.0; JOINT_COUNT],
            substeps,
            voltage_share: 1.0,
        }
    }

    /// The robot in this world.
    #[must_use]
    pub fn robot(&self) -> &Robot {
        &self.robot
    }

    /// Advances by [`Self::STEP_S`]. `None` is a servo without pulses: its motor
    /// gives no torque, and only its gears resist. A setpoint beyond the end stop is
    /// clamped to it, and NaN keeps the setpoint before. Servos act on a setpoint after
    /// their delay, rounded to the physics step.
    pub fn step(&mut self, setpoints_rad: &[Option<f64>; JOINT_COUNT]) -> StepOutcome {
        let mut mean = StepOutcome::default();
        let share = 1.0 / f64::from(self.substeps);
        for _ in 0..self.substeps {
            let one = self.substep(setpoints_rad);
            mean.servo_power_w += share * one.servo_power_w;
            mean.mechanical_power_w += share * one.mechanical_power_w;
            mean.returned_power_w += share * one.returned_power_w;
            mean.heat_power_w += share * one.heat_power_w;
            mean.holding_power_w += share * one.holding_power_w;
            mean.torque_share = mean.torque_share.max(one.torque_share);
            mean.supply_limited_share += share * one.supply_limited_share;
        }
        mean
    }

    fn substep(&mut self, asked_rad: &[Option<f64>; JOINT_COUNT]) -> StepOutcome {
        let setpoints_rad = self.servos.receive(asked_rad);
        let mut at_stops_n_m = [0.0; JOINT_COUNT];
        let torques_n_m = core::array::from_fn(|j| {
            let angle_rad = self.joint_angles_rad[j];
            at_stops_n_m[j] = self.servos.stop_n_m(j, angle_rad);
            self.servos.pull_n_m(&self.robot.servo, j, setpoints_rad[j], angle_rad, self.voltage_share)
        });
        let speeds_before_rad_s = self.joint_speeds_rad_s;
        let dampings_n_m_s_rad =
            self.servos.dampings_n_m_s_rad(&self.robot.servo, &torques_n_m, &speeds_before_rad_s);
        self.body.set_damping(&dampings_n_m_s_rad);
        self.apply(&torques_n_m);
        self.body.physics.step();
        self.read_joints();

        let mut outcome = StepOutcome::default();
        let (power, supply) = (&self.robot.power, &self.robot.supply);
        for (j, pull_n_m) in torques_n_m.iter().enumerate() {
            // Without pulses the gears only brake, and no power is drawn.
            if setpoints_rad[j].is_none() {
                continue;
            }
            // Damping is implicit: it acts at the speed after the step.
            let torque_n_m = pull_n_m - dampings_n_m_s_rad[j] * self.joint_speeds_rad_s[j];
            let speed_rad_s = 0.5 * (speeds_before_rad_s[j] + self.joint_speeds_rad_s[j]);
            let horn_w = torque_n_m * speed_rad_s;
            let pulled = pull_n_m.abs() / self.robot.servo.torque_limit_n_m;
            outcome.torque_share = outcome.torque_share.max(pulled);
            // Torque that the gears' friction or the end stop takes up does not pass the winding.
            let motor_n_m =
                pull_n_m - at_stops_n_m[j] - self.robot.servo.damping_n_m_s_rad * self.joint_speeds_rad_s[j];
            let heat_w = power.heat_w_per_n2_m2 * motor_n_m * motor_n_m;
            outcome.mechanical_power_w += horn_w.max(0.0);
            outcome.returned_power_w += (-horn_w).max(0.0);
            outcome.heat_power_w += heat_w;
            outcome.holding_power_w += (heat_w + (motor_n_m * speed_rad_s).min(0.0)).max(0.0);
        }
        outcome.servo_power_w = outcome.mechanical_power_w / power.efficiency + outcome.holding_power_w;
        let current_a = outcome.servo_power_w / supply.nominal_v;
        self.voltage_share =
            (1.0 - current_a * supply.resistance_ohm / supply.nominal_v).max(LEAST_VOLTAGE_SHARE);
        // Nothing draws more than a supply gives, whatever the torques are.
        let most_w = (supply.most_power_w() - power.electronics_w).max(0.0);
        if outcome.servo_power_w > most_w {
            let share = most_w / outcome.servo_power_w;
            outcome.servo_power_w = most_w;
            outcome.mechanical_power_w *= share;
            outcome.holding_power_w *= share;
            outcome.supply_limited_share = 1.0;
        }
        outcome
    }

    /// Applies each torque to the child, and its reaction to the parent, about the joint's axis.
    fn apply(&mut self, torques_n_m: &[f64; JOINT_COUNT]) {
        let Body { physics, torso, thighs, shins, axes, .. } = &mut self.body;
        let bodies = &mut physics.bodies;
        let torso_turn = *bodies[*torso].rotation();
        let mut on_torso = Vector::ZERO;
        for leg in 0..LEG_COUNT {
            let hip = (torso_turn * axes[leg]) * real(torques_n_m[leg]);
            let thigh = &mut bodies[thighs[leg]];
            let knee = (*thigh.rotation() * axes[LEG_COUNT + leg]) * real(torques_n_m[LEG_COUNT + leg]);
            thigh.reset_torques(false);
            thigh.add_torque(hip - knee, false);
            let shin = &mut bodies[shins[leg]];
            shin.reset_torques(false);
            shin.add_torque(knee, false);
            on_torso -= hip;
        }
        let torso = &mut bodies[*torso];
        torso.reset_torques(false);
        torso.add_torque(on_torso, false);
    }

    fn read_joints(&mut self) {
        let Some(multibody) = self.body.physics.multibody_joints.get_multibody(self.body.multibody) else {
            return;
        };
        let speeds = multibody.generalized_velocity();
        // After the torso's six, or none where a test holds it fixed.
        let first = speeds.len().saturating_sub(JOINT_COUNT);
        for (j, link) in multibody.links().skip(1).enumerate() {
            // The hinge turns about the x axis of its frame: coordinate 3.
            self.joint_angles_rad[j] = f64::from(link.joint().coords()[3]);
            self.joint_speeds_rad_s[j] = f64::from(speeds[first + j]);
        }
    }

    /// Position, orientation and velocity of the torso.
    #[must_use]
    pub fn torso(&self) -> TorsoState {
        let torso = &self.body.physics.bodies[self.body.torso];
        let wide = |v: Vector| v.to_array().map(f64::from);
        TorsoState {
            position_m: wide(torso.translation()),
            orientation_xyzw: torso.rotation().to_array().map(f64::from),
            velocity_m_s: wide(torso.linvel()),
            angular_velocity_rad_s: wide(torso.angvel()),
        }
    }

    /// Joint angles from neutral, hips 1 to 4, then knees.
    #[must_use]
    pub fn joint_angles_rad(&self) -> [f64; JOINT_COUNT] {
        self.joint_angles_rad
    }

    /// Joint speeds, hips 1 to 4, then knees.
    #[must_use]
    pub fn joint_speeds_rad_s(&self) -> [f64; JOINT_COUNT] {
        self.joint_speeds_rad_s
    }

    /// Each servo's own setpoint, on its way to the given one.
    #[must_use]
    pub fn servo_setpoints_rad(&self) -> [f64; JOINT_COUNT] {
        self.servos.setpoints_rad()
    }

    /// Middle of each foot's ball, legs 1 to 4, in the world's frame.
    #[must_use]
    pub fn feet_m(&self) -> [[f64; 3]; LEG_COUNT] {
        self.on_shins(&self.body.feet)
    }

    /// A point of each knee's axis, legs 1 to 4, in the world's frame.
    #[must_use]
    pub fn knees_m(&self) -> [[f64; 3]; LEG_COUNT] {
        self.on_shins(&self.body.knees)
    }

    fn on_shins(&self, points: &[Vector; LEG_COUNT]) -> [[f64; 3]; LEG_COUNT] {
        core::array::from_fn(|leg| {
            let shin = &self.body.physics.bodies[self.body.shins[leg]];
            shin.position().transform_point(points[leg]).to_array().map(f64::from)
        })
    }

    /// Which feet are in contact with the ground, legs 1 to 4.
    #[must_use]
    pub fn foot_contacts(&self) -> [bool; LEG_COUNT] {
        let radius_m = self.limbs.foot_radius_m;
        self.feet_m().map(|[.., z]| z < radius_m + CONTACT_M)
    }

    /// Whether anything but the feet touches the ground. A shin that touches within
    /// its foot's ball, as one that ends in a ball of its own thickness does, is the foot.
    #[must_use]
    pub fn body_touches_ground(&self) -> bool {
        let Body { physics, torso, thighs, shins, .. } = &self.body;
        let bodies = self.limbs.legs.iter().map(|leg| &leg.thigh).zip(thighs);
        let touches = core::iter::once((&self.limbs.torso, torso)).chain(bodies).any(|(link, handle)| {
            let pose = frame(physics.bodies[*handle].position());
            link.solids.iter().any(|solid| solid.lowest_m(&pose) < CONTACT_M)
        });
        let foot_m = self.limbs.foot_radius_m + CONTACT_M;
        touches
            || self.limbs.legs.iter().zip(shins).any(|(leg, handle)| {
                let pose = frame(physics.bodies[*handle].position());
                let middle = pose * leg.foot_m;
                leg.shin.solids.iter().any(|solid| solid.touches_beyond(&pose, CONTACT_M, &middle, foot_m))
            })
    }

    /// Whether the torso leans more than 1 rad.
    #[must_use]
    pub fn has_fallen(&self) -> bool {
        self.torso().tilt_rad() > FALLEN_TILT_RAD
    }
}

#[cfg(test)]
mod energy_balance;
#[cfg(test)]
mod gears;
#[cfg(test)]
mod pendulum;
#[cfg(test)]
mod pony;
#[cfg(test)]
mod tests;
