//! A search while it runs: what was tried, and what is tried next.
//!
//! Holds the order. A round begins with a Latin hypercube; then come batches
//! that a surrogate suggests, alternately among all gaits and among those near
//! the best, in a box that grows with success and shrinks without. After all
//! rounds the best few walk once more from starts that no step of the search
//! has seen, since the best of many has been lucky. Does not depend on how a
//! gait is scored.

use super::{BATCH, Evaluation, FINALISTS, Found, LEAST_DESIGN, Progress, STARTS, Search, Stage};
use crate::search::optimise::space::{Bounds, Motion, Space};
use crate::search::sinusoid::draw::{Stream, hypercube, seeds, stream};
use crate::search::sinusoid::surrogate::{Known, suggest};
use crate::search::sinusoid::task::GaitScore;
use crate::search::sinusoid::wave::{DIMENSION, Sinusoid, bounds};
use rand::{Rng as _, RngCore as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;

/// Share of a round's evaluations that its surrogate begins with: of TD3's budget 89, seven a number.
const DESIGN_SHARE: f64 = 0.3;
/// The box about the best: half its width at first, at most and at least, as shares of the range,
const HALF_WIDTH: (f64, f64, f64) = (0.2, 0.4, 0.03);
/// and the factors that success and failure change it by.
const WIDER: f64 = 1.5;
const NARROWER: f64 = 0.75;
/// Points whose numbers all differ by less than this count as the same.
const ALIKE: f64 = 0.01;

/// The state of a search.
pub struct SearchState<'a, 's> {
    search: &'s Search<'a>,
    bounds: Bounds,
    space: Space,
    starts: Vec<u64>,
    tried: Vec<Evaluation>,
    round: u32,
    /// Length of `tried` when this round began.
    round_began_at: usize,
    steps: u64,
    watch: &'s mut dyn FnMut(&Progress<'_>) -> bool,
}

