//! Predicted speed, power and cost of a table on the simulated robot.

use crate::robot::{PowerLine, Robot};
use crate::sim::World;
use crate::sim::open_loop::{self, FRAME_RATE_HZ};
use protocol::JOINT_COUNT;

/// The paper's trial, where the trials do not tell their own length.
pub const TRIAL_S: f64 = 12.0;
/// From standing to the table's first row, as in every trial of ours.
const ENTRY_S: f64 = 1.5;

/// What one table comes to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Prediction {
    /// Net distance over time.
    pub speed_m_s: f64,
    /// Positive work of the servos' horns over time.
    pub mechanical_w: f64,
    /// Heat of the windings that the supply pays.
    pub holding_w: f64,
    /// Electrical, by the robot's own power model.
    pub power_w: f64,
    /// Whether it lay down.
    pub fell: bool,
}

impl Prediction {
    /// Electrical power by a straight line over mechanical power, unbounded.
    #[must_use]
    pub fn free_power_w(&self, line: &PowerLine) -> f64 {
        line.at(self.mechanical_w)
    }
}

/// Plays a table as the authors' sketch did: each row is held for the sample
/// time, then the next is sent, over and over. Servos see a new pulse 60 times
/// a second, so a row begins with the first frame after its time.
#[must_use]
pub fn predict(
    robot: &Robot,
    sample_s: f64,
    angles_rad: &[[f64; JOINT_COUNT]],
    duration_s: f64,
) -> Prediction {
    predict_in(&mut World::new(robot), sample_s, angles_rad, duration_s)
}

/// The same in a world of one's own, such as one of finer steps.
pub fn predict_in(
    world: &mut World,
    sample_s: f64,
    angles_rad: &[[f64; JOINT_COUNT]],
    duration_s: f64,
) -> Prediction {
    let trial = open_loop::Trial { entry_s: ENTRY_S, duration_s, ..open_loop::Trial::default() };
    let rows = angles_rad.len().max(1);
    let walk = open_loop::play_in(world, &trial, &mut |t| {
        // Half a frame's hundredth: a time on the border belongs to the new row.
        let row = ((t + 0.01 / FRAME_RATE_HZ) / sample_s) as usize % rows;
        angles_rad.get(row).copied().unwrap_or_default()
    });
    Prediction {
        speed_m_s: walk.speed_m_s,
        mechanical_w: walk.mean_mechanical_power_w,
        holding_w: walk.mean_holding_power_w,
        power_w: walk.mean_power_w,
        fell: walk.fell,
    }
}

/// Mean over a table's steps of the sum over joints of the change, in radians a sample.
pub fn mean_step_rad(angles_rad: &[[f64; JOINT_COUNT]]) -> f64 {
    let count = angles_rad.len().max(1);
    let change = |from: &[f64; JOINT_COUNT], to: &[f64; JOINT_COUNT]| -> f64 {
        from.iter().zip(to).map(|(from, to)| (to - from).abs()).sum()
    };
    (0..count)
        .map(|row| match (angles_rad.get(row), angles_rad.get((row + 1) % count)) {
            (Some(from), Some(to)) => change(from, to),
            _ => 0.0,
        })
        .sum::<f64>()
        / count as f64
}
