//! A stretch of fixed length from every trial, aligned with the others' and averaged.
//!
//! This is the paper's method, with 4 s however long the stride is: trials are aligned
//! by the lag of the best correlation, then averaged. The ends of the stretch need not
//! meet, and it may hold any number of strides. Trials that do not move alike are an
//! error. Does not depend on the period.

use super::{
    Cut, MAX_PERIOD_S, MIN_CORRELATION, MIN_WINDOW_S, PASSES, SEARCH_STEP, Sample, Stride, StrideError,
    average_cuts, centre, check_moves, mean, similarity, stretch,
};

/// The paper's.
pub const PAPER_WINDOW_S: f64 = 4.0;
/// Trials among which the one most like the others is looked for: the paper's number.
const CANDIDATES: usize = 20;

/// Averages `window_s` of every trial, sampled `rate_hz` times a second.
///
/// The window has as many samples as fit it best at that rate; its correlation is
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
    let (mut kept, mut correlation) = (Vec::new(), 0.0);
    for _ in 0..PASSES {
        let best = centred.iter().enumerate().filter_map(|(trial, motion)| lay(trial, motion, &template));
        let alike: Vec<(Cut, f64)> = best.filter(|(_, correlation)| *correlation > MIN_CORRELATION).collect();
        if alike.len() * 2 <= trials.len() {
            return Err(StrideError::WindowsUnlike { kept: alike.len(), found: trials.len(), window_s });
        }
        correlation = alike.iter().map(|(_, correlation)| correlation).sum::<f64>() / alike.len() as f64;
        kept = alike.into_iter().map(|(cut, _)| cut).collect();
        template = mean(kept.iter().map(|&cut| stretch(&centred[cut.trial], cut, length)), length);
    }
    Ok(average_cuts(trials, rate_hz, &kept, trials.len(), correlation))
}

fn window(trial: usize, start: f64, length: usize) -> Cut {
    Cut { trial, start, end: start + length as f64 }
}

/// Where in a trial the template fits best, and its correlation: to the sample first, then between samples.
fn lay(trial: usize, motion: &[Sample], template: &[Sample]) -> Option<(Cut, f64)> {
    let last_start = motion.len().checked_sub(template.len() + 1)?;
    let correlate = |start: f64| {
        let cut = window(trial, start, template.len());
        (cut, similarity(&stretch(motion, cut, template.len()), template))
    };
    let better = |a: &(Cut, f64), b: &(Cut, f64)| a.1.total_cmp(&b.1);
    let (coarse, _) = (0..=last_start).map(|start| correlate(start as f64)).max_by(better)?;
    let steps = (1.0 / SEARCH_STEP) as i32;
    let near = (-steps..=steps).map(|step| coarse.start + f64::from(step) * SEARCH_STEP);
    near.filter(|start| (0.0..=last_start as f64).contains(start)).map(correlate).max_by(better)
}

/// The middle of the trial to which the others are most alike.
fn first_template(trials: &[Vec<Sample>], length: usize) -> Vec<Sample> {
    let long = (0..trials.len()).filter(|&trial| trials[trial].len() > length);
    let candidates: Vec<usize> = long.take(CANDIDATES).collect();
    let middle = |trial: usize| {
        let start = (trials[trial].len() - length) / 2;
        stretch(&trials[trial], window(trial, start as f64, length), length)
    };
    let correlation = |trial: usize| {
        let template = middle(trial);
        candidates
            .iter()
            .filter_map(|&other| lay(other, &trials[other], &template))
            .map(|(_, l)| l)
            .sum::<f64>()
    };
    let correlated = candidates.iter().map(|&trial| (trial, correlation(trial)));
    let best = correlated.max_by(|a, b| a.1.total_cmp(&b.1)).map_or(0, |(trial, _)| trial);
    middle(best)
}
