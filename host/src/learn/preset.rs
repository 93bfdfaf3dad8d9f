//! The presets: configurations that are part of the program.
//!
//! Holds their names and texts. Does not depend on what is in them.

use serde::{Deserialize, Serialize};

/// A preset, as `--preset` and `based_on` name it.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum Preset {
    /// The paper to the letter: 250,000 updates, its reward, white noise
    #[default]
    Paper,
    /// The paper's learner and budget, for a gait that the robot's servos can follow
    Walk,
    /// A first gait in minutes: 55,000 updates
    Quick,
    /// Like walk, on varied robots: another one in every episode
    Robust,
    /// Like walk, with the paper's electricity cost: PSTO in the study
    Psto,
}

impl Preset {
    /// The text of the file in `configs`.
    pub const fn text(self) -> &'static str {
        match self {
            Self::Paper => include_str!("../../configs/paper.toml"),
            Self::Walk => include_str!("../../configs/walk.toml"),
            Self::Quick => include_str!("../../configs/quick.toml"),
            Self::Robust => include_str!("../../configs/robust.toml"),
            Self::Psto => include_str!("../../configs/psto.toml"),
        }
    }

    /// The file's path, for errors.
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
