//! The methods that are compared, one [`MethodSpec`] each.
//!
//! Holds everything that depends on the method alone: its names, its colour,
//! where its gait is read from, how `--retrain` makes it, and what the paper
//! prints for it. [`Method::spec`] is the only place that lists them: a method
//! without an entry does not compile, and whatever differs by method elsewhere
//! is decided by a field of the entry. Does not depend on gaits, trials or
//! figures.

use crate::gait::scale::{POLICY_DEG_PER_ACTION, TABLE_DEG_PER_ACTION};
use crate::learn::preset::Preset;
use crate::paper::{self, Printed};
use crate::plot::{Colour, PALETTE};
use crate::robot::LegScale;
use clap::ValueEnum;
use serde::{Deserialize, Serialize};

/// The amplification at which every gait moves as it was found: a policy's
/// action is 45 degrees in training, and 24 in a gait at 1.0.
pub const OWN_STROKE: f64 = POLICY_DEG_PER_ACTION / TABLE_DEG_PER_ACTION;

/// A way to obtain a gait. The first three are the paper's.
///
/// The order of the variants is that of tables and legends.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Method {
    /// The policy's averaged stride, sample by sample
    Original,
    /// Sinusoids, found by Bayesian optimisation
    Sinusoid,
    /// The same stride through a polynomial of degree 10 for each joint, its seam free
    Psto,
    /// A policy that paid for electric power, through polynomials that close over the seam
    Ours,
    /// The trajectory itself, searched for the lowest cost of transport
    Searched,
    /// A gait of your own
    Yours,
    /// The authors' own unsmoothed tables, played as their sketch did
    AuthorsOriginal,
    /// The authors' own smoothed tables, played as their sketch did
    AuthorsPsto,
}

/// Where the gait of a method is read from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Origin {
    /// The averaged stride in a folder of gaits, played sample by sample.
    Stride,
    /// A gait file in a folder of gaits, named after the method: `psto.toml`.
    GaitFile,
    /// The gait file of `--gait`, copied into the study's folder of gaits.
    CommandLine,
    /// The tables of `--reference-tables`, under this name; only the simulation plays them.
    AuthorsTables(&'static str),
}

/// How `--retrain` makes the gait of a method.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Recipe {
    /// `train` with some seeds, then `record` and `fit` for the best of them.
    Train {
        /// What is trained with.
        preset: Preset,
        /// How many seeds are trained.
        seeds: u64,
        /// `fit --seam`.
        seam: &'static str,
        /// Whether stride, spread and learning curves are kept beside the gait: Figures 3 and 4,
        /// and the gait of whichever method is made [`Recipe::With`] this one.
        keeps_stride: bool,
    },
    /// Nothing by itself: it comes with the training of another method.
    With(Method),
    /// `sinusoid`, with as much simulated time as the training of these seeds takes.
    Sinusoid {
        /// The task of the search, and the training whose time it gets.
        preset: Preset,
        /// Seeds of that training.
        seeds: u64,
    },
    /// `optimise`, with a budget of trials.
    Optimise {
        /// Trials at an effort of 1.
        trials: f64,
        /// The fewest trials, whatever the effort.
        least_trials: f64,
    },
}

/// All that is particular to a method.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MethodSpec {
    /// In files, in JSON and on the command line.
    pub name: &'static str,
    /// In tables and legends.
    pub label: &'static str,
    /// Its gait within a sentence.
    pub gait: &'static str,
    /// What it is, in a sentence for somebody who has not read the paper.
    pub explained: &'static str,
    /// The same in every figure; black is what the authors measured.
    pub colour: Colour,
    /// Where its gait is read from.
    pub origin: Origin,
    /// How `--retrain` makes it; `None` if it cannot.
    pub recipe: Option<Recipe>,
    /// The paper's numbers; `None` for methods that are not in it.
    pub paper: Option<Printed>,
}

/// Beyond the palette.
const BROWN: Colour = Colour(121, 85, 72);
const GREY: Colour = Colour(130, 130, 130);
/// Seeds of PSTO's training, of which the best is taken; its rival gets as much simulated time.
const PSTO_SEEDS: u64 = 2;

