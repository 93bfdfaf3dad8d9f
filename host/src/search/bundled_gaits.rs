//! The gaits that come with the program, for both lengths of the Ant's legs.
//!
//! Holds the files in `gaits/` that `host optimise` made; each says by which
//! command and seed. Does not depend on how gaits are searched.

use crate::gait::gait_file::{GaitFile, GaitFileError};
use crate::robot::LegScale;
use std::path::Path;

/// The leg's length, and the file with its gait.
const GAITS: [(LegScale, &str, &str); 2] = [
    (LegScale::LONG, "gaits/ant-1L/searched.toml", include_str!("../../gaits/ant-1L/searched.toml")),
    (LegScale::SHORT, "gaits/ant-0.6L/searched.toml", include_str!("../../gaits/ant-0.6L/searched.toml")),
];

/// The gait for the Ant with shins of `leg_scale` times 0.23 m, at amplitude
/// 1.0; `None` for legs that none was searched for.
///
/// # Errors
/// [`GaitFileError`] if this program was built with a damaged file.
pub fn gait(leg_scale: LegScale) -> Result<Option<GaitFile>, GaitFileError> {
    let known = GAITS.into_iter().find(|(leg, ..)| *leg == leg_scale);
    known.map(|(_, name, text)| GaitFile::parse(text.as_bytes(), Path::new(name))).transpose()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gait::gait_file::Source;

    #[test]
    fn both_legs_have_a_closed_gait_that_says_how_it_was_made() {
        for leg in [LegScale::LONG, LegScale::SHORT] {
            let gait = gait(leg).expect("whole").expect("there is one");

            assert_eq!(gait.provenance.source, Source::Searched);
            assert_eq!(gait.provenance.leg_scale, Some(leg));
            assert!(gait.provenance.command.is_some() && gait.provenance.seed.is_some());
            let jumps = gait.joints.iter().map(|joint| joint.deviation_deg(0.0) - joint.deviation_deg(1.0));
            assert!(jumps.into_iter().all(|jump| jump.abs() < 1e-6), "{leg}");
        }
        assert!(super::gait(LegScale::new(0.8).expect("a leg scale")).expect("nothing to damage").is_none());
    }
}
