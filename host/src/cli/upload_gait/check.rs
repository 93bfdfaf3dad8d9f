//! The dry run of an upload: everything is checked, nothing is sent.
//!
//! Holds the table of what each joint will be asked for, and the check of the servos'
//! speed and pulses. Does not depend on the transfer.

use crate::calibration::RobotCalibration;
use crate::cli::explain::{failure, failure_with_help};
use crate::cli::material::Material;
use crate::cli::reach::{Port, unreachable_robot};
use crate::cli::{Cause, Failure};
use crate::device::link::LinkError;
use crate::device::link::ports::{self, SerialLink};
use crate::device::upload::upload_result::{DryRunResult, GaitResult, JointDemandResult};
use crate::gait::gait_player::{BeyondPulses, Demand};
use crate::pwm::count_us;
use crate::robot::Robot;
use protocol::command::Record;
use protocol::{Amplitude, Calibration, JOINT_COUNT, Joint, Speed};
use thiserror::Error;

#[derive(Debug, Error)]
#[error(
    "{joint} would need a pulse of {pulse_us:.0} us ({counts} counts) at {angle_deg:.1} degrees; \
     its calibration allows {min_us:.0} to {max_us:.0} us"
)]
struct Pulse {
    joint: &'static str,
    pulse_us: f64,
    counts: i32,
    angle_deg: f64,
    min_us: f64,
    max_us: f64,
}

/// What each joint will be asked for, and by which calibration.
pub struct Check {
    demands: [Demand; JOINT_COUNT],
    servo_deg_s: f64,
    calibration: Calibration,
    /// Whose calibration it is.
    of: String,
    beyond: Vec<BeyondPulses>,
    /// About the gait itself.
    doubts: Vec<String>,
}

impl Check {
    /// Checks the gait; `calibration` comes with words that say whose it is.
    pub fn of(material: &Material, amplitude: Amplitude, (calibration, of): (Calibration, String)) -> Self {
        let servo_deg_s = material.robot.servo.top_speed_rad_s().to_degrees();
        let playable = &material.playable;
        let beyond = Joint::ALL
            .into_iter()
            .filter_map(|joint| playable.beyond_pulses(joint, calibration.joint(joint), amplitude))
            .collect();
        let demands = playable.demands(amplitude, Speed::ONE, servo_deg_s);
        let doubts = material.doubts(amplitude);
        Self { demands, servo_deg_s, calibration, of, beyond, doubts }
    }

    fn us(&self, counts: i32) -> f64 {
        f64::from(counts) * count_us(&self.calibration.board())
    }

    fn pulse(&self, beyond: &BeyondPulses) -> Pulse {
        let BeyondPulses { joint, angle, counts, range } = *beyond;
        Pulse {
            joint: joint.name(),
            pulse_us: self.us(counts),
            counts,
            angle_deg: angle.deg(),
            min_us: self.us(range.0.into()),
            max_us: self.us(range.1.into()),
        }
    }

    /// What does not stop the robot, but will not look as planned.
    pub fn warnings(&self) -> Vec<String> {
        let beyond_speed: Vec<(Joint, &Demand)> =
            Joint::ALL.into_iter().zip(&self.demands).filter(|(_, d)| d.too_fast_share > 0.0).collect();
        let fastest = beyond_speed.iter().max_by(|a, b| a.1.fastest_deg_s.total_cmp(&b.1.fastest_deg_s));
        let too_fast = fastest.map(|(joint, demand)| {
            let others = match beyond_speed.len() - 1 {
                0 => String::new(),
                1 => "; another joint lags too".to_owned(),
                others => format!("; {others} other joints lag too"),
            };
            format!(
                "{} must turn at up to {:.0} degrees/s; its servo does {:.0}: it lags in {} of the stride{others}",
                joint.name(),
                demand.fastest_deg_s,
                self.servo_deg_s,
                percent(demand.too_fast_share)
            )
        });
        let beyond = self.beyond.iter().map(|beyond| format!("{}; it is held there", self.pulse(beyond)));
        self.doubts.iter().cloned().chain(too_fast).chain(beyond).collect()
    }

    /// An error if a pulse is beyond the calibration.
    pub fn verdict(&self) -> Result<(), Failure> {
        let Some(beyond) = self.beyond.first() else { return Ok(()) };
        let help = "take a smaller amplitude, or widen the servo's limits: host calibrate; \
                    or --clip holds it there";
        Err(failure_with_help(Cause::Input, self.pulse(beyond), help))
    }

    /// The table.
    pub fn print(&self) {
        println!("joint   lowest  highest  fastest      pulse   (degrees, degrees/s, us)");
        for (joint, demand) in Joint::ALL.into_iter().zip(&self.demands) {
            let (low, high) = self.pulses(joint, demand);
            println!(
                "{:5}  {:7.1}  {:7.1}  {:7.0}  {low:4.0}..{high:4.0}",
                joint.name(),
                demand.lowest_deg,
                demand.highest_deg,
                demand.fastest_deg_s
            );
        }
        println!("a servo does {:.0} degrees/s; pulses by {}", self.servo_deg_s, self.of);
    }

    /// The same for scripts.
    pub fn result(self, gait: GaitResult, amplitude: f64, warnings: Vec<String>) -> DryRunResult {
        let joint = |(joint, demand): (Joint, &Demand)| {
            let (shortest_us, longest_us) = self.pulses(joint, demand);
            JointDemandResult {
                name: joint.name().to_owned(),
                lowest_deg: demand.lowest_deg,
                highest_deg: demand.highest_deg,
                fastest_deg_s: demand.fastest_deg_s,
                too_fast_share: demand.too_fast_share,
                shortest_us,
                longest_us,
            }
        };
        let joints = Joint::ALL.into_iter().zip(&self.demands).map(joint).collect();
        let (servo_deg_s, calibration) = (self.servo_deg_s, self.of);
        DryRunResult { gait, dry_run: true, amplitude, warnings, servo_deg_s, calibration, joints }
    }

    /// Shortest and longest pulse, as the robot will send them.
    fn pulses(&self, joint: Joint, demand: &Demand) -> (f64, f64) {
        let calibration = self.calibration.joint(joint);
        let us = |deg: f64| self.us(calibration.counts((deg * 256.0).round() as i16).into());
        let (a, b) = (us(demand.lowest_deg), us(demand.highest_deg));
        (a.min(b), a.max(b))
    }
}

/// A share as a percentage, never as 0.0 % of something that happens.
fn percent(share: f64) -> String {
    if share < 0.0005 { "less than 0.1 %".to_owned() } else { format!("{:.1} %", 100.0 * share) }
}

/// The calibration that a robot has in use.
pub fn calibration_on(link: &mut SerialLink) -> Result<Option<Calibration>, LinkError> {
    let bytes = link.read(Record::Calibration)?;
    Ok(Calibration::from_bytes(&bytes).ok())
}

/// The robot's calibration; without a robot, that of its description.
pub fn calibration(port: &Port, robot: &Robot) -> Result<(Calibration, String), Failure> {
    match ports::connect(port.port.as_deref()) {
        Ok(mut link) => {
            let calibration = calibration_on(&mut link).map_err(unreachable_robot)?;
            let of = format!("the calibration of the robot on {}", link.name());
            Ok((calibration.unwrap_or_else(Calibration::authors), of))
        }
        Err(LinkError::NoPort { .. }) => {
            let described = RobotCalibration::of_robot(robot).record();
            let described = described.map_err(|error| failure(Cause::Input, error))?;
            Ok((described, format!("the description of {}: no robot is connected", robot.name)))
        }
        Err(error) => Err(unreachable_robot(error)),
    }
}