const ORIGINAL: MethodSpec = MethodSpec {
    name: "original",
    label: "original",
    gait: "the original gait",
    explained: "A neural network learned to walk by reinforcement learning; its joint angles, \
                averaged over 20 trials, are played back sample by sample.",
    colour: PALETTE[2],
    origin: Origin::Stride,
    recipe: Some(Recipe::With(Method::Psto)),
    paper: Some(paper::ORIGINAL),
};
const SINUSOID: MethodSpec = MethodSpec {
    name: "sinusoid",
    label: "sinusoid",
    gait: "the sinusoid gait",
    explained: "Every joint swings as a sine; amplitude, phase and offset of each pair of joints, \
                and the stride's duration, were found by Bayesian optimisation.",
    colour: PALETTE[1],
    origin: Origin::GaitFile,
    recipe: Some(Recipe::Sinusoid { preset: Preset::Psto, seeds: PSTO_SEEDS }),
    paper: Some(paper::SINUSOID),
};
const PSTO: MethodSpec = MethodSpec {
    name: "psto",
    label: "PSTO",
    gait: "the PSTO gait",
    explained: "The paper's method: the averaged stride of \u{201c}original\u{201d}, each joint's \
                smoothed by a polynomial of degree 10.",
    colour: PALETTE[0],
    origin: Origin::GaitFile,
    recipe: Some(Recipe::Train { preset: Preset::Psto, seeds: PSTO_SEEDS, seam: "free", keeps_stride: true }),
    paper: Some(paper::PSTO),
};
const OURS: MethodSpec = MethodSpec {
    name: "ours",
    label: "power-trained",
    gait: "the power-trained gait",
    explained: "As PSTO, but the network paid for electric power while it learned, and the curves \
                close over the stride's end without a jump.",
    colour: PALETTE[3],
    origin: Origin::GaitFile,
    recipe: Some(Recipe::Train { preset: Preset::Walk, seeds: 3, seam: "continuous", keeps_stride: false }),
    paper: None,
};
const SEARCHED: MethodSpec = MethodSpec {
    name: "searched",
    label: "searched",
    gait: "the searched gait",
    explained: "No network: the curves themselves were searched in the simulated robot for the \
                lowest cost of transport.",
    colour: PALETTE[5],
    origin: Origin::GaitFile,
    // Ten minutes of two cores.
    recipe: Some(Recipe::Optimise { trials: 30_000.0, least_trials: 300.0 }),
    paper: None,
};
const YOURS: MethodSpec = MethodSpec {
    name: "yours",
    label: "your gait",
    gait: "your gait",
    explained: "The gait that was named on the command line.",
    colour: BROWN,
    origin: Origin::CommandLine,
    recipe: None,
    paper: None,
};
const AUTHORS_ORIGINAL: MethodSpec = MethodSpec {
    name: "authors-original",
    label: "authors' original",
    gait: "the authors' original gait",
    explained: "The tables that the authors' robot played, unsmoothed, replayed in the simulation.",
    colour: GREY,
    origin: Origin::AuthorsTables("original"),
    recipe: None,
    paper: None,
};
const AUTHORS_PSTO: MethodSpec = MethodSpec {
    name: "authors-psto",
    label: "authors' PSTO",
    gait: "the authors' PSTO gait",
    explained: "The tables that the authors' robot played, smoothed, replayed in the simulation.",
    colour: PALETTE[4],
    origin: Origin::AuthorsTables("psto"),
    recipe: None,
    paper: None,
};

impl Method {
    /// Those that the paper compares, in its order.
    pub const PAPERS: [Self; 3] = [Self::Original, Self::Sinusoid, Self::Psto];

    /// The entry of this method in the table of methods.
    #[must_use]
    pub const fn spec(self) -> &'static MethodSpec {
        match self {
            Self::Original => &ORIGINAL,
            Self::Sinusoid => &SINUSOID,
            Self::Psto => &PSTO,
            Self::Ours => &OURS,
            Self::Searched => &SEARCHED,
            Self::Yours => &YOURS,
            Self::AuthorsOriginal => &AUTHORS_ORIGINAL,
            Self::AuthorsPsto => &AUTHORS_PSTO,
        }
    }

    /// Every method, in the order of tables and legends.
    pub fn all() -> impl Iterator<Item = Self> + Clone {
        Self::value_variants().iter().copied()
    }

    /// Those that a robot plays from a gait table.
    pub fn gaits() -> impl Iterator<Item = Self> + Clone {
        Self::all().filter(|method| !matches!(method.spec().origin, Origin::AuthorsTables(_)))
    }

    /// Those with gaits that come with the program: what is compared by default.
    pub fn bundled() -> impl Iterator<Item = Self> + Clone {
        Self::all().filter(|method| matches!(method.spec().origin, Origin::Stride | Origin::GaitFile))
    }

    /// In files, in JSON and on the command line.
    #[must_use]
    pub const fn name(self) -> &'static str {
        self.spec().name
    }

    /// In tables and legends.
    #[must_use]
    pub const fn label(self) -> &'static str {
        self.spec().label
    }

    /// The preset that decides how the method's gait is learned, or what it is searched for.
    #[must_use]
    pub const fn preset(self) -> Option<Preset> {
        match self.spec().recipe {
            Some(Recipe::Train { preset, .. } | Recipe::Sinusoid { preset, .. }) => Some(preset),
            Some(Recipe::With(other)) => other.preset(),
            Some(Recipe::Optimise { .. }) | None => None,
        }
    }

    /// Cost of transport and speed of the method's best in the paper's Table 2.
    #[must_use]
    pub fn table_2(self, leg: LegScale) -> Option<(f64, f64)> {
        let column = paper::LEGS.iter().position(|&papers| leg == papers)?;
        Some(self.spec().paper?.table_2[column])
    }

    /// The method's mean power at 0.12 m/s on long legs, in the paper.
    #[must_use]
    pub fn figure_5_w(self) -> Option<f64> {
        self.spec().paper.map(|printed| printed.figure_5_w)
    }
}

#[cfg(test)]
mod tests;
