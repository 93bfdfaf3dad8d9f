//! Bayesian optimisation of a sinusoidal gait.
//!
//! Owns the order of the search and its budget, in control steps as a learner's
//! is: a Latin hypercube first; then batches that a surrogate suggests, now
//! among all gaits, now among those near the best, in a box that grows with
//! success and shrinks without; last the best few once more from starts that no
//! step of the search has seen, since the best of many has been lucky.

use super::draw::{Stream, hypercube, seeds, stream};
use super::surrogate::{Known, suggest};
use super::task::{Task, Worth};
use super::wave::{DIMENSION, Pairs, Sinusoid, bounds};
use crate::optimise::basis::Basis;
use crate::optimise::space::{Bounds, Motion, Space};
use rand::{Rng as _, RngCore as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;

/// Episodes of an evaluation. With the presets' 1000 steps each, TD3's budget is 315 evaluations.
pub const STARTS: usize = 8;
/// Share of the evaluations that the surrogate begins with: of TD3's budget 89, seven a number.
const DESIGN_SHARE: f64 = 0.3;
/// A process of so many numbers needs more points than numbers.
const LEAST_DESIGN: u64 = DIMENSION as u64 + 1;
/// Evaluations a batch: they take about as much time as the surrogate that suggests them.
const BATCH: usize = 4;
/// Share of the budget for the comparison of the best.
const FINAL_SHARE: f64 = 0.05;
/// So many are compared.
const FINALISTS: usize = 5;
/// The box about the best: half its width at first, at most and at least, as shares of the range,
const HALF_WIDTH: (f64, f64, f64) = (0.2, 0.4, 0.03);
/// and what success and failure make of it.
const WIDER: f64 = 1.5;
const NARROWER: f64 = 0.75;

/// Points whose numbers differ by less than this are alike: to try both would tell nothing.
const ALIKE: f64 = 0.01;

/// Where a point came from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stage {
    /// The hypercube.
    Design,
    /// The surrogate, among all gaits.
    Everywhere,
    /// The surrogate, near the best.
    Near,
    /// The last comparison.
    Final,
}

impl Stage {
    /// As in files.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Design => "design",
            Self::Everywhere => "everywhere",
            Self::Near => "near",
            Self::Final => "final",
        }
    }
}

/// A gait that was tried.
#[derive(Debug, Clone, PartialEq)]
pub struct Evaluation {
    /// Why it was tried.
    pub stage: Stage,
    /// In the unit cube.
    pub point: Vec<f64>,
    /// The gait.
    pub gait: Sinusoid,
    /// What it was worth.
    pub worth: Worth,
}

/// How far a search is.
#[derive(Debug)]
pub struct Progress<'a> {
    /// Gaits tried.
    pub evaluations: usize,
    /// Control steps simulated.
    pub steps: u64,
    /// The best gait so far.
    pub best: &'a Evaluation,
}

/// What a search ended with.
#[derive(Debug, Clone, PartialEq)]
pub struct Found {
    /// The gait's curves, at the stroke that was tuned.
    pub motion: Motion,
    /// The gait.
    pub gait: Sinusoid,
    /// On the last comparison's starts; of a search that was stopped, on its own.
    pub worth: Worth,
    /// Everything that was tried, in order.
    pub evaluations: Vec<Evaluation>,
    /// Control steps simulated.
    pub steps: u64,
    /// Whether it was stopped before its end.
    pub stopped: bool,
}

/// A search.
#[derive(Debug, Clone)]
pub struct Search<'a> {
    /// What gaits are tried at.
    pub task: Task<'a>,
    /// Curves like waves.
    pub basis: Basis,
    /// Which legs swing together.
    pub pairs: Pairs,
    /// Of everything that is drawn.
    pub seed: u64,
    /// Control steps to simulate.
    pub budget: u64,
}

