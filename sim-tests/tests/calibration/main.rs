//! The robot's own build: servos, PWM, shunt, supply.

mod board;
mod record;

use protocol::calibration::{BoardCalibration, JointCalibration};
use protocol::{Calibration, JOINT_COUNT, Joint};

fn joints() -> [JointCalibration; JOINT_COUNT] {
    let authors = Calibration::authors();
    Joint::ALL.map(|joint| authors.joint(joint))
}

fn with_board(change: impl Fn(&mut BoardCalibration)) -> Calibration {
    let mut board = Calibration::authors().board();
    change(&mut board);
    Calibration::new(&joints(), &board)
}

/// Nothing of it is the authors': other outputs, half of them reversed, other scales.
fn another_build() -> ([JointCalibration; JOINT_COUNT], Calibration) {
    let joints = std::array::from_fn(|index| JointCalibration {
        channel: (5 * index as u8 + 3) % 8,
        reversed: index % 2 == 0,
        neutral_counts: 300 + 10 * index as u16,
        scale_q20: 5_000 + 700 * index as u16,
        min_counts: 280,
        max_counts: 390,
    });
    (joints, Calibration::new(&joints, &Calibration::authors().board()))
}
