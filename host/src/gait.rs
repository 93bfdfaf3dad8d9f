//! What a gait is, and how it is made from rows of joint angles.
//!
//! Holds the gait file, recorded trajectories, the search for their stride, the
//! polynomial fit, and the player that turns any of these into setpoints. Does
//! not depend on the simulator, on the learner, or on the link to a robot.

pub mod csv_text;
pub mod fit;
pub mod gait_file;
pub mod gait_player;
pub mod joint_map;
pub mod policy_record;
pub mod sampled_gait;
pub mod scale;
#[cfg(feature = "train")]
pub mod stride;
pub mod trajectory;