/// Under way.
struct Course<'a, 's> {
    search: &'s Search<'a>,
    bounds: Bounds,
    space: Space,
    starts: Vec<u64>,
    tried: Vec<Evaluation>,
    steps: u64,
    watch: &'s mut dyn FnMut(&Progress<'_>) -> bool,
}

impl Search<'_> {
    /// Control steps of one evaluation that nothing ends.
    fn evaluation_steps(&self) -> u64 {
        STARTS as u64 * self.task.episode_steps()
    }

    /// Starts that each of the best is compared on.
    fn final_starts(&self) -> u64 {
        let share = FINAL_SHARE * self.budget as f64;
        let each = share / (FINALISTS as f64 * self.task.episode_steps() as f64);
        (each as u64).max(STARTS as u64)
    }

    fn final_steps(&self) -> u64 {
        FINALISTS as u64 * self.final_starts() * self.task.episode_steps()
    }

    /// The least budget that is a search: a design, one batch, and the comparison.
    #[must_use]
    pub fn least_budget(&self) -> u64 {
        (LEAST_DESIGN + BATCH as u64 + FINALISTS as u64) * self.evaluation_steps()
    }

    /// Searches; `watch` is told of every batch and says whether to go on. A
    /// budget below [`Self::least_budget`] is taken for that.
    pub fn run(&self, watch: &mut dyn FnMut(&Progress<'_>) -> bool) -> Found {
        let search = Self { budget: self.budget.max(self.least_budget()), ..self.clone() };
        let bounds = bounds(search.task.robot, &search.task.env);
        let mut course = Course {
            bounds,
            space: Space::new(search.basis.clone(), bounds, 1),
            starts: seeds(search.seed, Stream::Starts, STARTS),
            tried: Vec::new(),
            steps: 0,
            watch,
            search: &search,
        };
        course.run()
    }
}

impl Course<'_, '_> {
    fn run(&mut self) -> Found {
        let search = self.search;
        let for_search = search.budget - search.final_steps();
        let whole = for_search / search.evaluation_steps();
        let design = ((DESIGN_SHARE * whole as f64) as u64).max(LEAST_DESIGN);
        let mut goes_on = true;
        for batch in hypercube(design as usize, DIMENSION, search.seed).chunks(BATCH) {
            goes_on = goes_on && self.try_all(Stage::Design, batch);
        }
        let mut random = stream(search.seed, Stream::Surrogate);
        let mut half_width = HALF_WIDTH.0;
        let mut is_near = false;
        // Falls end episodes early: what they leave of the budget is searched with.
        while goes_on && self.room(for_search) > 0 {
            let count = self.room(for_search).min(BATCH);
            let before = self.best().worth.reward_per_step;
            let (stage, limits) = if is_near {
                (Stage::Near, self.near(half_width))
            } else {
                (Stage::Everywhere, vec![[0.0, 1.0]; DIMENSION])
            };
            let points = self.suggested(&limits, count, random.next_u64());
            goes_on = self.try_all(stage, &points);
            if is_near {
                let is_better = self.best().worth.reward_per_step > before;
                let change = if is_better { WIDER } else { NARROWER };
                half_width = (half_width * change).min(HALF_WIDTH.1);
                if half_width < HALF_WIDTH.2 {
                    // Nothing better is near: look farther again.
                    half_width = HALF_WIDTH.0;
                }
            }
            is_near = !is_near;
        }
        if goes_on {
            self.compare();
        }
        self.found(!goes_on)
    }

    /// Evaluations that are left.
    fn room(&self, for_search: u64) -> usize {
        (for_search.saturating_sub(self.steps) / self.search.evaluation_steps()) as usize
    }

    /// The best of the search: of several alike the first.
    fn best(&self) -> &Evaluation {
        best(&self.tried)
    }

    fn near(&self, half_width: f64) -> Vec<[f64; 2]> {
        let box_about = |centre: &f64| [(centre - half_width).max(0.0), (centre + half_width).min(1.0)];
        self.best().point.iter().map(box_about).collect()
    }

