//! From servo pulses to a body: the angle that a position servo takes from its signal.
//!
//! Holds the calibration of the servos' pulses and the narrow view of a body
//! that the virtual robot needs. Does not depend on physics: [`host::sim::World`]
//! has them, and [`Bench`] has none.

use host::robot::Servo;
use host::sim::World;

/// Joints, in the protocol's order.
pub const JOINT_COUNT: usize = protocol::JOINT_COUNT;

/// Body steps in an emulated second; one frame of the firmware is four.
pub const STEPS_PER_S: u64 = 240;

/// Where the torso is.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Pose {
    /// Of the torso's middle.
    pub position_m: [f64; 3],
    /// Heading, counter-clockwise from the world's x.
    pub yaw_rad: f64,
    /// Angle between the torso's z axis and the world's.
    pub tilt_rad: f64,
}

/// A body with eight servos.
pub trait Body {
    /// Advances by 1/240 s and returns the servos' mean electrical power in
    /// watts. `None` is a servo without pulses.
    fn step(&mut self, setpoints_rad: &[Option<f64>; JOINT_COUNT]) -> f64;
    /// Where the torso is.
    fn pose(&self) -> Pose;
    /// Joint angles from neutral.
    fn joint_angles_rad(&self) -> [f64; JOINT_COUNT];
}

impl Body for World {
    fn step(&mut self, setpoints_rad: &[Option<f64>; JOINT_COUNT]) -> f64 {
        World::step(self, setpoints_rad).servo_power_w
    }

    fn pose(&self) -> Pose {
        let torso = self.torso();
        Pose { position_m: torso.position_m, yaw_rad: torso.yaw_rad(), tilt_rad: torso.tilt_rad() }
    }

    fn joint_angles_rad(&self) -> [f64; JOINT_COUNT] {
        World::joint_angles_rad(self)
    }
}

/// Servos in a vice: ideal ones, that draw a given power while they get pulses.
#[derive(Debug, Clone, Default)]
pub struct Bench {
    /// Each servo with pulses draws this.
    pub power_per_servo_w: f64,
    angles_rad: [f64; JOINT_COUNT],
}

impl Bench {
    /// Eight servos of this power.
    #[must_use]
    pub fn new(power_per_servo_w: f64) -> Self {
        Self { power_per_servo_w, angles_rad: [0.0; JOINT_COUNT] }
    }
}

impl Body for Bench {
    fn step(&mut self, setpoints_rad: &[Option<f64>; JOINT_COUNT]) -> f64 {
        let mut power_w = 0.0;
        for (angle, setpoint) in self.angles_rad.iter_mut().zip(setpoints_rad) {
            if let Some(setpoint) = setpoint {
                *angle = *setpoint;
                power_w += self.power_per_servo_w;
            }
        }
        power_w
    }

    fn pose(&self) -> Pose {
        Pose::default()
    }

    fn joint_angles_rad(&self) -> [f64; JOINT_COUNT] {
        self.angles_rad
    }
}

/// How the servos read their pulses, and which output each is wired to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PulseScale {
    /// Holds the servo at neutral.
    pub neutral_us: f64,
    /// Change per degree.
    pub us_per_deg: f64,
    /// Output of each joint.
    pub channels: [u8; JOINT_COUNT],
    /// Whether each servo turns against its joint.
    pub reversed: [bool; JOINT_COUNT],
}

impl PulseScale {
    /// The scale and wiring of a robot's servos.
    #[must_use]
    pub fn of(servo: &Servo) -> Self {
        Self {
            neutral_us: servo.neutral_pulse_us,
            us_per_deg: servo.pulse_us_per_deg,
            channels: servo.channels(),
            reversed: servo.reversed(),
        }
    }

    /// The angle that a pulse asks for.
    #[must_use]
    pub fn angle_deg(&self, pulse_us: f64) -> f64 {
        (pulse_us - self.neutral_us) / self.us_per_deg
    }

    /// The pulse that asks for an angle.
    #[must_use]
    pub fn pulse_us(&self, angle_deg: f64) -> f64 {
        self.neutral_us + angle_deg * self.us_per_deg
    }

    /// What the outputs ask of the joints.
    #[must_use]
    pub fn setpoints_rad(&self, pulses_us: &[Option<f64>]) -> [Option<f64>; JOINT_COUNT] {
        std::array::from_fn(|joint| {
            let pulse_us = pulses_us.get(usize::from(self.channels[joint])).copied().flatten()?;
            let angle_deg = self.angle_deg(pulse_us);
            Some(if self.reversed[joint] { -angle_deg } else { angle_deg }.to_radians())
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ANT: PulseScale = PulseScale {
        neutral_us: 1346.4,
        us_per_deg: 6.8,
        channels: [0, 1, 2, 3, 4, 5, 6, 7],
        reversed: [false; JOINT_COUNT],
    };

    #[test]
    fn neutral_is_330_counts_and_a_degree_five_thirds_of_a_count_at_the_nominal_oscillator() {
        assert!(ANT.angle_deg(330.0 * 4.08).abs() < 1e-9);
        assert!((ANT.pulse_us(3.0) - (330.0 + 5.0) * 4.08).abs() < 1e-9);
    }

    #[test]
    fn a_missing_pulse_is_a_limp_servo() {
        let setpoints = ANT.setpoints_rad(&[Some(1346.4), None]);

        assert!(setpoints[0].unwrap().abs() < 1e-9);
        assert!(setpoints[1..].iter().all(Option::is_none));
    }

    #[test]
    fn a_joint_follows_its_own_output_and_direction() {
        let mut crossed = ANT;
        crossed.channels.swap(0, 5);
        crossed.reversed[5] = true;

        let setpoints = crossed.setpoints_rad(&[Some(1346.4 + 68.0), None]);

        assert!((setpoints[5].unwrap().to_degrees() + 10.0).abs() < 1e-9, "{setpoints:?}");
        assert_eq!(setpoints.iter().flatten().count(), 1);
    }
}
