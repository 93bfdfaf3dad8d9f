//! Default names of gaits on the robot.
//!
//! Holds the forms and how they are cut to what a robot stores. Does not depend on a
//! gait's curves.

use super::{Provenance, Source};
use protocol::Name;
use std::path::Path;

impl Provenance {
    /// The gait's default name on the robot: `ant-seed-N` for one that was trained, with the
    /// robot's own name, else the name of the `trajectory`'s file, cut to what the robot can store.
    #[must_use]
    pub fn gait_name(&self, trajectory: &Path) -> String {
        let name = match (self.source, self.seed) {
            (Source::Trained, Some(seed)) => {
                short_name("", self.robot.as_deref().unwrap_or("ant"), &format!("-seed-{seed}"))
            }
            _ => trajectory.file_stem().unwrap_or_default().to_string_lossy().into_owned(),
        };
        let name: String =
            name.chars().filter(|c| matches!(c, ' '..='~')).take(protocol::Name::CAPACITY).collect();
        if name.trim().is_empty() { "gait".into() } else { name }
    }
}

/// A name that a robot can store: `before`, the robot's name in small letters, cut as far as
/// needed, and `after`.
#[must_use]
pub fn short_name(before: &str, robot: &str, after: &str) -> String {
    let room = Name::CAPACITY.saturating_sub(before.len() + after.len());
    let words = robot.split(|c: char| !c.is_ascii_alphanumeric()).filter(|word| !word.is_empty());
    let name = words.collect::<Vec<_>>().join("-").to_ascii_lowercase();
    let name = if name.is_empty() { "robot" } else { &name };
    format!("{before}{}{after}", name.chars().take(room).collect::<String>().trim_end_matches('-'))
}
