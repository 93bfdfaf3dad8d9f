//! The gaits that were found here, for both lengths of the Ant's legs.
//!
//! Owns the files in `gaits/`; each says by which command and seed it was made.
//! `host optimise` makes others.

use crate::gait::gait_file::{GaitFile, GaitFileError};
use std::path::Path;

/// The leg's length, and the file with its gait.
const GAITS: [(f64, &str, &str); 2] = [
    (1.0, "gaits/ant-1L/searched.toml", include_str!("../../gaits/ant-1L/searched.toml")),
    (0.6, "gaits/ant-0.6L/searched.toml", include_str!("../../gaits/ant-0.6L/searched.toml")),
];

/// The gait for the Ant with shins of `leg_scale` times 0.23 m, at amplitude
/// 1.0; `None` for legs that none was searched for.
///
/// # Errors
/// [`GaitFileError`] if this program was built with a damaged file.
pub fn gait(leg_scale: f64) -> Result<Option<GaitFile>, GaitFileError> {
    let same = |leg: f64| (leg - leg_scale).abs() < 1e-9;
    let known = GAITS.into_iter().find(|(leg, ..)| same(*leg));
    known.map(|(_, name, text)| GaitFile::parse(text.as_bytes(), Path::new(name))).transpose()
}

#[cfg(all(test, feature = "train"))]
mod tests {
    use super::*;
    use crate::gait::gait_file::Source;
    use crate::robot::Robot;
    use crate::search::optimise::space::{Bounds, Motion};

    #[test]
    fn both_legs_have_a_gait_that_keeps_its_robots_bounds() {
        for leg in [1.0, 0.6] {
            let robot = Robot::ant(leg).expect("a leg scale");
            let gait = gait(leg).expect("whole").expect("there is one");
            let motion = Motion::of(&gait, 1.0);
            let bounds = Bounds::of(&robot);

            assert_eq!(gait.provenance.source, Source::Searched);
            assert_eq!(gait.provenance.leg_scale, Some(leg));
            assert!(gait.provenance.command.is_some() && gait.provenance.seed.is_some());
            assert!(motion.fastest_deg_s(1.0) <= bounds.speed_deg_s * 1.001, "{leg}");
            assert!(motion.widest_deg(1.0) <= bounds.angle_deg + 0.01, "{leg}");
            let jumps = gait.joints.iter().map(|joint| joint.deviation_deg(0.0) - joint.deviation_deg(1.0));
            assert!(jumps.into_iter().all(|jump| jump.abs() < 1e-6), "{leg}");
        }
        assert!(super::gait(0.8).expect("nothing to damage").is_none());
    }
}
