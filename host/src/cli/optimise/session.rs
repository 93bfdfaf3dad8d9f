//! The searches of one command, with progress bar and Ctrl-C, and the report's robots.
//!
//! Holds what all searches and reports of a command share. Does not depend on how
//! a gait is searched.

use super::Args;
use crate::robot::Robot;
use crate::search::optimise::basis::Basis;
use crate::search::optimise::heading;
use crate::search::optimise::report::{AtAmplitude, Fresh, OverDraws, TRIAL_S, over_amplitudes, over_draws};
use crate::search::optimise::score::{Aim, Counted, Test};
use crate::search::optimise::search::{Found, Progress, Search, Stage, Start};
use crate::search::optimise::space::{Bounds, Motion, Space};
use crate::search::optimise::tolerances::{Draw, Tolerances};
use indicatif::{ProgressBar, ProgressStyle};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Length of a trial of the search; reports take the paper's 12 s.
const SEARCH_TRIAL_S: f64 = 5.0;
/// The report's seed is another than the search's.
const REPORT_SEED: u64 = 0x5eed_0f7e;
/// A report only plays gaits: the aim has no effect on a walk.
const REPORT: Test = Test { aim: Aim::Speed, counted: Counted::Distance, duration_s: TRIAL_S };
/// Draws at each amplitude: a quarter of the report's.
const AMPLITUDE_SHARE: usize = 4;
/// Between walks that are only for the progress bar.
const SHOWN_EVERY: Duration = Duration::from_secs(2);

/// The searches of one command.
pub struct SearchSession<'a> {
    pub args: &'a Args,
    pub robot: &'a Robot,
    pub basis: &'a Basis,
    pub stop: &'a AtomicBool,
    pub tolerances: Tolerances,
    pub counted: Counted,
}

impl SearchSession<'_> {
    /// The first search, from `--start`.
    pub fn first(&self, aim: Aim, start: &Start, budget: u64) -> Found {
        self.watched(aim, budget, "", |search, progress| search.run(start, progress))
    }

    /// A further search for another aim, from what was found so far.
    pub fn next(&self, found: &mut Found, aim: Aim, number: u64, budget: u64, what: &str) {
        self.watched(aim, budget, what, |search, progress| search.go_on(found, number, progress));
    }

    pub fn stopped(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }

    fn watched<T>(
        &self,
        aim: Aim,
        budget: u64,
        what: &str,
        go: impl FnOnce(&Search<'_>, &mut dyn FnMut(&Progress<'_>)) -> T,
    ) -> T {
        let bounds = Bounds::of(self.robot);
        let space = |waves| Space::new(self.basis.clone(), bounds, waves);
        let search = Search {
            robot: self.robot,
            space: &space,
            test: self.test(aim),
            tolerances: self.tolerances,
            seed: self.args.new.seed,
            budget,
            stop: self.stop,
        };
        let mut shown = Shown::new(&search, what);
        let found = go(&search, &mut |progress| shown.show(progress));
        shown.bar.finish_and_clear();
        found
    }

    /// A trial of the search.
    pub fn test(&self, aim: Aim) -> Test {
        Test { aim, counted: self.counted, duration_s: SEARCH_TRIAL_S }
    }

    /// A gait that was found, turned round if it goes backwards and the robot is symmetric.
    pub fn forward(&self, motion: Motion) -> Motion {
        heading::forward(self.robot, motion)
    }

    /// A gait over robots that no search has seen.
    pub fn over_draws(&self, motion: &Motion) -> OverDraws {
        let fresh = self.fresh(usize::from(self.args.draws));
        over_draws(self.robot, &self.tolerances, &REPORT, motion, 1.0, fresh)
    }

    /// The same from half its stroke to one and a half, over fewer robots.
    pub fn over_amplitudes(&self, motion: &Motion) -> Vec<AtAmplitude> {
        let fresh = self.fresh(usize::from(self.args.draws).div_ceil(AMPLITUDE_SHARE));
        over_amplitudes(self.robot, &self.tolerances, &REPORT, motion, fresh)
    }

    fn fresh(&self, draws: usize) -> Fresh<'_> {
        Fresh { seed: REPORT_SEED ^ self.args.new.seed, draws, stop: self.stop }
    }
}

/// The progress bar; in logs, one line for each tenth.
struct Shown<'a> {
    bar: ProgressBar,
    what: &'a str,
    budget: u64,
    /// The last line was at these trials.
    said: Option<u64>,
    test: Test,
    nominal: Draw,
    best: Option<(Instant, Motion, String)>,
}

impl<'a> Shown<'a> {
    fn new(search: &Search<'_>, what: &'a str) -> Self {
        let template = "{prefix}{msg} {bar:20} {pos}/{len} trials, {elapsed} elapsed, {eta} left";
        let style = ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar());
        let bar = ProgressBar::new(search.budget).with_style(style);
        bar.set_prefix(what.to_owned());
        let (budget, test, nominal) = (search.budget, search.test, Draw::nominal(search.robot));
        Self { bar, what, budget, said: None, test, nominal, best: None }
    }

    fn show(&mut self, progress: &Progress<'_>) {
        let stage = match progress.stage {
            Stage::Initialising => "initialising",
            Stage::Candidates => "comparing candidates",
            Stage::Refining => "refining",
            Stage::Validating => "validating",
        };
        if !self.bar.is_hidden() {
            let best = self.words(progress.motion);
            self.bar.set_length(self.budget.max(progress.trials));
            self.bar.set_position(progress.trials);
            self.bar.set_message(format!("{stage}: {best}"));
        } else if self.said.is_none_or(|said| progress.trials >= said + self.budget / 10) {
            self.said = Some(progress.trials);
            let best = self.words(progress.motion);
            eprintln!("{}{} of {} trials, {stage}: {best}", self.what, progress.trials, self.budget);
        }
    }

    /// Result of one walk on the fitted robot: for display, counted in no budget, and used for no choice.
    fn words(&mut self, motion: &Motion) -> String {
        if let Some((at, known, words)) = &self.best
            && (known == motion || (!self.bar.is_hidden() && at.elapsed() < SHOWN_EVERY))
        {
            return words.clone();
        }
        let walk = self.test.walk(&self.nominal, motion, 1.0);
        let words = if walk.cost_of_transport.is_finite() && !walk.fell {
            format!(
                "best so far: cost of transport {:.3} at {:.3} m/s",
                walk.cost_of_transport, walk.speed_m_s
            )
        } else {
            "no gait walks yet".to_owned()
        };
        self.best = Some((Instant::now(), motion.clone(), words.clone()));
        words
    }
}
