//! What is compared.
//!
//! Owns the names, for people and for files, and what each method is.

use serde::{Deserialize, Serialize};

/// The amplification at which every gait moves as it was found: a policy's
/// action is 45 degrees in training, and 24 in a gait at 1.0.
pub const OWN_STROKE: f64 = 45.0 / 24.0;

/// A way to come by a gait. The first three are the paper's.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize, clap::ValueEnum,
)]
#[serde(rename_all = "kebab-case")]
pub enum Method {
    /// The policy's averaged stride, sample by sample.
    Original,
    /// Sinusoids, found by Bayesian optimisation.
    Sinusoid,
    /// The same stride through a polynomial of degree 10 for each joint, its seam free.
    Psto,
    /// A policy that paid for electric power, through polynomials that close over the seam.
    Ours,
    /// The trajectory itself, searched for cost of transport.
    Searched,
    /// A gait of the user's own.
    Yours,
    /// The authors' own unsmoothed tables, played as their sketch did.
    AuthorsOriginal,
    /// The authors' own smoothed tables, played as their sketch did.
    AuthorsPsto,
}

impl Method {
    /// In the order of tables and legends.
    pub const ALL: [Self; 8] = [
        Self::Original,
        Self::Sinusoid,
        Self::Psto,
        Self::Ours,
        Self::Searched,
        Self::Yours,
        Self::AuthorsOriginal,
        Self::AuthorsPsto,
    ];
    /// Those that the paper compares.
    pub const PAPERS: [Self; 3] = [Self::Original, Self::Sinusoid, Self::Psto];
    /// Those that a robot plays from a gait file.
    pub const GAITS: [Self; 6] =
        [Self::Original, Self::Sinusoid, Self::Psto, Self::Ours, Self::Searched, Self::Yours];

    /// In files and JSON.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Original => "original",
            Self::Sinusoid => "sinusoid",
            Self::Psto => "psto",
            Self::Ours => "ours",
            Self::Searched => "searched",
            Self::Yours => "yours",
            Self::AuthorsOriginal => "authors-original",
            Self::AuthorsPsto => "authors-psto",
        }
    }

    /// In legends.
    #[must_use]
    pub const fn label(self) -> &'static str {
        match self {
            Self::Original => "original",
            Self::Sinusoid => "sinusoid",
            Self::Psto => "PSTO",
            Self::Ours => "power-trained",
            Self::Searched => "searched",
            Self::Yours => "your gait",
            Self::AuthorsOriginal => "authors' original",
            Self::AuthorsPsto => "authors' PSTO",
        }
    }

    /// What it is, in a sentence for somebody who has not read the paper.
    #[must_use]
    pub const fn explained(self) -> &'static str {
        match self {
            Self::Original => {
                "A neural network learned to walk by reinforcement learning; its joint angles, averaged over \
                 20 trials, are played back sample by sample."
            }
            Self::Sinusoid => {
                "Every joint swings as a sine; amplitude, phase and offset of each pair of joints, and the \
                 stride's duration, were found by Bayesian optimisation."
            }
            Self::Psto => {
                "The paper's method: the averaged stride of \u{201c}original\u{201d}, each joint's smoothed by \
                 a polynomial of degree 10."
            }
            Self::Ours => {
                "As PSTO, but the network paid for electric power while it learned, and the curves close over \
                 the stride's end without a jump."
            }
            Self::Searched => {
                "No network: the curves themselves were searched in the twin for the least cost of transport."
            }
            Self::Yours => "The gait that was named on the command line.",
            Self::AuthorsOriginal => {
                "The tables that the authors' robot played, unsmoothed, replayed in the twin."
            }
            Self::AuthorsPsto => "The tables that the authors' robot played, smoothed, replayed in the twin.",
        }
    }

    /// Of that name.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|method| method.name() == name)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_those_of_json_and_are_found_again() {
        for method in Method::ALL {
            assert_eq!(serde_json::to_value(method).unwrap(), method.name());
            assert_eq!(Method::from_name(method.name()), Some(method));
        }
    }
}
