//! Gaits go forward: what of a displacement counts, and turning a gait round.
//!
//! Holds the choice between the two by the robot's symmetry. Does not depend on
//! how gaits are searched.

use super::report::TRIAL_S;
use super::score::{Aim, Counted, Test};
use super::space::Motion;
use super::tolerances::Draw;
use crate::robot::Robot;
use protocol::{JOINT_COUNT, LEG_COUNT};

impl Counted {
    /// A symmetric robot's gait can be turned round afterwards, so that distance in
    /// any direction counts; of any other robot's, only what goes forward.
    #[must_use]
    pub fn of(robot: &Robot) -> Self {
        if robot.is_symmetric_by_half_turn() { Self::Distance } else { Self::Forward }
    }
}

/// Where a motion takes the described robot in 12 s, along x and y.
#[must_use]
pub fn displacement_m(robot: &Robot, motion: &Motion) -> [f64; 2] {
    let test = Test { aim: Aim::Speed, counted: Counted::Distance, duration_s: TRIAL_S };
    test.walk(&Draw::nominal(robot), motion, 1.0).displacement_m
}

/// The motion, or where it takes a symmetric robot towards -x, the same motion with
/// legs 1 and 3, and 2 and 4, exchanged.
#[must_use]
pub fn forward(robot: &Robot, motion: Motion) -> Motion {
    let goes_back = displacement_m(robot, &motion)[0] < 0.0;
    if goes_back && robot.is_symmetric_by_half_turn() { with_opposite_legs(&motion) } else { motion }
}

fn with_opposite_legs(motion: &Motion) -> Motion {
    let opposite = |j: usize| j / LEG_COUNT * LEG_COUNT + (j + LEG_COUNT / 2) % LEG_COUNT;
    Motion {
        period_s: motion.period_s,
        centres_deg: core::array::from_fn::<_, JOINT_COUNT, _>(|j| motion.centres_deg[opposite(j)]),
        curves_deg: core::array::from_fn(|j| motion.curves_deg[opposite(j)]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gait::gait_file::GaitFile;
    use crate::robot::LegScale;
    use crate::sim::open_loop::Direction;
    use std::path::Path;

    fn searched() -> (Robot, Motion) {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("gaits/ant-1L/searched.toml");
        (Robot::ant(LegScale::LONG).unwrap(), Motion::of(&GaitFile::load(&path).unwrap(), 1.0))
    }

    #[test]
    fn a_gait_that_goes_back_is_turned_round_and_one_that_goes_forward_stays() {
        let (robot, forwards) = searched();
        let backwards = with_opposite_legs(&forwards);

        assert_eq!(Direction::of(displacement_m(&robot, &backwards)), Direction::Backward);
        assert_eq!(forward(&robot, backwards), forwards);
        assert_eq!(forward(&robot, forwards.clone()), forwards);
    }

    #[test]
    fn the_gait_of_a_robot_that_is_not_symmetric_is_left_as_it_was_found() {
        let (mut robot, forwards) = searched();
        std::sync::Arc::make_mut(&mut robot.drawn).legs[0].hip.in_parent.translation.y += 0.002;
        let backwards = with_opposite_legs(&forwards);

        assert_eq!(Counted::of(&robot), Counted::Forward);
        assert_eq!(forward(&robot, backwards.clone()), backwards);
    }
}
