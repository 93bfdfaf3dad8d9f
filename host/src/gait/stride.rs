//! Averages many strides into one: finds the period that all joints share.
//!
//! Holds the search for the fundamental, the cutting of each trial into strides and
//! their average over phase; [`window`] averages stretches of a fixed length instead.
//! Motion that does not repeat is an error: the mean of strides that are out of step
//! is not a stride. Does not depend on who moved.

mod error;
pub mod window;

pub use error::StrideError;

use protocol::JOINT_COUNT;

/// One sample of all joints.
pub type Sample = [f64; JOINT_COUNT];

/// Shorter repetitions are tremor.
pub const MIN_PERIOD_S: f64 = 0.2;
/// Longer ones hold more than one stride, or a degree-10 polynomial cannot follow them.
pub const MAX_PERIOD_S: f64 = 4.0;
/// Least normalised correlation with itself one period later for motion to count as periodic.
pub const MIN_CORRELATION: f64 = 0.6;
/// Shortest window of a recording, in seconds: shorter ones hold too few samples for a curve of degree 10.
pub const MIN_WINDOW_S: f64 = 0.5;
/// A shorter period whose correlation is this share of the best is the fundamental;
/// its multiples are always about as good.
const FUNDAMENTAL_SHARE: f64 = 0.9;
/// Less motion than this, rms over all joints in action units, is standing: 0.5 degrees.
const STILL_RMS: f64 = 0.011;
/// A stride may last this much more or less than the common period.
const STRETCH: f64 = 0.2;
/// Strides are laid onto each other so many times; the average settles in two.
const PASSES: usize = 4;
/// Stride starts are looked for in steps of this share of a sample.
const SEARCH_STEP: f64 = 0.25;

/// One stride, averaged.
#[derive(Debug, Clone, PartialEq)]
pub struct Stride {
    /// Mean duration of the strides in it.
    pub period_s: f64,
    /// Evenly spaced over the period, the first at phase 0.
    pub samples: Vec<Sample>,
    /// Strides in the average.
    pub averaged: usize,
    /// Strides that were unlike the others.
    pub left_out: usize,
    /// Standard deviation of the strides about the average, sample by sample.
    pub deviations: Vec<Sample>,
    /// The same, rms over phase.
    pub spread: Sample,
    /// Normalised correlation of the motion with itself one period later.
    pub correlation: f64,
}

/// A stretch of one trial, in samples.
#[derive(Debug, Clone, Copy)]
struct Cut {
    trial: usize,
    start: f64,
    end: f64,
}

/// Averages the strides of all trials, sampled `rate_hz` times a second.
///
/// The stride has as many samples as fit its period best at that rate.
///
/// # Errors
/// [`StrideError`] if the motion is not a gait.
pub fn average(trials: &[Vec<Sample>], rate_hz: f64) -> Result<Stride, StrideError> {
    let centred: Vec<Vec<Sample>> = trials.iter().map(|trial| centre(trial)).collect();
    let (lag, correlation) = fundamental(&centred, rate_hz)?;
    let phases = (lag.round() as usize).max(2);
    let mut template = first_template(&centred, lag, phases);
    let (mut kept, mut found) = (Vec::new(), 0);
    for _ in 0..PASSES {
        let cuts: Vec<Cut> =
            (0..centred.len()).flat_map(|trial| cut(trial, &centred[trial], &template, lag)).collect();
        found = cuts.len();
        kept = cuts;
        kept.retain(|&cut| {
            similarity(&stretch(&centred[cut.trial], cut, phases), &template) > MIN_CORRELATION
        });
        if kept.len() * 2 <= found || kept.is_empty() {
            return Err(StrideError::Unlike { kept: kept.len(), found, period_s: lag / rate_hz });
        }
        template = mean(kept.iter().map(|&cut| stretch(&centred[cut.trial], cut, phases)), phases);
    }
    Ok(average_cuts(trials, rate_hz, &kept, found, correlation))
}

