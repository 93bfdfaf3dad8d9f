//! The configurations that come with the program.
//!
//! Owns their texts and which stands on which; refuses to judge their numbers.

use serde::{Deserialize, Serialize};

/// A configuration by name, as `--preset` and `based_on` know it.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum Preset {
    /// The paper to the letter: 250,000 updates, its reward, its white noise.
    #[default]
    Paper,
    /// The paper's learner and budget, for a gait that the robot's servos can play.
    Walk,
    /// A first gait in minutes: 55,000 updates.
    Quick,
    /// As walk, but on another robot every episode, within the twin's spread.
    Robust,
    /// As walk, with the paper's electricity cost: what the experiment's PSTO learns with.
    Psto,
}

impl Preset {
    /// The file as it stands in `configs`.
    pub const fn text(self) -> &'static str {
        match self {
            Self::Paper => include_str!("../../../configs/paper.toml"),
            Self::Walk => include_str!("../../../configs/walk.toml"),
            Self::Quick => include_str!("../../../configs/quick.toml"),
            Self::Robust => include_str!("../../../configs/robust.toml"),
            Self::Psto => include_str!("../../../configs/psto.toml"),
        }
    }

    /// What errors call the file.
    pub const fn path(self) -> &'static str {
        match self {
            Self::Paper => "configs/paper.toml",
            Self::Walk => "configs/walk.toml",
            Self::Quick => "configs/quick.toml",
            Self::Robust => "configs/robust.toml",
            Self::Psto => "configs/psto.toml",
        }
    }
}