impl<'a, 's> SearchState<'a, 's> {
    pub fn of(search: &'s Search<'a>, watch: &'s mut dyn FnMut(&Progress<'_>) -> bool) -> Self {
        let bounds = bounds(search.task.robot, &search.task.env);
        Self {
            bounds,
            space: Space::new(search.basis.clone(), bounds, 1),
            starts: seeds(search.seed, Stream::Starts, STARTS),
            tried: Vec::new(),
            round: 0,
            round_began_at: 0,
            steps: 0,
            watch,
            search,
        }
    }

    pub fn run(&mut self) -> Found {
        let search = self.search;
        let for_rounds = search.budget - search.final_steps();
        let rounds = search.rounds();
        let mut goes_on = true;
        for round in 0..rounds {
            (self.round, self.round_began_at) = (round, self.tried.len());
            // Falls end episodes early: the round itself spends what they leave of the budget.
            goes_on = goes_on && self.round(for_rounds * u64::from(round + 1) / u64::from(rounds));
        }
        if goes_on {
            self.compare();
        }
        self.found(!goes_on)
    }

    /// One search, until so many steps are done. Returns whether to go on after it.
    fn round(&mut self, steps_at_end: u64) -> bool {
        let search = self.search;
        let seed = search.round_seed(self.round);
        let whole = (steps_at_end - self.steps) / search.evaluation_steps();
        let design = ((DESIGN_SHARE * whole as f64) as u64).max(LEAST_DESIGN);
        let mut goes_on = true;
        for batch in hypercube(design as usize, DIMENSION, seed).chunks(BATCH) {
            goes_on = goes_on && self.try_all(Stage::Design, batch);
        }
        let mut random = stream(seed, Stream::Surrogate);
        let mut half_width = HALF_WIDTH.0;
        let mut is_near = false;
        while goes_on && self.room(steps_at_end) > 0 {
            let count = self.room(steps_at_end).min(BATCH);
            let before = self.best().score.reward_per_step;
            let (stage, limits) = if is_near {
                (Stage::Near, self.near(half_width))
            } else {
                (Stage::Everywhere, vec![[0.0, 1.0]; DIMENSION])
            };
            let points = self.suggested(&limits, count, random.next_u64());
            goes_on = self.try_all(stage, &points);
            if is_near {
                let is_better = self.best().score.reward_per_step > before;
                let change = if is_better { WIDER } else { NARROWER };
                half_width = (half_width * change).min(HALF_WIDTH.1);
                if half_width < HALF_WIDTH.2 {
                    // Nothing better is near: widen the box again.
                    half_width = HALF_WIDTH.0;
                }
            }
            is_near = !is_near;
        }
        goes_on
    }

    /// Evaluations for which the budget of the round still suffices.
    fn room(&self, steps_at_end: u64) -> usize {
        (steps_at_end.saturating_sub(self.steps) / self.search.evaluation_steps()) as usize
    }

    /// Evaluations of this round.
    fn of_round(&self) -> &[Evaluation] {
        self.tried.get(self.round_began_at..).unwrap_or_default()
    }

    /// The best of the round; the first of equals.
    fn best(&self) -> &Evaluation {
        best(self.of_round())
    }

    fn near(&self, half_width: f64) -> Vec<[f64; 2]> {
        let box_about = |centre: &f64| [(centre - half_width).max(0.0), (centre + half_width).min(1.0)];
        self.best().point.iter().map(box_about).collect()
    }

    /// Points that the surrogate suggests; a random point in place of each that is not new.
    fn suggested(&self, limits: &[[f64; 2]], count: usize, seed: u64) -> Vec<Vec<f64>> {
        let points: Vec<Vec<f64>> = self.of_round().iter().map(|tried| tried.point.clone()).collect();
        let costs: Vec<f64> = self.of_round().iter().map(|tried| -tried.score.reward_per_step).collect();
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

    /// Evaluates points. Returns whether to go on.
    fn try_all(&mut self, stage: Stage, points: &[Vec<f64>]) -> bool {
        let gaits: Vec<Sinusoid> = points.iter().map(|point| Sinusoid::at(point, self.bounds)).collect();
        let motions: Vec<Motion> = gaits.iter().map(|gait| self.motion(gait)).collect();
        let scores = self.search.task.scores(&motions, &self.starts);
        for ((point, gait), score) in points.iter().zip(gaits).zip(scores) {
            self.steps += score.steps;
            self.tried.push(Evaluation { round: self.round, stage, point: point.clone(), gait, score });
        }
        self.report()
    }

    fn report(&mut self) -> bool {
        let progress = Progress { evaluations: self.tried.len(), steps: self.steps, best: best(&self.tried) };
        (self.watch)(&progress)
    }

    /// Evaluates the best few on new starts.
    fn compare(&mut self) {
        let mut ranked: Vec<Evaluation> = self.tried.clone();
        ranked.sort_by(|a, b| b.score.reward_per_step.total_cmp(&a.score.reward_per_step));
        ranked.truncate(FINALISTS);
        let starts = seeds(self.search.seed, Stream::FinalStarts, self.search.final_starts() as usize);
        let motions: Vec<Motion> = ranked.iter().map(|finalist| self.motion(&finalist.gait)).collect();
        for (finalist, score) in ranked.into_iter().zip(self.search.task.scores(&motions, &starts)) {
            self.steps += score.steps;
            self.tried.push(Evaluation { stage: Stage::Final, score, ..finalist });
        }
    }

    fn found(&self, stopped: bool) -> Found {
        let finals: Vec<Evaluation> =
            self.tried.iter().filter(|tried| tried.stage == Stage::Final).cloned().collect();
        let best = best(if finals.is_empty() { &self.tried } else { &finals });
        Found {
            motion: self.motion(&best.gait),
            gait: best.gait,
            score: best.score,
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

/// The first of equals. There always is one: a search's first batch is always tried.
fn best(tried: &[Evaluation]) -> &Evaluation {
    let better =
        |a: &&Evaluation, b: &&Evaluation| a.score.reward_per_step.total_cmp(&b.score.reward_per_step);
    tried.iter().rev().max_by(better).unwrap_or(&NOTHING)
}

/// The best of no gaits.
static NOTHING: Evaluation = Evaluation {
    round: 0,
    stage: Stage::Design,
    point: Vec::new(),
    gait: Sinusoid::STILL,
    score: GaitScore::NOTHING,
};