/// The mean of the `cuts` that were kept of those `found`, and how far they are from it.
fn average_cuts(
    trials: &[Vec<Sample>],
    rate_hz: f64,
    cuts: &[Cut],
    found: usize,
    correlation: f64,
) -> Stride {
    let duration = cuts.iter().map(|cut| cut.end - cut.start).sum::<f64>() / cuts.len() as f64;
    let phases = (duration.round() as usize).max(2);
    let strides: Vec<_> = cuts.iter().map(|&cut| stretch(&trials[cut.trial], cut, phases)).collect();
    let samples = mean(strides.iter().cloned(), phases);
    let deviation = |(phase, mean): (usize, &Sample)| {
        std::array::from_fn(|joint| {
            let squares: f64 =
                strides.iter().map(|stride| (stride[phase][joint] - mean[joint]).powi(2)).sum();
            (squares / strides.len() as f64).sqrt()
        })
    };
    let deviations: Vec<Sample> = samples.iter().enumerate().map(deviation).collect();
    let spread = std::array::from_fn(|joint| {
        let squares: f64 = deviations.iter().map(|deviation| deviation[joint].powi(2)).sum();
        (squares / phases as f64).sqrt()
    });
    Stride {
        period_s: duration / rate_hz,
        samples,
        averaged: cuts.len(),
        left_out: found - cuts.len(),
        deviations,
        spread,
        correlation,
    }
}

/// A trial without each joint's mean.
fn centre(trial: &[Sample]) -> Vec<Sample> {
    let mean: Sample =
        std::array::from_fn(|joint| trial.iter().map(|s| s[joint]).sum::<f64>() / trial.len().max(1) as f64);
    trial.iter().map(|sample| std::array::from_fn(|joint| sample[joint] - mean[joint])).collect()
}

fn dot(a: &Sample, b: &Sample) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Normalised correlation of a trial with itself `lag` samples later, over all joints.
fn correlation(trial: &[Sample], lag: usize) -> f64 {
    let (mut product, mut early, mut late) = (0.0, 0.0, 0.0);
    for (now, then) in trial.iter().zip(trial.iter().skip(lag)) {
        product += dot(now, then);
        early += dot(now, now);
        late += dot(then, then);
    }
    product / (early * late).sqrt().max(f64::MIN_POSITIVE)
}

/// The middle trial's correlation: a few odd trials do not move it.
fn median_correlation(trials: &[Vec<Sample>], lag: usize) -> f64 {
    let mut all: Vec<f64> = trials.iter().map(|trial| correlation(trial, lag)).collect();
    all.sort_by(f64::total_cmp);
    all[all.len() / 2]
}

/// Refuses trials, each less its mean, in which next to nothing moves.
fn check_moves(trials: &[Vec<Sample>]) -> Result<(), StrideError> {
    let numbers = trials.iter().map(|trial| trial.len() * JOINT_COUNT).sum::<usize>() as f64;
    let rms = (trials.iter().flatten().map(|s| dot(s, s)).sum::<f64>() / numbers).sqrt();
    if rms < STILL_RMS { Err(StrideError::Still { rms }) } else { Ok(()) }
}

/// How long a stride lasts, where the motion has any.
#[must_use]
pub fn period_s(trials: &[Vec<Sample>], rate_hz: f64) -> Option<f64> {
    let centred: Vec<Vec<Sample>> = trials.iter().map(|trial| centre(trial)).collect();
    fundamental(&centred, rate_hz).ok().map(|(lag, _)| lag / rate_hz)
}

/// The period in samples, between samples where need be, and its correlation.
fn fundamental(trials: &[Vec<Sample>], rate_hz: f64) -> Result<(f64, f64), StrideError> {
    let longest = trials.iter().map(Vec::len).max().unwrap_or(0);
    let least = (MIN_PERIOD_S * rate_hz).ceil() as usize;
    // Three periods must fit: two to cut at unknown phase, one to compare.
    let most = ((MAX_PERIOD_S * rate_hz) as usize).min(longest / 3);
    if most <= least + 1 {
        return Err(StrideError::TooShort { duration_s: longest as f64 / rate_hz });
    }
    check_moves(trials)?;
    let curve: Vec<f64> = (0..=most + 1).map(|lag| median_correlation(trials, lag)).collect();
    let is_peak = |&lag: &usize| curve[lag] >= curve[lag - 1] && curve[lag] > curve[lag + 1];
    let peaks: Vec<usize> = (least..=most).filter(is_peak).collect();
    let best = peaks.iter().copied().max_by(|&a, &b| curve[a].total_cmp(&curve[b]));
    let Some(best) = best.filter(|&lag| curve[lag] >= MIN_CORRELATION) else {
        let lag = best.unwrap_or(most);
        return Err(StrideError::NotPeriodic { correlation: curve[lag], period_s: lag as f64 / rate_hz });
    };
    let share = FUNDAMENTAL_SHARE * curve[best];
    let lag = peaks.iter().copied().find(|&lag| curve[lag] >= share).unwrap_or(best);
    // The top of the parabola through three samples.
    let (left, top, right) = (curve[lag - 1], curve[lag], curve[lag + 1]);
    let bend = left - 2.0 * top + right;
    let shift = if bend < 0.0 { 0.5 * (left - right) / bend } else { 0.0 };
    Ok((lag as f64 + shift.clamp(-0.5, 0.5), top))
}