    /// What the surrogate suggests, or, where that is nothing new, what chance does.
    fn suggested(&self, limits: &[[f64; 2]], count: usize, seed: u64) -> Vec<Vec<f64>> {
        let points: Vec<Vec<f64>> = self.tried.iter().map(|tried| tried.point.clone()).collect();
        let costs: Vec<f64> = self.tried.iter().map(|tried| -tried.worth.reward_per_step).collect();
        let known = Known { points: &points, costs: &costs };
        let mut suggested = suggest(&known, limits, count, seed).unwrap_or_default();
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        suggested.truncate(count);
        suggested.resize(count, Vec::new());
        for number in 0..count {
            let (before, point) = suggested.split_at(number);
            let is_known = |known: &Vec<f64>| farthest(known, &point[0]) < ALIKE;
            if point[0].is_empty() || points.iter().chain(before).any(is_known) {
                suggested[number] =
                    limits.iter().map(|&[low, high]| random.random_range(low..=high)).collect();
            }
        }
        suggested
    }

    fn motion(&self, gait: &Sinusoid) -> Motion {
        gait.motion(self.search.pairs, &self.space)
    }

    /// Whether to go on.
    fn try_all(&mut self, stage: Stage, points: &[Vec<f64>]) -> bool {
        let gaits: Vec<Sinusoid> = points.iter().map(|point| Sinusoid::at(point, self.bounds)).collect();
        let motions: Vec<Motion> = gaits.iter().map(|gait| self.motion(gait)).collect();
        let worths = self.search.task.worth(&motions, &self.starts);
        for ((point, gait), worth) in points.iter().zip(gaits).zip(worths) {
            self.steps += worth.steps;
            self.tried.push(Evaluation { stage, point: point.clone(), gait, worth });
        }
        self.told()
    }

    fn told(&mut self) -> bool {
        let progress = Progress { evaluations: self.tried.len(), steps: self.steps, best: best(&self.tried) };
        (self.watch)(&progress)
    }

    /// The best few on fresh starts.
    fn compare(&mut self) {
        let mut ranked: Vec<Evaluation> = self.tried.clone();
        ranked.sort_by(|a, b| b.worth.reward_per_step.total_cmp(&a.worth.reward_per_step));
        ranked.truncate(FINALISTS);
        let starts = seeds(self.search.seed, Stream::FinalStarts, self.search.final_starts() as usize);
        let motions: Vec<Motion> = ranked.iter().map(|finalist| self.motion(&finalist.gait)).collect();
        for (finalist, worth) in ranked.into_iter().zip(self.search.task.worth(&motions, &starts)) {
            self.steps += worth.steps;
            self.tried.push(Evaluation { stage: Stage::Final, worth, ..finalist });
        }
    }

    fn found(&self, stopped: bool) -> Found {
        let finals: Vec<Evaluation> =
            self.tried.iter().filter(|tried| tried.stage == Stage::Final).cloned().collect();
        let best = if finals.is_empty() { self.best() } else { best(&finals) };
        Found {
            motion: self.motion(&best.gait),
            gait: best.gait,
            worth: best.worth,
            evaluations: self.tried.clone(),
            steps: self.steps,
            stopped,
        }
    }
}

/// Largest difference of any number.
fn farthest(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// Of several alike the first. There always is one: a search's first batch is tried whatever happens.
fn best(tried: &[Evaluation]) -> &Evaluation {
    let better =
        |a: &&Evaluation, b: &&Evaluation| a.worth.reward_per_step.total_cmp(&b.worth.reward_per_step);
    tried.iter().rev().max_by(better).unwrap_or(&NOTHING)
}

/// Stands for the best of no gaits.
static NOTHING: Evaluation =
    Evaluation { stage: Stage::Design, point: Vec::new(), gait: Sinusoid::STILL, worth: Worth::NOTHING };
