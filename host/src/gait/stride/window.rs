//! A stretch of fixed length from every trial, laid onto the others' and averaged.
//!
//! The paper's way, with 4 s, whatever the stride: trials aligned by the lag of
//! the best correlation, then averaged. Owns the choice of the stretch in
//! each trial: where it correlates best with those of the others. Its ends need
//! not meet, and it may hold any number of strides. Refuses trials that do not
//! move alike.

use super::{
    Cut, MAX_PERIOD_S, MIN_LIKENESS, PASSES, SEARCH_STEP, Sample, Stride, StrideError, average_cuts, centre,
    check_moves, mean, similarity, stretch,
};

/// The paper's.
pub const PAPER_WINDOW_S: f64 = 4.0;
/// Shorter ones hold too few samples for a curve of degree 10.
pub const MIN_WINDOW_S: f64 = 0.5;
/// Trials among which the one most like the others is looked for: the paper's number.
const CANDIDATES: usize = 20;

/// Averages `window_s` of every trial, sampled `rate_hz` times a second.
///
/// The window has as many samples as fit it best at that rate; its likeness is
/// the mean correlation of the trials' windows with the average.
///
/// # Errors
/// [`StrideError`] if the trials do not move, are too short to move the window
/// by a stride, or do not move alike.
pub fn average(trials: &[Vec<Sample>], rate_hz: f64, window_s: f64) -> Result<Stride, StrideError> {
    let longest = trials.iter().map(Vec::len).max().unwrap_or(0);
    let duration_s = longest as f64 / rate_hz;
    let most_s = duration_s - MAX_PERIOD_S;
    if !(MIN_WINDOW_S..=most_s).contains(&window_s) {
        return Err(StrideError::Window { window_s, duration_s, most_s });
    }
    let length = (window_s * rate_hz).round() as usize;
    let centred: Vec<Vec<Sample>> = trials.iter().map(|trial| centre(trial)).collect();
    check_moves(&centred)?;
    let mut template = first_template(&centred, length);
    let (mut kept, mut likeness) = (Vec::new(), 0.0);
    for _ in 0..PASSES {
        let best = centred.iter().enumerate().filter_map(|(trial, motion)| lay(trial, motion, &template));
        let alike: Vec<(Cut, f64)> = best.filter(|(_, likeness)| *likeness > MIN_LIKENESS).collect();
        if alike.len() * 2 <= trials.len() {
            return Err(StrideError::WindowsUnlike { kept: alike.len(), found: trials.len(), window_s });
        }
        likeness = alike.iter().map(|(_, likeness)| likeness).sum::<f64>() / alike.len() as f64;
        kept = alike.into_iter().map(|(cut, _)| cut).collect();
        template = mean(kept.iter().map(|&cut| stretch(&centred[cut.trial], cut, length)), length);
    }
    Ok(average_cuts(trials, rate_hz, &kept, trials.len(), likeness))
}

fn window(trial: usize, start: f64, length: usize) -> Cut {
    Cut { trial, start, end: start + length as f64 }
}

/// Where in a trial the template lies best, and how well: to the sample first, then between samples.
fn lay(trial: usize, motion: &[Sample], template: &[Sample]) -> Option<(Cut, f64)> {
    let last_start = motion.len().checked_sub(template.len() + 1)?;
    let judge = |start: f64| {
        let cut = window(trial, start, template.len());
        (cut, similarity(&stretch(motion, cut, template.len()), template))
    };
    let better = |a: &(Cut, f64), b: &(Cut, f64)| a.1.total_cmp(&b.1);
    let (coarse, _) = (0..=last_start).map(|start| judge(start as f64)).max_by(better)?;
    let steps = (1.0 / SEARCH_STEP) as i32;
    let near = (-steps..=steps).map(|step| coarse.start + f64::from(step) * SEARCH_STEP);
    near.filter(|start| (0.0..=last_start as f64).contains(start)).map(judge).max_by(better)
}

/// The middle of the trial to which the others are most alike.
fn first_template(trials: &[Vec<Sample>], length: usize) -> Vec<Sample> {
    let long = (0..trials.len()).filter(|&trial| trials[trial].len() > length);
    let candidates: Vec<usize> = long.take(CANDIDATES).collect();
    let middle = |trial: usize| {
        let start = (trials[trial].len() - length) / 2;
        stretch(&trials[trial], window(trial, start as f64, length), length)
    };
    let likeness = |trial: usize| {
        let template = middle(trial);
        candidates
            .iter()
            .filter_map(|&other| lay(other, &trials[other], &template))
            .map(|(_, l)| l)
            .sum::<f64>()
    };
    let judged = candidates.iter().map(|&trial| (trial, likeness(trial)));
    let best = judged.max_by(|a, b| a.1.total_cmp(&b.1)).map_or(0, |(trial, _)| trial);
    middle(best)
}