/// The motion `position` samples into a trial, between samples where need be.
fn at(trial: &[Sample], position: f64) -> Sample {
    let last = trial.len() - 1;
    let before = (position.max(0.0) as usize).min(last);
    let share = (position - before as f64).clamp(0.0, 1.0);
    let after = &trial[(before + 1).min(last)];
    std::array::from_fn(|joint| trial[before][joint] * (1.0 - share) + after[joint] * share)
}

/// A cut at `phases` evenly spaced phases.
fn stretch(trial: &[Sample], cut: Cut, phases: usize) -> Vec<Sample> {
    let step = (cut.end - cut.start) / phases as f64;
    (0..phases).map(|phase| at(trial, cut.start + phase as f64 * step)).collect()
}

fn similarity(a: &[Sample], b: &[Sample]) -> f64 {
    let sum = |x: &[Sample], y: &[Sample]| x.iter().zip(y).map(|(x, y)| dot(x, y)).sum::<f64>();
    sum(a, b) / (sum(a, a) * sum(b, b)).sqrt().max(f64::MIN_POSITIVE)
}

fn mean(strides: impl Iterator<Item = Vec<Sample>>, phases: usize) -> Vec<Sample> {
    let mut sum = vec![[0.0; JOINT_COUNT]; phases];
    let mut count = 0.0_f64;
    for stride in strides {
        count += 1.0;
        for (sum, sample) in sum.iter_mut().zip(&stride) {
            for (sum, value) in sum.iter_mut().zip(sample) {
                *sum += value;
            }
        }
    }
    sum.iter().map(|sample| sample.map(|value| value / count.max(1.0))).collect()
}

/// A stride from the middle of the trial that repeats itself best.
fn first_template(trials: &[Vec<Sample>], lag: f64, phases: usize) -> Vec<Sample> {
    let whole = lag.round() as usize;
    let correlation = |trial: &Vec<Sample>| correlation(trial, whole);
    let best = (0..trials.len())
        .filter(|&trial| trials[trial].len() as f64 >= 2.0 * lag)
        .max_by(|&a, &b| correlation(&trials[a]).total_cmp(&correlation(&trials[b])))
        .unwrap_or(0);
    let start = (trials[best].len() as f64 - lag) / 2.0;
    stretch(&trials[best], Cut { trial: best, start, end: start + lag }, phases)
}

/// Cuts a trial into strides that start where the template does.
fn cut(trial: usize, motion: &[Sample], template: &[Sample], lag: f64) -> Vec<Cut> {
    let last_start = motion.len() as f64 - 1.0 - lag;
    let best_start = |from: f64, to: f64| {
        let steps = ((to.min(last_start) - from) / SEARCH_STEP).floor();
        (0..=steps.max(-1.0) as i64)
            .map(|step| from + step as f64 * SEARCH_STEP)
            .map(|start| {
                let window = stretch(motion, Cut { trial, start, end: start + lag }, template.len());
                (start, similarity(&window, template))
            })
            .max_by(|a, b| a.1.total_cmp(&b.1))
            .map(|(start, _)| start)
    };
    let mut cuts = Vec::new();
    if last_start < 0.0 {
        return cuts;
    }
    let Some(mut start) = best_start(0.0, lag) else { return cuts };
    while start + (1.0 + STRETCH) * lag <= last_start {
        let Some(end) = best_start(start + (1.0 - STRETCH) * lag, start + (1.0 + STRETCH) * lag) else {
            break;
        };
        cuts.push(Cut { trial, start, end });
        start = end;
    }
    cuts
}

#[cfg(test)]
mod tests;
